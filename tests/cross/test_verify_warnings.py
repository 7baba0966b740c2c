# SPDX-License-Identifier: MIT
"""Rows use bodies and contacts beyond what they are good for, on purpose: the command does not warn of that, but of all
else."""

import logging
import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.large_rotation import LargeRotation
from dolfinx_impact.assembly.locking import Locking, warn_of_locking
from dolfinx_impact.common.messages import INITIAL_PENETRATION
from impact_verify import cross_check, html, plastic_bodies, solution, verify_command
from impact_verify.model_warnings import model_warnings_off

OTHER = "something else"


def bad_models():
    """A body of small strain that is turned, overlaps a plane by 0.1 and locks; a warning of another kind."""
    block = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    V = fem.functionspace(block, ("Lagrange", 1, (2,)))
    bottom = mesh.locate_entities_boundary(block, 1, lambda x: np.isclose(x[1], 0.0))
    tags = mesh.meshtags(block, 1, bottom, np.full(len(bottom), 1, dtype=np.int32))
    pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.1), (0.0, 1.0)))
    law = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    di.StaticProblem(fem.Function(V), law, contact=[di.Penalty(pair)])
    u = fem.Function(V)
    u.interpolate(lambda x: np.array([-x[1] - x[0], x[0] - x[1]]))  # a quarter of a turn
    everywhere = np.arange(V.dofmap.index_map.size_local, dtype=np.int32)
    di.StaticProblem(fem.Function(V), law, bcs=[fem.dirichletbc(u, everywhere)]).solve()
    warn_of_locking(u, di.J2Plasticity(1.0, 0.3, yield_stress=1.0, hardening=1.0, hypothesis="plane_strain"))
    warnings.warn(OTHER)


def told(work, caplog):
    """Kinds of warnings and numbers of log records that a function gives, and texts of the warnings without a kind."""
    caplog.clear()
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        work()
    kinds = {w.category for w in found}
    return kinds, len(caplog.records), [str(w.message) for w in found if w.category is UserWarning]


def test_a_user_is_told(caplog):
    assert told(bad_models, caplog) == ({LargeRotation, Locking, UserWarning}, 1, [OTHER])


@pytest.mark.parametrize("command", [False, True])
def test_rows_of_the_command_are_not_told_of_their_models(command, monkeypatch, caplog, tmp_path):
    """And afterwards the user is again, after an error, too."""
    monkeypatch.setattr(solution, "run", lambda report, progress: bad_models())
    monkeypatch.setattr(plastic_bodies, "solution_rows", lambda report: None)
    monkeypatch.setattr(html, "differences_plot", lambda report, folder: "none.png")
    levels = ["--levels", "solution", "--output", str(tmp_path)]
    work = (lambda: verify_command.main(levels)) if command else (lambda: cross_check(levels=["solution"]))
    assert told(work, caplog) == ({UserWarning}, 0, [OTHER])
    with pytest.raises(ZeroDivisionError), model_warnings_off():
        raise ZeroDivisionError
    assert INITIAL_PENETRATION.level == logging.NOTSET
    assert told(bad_models, caplog)[:2] == ({LargeRotation, Locking, UserWarning}, 1)
