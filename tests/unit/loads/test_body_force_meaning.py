# SPDX-License-Identifier: MIT
"""A body force is one per mass, or one per volume: a value that looks like the other one is warned of."""

import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

STEEL = {"SI": (2.1e11, 7850.0, 9.81), "mm, t, s": (2.1e5, 7.85e-9, 9810.0), "inches": (3e7, 7.3e-4, 386.1)}


def make(kind, loads, young, density):
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    law = di.LinearElastic(young, 0.3, density, "plane_strain")
    fixed = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: x[0] < 0.1), V)
    given = {} if kind is di.StaticProblem else {"velocity": fem.Function(V)}
    return kind(fem.Function(V), law, bcs=[fixed], loads=loads, **given)


@pytest.mark.parametrize("kind", [di.StaticProblem, di.NewmarkProblem, di.ExplicitProblem])
@pytest.mark.parametrize("units", STEEL)
def test_the_other_meaning_is_warned_of(kind, units):
    young, density, g = STEEL[units]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make(kind, [di.BodyForce((0, -g)), di.BodyForce((0, -density * g), per_mass=False)], young, density)
        make(kind, [di.BodyForce((0, -50 * g)), di.BodyForce((3.0, -density))], young, density)
    with pytest.warns(UserWarning, match="density .* times gravity.*per_mass=False"):
        make(kind, [di.BodyForce((density * g * 0.6, -density * g * 0.8))], young, density)
    with pytest.warns(UserWarning, match="is gravity, but counts as a force per volume"):
        make(kind, [di.BodyForce((0, -g), per_mass=False)], young, density)


def test_one_unit_of_density_means_both():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for per_mass in (True, False):
            make(di.StaticProblem, [di.BodyForce((0, -9.81), per_mass)], 100.0, 1.0)


def test_bodies_without_weight():
    with pytest.warns(UserWarning, match="acts on nothing.*density is zero"):
        make(di.StaticProblem, [di.BodyForce((0, -9.81))], 100.0, 0.0)


def test_meaning_is_said():
    assert "per_mass=True" in repr(di.BodyForce((0, 1))) and "per_mass=False" in repr(di.BodyForce((0, 1), False))
    with pytest.raises(TypeError, match="per_mass"):
        di.BodyForce((0, 1), "volume")
