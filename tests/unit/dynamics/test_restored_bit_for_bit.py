# SPDX-License-Identifier: MIT
"""A restored run is the uninterrupted one, bit for bit on one rank: motion, energies and contact forces of every step,
explicit and implicit, for all kinds of contact, laws and schemes."""

import functools

import numpy as np
import pytest
import stable_step_checks
from dolfinx import fem, mesh
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


def divided(tag, moved=0):
    """Tags of the blocks, a surface in two parts: 0.6 of it keeps its tag, the others get 99.

    Args:
        moved: number of facets by which the second part is larger.
    """
    made = blocks()
    facets, values = made.facet_tags.indices, made.facet_tags.values.copy()
    of_tag = np.flatnonzero(values == tag)
    along = mesh.compute_midpoints(made.mesh, 1, facets[of_tag])[:, 0]
    values[of_tag[np.argsort(along)][int(0.6 * len(of_tag)) - moved :]] = 99
    return mesh.meshtags(made.mesh, 1, facets, values)


def pairs_that_share(how, friction, contact, moved=0, order=1):
    """Two contacts with common slave nodes: a slave or a master in two tags, a block on two planes at an angle, or each
    surface the slave of the other one."""
    slave, master = (blocks().tags[name] for name in ("slave_surface", "master_surface"))
    tags, pairs = blocks().facet_tags, [(slave, master), (master, slave)]
    if how == "slave in two":
        tags, pairs = divided(slave, moved), [(slave, master), (99, master)]
    elif how == "master in two":
        tags, pairs = divided(master, moved), [(slave, master), (slave, 99)]
    elif how == "groove":
        c, s = np.cos(0.3), np.sin(0.3)  # 34 degrees between them: nodes have a condition for each
        planes = [di.RigidPlane((at, 0.502), (lean * s, c)) for at, lean in ((0.2, 1), (1.2, -1))]
        tags, pairs = divided(slave, moved), [(slave, planes[0]), (slave, planes[1])]
    return [contact(di.ContactPair(tags, *pair, friction=friction)) for pair in pairs[::order]]


def thrown(kind, contact, law, friction, rigid, shared=None, **options):
    """A block thrown obliquely on a block, or on a plane, that moves up and down; problem in time, not run yet.

    Args:
        shared: arguments of `pairs_that_share`, for contacts with common nodes.
    """
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
    contacts = [contact(pair)] if shared is None else pairs_that_share(friction=friction, contact=contact, **shared)
    return kind(
        u, LAWS[law](), velocity=v, bcs=[moving], loads=loads, contact=contacts, damping=di.Rayleigh(0.1, 1e-5),
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
    assert whole.step > max(when) + 2 and np.any(np.array(whole.force_history)[:, : max(when)] != 0.0)
    for step in when:
        again = make()
        again.restore(path / f"{step}.h5")
        np.testing.assert_array_equal(state(again), states[step])
        again.advance(end, callback=keep, progress=False, **steps)
        np.testing.assert_array_equal(state(again), state(whole))
        rows = whole.step - step
        assert len(again.energy_history) == rows
        np.testing.assert_array_equal(again.energy_history[-rows:], whole.energy_history[-rows:])
        for ours, others in zip(again.force_history, whole.force_history):
            np.testing.assert_array_equal(ours[-rows:], others[-rows:])


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


@pytest.mark.parametrize("cell", ("triangle", "quadrilateral"))
def test_steps_that_follow_the_body(cell, tmp_path):
    """Of a body that is struck hard: steps are shortened on the way, where the stable step is looked at again, also one
    step after the checkpoint."""

    def make():
        block = stable_step_checks.Block(cell, comm=MPI.COMM_SELF)
        block.velocity.interpolate(lambda x: np.vstack([0.0 * x[1 : block.dim], 0.0 * x[0] - 0.4]))
        law = di.NeoHookean(1.0, 0.3, 1.0, block.hypothesis)
        return di.ExplicitProblem(block.u, law, velocity=block.velocity, contact=[di.Penalty(block.pair)])

    looks = stable_step_checks.Looks(problem := make())
    problem.advance(2.0, progress=False)
    assert looks.times > 5 and problem.step > 1.05 * 2.0 / (0.9 * make().stable_step())
    compare(make, tmp_path, 2.0, tuple(range(3, problem.step - 3, 2)))


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


SHARED = ("slave in two", "master in two", "groove", "both ways")
TABLES = [
    *((di.ExplicitProblem, contact, how) for contact in ("kinematic", "penalty") for how in SHARED),
    # Multipliers refuse two pairs of which each has the other's slave for its master.
    *((di.NewmarkProblem, contact, how) for contact in ("multipliers", "penalty") for how in SHARED[:3]),
]

# Springs act at each point or node on its own; a divided master has the equations of a divided slave.
REPEATED = (("penalty", "slave in two"), ("penalty", "both ways"), ("multipliers", "master in two"))


def sharing(kind, contact, how, friction, law="linear", **of_pairs):
    """Function that makes a problem with common nodes, and its steps."""
    table = EXPLICIT if kind is di.ExplicitProblem else IMPLICIT
    make = functools.partial(thrown, kind, table[contact], law, friction, False, {"how": how, **of_pairs})
    return make, DT if kind is di.NewmarkProblem else 0.5 * make().stable_step()


@pytest.mark.long_rows(where=lambda contact, how, friction: not friction or (contact, how) in REPEATED)
@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("kind, contact, how", TABLES)
def test_pairs_with_common_nodes(kind, contact, how, friction, tmp_path):
    explicit = kind is di.ExplicitProblem
    make, dt = sharing(kind, contact, how, friction, law="neo-Hookean" if explicit else "linear")
    compare(make, tmp_path, (40 if explicit else 12) * dt, (4, 9, 14) if explicit else (4, 7), dt=dt)


@pytest.mark.long_rows(where=lambda contact, how: contact == "penalty" or (contact, how) in REPEATED)
@pytest.mark.parametrize("kind, contact, how", TABLES)
def test_other_pairs_with_common_nodes_are_refused(kind, contact, how, tmp_path):
    """The same pairs in another order, and one facet that is in the other one's tag."""
    make, dt = sharing(kind, contact, how, 0.3)
    problem = make()
    problem.advance(4 * dt, dt=dt, progress=False)
    problem.save(tmp_path / "a.h5")
    others = {"order": -1} if how == "both ways" else {"order": -1, "moved": 1}
    for name, value in others.items():
        other = sharing(kind, contact, how, 0.3, **{name: value})[0]()
        before = other.u.x.array.copy()
        with pytest.raises(ValueError, match="of another problem.*contact"):
            other.restore(tmp_path / "a.h5")
        np.testing.assert_array_equal(other.u.x.array, before)
    same = make()
    same.restore(tmp_path / "a.h5")
    np.testing.assert_array_equal(state(same), state(problem))
