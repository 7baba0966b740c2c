# SPDX-License-Identifier: MIT
"""Problems on meshes of which a rank owns no cell, as with more ranks than cells. See on_ranks.py.

A partitioner gives all cells to one rank, the first or the last, so that any number of ranks shows it.
"""

import functools
import itertools

import basix.ufl
import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder
from idle_rank import working_ranks

import dolfinx_impact as di
from dolfinx_impact import compat, meshes
from dolfinx_impact.io.run_folder import RunFolder, vertex_average

COMM = MPI.COMM_WORLD
OWNERS = (COMM.size - 1, 0)  # by turns: rank 0, which writes files, has all cells or none
DT = 4e-3
ELASTIC = functools.partial(di.LinearElastic, 1e3, 0.3, 1.0, "plane_strain")
PLASTIC = functools.partial(
    di.J2Plasticity, 1e3, 0.3, density=1.0, yield_stress=5.0, hardening=50.0, hypothesis="plane_strain"
)


def all_cells_on(owner):
    """Partitioner of create_mesh that sends every cell to one rank."""

    def partition(comm, num_ranks, cell_types, cells):
        num_cells = len(cells[0]) // 4  # quadrilaterals
        return compat.adjacencylist(np.full((num_cells, 1), owner, dtype=np.int32))

    return partition


@functools.cache
def blocks(owner):
    """Two blocks with a small gap."""
    size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (4, 2), "upper_cells": (3, 2)}
    made = meshes.make("two_blocks", COMM, gap=2e-3, partitioner=all_cells_on(owner), **size)
    num_cells = made.mesh.topology.index_map(2).size_local
    assert working_ranks(COMM) < COMM.size or (num_cells > 0) == (COMM.rank == owner)
    return made


def thrown(owner, kind, contact, law=PLASTIC, **options):
    """A block thrown obliquely on another one, with every kind of load; problem in time, not run yet."""
    made = blocks(owner)
    tags = made.tags
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    v.x.array.reshape(-1, 2)[np.unique(V.dofmap.list[made.cell_tags.find(tags["slave_body"])])] = (0.5, -1.0)
    v.x.scatter_forward()
    bottom = fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags["bottom"]))
    moving = di.PrescribedMotion(fem.dirichletbc(np.array([0.0, 0.002]), bottom, V), lambda t: np.sin(20 * t) ** 2)
    material = di.MaterialMap(made.cell_tags, {tags["slave_body"]: law(), tags["master_body"]: law()})
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=0.3)
    facets = made.facet_tags
    loads = [
        di.BodyForce((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t)), di.Traction(facets, tags["top"], (0.0, -0.1)),
        di.FollowerPressure(facets, tags["top"], 0.1), di.Foundation(facets, tags["top"], 0.1, 1e-3),
        di.AddedMass(facets, tags["top"], 0.1),
    ]  # fmt: skip
    return kind(u, material, velocity=v, bcs=[moving], loads=loads, contact=[contact(pair)], **options)


def goes_on(make, path, until, **steps):
    """Run with a recorder, save, go on; another problem that is restored does the same."""
    whole = make()
    recorder = whole.record(path / "run", fields=("displacement", "stress"), every=3, points=[[0.7, 1.0]])
    whole.advance(until, progress=False, **steps)
    whole.save(path / "run.h5")
    recorder.close()
    again = make()
    again.restore(path / "run.h5")
    for problem in (whole, again):
        problem.advance(1.5 * until, progress=False, **steps)
    assert whole.energy["friction"] > 0.0 and np.isfinite(whole.energy["total"])
    # MUMPS does not sum in the same order twice on several ranks: to the tolerance of Newton's method.
    close = 1e-8 if COMM.size > 1 and isinstance(whole, di.NewmarkProblem) else 0.0
    np.testing.assert_allclose(again.contact[0].force, whole.contact[0].force, rtol=close)
    np.testing.assert_allclose(again.u.x.array, whole.u.x.array, rtol=0.0, atol=close)


def check_explicit_runs():
    contacts = (di.Penalty, functools.partial(di.Penalty, balanced=True), di.Kinematic)
    options = {"bulk_viscosity": (0.06, 1.2), "mass_scaling": 2e-4, "damping": di.Rayleigh(0.1, 1e-6)}
    for contact, owner in zip(contacts, itertools.cycle(OWNERS)):
        with shared_folder() as path:
            goes_on(lambda c=contact, o=owner: thrown(o, di.ExplicitProblem, c, **options), path, 0.03)


def check_implicit_runs():
    contacts = (di.Lagrange, functools.partial(di.Penalty, penalty=1e5))
    for contact, owner in zip(contacts, OWNERS):
        with shared_folder() as path:
            goes_on(lambda c=contact, o=owner: thrown(o, di.NewmarkProblem, c, rho_inf=0.8), path, 5 * DT, dt=DT)


def check_static_problems_and_their_output():
    contacts = (
        di.Lagrange, functools.partial(di.Lagrange, basis="standard"), di.Penalty,
        functools.partial(di.Penalty, augmented=True),
    )  # fmt: skip
    for contact, owner in zip(contacts, itertools.cycle(OWNERS)):
        problem = pressed(owner, contact, smooth=True)
        c, law = problem.contact[0], problem.material
        field = c.field(problem, c.pressure, "pressure")
        assert COMM.allreduce(np.abs(field.x.array).max(initial=0.0), MPI.MAX) > 1.0
        stress = vertex_average(law.stress(problem.u)[1, 1], problem.space.mesh, "stress")
        assert COMM.allreduce(stress.x.array.min(initial=0.0), MPI.MIN) < -1.0
        with shared_folder() as path, RunFolder(path, {}) as run:
            run.fields("solution", [problem.u, stress])


def check_runs_that_begin_with_an_equilibrium():
    for owner in OWNERS:
        static = pressed(owner, di.Lagrange, law=PLASTIC)
        springs = di.Penalty(static.contact[0].pair)
        explicit = di.ExplicitProblem.from_static(static, contact=[springs], bcs=held(static.space, blocks(owner)))
        explicit.advance(3 * explicit.stable_step(), progress=False)
        assert explicit.contact[0].force[1] > 1.0


def held(V, made):
    """The lower block stands, the upper one is pressed down."""
    at = {
        name: fem.locate_dofs_topological(V, 1, made.facet_tags.find(made.tags[name])) for name in ("bottom", "top")
    }  # fmt: skip
    return [fem.dirichletbc(np.zeros(2), at["bottom"], V), fem.dirichletbc(np.array([0.0, -0.01]), at["top"], V)]


def pressed(owner, contact, law=ELASTIC, **of_pair):
    """Static problem of the two blocks, solved."""
    made = blocks(owner)
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    surfaces = made.tags["slave_surface"], made.tags["master_surface"]
    pair = di.ContactPair(made.facet_tags, *surfaces, friction=0.3, **of_pair)
    problem = di.StaticProblem(fem.Function(V), law(), bcs=held(V, made), contact=[contact(pair)])
    assert problem.solve().converged and problem.contact[0].force[1] > 1.0
    return problem


def ring(owner):
    """A ring with 2 cells across."""
    cells, x, quads = 24, np.zeros((0, 2)), np.zeros((0, 4), dtype=np.int64)
    if COMM.rank == 0:
        r, angle = np.linspace(0.5, 1.0, 3), 2 * np.pi * np.arange(cells) / cells
        x = np.array([[a * np.cos(t), a * np.sin(t)] for t in angle for a in r])
        node = 3 * np.arange(cells)
        after = np.roll(node, -1)
        quads = np.array([[n + i, n + i + 1, m + i, m + i + 1] for n, m in zip(node, after) for i in range(2)])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    return mesh.create_mesh(COMM, quads, x=x, e=element, partitioner=all_cells_on(owner))


def wheel(owner, law, friction, approach, contact=di.Lagrange):
    """A wheel that rolls on a rigid plane."""
    domain = ring(owner)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    rim = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > 0.9)
    tags = mesh.meshtags(domain, 1, np.sort(rim), np.full(len(rim), 7, np.int32))
    num = domain.topology.index_map(2).size_local
    body = mesh.meshtags(domain, 2, np.arange(num, dtype=np.int32), np.full(num, 1, np.int32))
    hub = fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < 0.51)
    plane = di.RigidPlane((0.0, -1.0), (0.0, 1.0))
    plane.velocity = (-1.0, 0.0)
    spin, pair = di.Spin((0, 0), (0, 0, 1), -1.0), di.ContactPair(tags, 7, plane, friction=friction)
    bcs = [fem.dirichletbc(np.array([0.0, -approach]), hub, V)]
    return di.RollingProblem(fem.Function(V), law(), body, {1: spin}, contact=[contact(pair)], bcs=bcs)


def check_rolling():
    """A curve of creep in a file, a body whose plastic flow turns with it, and a wheel that touches nothing."""
    with shared_folder() as path:
        curve = wheel(OWNERS[0], ELASTIC, 0.3, 0.002).sweep(creep=[0.0, 2e-3], file=path / "a.h5", progress=False)
    assert curve["force"][0, 1] > 0.0
    assert wheel(OWNERS[1], PLASTIC, 0.0, 0.002).solve().converged
    apart = wheel(OWNERS[1], ELASTIC, 0.3, -0.1).sweep(creep=[0.0, 2e-3], progress=False)
    np.testing.assert_array_equal(apart["force"], 0.0)


def check_frequencies_of_a_wheel():
    """SLEPc's vectors have no rows on the idle rank. 1e-8: the eigensolver's tolerance is 1e-10."""
    found = []
    for owner in (*OWNERS, 0):
        problem = wheel(owner, ELASTIC, 0.0, 0.002, di.Penalty)
        problem.solve()
        found.append(problem.frequencies(3))
    assert found[0].shape == (3,) and np.all(found[0] != 0.0)
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=1e-8)
