# SPDX-License-Identifier: MIT
"""A restored run is the uninterrupted one, bit for bit on one rank: motion, energies and contact forces of every step,
explicit and implicit, for all kinds of contact, laws and schemes."""

import functools

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

DT = 4e-3  # of implicit runs: the blocks touch in the second step
PLANE = {"hypothesis": "plane_strain", "density": 1.0}
LAWS = {
    "linear": functools.partial(di.LinearElastic, 1e3, 0.3, **PLANE),
    "neo-Hookean": functools.partial(di.NeoHookean, 1e3, 0.3, **PLANE),
    "J2": functools.partial(di.J2Plasticity, 1e3, 0.3, yield_stress=5.0, hardening=50.0, kinematic=20.0, **PLANE),
    "finite J2": functools.partial(di.J2Plasticity, 1e3, 0.3, yield_stress=5.0, finite_strain=True, **PLANE),
}
EXPLICIT = {
    "penalty": di.Penalty, "given penalty": functools.partial(di.Penalty, penalty=1e4),
    "balanced": functools.partial(di.Penalty, balanced=True), "kinematic": di.Kinematic,
}  # fmt: skip
IMPLICIT = {
    "multipliers": di.Lagrange,
    "standard basis": functools.partial(di.Lagrange, basis="standard"),
    "penalty": di.Penalty,
    "augmented": functools.partial(di.Penalty, penalty=1e5, augmented=True, tolerance=1e-4),
}
SCHEMES = {
    "Newmark": {}, "Chung and Hulbert": {"rho_inf": 0.8}, "damped": {"beta": 0.3025, "gamma": 0.6},
    "HHT": {"hht": -0.1, "lumping": "auto", "impact": "none"},
}  # fmt: skip


@functools.cache
def blocks():
    """Two blocks with a small gap."""
    size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (7, 3), "upper_cells": (6, 3)}
    return meshes.make("two_blocks", MPI.COMM_SELF, gap=2e-3, **size)


def thrown(kind, contact, law, friction, rigid, **options):
    """A block thrown obliquely on a block, or on a plane, that moves up and down; problem in time, not run yet."""
    made = blocks()
    tags, facets = made.tags, made.facet_tags
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    upper = np.unique(V.dofmap.list[made.cell_tags.find(tags["slave_body"])])
    v.x.array.reshape(-1, 2)[upper] = (0.5, -0.4)
    bottom = fem.locate_dofs_topological(V, 1, facets.find(tags["bottom"]))
    moving = di.PrescribedMotion(fem.dirichletbc(np.array([0.0, 0.002]), bottom, V), lambda t: np.sin(20 * t) ** 2)
    master = tags["master_surface"]
    if rigid:
        master = di.RigidPlane((0.0, 0.5), (0.0, 1.0))
        master.motion = lambda t: (0.0, 0.002 * np.sin(20 * t) ** 2, 0.0)
    pair = di.ContactPair(facets, tags["slave_surface"], master, friction=friction)
    loads = [di.BodyForce((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t))]
    return kind(
        u, LAWS[law](), velocity=v, bcs=[moving], loads=loads, contact=[contact(pair)], damping=di.Rayleigh(0.1, 1e-5),
        **options,
    )  # fmt: skip


def state(problem):
    """All that is told of the present state."""
    parts = [f.x.array for f in (problem.u, problem.velocity, problem.acceleration)]
    parts += [field.values for _, field in problem.history.items()] if problem.has_history else []
    for c in problem.contact:
        parts += [c.force, c.moment, [c.area, c.dissipated], c.gap, c.normal, c.pressure, c.traction, c.slip, c.status]
    return np.concatenate([np.ravel(part) for part in (*parts, [problem.time, problem.step])])


def compare(make, path, end, when, **steps):
    """Whether runs that are restored in steps `when` have the states and the rows of the run that saved there."""
    states, whole = {}, make()

    def keep(problem):
        if problem.step in when:
            problem.save(path / f"{problem.step}.h5")
            states[problem.step] = state(problem)

    whole.advance(end, callback=keep, progress=False, **steps)
    assert whole.step > max(when) + 2 and np.any(whole.force_history[0][: max(when)] != 0.0)
    for step in when:
        again = make()
        again.restore(path / f"{step}.h5")
        np.testing.assert_array_equal(state(again), states[step])
        again.advance(end, callback=keep, progress=False, **steps)
        np.testing.assert_array_equal(state(again), state(whole))
        rows = whole.step - step
        assert len(again.energy_history) == rows
        np.testing.assert_array_equal(again.energy_history[-rows:], whole.energy_history[-rows:])
        np.testing.assert_array_equal(again.force_history[0][-rows:], whole.force_history[0][-rows:])


@pytest.mark.covering(2)
@pytest.mark.parametrize("rigid", (False, True))
@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("contact", EXPLICIT)
def test_explicit_runs(contact, law, friction, rigid, tmp_path):
    if rigid and contact == "balanced":
        contact = "penalty"  # a pair with an obstacle has one direction
    make = functools.partial(thrown, di.ExplicitProblem, EXPLICIT[contact], law, friction, rigid)
    dt = make().stable_step()
    compare(make, tmp_path, 40 * dt, (4, 9, 14), dt=0.5 * dt)


@pytest.mark.covering(1)
@pytest.mark.parametrize("rigid", (False, True))
@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("tolerance", (None, 1e-3))
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("contact", IMPLICIT)
def test_implicit_runs(contact, scheme, tolerance, law, friction, rigid, tmp_path):
    if rigid and contact == "standard basis":
        contact = "multipliers"  # obstacles take no other basis
    make = functools.partial(thrown, di.NewmarkProblem, IMPLICIT[contact], law, friction, rigid, **SCHEMES[scheme])
    when = (4, 7) if tolerance is None else (4, 13)  # steps that an error chooses are short at first
    compare(make, tmp_path, 12 * DT, when, dt=DT, tolerance=tolerance)


def test_friction_at_its_limit_is_told_as_it_was(tmp_path):
    """Of points that slide: evaluated once more, the traction is scaled to its bound again, which rounds."""
    make = functools.partial(thrown, di.NewmarkProblem, di.Penalty, "linear", 0.3, False, **SCHEMES["HHT"])
    compare(make, tmp_path, 12 * DT, (4, 7), dt=DT)
