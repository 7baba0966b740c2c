# SPDX-License-Identifier: MIT
"""Frictional impact of bodies that are cut by the ranks, against the same run on one rank, and what it must keep. See
on_ranks.py."""

import numpy as np
from dolfinx import fem
from idle_rank import working_ranks
from mpi4py import MPI
from on_ranks import on_rank_0
from partitioned_bodies import scattered

import dolfinx_impact as di
from dolfinx_impact import meshes


COMM = MPI.COMM_WORLD
STEPS, LOOKS = 1000, 20
# Of the largest entry. Two orders of the same sums differ by round-off, 1e-16 a step, 1e-13 in 1,000 steps if nothing
# amplifies it. Every time the bodies part and meet again what differs may grow, by the ratio of times between and in
# contact, some ten; they do so three or four times. Who is closed, who sticks is the same on all: no edge lies on an
# edge, no gap is zero. (Found: 2e-13 and less; the difference does not grow exponentially.)
SAME = 1e-9
METHODS = (di.Penalty, di.Kinematic)
SIZES = {
    2: {"lower": (2.5, 0.5), "upper": (0.6, 0.4), "lower_cells": (13, 3), "upper_cells": (4, 3), "offset": 0.1},
    3: {
        "lower": (2.5, 1.0, 0.5), "upper": (0.6, 0.5, 0.4), "lower_cells": (13, 5, 2), "upper_cells": (4, 3, 2),
        "offset": (0.1, 0.23),
    },
}  # fmt: skip


def blocks(comm, dim, cell=None, seed=None, degree=1, **more):
    """A small block over the left end of a long one: mesh recipe, space, whether nodes are the small one's."""
    options = {} if seed is None else {"partitioner": scattered(seed)}
    made = meshes.make("two_blocks", comm, cell=cell, **{"gap": 0.003, **SIZES[dim], **options, **more})
    V = fem.functionspace(made.mesh, ("Lagrange", degree, (dim,)))
    return made, V, V.tabulate_dof_coordinates()[:, dim - 1] > 0.5015


def thrown(comm, dim, method, speed, press=0.0, cell=None, seed=None, steps=STEPS, clamped=False, size={}, **options):
    """The small block thrown at the long one, obliquely; problem after some steps."""
    made, V, upper = blocks(comm, dim, cell, seed, **size)
    law = di.NeoHookean(1e3, 0.3, 1.0, "3d" if dim == 3 else "plane_strain")
    v = fem.Function(V)
    v.x.array.reshape(-1, dim)[upper] = speed
    tags, bcs, loads = made.tags, [], []
    if clamped:
        bottom = fem.locate_dofs_topological(V, dim - 1, made.facet_tags.find(tags["bottom"]))
        bcs = [fem.dirichletbc(np.zeros(dim), bottom, V)]
    if press:
        loads = [di.Traction(made.facet_tags, tags["top"], (0.0,) * (dim - 1) + (-press,))]
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=0.3)
    problem = di.ExplicitProblem(
        fem.Function(V), law, velocity=v, bcs=bcs, loads=loads, contact=[method(pair)], **options
    )
    dt = 0.5 * problem.stable_step()
    seen, partners = [], []
    cells = made.mesh.topology.index_map(dim).size_local
    made.mesh.topology.create_connectivity(dim - 1, dim)
    cell_of = made.mesh.topology.connectivity(dim - 1, dim)
    masters = [f for f in made.facet_tags.find(tags["master_surface"]) if cell_of.links(f)[0] < cells]
    masters = [fem.locate_dofs_topological(V, dim - 1, np.array([f]), remote=False) for f in masters]
    for part in range(LOOKS):
        problem.advance((part + 1) * steps // LOOKS * dt, dt=dt, progress=False)
        seen.append(problem.contact[0].area)
        partners.append(ranks_that_meet(comm, problem, masters))
    return problem, seen, partners


def ranks_that_meet(comm, problem, masters):
    """Of all slave nodes, by their place at rest: owner, and that of the master facet next to them (-1: open)."""
    contact, dim = problem.contact[0], problem.space.mesh.geometry.dim
    moved = problem.space.tabulate_dof_coordinates()[:, :dim] + problem.u.x.array.reshape(-1, dim)
    places = comm.allgather(np.array([moved[nodes].mean(axis=0) for nodes in masters]).reshape(-1, dim))
    owners = np.repeat(np.arange(comm.size), [len(p) for p in places])
    far = np.linalg.norm(contact.points[:, None] - np.vstack(places)[None], axis=2)
    meets = np.where(contact.status > 0, owners[np.argmin(far, axis=1)], -1)
    at_rest = problem.space.tabulate_dof_coordinates()[contact.nodes]
    rows = np.vstack(comm.allgather(np.column_stack([at_rest, np.full(len(meets), comm.rank), meets])))
    return rows[np.lexsort(rows[:, :3].round(9).T)][:, 3:].astype(int)


def by_place(comm, f):
    """Values of a nodal function of all ranks, sorted by place."""
    V = f.function_space
    n, dim = V.dofmap.index_map.size_local, V.dofmap.bs
    rows = np.hstack([V.tabulate_dof_coordinates()[:n], f.x.array[: dim * n].reshape(-1, dim)])
    rows = np.vstack(comm.allgather(rows))
    return rows[np.lexsort(rows[:, :3].round(9).T)][:, 3:]


def facts(comm, problem):
    """What two runs of the same problem must agree in. Collective."""
    contact, V = problem.contact[0], problem.space
    at_rest = V.tabulate_dof_coordinates()[contact.nodes]
    points = np.column_stack([at_rest, contact.status, contact.traction, contact.slip, contact.points])
    points = np.vstack(comm.allgather(points))
    points = points[np.lexsort(points[:, :3].round(9).T)][:, 3:]
    dim = V.mesh.geometry.dim
    return {
        **{
            name: points[:, columns]
            for name, columns in zip(
                ("status", "traction", "slip", "points"), np.split(np.arange(1 + 3 * dim), (1, 1 + dim, 1 + 2 * dim))
            )
        },
        **{name: by_place(comm, getattr(problem, name)) for name in ("u", "velocity", "acceleration")},
        **{"energies": list(problem.energy.values()), "force": contact.force, "area": contact.area},
        "dissipated": contact.dissipated,
    }


def run_alone(**case):
    """Facts of a run on rank 0 alone, and some of its numbers: largest motion, area in contact at the looks,
    part of the energy that went into friction. Collective."""

    def run():
        alone, closed, _ = thrown(MPI.COMM_SELF, **case)
        lost = alone.contact[0].dissipated / alone.energy_history[0, 1]
        return facts(MPI.COMM_SELF, alone), (np.abs(alone.u.x.array).max(), closed, lost)

    return on_rank_0(COMM, run)


def assert_same(here, there):
    for name, value in there.items():
        assert np.shape(here[name]) == np.shape(value)
        assert np.abs(np.subtract(here[name], value)).max() <= SAME * np.abs(value).max() + 1e-12, name


def check_sliding_block_is_the_same_on_all_ranks():
    """A block pressed down slides along three quarters of a clamped one, over what other ranks have of it."""
    stiff = di.Rayleigh(0.0, 1e-4)
    for dim, cell, seed, damping in (
        (2, "triangle", None, None),
        (2, "triangle", 3, None),
        (2, "triangle", 3, stiff),
        (3, "hexahedron", 3, None),
    ):
        for method in METHODS if damping is None else (di.Kinematic,):
            case = dict(
                dim=dim,
                method=method,
                cell=cell,
                damping=damping,
                speed=(3.0,) + (0.0,) * (dim - 2) + (-0.5,),
                press=6.2,  # enough that every case is in contact at the last look
            )
            alone, (moved, closed, lost) = run_alone(clamped=True, **case)
            assert moved > 0.75 and np.count_nonzero(closed) >= 3 and closed[-1] > 0 and lost > 0.3, (
                moved,
                closed,
                lost,
            )
            problem, _, partners = thrown(COMM, clamped=True, seed=seed, **case)
            assert_same(facts(COMM, problem), alone)
            if seed is not None and working_ranks(COMM) > 1:
                slave, master = np.array(partners)[..., 0], np.array(partners)[..., 1]
                assert np.any((master >= 0) & (master != slave)), "no pair is split"
                closed_on = [set(column[column >= 0]) for column in master.T]
                assert any(
                    len(ranks) > 1 for ranks in closed_on
                ), "no node has come from one rank's facets to another's"


def momenta(problem):
    """Linear and angular momentum about the origin, and the size of what they are sums of. Collective."""
    V, dim = problem.space, problem.space.mesh.geometry.dim
    n = V.dofmap.index_map.size_local
    m = problem.mass.array[: dim * n].reshape(-1, dim)
    x = V.tabulate_dof_coordinates()[:n].copy()
    x[:, :dim] += problem.u.x.array[: dim * n].reshape(-1, dim)
    p = np.zeros((n, 3))
    p[:, :dim] = m * problem.velocity.x.array[: dim * n].reshape(-1, dim)
    parts = [
        p.sum(axis=0),
        np.cross(x, p).sum(axis=0),
        [np.abs(p).sum(), (np.abs(x).max(initial=0.0) * np.abs(p)).sum()],
    ]
    sums = V.mesh.comm.allreduce(np.concatenate(parts), MPI.SUM)
    return sums[:3], sums[3:6], sums[6], sums[7]


def check_free_bodies_keep_their_momentum():
    """Linear and angular momentum of two free bodies, to 1e-12, through an oblique impact with friction: over the
    middle, over the master's rim, and with faces that are flush at the rim."""
    for dim in (2, 3):
        ends = {"offset": -0.3 if dim == 2 else (-0.3, -0.2)}
        flush = {"upper": SIZES[dim]["lower"], "offset": 0.0 if dim == 2 else (0.0, 0.0)}
        for method in METHODS:
            for size in ({}, ends, flush):
                speed = (0.7,) + (0.2,) * (dim - 2) + (-1.0,)
                start = momenta(thrown(COMM, dim, method, speed, steps=0, seed=5, size=size)[0])
                problem, closed, _ = thrown(COMM, dim, method, speed, seed=5, size=size)
                end = momenta(problem)
                assert problem.contact[0].dissipated > 0.02 * problem.energy_history[0, 1], (closed, size)
                assert np.abs(end[0] - start[0]).max() <= 1e-12 * start[2]
                assert np.abs(end[1] - start[1]).max() <= 1e-12 * start[3], (method, size)
                # Kinematic: works as in docs/explicit/energies.md. Penalty: a hundredth for each node that closes.
                drift = abs(problem.energy["drift"])
                assert drift <= (1e-12 if method is di.Kinematic else 0.02), (method, size, drift)


def check_quadratic_bodies_keep_their_momentum():
    """Likewise with displacements of degree 2 on cells of degree 1."""
    for dim, steps in ((2, STEPS), (3, 300)):
        speed = (0.7,) + (0.2,) * (dim - 2) + (-1.0,)
        for method in METHODS:
            size = {"degree": 2}
            start = momenta(thrown(COMM, dim, method, speed, steps=0, seed=5, size=size)[0])
            problem, *_ = thrown(COMM, dim, method, speed, seed=5, size=size, steps=steps)
            end = momenta(problem)
            assert problem.contact[0].dissipated > 0.01 * problem.energy_history[0, 1], (dim, method)
            assert np.abs(end[0] - start[0]).max() <= 1e-12 * start[2]
            assert np.abs(end[1] - start[1]).max() <= 1e-12 * start[3], (dim, method)


def check_deep_overlap_is_refused_at_set_up():
    """More than half a facet: an error on all ranks before any step; less is taken. Deformable and rigid masters."""
    facet = {2: 2.5 / 13, 3: np.hypot(2.5 / 13, 1.0 / 5)}  # of the master; longest distance between corners
    slave = {2: 0.6 / 4, 3: np.hypot(0.6 / 4, 0.5 / 3)}  # rigid masters have none
    for dim in (2, 3):
        up = (0.0,) * (dim - 1) + (1.0,)
        for method in METHODS:
            for rigid in (False, True):
                for part in (0.45, 0.55):
                    deep = part * (slave if rigid else facet)[dim]
                    made, V, _ = blocks(COMM, dim, seed=2, gap=-0.003 if rigid else -deep)
                    tags, low = made.tags, 0.5 - 0.003 + deep  # of the plane: the upper block begins at 0.497
                    master = di.RigidPlane((0.0,) * (dim - 1) + (low,), up) if rigid else tags["master_surface"]
                    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], master)
                    law = di.NeoHookean(1e3, 0.3, 1.0, "3d" if dim == 3 else "plane_strain")
                    try:
                        di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V), contact=[method(pair)])
                        said = ""
                    except ValueError as error:
                        said = str(error)
                    assert ("overlap at the start" in said) == (part > 0.5), (dim, method, rigid, part, said)
                    assert len(set(COMM.allgather(said))) == 1
