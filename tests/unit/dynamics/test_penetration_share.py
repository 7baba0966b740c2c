# SPDX-License-Identifier: MIT
"""How much of the deformation is penetration: springs in series with a bar, and when a run is warned."""

import math
import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.dynamics.penetration_share import SLOW, STEPS, WARN, PenetrationShare

E = 1000.0
NAMES = ("contact", "internal", "plastic", "kinetic")


@pytest.fixture
def u():
    """Displacement of a unit square."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    return fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))


def steps(count=1, **energies):
    """Rows of energies; those that are not given are zero."""
    rows = np.zeros(count, [(name, float) for name in NAMES])
    for name, value in energies.items():
        rows[name] = value
    return rows


def share(u, springs=(True,), law=di.LinearElastic, from_rest=False):
    return PenetrationShare(u, law(E, 0.0, 1.0, "plane_strain"), (), springs, from_rest)


@pytest.mark.parametrize("ratio", (0.01, 1.0, 30.0))
def test_the_share_is_that_of_springs_in_series(u, ratio):
    """A bar of the stiffness k on a spring of the stiffness k/ratio under one force F: penetration over approach."""
    k, force = 50.0, 3.0
    bar, spring = force**2 / (2 * k), ratio * force**2 / (2 * k)
    found = share(u).of(spring, steps(internal=bar, contact=spring)[0])
    assert found == pytest.approx(ratio / (1.0 + ratio), rel=1e-14)


def test_without_deformation_there_is_none_and_without_a_material_nothing_is_known(u):
    assert share(u).of(0.0, steps()[0]) == 0.0
    assert math.isnan(PenetrationShare(u, None, (), [True], False).of(1.0, steps(contact=1.0)[0]))


def test_bodies_that_were_deformed_at_the_start_count_with_that_energy(u):
    """Where the integrator's energy begins with zero: E e^2/2 of the strain at the start is added."""
    strain = 0.02
    u.interpolate(lambda x: np.array([strain * x[0], 0.0 * x[0]]))
    from_rest = share(u, law=di.StVenantKirchhoff, from_rest=True)
    from_rest.update(steps()[0])
    green = strain + strain**2 / 2
    at_start = E * green**2 / 2
    assert from_rest.of(at_start, steps(contact=at_start)[0]) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("part, warned", [(0.9 * WARN, False), (1.1 * WARN, True)])
def test_a_load_that_is_borne_for_some_time_is_judged(u, part, warned):
    """Energies of which `part` is penetration, in as many slow steps as it takes; once, and not again."""
    watch = share(u)
    watch.add(steps(STEPS - 1, contact=part, internal=1.0 - part, kinetic=0.9 * SLOW))
    assert not warnings_of(watch)
    watch.add(steps(1, contact=part, internal=1.0 - part, kinetic=0.9 * SLOW))
    assert bool(warnings_of(watch)) == warned
    assert not warnings_of(watch)
    watch.begin_anew()
    assert not warnings_of(watch)


@pytest.mark.parametrize("springs, kinetic", [((False,), 0.0), ((), 0.0), ((True,), 1.1 * SLOW)])
def test_impacts_and_contacts_without_springs_are_not_judged(u, springs, kinetic):
    watch = share(u, springs)
    watch.add(steps(2 * STEPS, contact=0.5, internal=0.5, kinetic=kinetic))
    assert not warnings_of(watch)


def warnings_of(watch):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        watch.warn()
    assert all("penetration of the springs of penalty contact" in str(w.message) for w in found)
    return found
