# SPDX-License-Identifier: MIT
"""Level ranks: the real processes on a part of the cases, healthy and with faults that show on several ranks only."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from fault_injection import assert_caught, assert_healthy

from impact_verify import ranks
from impact_verify.report import Report

PRELUDE = """
import sys
from impact_verify import ranks
from dolfinx_impact import operators
ranks.CASES = ranks.CASES[:1]
ranks.contact_ranks.CASES = [(*c[:3], c[3][:1]) for c in ranks.contact_ranks.CASES[:1] if {contact}]
ranks.explicit_ranks.STEPS = 300
ranks.explicit_ranks.CASES = [c for c in ranks.explicit_ranks.CASES[:1] if {explicit}]
{fault}
sys.argv = ["ranks", sys.argv[1]]
ranks.main()
"""

# A ghost node's contributions stay where they were computed: nothing to see on one rank.
NO_REVERSE_SCATTER = """
def apply(self, b=None):
    b = self.vector()
    self.assemble(b.array)
    return b
operators.InternalForce.apply = apply
"""
# Every rank reports its own part of the energy.
LOCAL_ENERGY = """
operators.Energy.value = lambda self: (self._update(), self._cpp_object.value())[1]
"""


# Every rank reports its own part of the total contact force.
LOCAL_TOTAL = """
from dolfinx_impact.contact.output import ContactOutput
def total(self):
    return (self.weight[:, None] * self.traction)[self.status > 0].sum(axis=0)
ContactOutput.force = property(total, ContactOutput.force.fset)
"""


# What rank 0 does not have of the contact surfaces is forgotten: contact is lost where pairs are split.
LOST_FACETS = """
from mpi4py import MPI
from dolfinx_impact.contact import pair
right = pair._surface
pair._surface = lambda V, facets: right(V, facets if MPI.COMM_WORLD.rank == 0 else facets[:0])
"""
# Energies of this rank's part of the bodies.
LOCAL_ENERGIES = """
from dolfinx_impact.dynamics.explicit import ExplicitProblem
right = ExplicitProblem.energy_history.fget
def energy_history(self):
    n = self.num_owned
    part = n / self.comm.allreduce(n)
    return right(self) * ([1.0] + 9 * [part])
ExplicitProblem.energy_history = property(energy_history)
"""


@pytest.fixture(scope="module")
def on_one_rank():
    """(contact, explicit) -> text that a healthy run on one rank wrote. Faults on several ranks do not show there."""
    return {}


@pytest.fixture
def launch(monkeypatch, on_one_rank):
    """launch(fault, contact, explicit): ranks.run starts its processes with a prelude: the first case only, and a
    fault. Those on one rank run once for all tests."""
    real = subprocess.run

    def prepare(fault="", contact=False, explicit=False):
        def run(command, **kwargs):
            path, known = Path(command[-1]), on_one_rank.get((contact, explicit))
            if command[0] == sys.executable and known:
                path.write_text(known)
                return subprocess.CompletedProcess(command, 0, "", "")
            prelude = ["-c", PRELUDE.format(fault=fault, contact=contact, explicit=explicit), command[-1]]
            done = real([*command[: command.index("-m")], *prelude], **kwargs)
            if command[0] == sys.executable and not fault and done.returncode == 0:
                on_one_rank[contact, explicit] = path.read_text()
            return done

        monkeypatch.setattr(ranks.subprocess, "run", run)

    return prepare


def tamper(monkeypatch, change):
    """ranks.run gets values that never saw a process; `change` alters those of two ranks."""

    def run(command, **kwargs):
        values = {f"triangle|2|plane_strain|{form}": [[1.0, 2.0], [3.0, -4.0]] for form in ("mass", "solution")}
        path = Path(command[-1])
        if path.stem == "2":
            change(values)
        path.write_text(json.dumps(values))
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(ranks.subprocess, "run", run)


def report(counts=(2,)):
    result = Report()
    ranks.run(result, counts)
    return result


@pytest.mark.mpi
@pytest.mark.parametrize("counts", [(2,), pytest.param((2, 3), marks=pytest.mark.slow)])
def test_the_healthy_state_passes(counts, launch):
    launch()
    found = report(counts)
    assert_healthy(found, "ranks", 6 * len(counts))
    assert {r.name for r in found.rows} == {f"{n} ranks against 1" for n in counts}
    forms = {"linear_elastic.force", "linear_elastic.energy", "neo_hookean.force", "neo_hookean.energy", "lumped_mass"}
    assert {r.form for r in found.rows} == forms | {"solution"}


@pytest.mark.mpi
def test_contact_on_two_ranks(launch):
    launch(contact=True)
    found = report()
    assert_healthy(found, "ranks", 10)
    values = {f"contact.lagrange_{what}" for what in ("u", "friction_u", "force", "total")}
    assert values <= {r.form for r in found.rows}


@pytest.mark.mpi
def test_contact_that_every_rank_sums_up_for_itself(launch):
    launch(LOCAL_TOTAL, contact=True)
    assert {r.form for r in report().failures()} == {"contact.lagrange_total"}


@pytest.mark.mpi
@pytest.mark.parametrize("counts", [(2,), pytest.param((2, 4), marks=pytest.mark.slow)])
def test_explicit_runs_on_two_and_four_ranks(counts, launch):
    launch(explicit=True)
    found = report(counts)
    assert_healthy(found, "ranks", len(counts) * (6 + 12))
    methods = ("penalty", "balanced", "kinematic")
    values = {f"explicit.{m}_{what}" for m in methods for what in ("u", "velocity", "force", "energy")}
    assert values <= {r.form for r in found.rows}


@pytest.mark.mpi
def test_contact_that_is_lost_where_pairs_are_split(launch):
    launch(LOST_FACETS, explicit=True)
    failures = {r.form for r in report().failures()}
    assert failures == {f"explicit.{m}_{what}" for m in ("penalty", "balanced", "kinematic")
                        for what in ("u", "velocity", "force", "energy")}  # fmt: skip


@pytest.mark.slow
@pytest.mark.mpi
def test_energies_of_a_rank_alone(launch):
    launch(LOCAL_ENERGIES, explicit=True)
    assert {r.form for r in report().failures()} == {
        f"explicit.{m}_energy" for m in ("penalty", "balanced", "kinematic")
    }


@pytest.mark.mpi
def test_contributions_of_ghosts_forgotten(launch):
    launch(NO_REVERSE_SCATTER)
    failures = report().failures()
    assert {r.form for r in failures} >= {"linear_elastic.force", "neo_hookean.force"}
    assert all(r.level == "ranks" and "on 2 ranks" in r.note for r in failures)
    assert not {r.form for r in failures} & {"linear_elastic.energy", "neo_hookean.energy"}


@pytest.mark.mpi
def test_an_energy_that_is_not_summed_over_the_ranks(launch):
    launch(LOCAL_ENERGY)
    assert {r.form for r in report().failures()} == {"linear_elastic.energy", "neo_hookean.energy"}


@pytest.mark.mpi
def test_a_run_that_fails_is_an_error_with_its_output(launch, on_one_rank):
    on_one_rank.clear()  # this fault shows there
    launch("raise SystemError('the sea is out')")
    with pytest.raises(RuntimeError, match="the run on 1 ranks failed(.|\n)*the sea is out"):
        report()


@pytest.mark.parametrize(
    "factor, passed", [(1 + 1e-14, True), (1 + 1e-11, False), (-1.0, False), (float("nan"), False)]
)
def test_one_value_that_differs(factor, passed, monkeypatch):
    def change(values):
        values["triangle|2|plane_strain|mass"][1][1] *= factor

    tamper(monkeypatch, change)
    if passed:
        assert report().passed
    else:
        assert assert_caught(report(), "ranks", "mass").note.startswith("entry [1, 1] by position")


def test_a_value_too_few(monkeypatch):
    tamper(monkeypatch, lambda values: values["triangle|2|plane_strain|solution"].pop())
    assert "(1, 2) values" in assert_caught(report(), "ranks", "solution").note


def test_a_form_that_is_missing_on_two_ranks(monkeypatch):
    tamper(monkeypatch, lambda values: values.pop("triangle|2|plane_strain|mass"))
    assert_caught(report(), "ranks", "mass")
