# SPDX-License-Identifier: MIT
"""What tells one explicit problem from another, the same on any number of ranks: what a checkpoint is compared by.

Texts and whole numbers are compared exactly, numbers with all their digits. Sums over nodes are compared to round-off,
as their order depends on the ranks.
"""

import hashlib

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

LONG = 2000  # characters of a text that are kept; of longer ones a checksum


def signature(problem, x):
    """Dict of texts, whole numbers and, under "sums", arrays. Collective.

    Args:
        x: reference positions of this rank's owned nodes, (n, gdim) [L].
    """
    V, mesh, comm = problem.space, problem.space.mesh, problem.comm
    n, bs = V.dofmap.index_map.size_local, V.dofmap.index_map_bs
    mass = problem.mass.array[: n * bs].reshape(n, bs)[:, 0]
    out = {
        "cell": mesh.topology.cell_name(),
        "degree": int(V.element.basix_element.degree),
        "degree of the geometry": int(mesh.geometry.cmap.degree),
        "num_cells": int(mesh.topology.index_map(mesh.topology.dim).size_global),
        "num_nodes": int(V.dofmap.index_map.size_global),
        "material": _material(problem),
        "damping": f"alpha {problem.damping.alpha!r}, beta {problem.damping.beta!r}",
        "bulk viscosity": repr(problem._viscosity),
        "lumping": repr(problem.lumping),
        "mass scaling": repr(problem.mass_scaling),
        "scheme": problem.scheme,
        "loads": "; ".join(_load(load, mesh) for load in problem.loads),
        "contact": "; ".join(_contact(c, mesh) for c in problem.contact),
        "sums of masses": comm.allreduce(np.concatenate([[mass.sum()], mass @ x, mass @ x**2]), MPI.SUM),
    }
    for k, load in enumerate(problem._loads):
        # As it would act now: its value may have been changed since the last step.
        values = np.zeros(n * bs)
        values[load.dofs] = load.forces()
        values = values.reshape(n, bs)
        out[f"sums of load {k}"] = comm.allreduce(
            np.concatenate([[np.abs(values).sum()], values.sum(axis=0), *(values.T @ x)]), MPI.SUM
        )
    return {name: short(value) if isinstance(value, str) else value for name, value in out.items()}


def supports(problem):
    """Prescribed degrees of freedom: owned nodes, and for each component whether it is prescribed, its value [L], and
    the number of its function of time (-1: none)."""
    bs = problem.space.dofmap.index_map_bs
    rows = np.zeros((problem.num_owned, 3))
    rows[:, 2] = -1
    for dofs, values, column in problem._supports:
        rows[dofs] = np.column_stack([np.ones(len(dofs)), values, np.full(len(dofs), column)])
    rows = rows.reshape(-1, bs, 3)
    nodes = np.flatnonzero(rows[:, :, 0].any(axis=1))
    return nodes, np.ascontiguousarray(rows[nodes].transpose(0, 2, 1)).reshape(-1, 3 * bs)


def functions_of_time(functions, time, beyond):
    """Values of all functions of time up to the present, as a flat array."""
    times = np.append(np.linspace(0.0, time, 5), beyond)
    return functions.table(times).ravel()


def short(text):
    if len(text) <= LONG:
        return text
    return f"{text[: LONG // 10]}... (checksum {hashlib.blake2b(text.encode(), digest_size=16).hexdigest()})"


def _marks(comm, numbers):
    """Count and checksum of numbers over all ranks, each known on one rank, in any order. Collective."""
    x = np.asarray(numbers, dtype=np.uint64) + np.uint64(0x9E3779B97F4A7C15)
    for factor, shift in ((0xBF58476D1CE4E5B9, 30), (0x94D049BB133111EB, 27)):  # as the generator splitmix64 mixes
        x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
    sums = np.array([len(x), (x ^ (x >> np.uint64(31))).sum(dtype=np.uint64)], dtype=np.uint64)
    comm.Allreduce(MPI.IN_PLACE, sums, MPI.SUM)
    return f"{sums[0]} of checksum {sums[1]:x}"


def _cells(tags, tag):
    """The cells with a tag, by their numbers in the mesh's input. Collective."""
    topology = tags.topology
    cells = tags.find(tag)
    cells = cells[cells < topology.index_map(topology.dim).size_local]
    return f"cells {_marks(topology.comm, topology.original_cell_index[cells])}"


def _facets(mesh, tags, tag):
    """The facets of the boundary with a tag, by the numbers of their cells in the mesh's input and their own there.
    Collective."""
    topology, dim = mesh.topology, mesh.topology.dim
    topology.create_connectivity(dim - 1, dim)
    topology.create_connectivity(dim, dim - 1)
    to_cell, to_facet = topology.connectivity(dim - 1, dim), topology.connectivity(dim, dim - 1)
    facets = tags.find(tag)
    cells = to_cell.array[to_cell.offsets[facets]]
    own = cells < topology.index_map(dim).size_local
    facets, cells = facets[own], cells[own]
    around = to_facet.array.reshape(to_facet.num_nodes, -1)[cells]
    local = np.argmax(around == facets[:, None], axis=1)
    return f"facets {_marks(mesh.comm, 8 * topology.original_cell_index[cells] + local)}"


def _material(problem):
    if problem.material is not None:
        tags = problem.material.cell_tags
        parts = [
            repr(m) if tag is None else f"{tag}: {m!r} on {_cells(tags, tag)}" for tag, m in problem.material.parts()
        ]
        return ", ".join(parts)
    constants = [np.asarray(c.value).tolist() for c in problem._residual_form.constants()]
    density = problem._given_density
    if isinstance(density, ufl.core.expr.Expr):
        density = (density * ufl.dx(domain=problem.space.mesh)).signature()[:32]
    return f"a residual of one's own, {problem._residual_form.signature()[:32]}, {constants!r}, density {density!r}"


def _load(load, mesh):
    """Kind, place and value; that of `constant`, which may have been changed since the load was made."""
    words = [type(load).__name__]
    if hasattr(load, "per_mass"):
        words.append("per mass" if load.per_mass else "per volume")
    if hasattr(load, "tag"):
        words.append(f"tag {load.tag}, {_facets(mesh, load.facet_tags, load.tag)}")
    constant = getattr(load, "constant", None)
    if isinstance(constant, fem.Constant):
        words.append(f"constant.value {np.asarray(constant.value).tolist()!r}")
    words.append("with an amplitude" if getattr(load, "amplitude", None) is not None else "without amplitude")
    return ", ".join(words)


def _contact(contact, mesh):
    pair = contact.pair
    master = pair.master
    if pair.rigid:
        numbers = [np.asarray(v).tolist() for v in (master._point, master._direction, master._radius)]
        numbers += [master._checksum] if master._checksum else []
        motion = "with" if master.motion is not None else "without"
        master = f"rigid {master._kind} {numbers!r} at {master.displacement.tolist()!r} {motion} motion"
    else:
        master = f"master {master}, {_facets(mesh, pair.facet_tags, master)}"
    slave = f"slave {pair.slave}, {_facets(mesh, pair.facet_tags, pair.slave)}"
    options = ", ".join(f"{name} {value!r}" for name, value in sorted(contact.options.items()))
    limits = f"friction {pair.friction!r}, search distance {pair.search_distance!r}"
    return f"{slave}, {master}, {limits}, {contact._law.__name__}, {options}"
