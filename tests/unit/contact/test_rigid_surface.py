# SPDX-License-Identifier: MIT
"""Rigid surfaces as masters in static and explicit problems."""

import numpy as np
import pytest
import rigid_surface_checks
from dolfinx import fem
from mpi4py import MPI
from on_ranks import rank_tests
from rigid_surface_checks import block, flat

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(rigid_surface_checks, ranks=(3,))


def test_a_run_goes_on_from_its_checkpoint(tmp_path):
    """In contact with a wavy floor: bit for bit."""

    def make(height=0.02):
        V, tags = block(MPI.COMM_SELF)
        v = fem.Function(V)
        v.interpolate(lambda x: np.array([0.3 + 0 * x[0], -1.0 + 0 * x[0]]))
        floor = di.RigidSurface.from_function(lambda x: height * np.sin(5 * x) - 0.03, (-1.0, 2.0), (0, 0), (0, 1))
        law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
        pair = di.ContactPair(tags, 1, floor, friction=0.2)
        return di.ExplicitProblem(fem.Function(V), law, velocity=v, contact=[di.Penalty(pair)])

    whole = make()
    dt = 0.5 * whole.stable_step()
    whole.advance(40 * dt, dt=dt, progress=False)
    assert whole.contact[0].area > 0.0 and np.all(whole.contact[0].gap > -0.02)
    whole.save(tmp_path / "half.h5")
    whole.advance(120 * dt, dt=dt, progress=False)
    again = make()
    again.restore(tmp_path / "half.h5")
    again.advance(120 * dt, dt=dt, progress=False)
    np.testing.assert_array_equal(again.u.x.array, whole.u.x.array)
    with pytest.raises(ValueError, match="another problem: contact"):
        make(0.021).restore(tmp_path / "half.h5")


def test_a_surface_that_looks_away_is_told():
    V, tags = block(MPI.COMM_SELF)
    law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
    turned = di.RigidSurface.from_function(lambda x: 0.0 * x, (-2, 3), (0.0, -0.001), (0.0, -1.0))
    reverse = di.RigidSurface.from_facets([[-2.0, -0.001], [3.0, -0.001]], [[0, 1]])
    for surface, text in ((turned, "normal round"), (reverse, "order of the facets' points round")):
        with pytest.raises(ValueError, match=text):
            pair = di.ContactPair(tags, 1, surface)
            di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V), contact=[di.Penalty(pair)])
    assert len(list(flat())) == 3
