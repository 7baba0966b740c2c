# SPDX-License-Identifier: MIT
"""Meshes shared out anew: the same mesh with the same tags, and equal work, by what the ranks compute. See
on_ranks.py."""

import itertools

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from empty_rank_checks import all_cells_on
from mpi4py import MPI
from partitioned_bodies import scattered
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact.common.cell_numbers import input_cell_numbers
from dolfinx_impact.compat import geometry_dofmap

COMM = MPI.COMM_WORLD
NODE_COST = 3.0
BALANCED = 0.10  # the largest work over the mean, less one: what a step may lose to waiting
SIZE = {"lower": (1.1, 1.1, 0.5), "upper": (1.0, 1.0, 0.5)}


def blocks(cell="hexahedron", degree=1, n=10, **options):
    """Two blocks of n x n x n/2 cells each, of which the upper one's lower face is the slave."""
    counts = {"lower_cells": (n, n, n // 2), "upper_cells": (n, n, n // 2)}
    return meshes.make("two_blocks", COMM, cell=cell, degree=degree, gap=0.01, **SIZE, **counts, **options)


def measures(domain, cell_tags, facet_tags):
    """Volume and area by tag, and their first moments, of all ranks."""
    x, found = ufl.SpatialCoordinate(domain), {}
    for kind, tags in (("dx", cell_tags), ("ds", facet_tags)):
        for tag in sorted(set().union(*COMM.allgather(set(tags.values.tolist())))):
            measure = getattr(ufl, kind)(domain=domain, subdomain_data=tags)(tag)
            for integrand in (fem.Constant(domain, 1.0), x[0] + 2 * x[1] + 3 * x[2]):
                value = fem.assemble_scalar(ffcx_form(integrand * measure))
                found.setdefault((kind, tag), []).append(COMM.allreduce(value))
    return found


def check_mesh_and_tags_come_along():
    """Volumes, areas and centroids by tag, of hexahedra and of curved-sided tetrahedra, to round-off of sums."""
    for cell, degree in (("hexahedron", 1), ("tetrahedron", 2)):
        made = blocks(cell, degree, 6, **({"partitioner": scattered(4)} if COMM.size > 1 else {}))
        shared = di.partition(made.mesh, made.cell_tags, made.facet_tags)
        domain, cells, facets = shared
        assert isinstance(shared, di.PartitionedMesh)
        assert domain.topology.index_map(3).size_global == made.mesh.topology.index_map(3).size_global
        assert domain.topology.index_map(3).num_ghosts == 0
        assert domain.geometry.index_map().size_global == made.mesh.geometry.index_map().size_global
        before, after = (measures(*m) for m in ((made.mesh, made.cell_tags, made.facet_tags), (domain, cells, facets)))
        assert before.keys() == after.keys() and cells.name == made.cell_tags.name
        for key, values in before.items():
            assert np.allclose(after[key], values, rtol=1e-12), key


def contact_problem(domain, facet_tags, tags):
    """The upper block, which slides on the lower one with friction."""
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    pair = di.ContactPair(facet_tags, slave=tags["slave_surface"], master=tags["master_surface"], friction=0.3)
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: np.where(x[2] > 0.505, 1.0, 0.0) * np.array([[1.0], [0.3], [-2.0]]))
    law = di.LinearElastic(1e3, 0.3, 1.0, "3d")
    return di.ExplicitProblem(fem.Function(V), law, velocity=velocity, contact=[di.Penalty(pair)])


def contact_run(*given):
    """Some steps of it."""
    problem = contact_problem(*given)
    problem.advance(0.02, progress=False)
    return problem


def work_of(problem):
    """Cells that this rank's kernels compute in a step, and what its slave nodes cost beside them."""
    parts = [part._cpp_object for part in problem._bodies.internal._parts]
    per_cell = problem._bodies.internal._parts[0]._kernels[0].flops
    return sum(part.flops for part in parts) / per_cell + NODE_COST * len(problem.contact[0].nodes)


def imbalance(work):
    """Largest over the mean, less one."""
    return COMM.allreduce(work, MPI.MAX) * COMM.size / COMM.allreduce(work) - 1.0


def check_equal_work():
    """Ranks compute equal numbers of cells and slave nodes, as `imbalance` says; the run is the same."""
    made = blocks(n=10 if COMM.size < 8 else 16)  # a node that one rank or another owns is 4 % of 60 cells
    shared = di.partition(made.mesh, None, made.facet_tags, slave=[made.tags["slave_surface"]], node_cost=NODE_COST)
    problem, before = (contact_run(m, t, made.tags) for m, t in (
        (shared.mesh, shared.facet_tags), (made.mesh, made.facet_tags)))  # fmt: skip
    assert shared.cell_tags is None and work_of(problem) == pytest.approx(shared.work, rel=1e-12)
    assert imbalance(work_of(problem)) == pytest.approx(shared.imbalance, abs=1e-12) and shared.imbalance < BALANCED
    # Sums in another order: round-off of 100 steps, 1e-14 each, of nodes that part and meet a few times.
    assert np.allclose(problem.contact[0].force, before.contact[0].force, rtol=1e-9)
    assert problem.energy["kinetic"] == pytest.approx(before.energy["kinetic"], rel=1e-9)


def places_by_number(domain):
    """Vertices of the cells and places of the nodes by their numbers in the mesh's input, of all ranks; cells come with
    the order of their nodes, by which facets are told."""
    num, nodes = domain.topology.index_map(domain.topology.dim).size_local, domain.geometry.index_map().size_local
    x = domain.geometry.x
    cells = zip(input_cell_numbers(domain.topology)[:num].tolist(), x[geometry_dofmap(domain)[:num]])
    points = zip(domain.geometry.input_global_indices[:nodes].tolist(), x[:nodes])
    found = [dict(pair for rank in COMM.allgather(list(given)) for pair in rank) for given in (cells, points)]
    assert [len(numbers) for numbers in found] == [domain.topology.index_map(domain.topology.dim).size_global,
                                                   domain.geometry.index_map().size_global]  # fmt: skip
    return found


def check_input_numbers_stay():
    """Cells and nodes keep the numbers of the first mesh's input, also where a mesh is shared out twice: of all cells,
    straight and curved. Coordinates are copied, so that they agree to the last bit."""
    for cell, degree in itertools.product(("triangle", "quadrilateral", "tetrahedron", "hexahedron"), (1, 2)):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        size = {} if dim == 3 else {"lower": (1.1, 0.5), "upper": (1.0, 0.5)}
        counts = {"lower_cells": (4,) * dim, "upper_cells": (3,) * dim}
        given = {"partitioner": scattered(4)} if COMM.size > 1 else {}
        made = meshes.make("two_blocks", COMM, cell=cell, degree=degree, **counts, **({**SIZE, **size}), **given)
        once = di.partition(made.mesh, None, made.facet_tags, slave=made.tags["slave_surface"])
        twice = di.partition(once.mesh, cell_cost=lambda x: 1.0 + 20.0 * (x[:, 0] > 0.4))
        before = places_by_number(made.mesh)
        for shared in (once, twice):
            for was, now in zip(before, places_by_number(shared.mesh)):
                assert was.keys() == now.keys() and all(np.array_equal(was[k], now[k]) for k in was), (cell, degree)


def check_submesh():
    """A submesh has no input: what is made of it has numbers, each once."""
    whole = mesh.create_unit_square(COMM, 6, 5, mesh.CellType.quadrilateral)
    kept = mesh.locate_entities(whole, 2, lambda x: x[0] < 0.7)
    shared = di.partition(mesh.create_submesh(whole, 2, kept)[0])
    cells, _ = places_by_number(shared.mesh)
    assert sorted(cells) == list(range(4 * 5))


def check_checkpoints_of_other_partitions():
    """A run that was saved on a mesh shared out goes on where the mesh is shared out in another way, and on the mesh
    that was given."""
    made = blocks(n=6)
    dear = {"cell_cost": lambda x: 1.0 + 5.0 * (x[:, 0] > 0.3)}
    shared = [di.partition(made.mesh, None, made.facet_tags, **given) for given in ({}, dear)]
    others = [(m.mesh, m.facet_tags, made.tags) for m in (shared[1], made)]
    run = contact_problem(shared[0].mesh, shared[0].facet_tags, made.tags)
    run.advance(0.01, progress=False)
    with shared_folder() as folder:
        run.save(folder / "run.h5")
        run.advance(0.02, progress=False)
        for given in others:
            again = contact_problem(*given)
            again.restore(folder / "run.h5")
            again.advance(0.02, progress=False)
            assert again.step == run.step
            # Sums in another order, as in check_equal_work.
            assert np.allclose(again.contact[0].force, run.contact[0].force, rtol=1e-9)
            assert again.energy["friction"] == pytest.approx(run.energy["friction"], rel=1e-9) != 0.0


def check_dear_cells():
    """A cost of cells counts: where it is ten, ranks have fewer of them."""
    domain = mesh.create_unit_square(COMM, 24, 24)
    shared = di.partition(domain, cell_cost=lambda x: np.where(x[:, 0] < 0.25, 10.0, 1.0))
    middles = mesh.compute_midpoints(shared.mesh, 2, np.arange(shared.mesh.topology.index_map(2).size_local))
    assert shared.work == pytest.approx(np.where(middles[:, 0] < 0.25, 10.0, 1.0).sum(), rel=1e-14)
    assert shared.imbalance < BALANCED and shared.mesh.geometry.dim == 2


def check_bad_arguments():
    """Are refused on all ranks."""
    domain = mesh.create_unit_square(COMM, 4, 4)
    facets = mesh.meshtags(domain, 1, np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))
    others = mesh.create_unit_square(COMM, 2, 2)
    foreign = mesh.meshtags(others, 1, np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))
    for error, words, given in (
        (TypeError, "MeshTags", {"cell_tags": 3}),
        (ValueError, "dimension 2", {"cell_tags": facets}),
        (ValueError, "facet_tags", {"slave": [1]}),
        (ValueError, "no facet of facet_tags has the tag 7", {"facet_tags": facets, "slave": 7}),
        (ValueError, "facet_tags: the tags are of another mesh", {"facet_tags": foreign}),
        (ValueError, "node_cost", {"node_cost": -1.0}),
        (ValueError, "all cells cost nothing", {"cell_cost": lambda x: 0.0 * x[:, 0]}),
        (ValueError, "negative", {"cell_cost": lambda x: -np.ones(len(x))}),
        (ValueError, "midpoints", {"cell_cost": lambda x: np.ones(3)}),
    ):
        with pytest.raises(error, match=words):
            di.partition(domain, **given)
    with pytest.raises(TypeError, match="mesh"):
        di.partition(None)


def check_ranks_without_cells():
    """A rank that owns no cell of the mesh that is given, or of what is made of it."""
    for owner in (0, COMM.size - 1):
        given = {"partitioner": all_cells_on(owner)} if COMM.size > 1 else {}
        domain = mesh.create_unit_square(COMM, 6, 4, mesh.CellType.quadrilateral, **given)
        side = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 1.0))
        tags = mesh.meshtags(domain, 1, side, np.full(len(side), 3, dtype=np.int32))
        shared = di.partition(domain, None, tags, slave=3)
        ds = ufl.ds(domain=shared.mesh, subdomain_data=shared.facet_tags)
        found = [
            fem.assemble_scalar(ffcx_form(fem.Constant(shared.mesh, 1.0) * d)) for d in (ufl.dx(shared.mesh), ds(3))
        ]
        assert np.allclose(COMM.allreduce(np.array(found)), 1.0, rtol=1e-13)
        assert COMM.allreduce(shared.work) == 24 + 7 * NODE_COST and shared.mesh.topology.index_map(2).size_local > 0
    one = di.partition(mesh.create_unit_cube(COMM, 1, 1, 1, mesh.CellType.hexahedron))
    assert one.mesh.topology.index_map(3).size_global == 1 and COMM.allreduce(one.work) == 1.0
    assert one.imbalance == pytest.approx(COMM.size - 1.0)
