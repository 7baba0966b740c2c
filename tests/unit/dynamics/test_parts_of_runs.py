# SPDX-License-Identifier: MIT
"""Parts around the steps of explicit and implicit runs, each by itself."""

import types

import numpy as np
import pytest
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.amplitude import Amplitude
from dolfinx_impact.dynamics.advance_calls import AdvanceCalls
from dolfinx_impact.dynamics.functions_of_time import FunctionsOfTime
from dolfinx_impact.dynamics.inputs import Inputs
from dolfinx_impact.dynamics.read_once import ReadOnce


def test_calls_that_are_refused():
    calls = AdvanceCalls()
    assert calls.check(1.0, 2, None, None) == 2.0
    for wrong, error in (((2.0, 1.0, None, None), ValueError), ((0.0, "soon", None, None), TypeError)):
        with pytest.raises(error, match="until"):
            calls.check(*wrong)
    for wrong in ((0.0, 1.0, 3, None), (0.0, 1.0, None, 3)):
        with pytest.raises(TypeError, match="must be a function"):
            calls.check(*wrong)


def test_one_call_at_a_time_and_another_after_an_error():
    calls = AdvanceCalls()
    with pytest.raises(KeyError), calls.running():
        with pytest.raises(RuntimeError, match="while it runs"):
            calls.check(0.0, 1.0, None, None)
        raise KeyError
    assert calls.check(0.0, 1.0, None, None) == 1.0


def test_update_comes_before_the_callback():
    problem, order = types.SimpleNamespace(time=0.5, step=6), []
    both = AdvanceCalls.at_present(lambda p: order.append("callback"), lambda p, t: order.append(t))
    both(problem)
    assert order == [0.5, "callback"]
    assert AdvanceCalls.at_present(print, None) is print
    AdvanceCalls.at_present(None, lambda p, t: order.append("alone"))(problem)
    assert order[-1] == "alone"
    for every, called in ((4, False), (3, True)):
        AdvanceCalls.at_present(lambda p: order.append("callback"), lambda p, t: order.append(t), every)(problem)
        assert order[-2:] == ([0.5, "callback"] if called else ["alone", 0.5])


def test_functions_of_time_are_columns_of_one_table():
    functions, times = FunctionsOfTime(), np.linspace(0.0, 1.0, 5)
    assert functions.table(times).shape == (5, 0)
    assert functions.add(Amplitude(lambda t: 2 * t, "first", 1)) == [0]
    assert functions.add(Amplitude(lambda t: (t, 0.0, t**2), "motion", 3)) == [1, 2, 3]
    assert functions.add(Amplitude(([0.0, 1.0], [1.0, 3.0]), "last", 1)) == [4]
    expected = np.column_stack([2 * times, times, 0 * times, times**2, 1 + 2 * times])
    np.testing.assert_allclose(functions.table(times), expected, rtol=1e-15)


class Recorded:
    """Stands for terms, loads, frequencies and the integrator: remembers what was called."""

    def __init__(self, changed=False):
        self.now, self.calls = changed, []

    def changed(self):
        return self.now

    def change(self):
        return 0.25

    def values(self):
        return 7.0

    def __getattr__(self, name):
        return lambda *args: self.calls.append((name, *args))


@pytest.mark.parametrize("term, load, frequency", [(True, False, False), (False, True, False), (False, False, True)])
def test_what_has_changed_is_copied_and_nothing_else(term, load, frequency):
    terms, loads = [Recorded(), Recorded(term)], [Recorded(), Recorded(load)]
    integrator, frequencies, changes = Recorded(), Recorded(frequency), Recorded()
    inputs = Inputs(MPI.COMM_SELF, integrator, terms, loads, frequencies, changes)
    inputs.update_changed()
    assert [t.calls for t in terms] == [[("update",)] * term] * 2
    assert integrator.calls == [("revise",)] * term + [("set_load", 1, 7.0)] * load
    assert changes.calls == [("add", 0.25)] * frequency and frequencies.calls == [("store_inputs",)] * frequency
    inputs.update_all()
    assert integrator.calls[-2:] == [("set_load", 0, 7.0), ("set_load", 1, 7.0)]
    assert all(t.calls[-1] == ("update",) for t in terms) and frequencies.calls[-1] == ("store_inputs",)


@pytest.mark.parametrize("what, value", [("displacement", (0.0, 0.1)), ("motion", lambda t: (0.0, t, 0.0))])
def test_a_rigid_master_that_others_move_is_refused(what, value):
    plane = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    pair = types.SimpleNamespace(name="wheel", rigid=True, rigid_master=plane)
    soft = types.SimpleNamespace(name="rail", rigid=False)
    supports = Recorded()
    once = ReadOnce(supports, [types.SimpleNamespace(pair=p) for p in (pair, soft)])
    once.check()
    assert supports.calls == [("check",)]
    setattr(plane, what, value)
    with pytest.raises(ValueError, match=f"wheel: the {what} of the rigid master was changed"):
        once.check()
