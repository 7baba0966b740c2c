# SPDX-License-Identifier: MIT
"""Cost of a static contact solve, as a multiple of one linear solve of the same bodies tied together.

A round body is pressed on a flat one without friction, in one load step from first contact to Hertz's pressure. Both
solves run in the same process with the same linear solver and tolerance.
"""

import time
from collections.abc import Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import DirichletBC
from mpi4py import MPI

from dolfinx_impact import _cpp
from dolfinx_impact import materials, meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.contact.mortar.lagrange import Lagrange, LagrangeContact
from dolfinx_impact.contact.pair import ContactPair
from dolfinx_impact.statics.static_problem import StaticProblem
from .rows import Job, Row, row
from .setup import most_memory

RTOL = 1e-10
# (name, cell, mesh size at the contact, of the largest cells): half-width 1, bodies of size 12, radius 50
CASES = (
    ("30k unknowns", "quadrilateral", 0.075, 1.0),
    ("30k unknowns", "hexahedron", 0.16, 12.0),
)
LARGE = (
    ("300k unknowns", "quadrilateral", 0.023, 0.29),
    ("300k unknowns", "hexahedron", 0.056, 12.0),
    ("one million unknowns", "hexahedron", 0.0345, 12.0),
)
SOLVE = "static contact solve / tied linear solve"
MEMORY = 24.0  # of a machine that one million unknowns shall fit in [GB]


@lru_cache(maxsize=1)
def pressed_mesh(cell: str, h: float, coarse: float) -> Any:
    """Mesh of the two bodies, which the solves of a case share.

    Args:
        cell: "quadrilateral" or "hexahedron".
        h: mesh size at the contact [L].
        coarse: size of the largest cells [L].

    Returns:
        Mesh with its tags.
    """
    solid = cell == "hexahedron"
    recipe = "sphere_on_half_space" if solid else "cylinder_on_half_plane"
    sizes = {"radius": 50.0, "a": 1.0, "h": h, "width": 12.0, "height": 12.0, "coarse": coarse}
    return meshes.make(recipe, MPI.COMM_SELF, **sizes, **({"core": 1.3, "symmetry": "quarter"} if solid else {}))


class PressedBodies:
    """A quarter of a ball (in the plane: half of a cylinder) on a block; its top is displaced downwards.

    Args:
        cell: "quadrilateral" or "hexahedron".
        h: mesh size at the contact [L].
        coarse: size of the largest cells [L].
        friction: Coulomb's friction coefficient [1].
    """

    def __init__(self, cell: str, h: float, coarse: float, friction: float = 0.0) -> None:
        solid, model = cell == "hexahedron", pressed_mesh(cell, h, coarse)
        gdim = model.mesh.geometry.dim
        self.V = V = fem.functionspace(model.mesh, ("Lagrange", 1, (gdim,)))
        self.num_unknowns: int = gdim * V.dofmap.index_map.size_global
        down = -0.02 if solid else -0.03

        def prescribe(name: str, component: int, value: float = 0.0) -> DirichletBC:
            facets = model.facet_tags.find(model.tags[name])
            dofs = fem.locate_dofs_topological(V.sub(component), gdim - 1, facets)
            return fem.dirichletbc(np.asarray(value), dofs, V.sub(component))

        bcs = [prescribe("bottom", c) for c in range(gdim)] + [prescribe("top", gdim - 1, down)]
        bcs += [prescribe(f"symmetry_{axis}", c) for c, axis in enumerate("xy"[: gdim - 1])]
        law = materials.LinearElastic(568.0, 0.3, hypothesis="3d" if solid else "plane_strain")
        tags = model.tags["slave_surface"], model.tags["master_surface"]
        pair = ContactPair(model.facet_tags, slave=tags[0], master=tags[1], friction=friction)
        self.problem = StaticProblem(fem.Function(V), law, bcs=bcs, contact=[Lagrange(pair)])


def tied_solution(model: PressedBodies) -> FloatArray:
    """One linear solve with every slave node tied to the master: residual, stiffness, condensation, solution.

    Args:
        model: bodies with friction, so that closed nodes stick.

    Returns:
        Increments of displacement over owned degrees of freedom [L].

    Raises:
        RuntimeError: the linear solver failed.
    """
    problem, contact = model.problem, model.problem.contact[0]
    assert isinstance(contact, LagrangeContact)
    target = problem.u.x.array.copy()
    for bc in problem.bcs:
        bc.set(target)
    residual = problem.assemble_residual().array.copy()
    contact.update_gap(problem.u.x.array)
    contact.active = contact.usable
    contact.opening = np.zeros(len(contact.nodes))
    K = problem.tangent.assemble()
    diagonal = K.getDiagonal()
    mean = float(np.abs(diagonal.array).mean())
    space, num_owned = problem.space, problem.num_owned
    first = space.dofmap.index_map.local_range[0] * space.dofmap.index_map_bs
    tied = _cpp.multipliers.Condensation(space.mesh.comm, num_owned, first, contact.gdim, [contact.constraints()])
    system = _cpp.solve.CondensedSystem(K, [], True, tied, problem.fixed[:num_owned] | tied.pinned, mean)
    x, b = system.create_vector(), system.create_vector()
    x.array[:] = tied.unknowns(target[:num_owned])
    system.load(residual, x, b)
    fault = problem.linear_solver.solve(system, b, x, RTOL)
    if fault:
        raise RuntimeError(f"the tied problem: {fault}")
    return system.displacements(x)


def tied_seconds(model: PressedBodies) -> float:
    """Time of `tied_solution`.

    Args:
        model: bodies with friction, so that closed nodes stick.

    Returns:
        Wall-clock time [s].

    Raises:
        RuntimeError: the linear solver failed.
    """
    model.problem.contact[0].begin_step(model.problem.u.x.array, None)
    start = time.perf_counter()
    tied_solution(model)
    return time.perf_counter() - start


def contact_rows(cases: Sequence[tuple[str, str, float, float]] = CASES) -> list[Row]:
    """Measure the contact solve against the tied solve, and the share of contact (search, integrals, assembly) in it.

    Args:
        cases: name, cell, mesh size at the contact and size of the largest cells [L].

    Returns:
        Rows.
    """
    rows = []
    for name, cell, h, coarse in cases:
        tied = tied_seconds(PressedBodies(cell, h, coarse, friction=1.0))
        model = PressedBodies(cell, h, coarse)
        start = time.perf_counter()
        report = model.problem.solve(rtol=RTOL)
        seconds = time.perf_counter() - start
        label = f"{cell} P1, {model.num_unknowns} unknowns"
        rows.append(row(SOLVE, label, 1, seconds, "s", tied))
        rows.append(row("  of which contact", label, 1, report.seconds["contact"], "s", seconds))
        rows.append(row("  Newton iterations, nodes in contact", label, 1, sum(report.iterations), "",
                        report.active_set_sizes[-1][-1]))  # fmt: skip
        rows.append(row("  most memory of the process so far", label, 1, most_memory() * 1e-9, "GB", MEMORY))
    return rows


def jobs(large: bool) -> list[Job]:
    """Measurements of static contact.

    Args:
        large: include problems of 300,000 and one million unknowns.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    cases = CASES + (LARGE if large else ())
    return [(f"static contact, {case[0]}", partial(contact_rows, (case,))) for case in cases]
