# SPDX-License-Identifier: MIT
"""Level c: static problems solved by both sides; displacements and reactions."""

from collections.abc import Mapping, Sequence

import basix
import numpy as np
from dolfinx import fem, mesh
from dolfinx.fem import DirichletBC
from dolfinx.mesh import Mesh, MeshTags
from dolfinx_impact.own_forms import distorted_block
from impact_reference import StaticSolution
from mpi4py import MPI

from dolfinx_impact import loads, materials
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.forms import quadrature
from dolfinx_impact.foundation import Foundation
from dolfinx_impact.statics.static_problem import StaticProblem
from . import differences, matched_body
from .nodes import TheirRule
from .report import Report

TOLERANCE = 1e-9
REASON = "round-off times the condition of the stiffness matrix (up to 1e6)"


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    if report.wants("quadrilateral", 1):
        wheel(report)
    block(report)
    founded(report)
    rubber(report)


def _compare(
    report: Report,
    body: matched_body.Body,
    form: str,
    name: str,
    ours: FloatArray,
    reactions: FloatArray,
    theirs: StaticSolution,
) -> None:
    element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
    u, r = body.to_ours(theirs.u), body.to_ours(theirs.reactions)
    for what, a, b in (("u", ours, u), ("reactions", reactions, r)):
        difference, note = differences.largest_difference(body, a, b)
        report.add("solution", form, *element, difference, TOLERANCE, REASON, f"{what} of the {name}", note)


def _fixed_dofs(bcs: Sequence[DirichletBC]) -> IntArray:
    return np.unique(np.concatenate([bc.dof_indices()[0] for bc in bcs]))


def wheel(report: Report, pressure: float = 5e8, half_width: float = 4.5e-3) -> None:
    """Add the rows of a wheel and a rail under a uniform patch of pressure on both running surfaces.

    Args:
        report: report to add to.
        pressure: pressure [Pa].
        half_width: half of the width of the patch [m].
    """
    from dolfinx_impact import meshes as recipes  # type: ignore[attr-defined,unused-ignore]  # installed beside it

    made = recipes.make("wheel_on_rail_2d", comm=MPI.COMM_SELF, gap=1e-4)
    domain, tags = made.mesh, made.tags
    steel = materials.LinearElastic(207e9, 0.3, 7800.0, "plane_strain")
    body = matched_body.Body(domain, 1, steel)
    V = body.V
    u = fem.Function(V, name="u")
    bcs = [
        fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags[name])), V)
        for name in ("hub", "bottom")
    ]
    patch = _patch_tags(domain, made.facet_tags, tags, half_width)
    problem = StaticProblem(
        u,
        steel,
        bcs=bcs,
        loads=[loads.Traction(patch, 1, (0.0, -pressure)), loads.Traction(patch, 2, (0.0, pressure))],
    )
    problem.solve()
    load = body.model.traction(body.their_facets(patch, 1), [0.0, -pressure])
    load = load + body.model.traction(body.their_facets(patch, 2), [0.0, pressure])
    theirs = body.model.solve_static(body.order[_fixed_dofs(bcs)], 0.0, load)
    _compare(report, body, "linear_elastic.tangent", "wheel on rail", u.x.array, problem.reactions().x.array, theirs)


def _patch_tags(domain: Mesh, facet_tags: MeshTags, tags: Mapping[str, int], half_width: float) -> MeshTags:
    """Facets of the patch: 1 on the rail (master surface), 2 on the wheel (slave surface)."""
    found = []
    for number, name in ((1, "master_surface"), (2, "slave_surface")):
        facets = facet_tags.find(tags[name])
        x = mesh.compute_midpoints(domain, 1, facets)
        near = facets[(np.abs(x[:, 0]) < half_width) & (np.abs(x[:, 1]) < half_width)]
        found.append((near, np.full(len(near), number, dtype=np.int32)))
    facets, values = (np.concatenate(a) for a in zip(*found))
    order = np.argsort(facets)
    return mesh.meshtags(domain, 1, facets[order].astype(np.int32), values[order])


def block(report: Report) -> None:
    """Add the rows of a distorted block, clamped below, under traction and gravity, for every element.

    Args:
        report: report to add to.
    """
    for cell, hypothesis in (
        ("triangle", "plane_strain"),
        ("quadrilateral", "plane_stress"),
        ("quadrilateral", "axisymmetric"),
        ("tetrahedron", "3d"),
        ("hexahedron", "3d"),
    ):
        for degree in (1, 2):
            if not report.wants(cell, degree):
                continue
            _block(report, cell, hypothesis, degree)


def _block(report: Report, cell: str, hypothesis: str, degree: int) -> None:
    domain = distorted_block.block(cell, 4)
    dim = domain.geometry.dim
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    used = quadrature.stiffness_degree(cell, degree, 1, hypothesis)
    exact = cell in quadrature.SIMPLICES
    body = matched_body.Body(domain, degree, steel)
    tags = _tags(domain, dim - 1)
    V = body.V
    u = fem.Function(V, name="u")
    clamped = fem.locate_dofs_topological(V, dim - 1, tags.find(1))
    bcs = [fem.dirichletbc(np.zeros(dim), clamped, V)]
    t, g = np.arange(1.0, dim + 1) / 100, np.full(dim, -0.01)
    problem = StaticProblem(u, steel, bcs=bcs, loads=[loads.Traction(tags, 2, t), loads.BodyForce(g)])
    problem.solve()
    load = body.model.traction(body.their_facets(tags, 2), t) + body.model.body_force(1.5 * g)
    if not exact:  # both sides take this rule for the stiffness; the default rules of the loads are exact
        body.model.rule = f"gauss_jacobi:{used}"
    fixed = (dim * clamped[:, None] + np.arange(dim)).ravel()
    theirs = body.model.solve_static(body.order[fixed], 0.0, load)
    _compare(report, body, "linear_elastic.tangent", "block", u.x.array, problem.reactions().x.array, theirs)


def founded(report: Report) -> None:
    """Add the rows of a block on springs alone, along the coordinates below and along the normal at its sides.

    Args:
        report: report to add to.
    """
    for cell, degree in (("triangle", 2), ("quadrilateral", 1), ("tetrahedron", 1), ("hexahedron", 2)):
        if report.wants(cell, degree):
            _founded(report, cell, degree)


def _founded(report: Report, cell: str, degree: int) -> None:
    domain = distorted_block.block(cell, 4)
    dim = domain.geometry.dim
    hypothesis = "plane_strain" if dim == 2 else "3d"
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    body = matched_body.Body(domain, degree, steel)
    model, tags = body.model, _tags(domain, dim - 1)
    along, t = 0.5 + 0.1 * np.arange(dim), np.arange(1.0, dim + 1) / 100
    foundation = Foundation(tags, 1, along)
    u = fem.Function(body.V, name="u")
    springs = [foundation, Foundation(tags, 2, 0.3)]
    StaticProblem(u, steel, loads=[*springs, loads.Traction(tags, 2, t)]).solve()
    load = model.traction(body.their_facets(tags, 2), t)
    if cell not in quadrature.SIMPLICES:
        model.rule = f"gauss_jacobi:{quadrature.stiffness_degree(cell, degree, 1, hypothesis)}"
    model.facet_rule = matched_body.foundation_rule(body)
    model.add_foundation(body.their_facets(tags, 1), along)
    model.add_foundation(body.their_facets(tags, 2), 0.3)
    theirs = model.solve_static(np.zeros(0, dtype=np.int64), 0.0, load)
    element = (cell, degree, 1, hypothesis)
    difference, note = differences.largest_difference(body, u.x.array, body.to_ours(theirs.u))
    report.add("solution", "foundation", *element, difference, TOLERANCE, REASON, "u of the block on springs", note)
    force = -(model.foundation(body.their_facets(tags, 1), along) @ theirs.u).reshape(-1, dim).sum(axis=0)
    found = foundation.force(u)
    note = f"UFL {found.tolist()}, hand-written {force.tolist()}"
    difference = differences.relative(found, force)
    report.add("solution", "foundation", *element, difference, TOLERANCE, REASON, "force of the springs", note)


def _tags(domain: Mesh, dim: int) -> MeshTags:
    """Facets of dimension `dim`: 1 on the lower face, 2 on the upper face."""
    bottom = mesh.locate_entities_boundary(domain, dim, lambda x: np.isclose(x[dim], 0.0))
    top = mesh.locate_entities_boundary(domain, dim, lambda x: np.isclose(x[dim], 1.0))
    facets = np.concatenate([bottom, top])
    values = np.repeat([1, 2], [len(bottom), len(top)]).astype(np.int32)
    order = np.argsort(facets)
    return mesh.meshtags(domain, dim, facets[order], values[order])


def rubber(report: Report) -> None:
    """Add the rows of neo-Hookean and St Venant-Kirchhoff blocks that are stretched by a quarter and sheared.

    Args:
        report: report to add to.
    """
    cases: tuple[tuple[str, int, str, type[matched_body.Material]], ...] = (
        ("hexahedron", 1, "neo_hookean", materials.NeoHookean),
        ("tetrahedron", 2, "neo_hookean", materials.NeoHookean),
        ("hexahedron", 2, "st_venant_kirchhoff", materials.StVenantKirchhoff),
    )
    for cell, degree, law, kind in cases:
        if not report.wants(cell, degree):
            continue
        domain = distorted_block.block(cell, 2)
        material = kind(1.0, 0.3, 1.0, "3d")
        used = quadrature.stiffness_degree(cell, degree)
        rule: TheirRule = f"gauss_jacobi:{used}"
        if cell in quadrature.SIMPLICES:
            rule = basix.make_quadrature(basix.CellType.tetrahedron, used)
        body = matched_body.Body(domain, degree, material, law, rule)
        tags = _tags(domain, 2)
        V = body.V
        u = fem.Function(V, name="u")
        ends = [fem.locate_dofs_topological(V, 2, tags.find(t)) for t in (1, 2)]
        pull = np.array([0.1, 0.0, 0.25])
        bcs = [fem.dirichletbc(np.zeros(3), ends[0], V), fem.dirichletbc(pull, ends[1], V)]
        problem = StaticProblem(u, material, bcs=bcs)
        problem.solve(rtol=1e-13)
        fixed = np.concatenate([(3 * e[:, None] + np.arange(3)).ravel() for e in ends])
        values = np.concatenate([np.zeros(3 * len(ends[0])), np.tile(pull, len(ends[1]))])
        theirs = body.model.solve_static(body.order[fixed], values, tolerance=1e-13)
        _compare(report, body, f"{law}.tangent", "stretched block", u.x.array, problem.reactions().x.array, theirs)
