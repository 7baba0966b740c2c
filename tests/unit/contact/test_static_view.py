# SPDX-License-Identifier: MIT
"""Views of contacts in C++, and rigid obstacles as problems see them, without a problem."""

import logging
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.contact.rigid import _Rigid
from dolfinx_impact.common.messages import INITIAL_PENETRATION
from dolfinx_impact.contact.static_view import StaticContactView


class Recorded:
    """Stands for a contact in C++: remembers calls; arrays are flat."""

    points = normal = traction = slip = np.arange(6.0)
    gap = pressure = weight = [1.0, 2.0, 3.0]
    status, fault, symmetric, num_active = [0, 1, 2], "no master", 1, np.int64(2)

    def __init__(self):
        self.calls = []
        self.initial = SimpleNamespace(warning="overlaps")

    def __getattr__(self, name):
        def called(*args):
            self.calls.append((name, *args))
            return {"covered": [0.5, 1.0, 0.0], "update_active_set": np.int32(4), "augment": 1}.get(name, 2.5)

        return called


@pytest.fixture
def view():
    class View(StaticContactView):
        pair, comm, gdim = None, MPI.COMM_SELF, 2

        def __init__(self):
            self._cpp_object = Recorded()

    return View()


def test_results_are_rows_and_numbers(view):
    for name in ("points", "normal", "traction", "slip"):
        assert getattr(view, name).tolist() == [[0, 1], [2, 3], [4, 5]], name
    for name, kind in (("gap", "f"), ("pressure", "f"), ("weight", "f"), ("status", "i")):
        found = getattr(view, name)
        assert found.shape == (3,) and found.dtype.kind == kind, name
    assert view.covered().tolist() == [0.5, 1.0, 0.0]
    assert view.symmetric is True and view.num_active == 2 and view.fault == "no master"


def test_calls_are_those_of_the_object(view):
    calls, u = view._cpp_object.calls, np.arange(8.0)[::2]
    assert view.update_active_set(True, 3) == 4 and calls[-1] == ("update_active_set", True, 3)
    assert view.augment() is True
    view.update_gap(u)
    assert calls[-1][0] == "update_gap" and calls[-1][1].flags.c_contiguous and np.array_equal(calls[-1][1], u)
    view.begin_step(u, np.array([1, 2, 3]), None)
    assert calls[-1][2:] == ([1.0, 2.0, 3.0], None) and all(type(x) is float for x in calls[-1][2])
    view.begin_step(u, None, u)
    assert calls[-1][2] is None and calls[-1][3] is u
    for name in ("violation", "round_off", "stored_energy"):
        assert getattr(view, name)() == 2.5 and calls[-1] == (name,)
    for name in ("prescribed_overlap", "passed_through", "largest_violation", "mesh_advice"):
        assert getattr(view, name)() == "2.5" and calls[-1] == (name,)
    for name in ("check_parameters", "accept_step", "forget"):
        assert getattr(view, name)() is None and calls[-1] == (name,)


def test_penetrations_at_rest_are_logged(view, caplog):
    with caplog.at_level(logging.WARNING, logger=INITIAL_PENETRATION.name):
        view._tell_of_penetration()
        view._cpp_object.initial.warning = ""
        view._tell_of_penetration()
    assert [r.getMessage() for r in caplog.records] == ["overlaps"]


# --- rigid obstacles -------------------------------------------------------------------------------------------------

OBSTACLES = [
    (di.RigidPlane((0, 1), (0, 2)), "point=[0.0, 1.0, 0.0], normal=[0.0, 1.0, 0.0]", "turn the plane's normal"),
    (di.RigidSphere((0, 1), -2.0), "center=[0.0, 1.0, 0.0], radius=-2.0", "is around it"),
    (di.RigidCylinder((0, 1), 3.0), "center=[0.0, 1.0, 0.0], radius=3.0, axis=[0.0, 0.0, 1.0]", "is inside it"),
]


@pytest.mark.parametrize("rigid, made_of, hint", OBSTACLES, ids=[type(o[0]).__name__ for o in OBSTACLES])
def test_what_an_obstacle_is_recognised_by(rigid, made_of, hint):
    assert isinstance(rigid, _Rigid) and repr(rigid) == f"{type(rigid).__name__}({made_of})"
    assert hint in rigid.orientation_hint()
    shape, here = rigid.shape_description(), rigid.description()
    assert rigid.shared(2) is rigid.shared(2) is not rigid.shared(3)
    assert rigid.shared(2).orientation_hint == rigid.orientation_hint()
    before = rigid.same_on_all_ranks()
    rigid.displacement, rigid.motion = (0.5, 0.0), lambda t: (t, 0, 0)
    try:
        assert rigid.shape_description() == shape and rigid.description() != here
        assert rigid.description().endswith("at [0.5, 0.0, 0.0] with motion")
        assert repr(rigid).endswith("displacement=[0.5, 0.0, 0.0], motion=...)")
        assert not np.array_equal(before[4], rigid.same_on_all_ranks()[4])
    finally:
        rigid.displacement, rigid.motion = (0.0, 0.0), None
    for wrong in ((0.0, np.nan), (1.0,), (1.0, 2.0, 3.0, 4.0)):
        with pytest.raises(ValueError, match="velocity"):
            rigid.velocity = wrong


def test_obstacles_out_of_the_plane():
    for rigid in (di.RigidSphere((0, 0, 1), 1.0), di.RigidPlane((0, 0), (0, 1, 1))):
        assert rigid.obstacle(3) is not None
        with pytest.raises(ValueError, match="outside the plane|third component"):
            rigid.obstacle(2)
