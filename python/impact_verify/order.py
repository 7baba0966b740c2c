# SPDX-License-Identifier: MIT
"""Level e: orders of convergence against a manufactured solution, both solvers: p + 1 in L2, p in H1."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias, cast

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from dolfinx.fem import Function
from dolfinx.mesh import exterior_facet_indices

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact import compat, materials
from dolfinx_impact.common.progress_bar import transient_bar
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.forms import loads, quadrature
from dolfinx_impact.loads import Load
from dolfinx_impact.statics.static_problem import StaticProblem
from . import matched_body
from .report import Report

TOLERANCE = 0.1
REASON = "rate over the last two of four meshes against theory"
# Cell, degree and hypothesis; and the cells per side of the meshes.
Key: TypeAlias = tuple[str, int, str]
Case: TypeAlias = tuple[str, int, str, tuple[int, ...]]
# Cells per side, and for each mesh the errors in L2 and H1 of our side, then of the other side.
Results: TypeAlias = dict[Key, tuple[IntArray, FloatArray]]
CASES: tuple[Case, ...] = (
    ("triangle", 1, "plane_strain", (8, 16, 32, 64)),
    ("triangle", 2, "plane_strain", (4, 8, 16, 32)),
    ("quadrilateral", 1, "plane_stress", (8, 16, 32, 64)),
    ("quadrilateral", 2, "axisymmetric", (4, 8, 16, 32)),
    ("tetrahedron", 1, "3d", (4, 6, 9, 14)),
    ("tetrahedron", 2, "3d", (2, 3, 4, 6)),
    ("hexahedron", 1, "3d", (4, 6, 9, 14)),
    ("hexahedron", 2, "3d", (2, 3, 4, 6)),
)


def exact(
    x: FloatArray | ufl.SpatialCoordinate,
    dim: int,
    sin: Callable[[Any], Any] = np.sin,
    cos: Callable[[Any], Any] = np.cos,
) -> list[Any]:
    """Manufactured displacement, for coordinates of UFL and NumPy.

    Args:
        x: coordinates, shape (dim, ...) [L].
        dim: dimension of space.
        sin: sine of NumPy or UFL.
        cos: cosine of NumPy or UFL.

    Returns:
        Components of the displacement [L].
    """
    if dim == 2:
        return [0.1 * sin(0.9 * x[0] + 0.6 * x[1]) + 0.05 * x[0], 0.1 * cos(0.7 * x[0] - 0.8 * x[1])]
    return [
        0.1 * sin(0.9 * x[0] + 0.6 * x[1] - 0.4 * x[2]),
        0.1 * cos(0.7 * x[0] - 0.8 * x[1]),
        0.1 * sin(x[2] + 0.5 * x[0]),
    ]


def run(report: Report, folder: Path | None = None, progress: bool = True, cases: Sequence[Case] = CASES) -> Results:
    """Add the rows of this level.

    Args:
        report: report to add to.
        folder: folder of a plot, which is added to the report; None for no plot.
        progress: show a progress bar.
        cases: elements and meshes.

    Returns:
        Cells per side and errors by element.
    """
    results: Results = {}
    cases = [c for c in cases if report.wants(c[0], c[1])]
    with transient_bar(progress) as bar:
        task = bar.add_task("manufactured solutions", total=len(cases) * 4)
        for cell, degree, hypothesis, sizes in cases:
            rows = []
            for n in sizes:
                rows.append(_errors(cell, degree, hypothesis, n))
                bar.advance(task)
            results[(cell, degree, hypothesis)] = (np.array(sizes), np.array(rows))
    for (cell, degree, hypothesis), (counts, errors) in results.items():
        rates = np.log(errors[:-1] / errors[1:]) / np.log(counts[1:] / counts[:-1])[:, None]
        element = (cell, degree, 1, hypothesis)
        for k, (side, norm) in enumerate(
            (("UFL", "L2"), ("UFL", "H1"), ("hand-written", "L2"), ("hand-written", "H1"))
        ):
            expected, rate = degree + (norm == "L2"), rates[-1, k]
            name = f"{side}: {norm} rate {rate:.2f}, theory {expected}"
            note = f"rates {np.round(rates[:, k], 2).tolist()}"
            # Only rates below theory are errors.
            below = max(expected - rate, 0.0)
            report.add("order", "linear_elastic.tangent", *element, below, TOLERANCE, REASON, name, note)
    if folder is not None and results:
        report.figures.append(("Convergence of both solvers", _plot(results, folder)))
    return results


def _errors(cell: str, degree: int, hypothesis: str, n: int) -> list[float]:
    """Errors in L2 and H1 of our side, then of the other side."""
    domain = distorted_block.block(cell, n, distortion=0.05)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += 0.5
    steel = materials.LinearElastic(1.0, 0.3, 1.0, hypothesis)
    body = matched_body.Body(domain, degree, steel)
    return [*_ours(body, steel), *_theirs(body)]


def _source(body: matched_body.Body, steel: materials.LinearElastic) -> ufl.core.expr.Expr:
    """Body force that makes the manufactured displacement the solution: minus the divergence of its stress."""
    x = ufl.SpatialCoordinate(body.mesh)
    u = ufl.as_vector(exact(x, body.gdim, ufl.sin, ufl.cos))
    law = steel.law(body.mesh)
    sigma = law.stress(u)
    f = [-sum(ufl.Dx(sigma[i, j], j) for j in range(body.gdim)) for i in range(body.gdim)]
    if body.hypothesis == "axisymmetric":
        f[0] -= (sigma[0, 0] - sigma[2, 2]) / x[0]
        f[1] -= sigma[1, 0] / x[0]
    return ufl.as_vector(f)


class _Source:
    """The manufactured source as a load, f an expression of UFL."""

    def __init__(self, f: ufl.core.expr.Expr, degree: int) -> None:
        self.f, self.degree = f, degree

    def form(self, u: Function, v: ufl.Argument, material: matched_body.Material) -> ufl.Form:
        mesh = u.function_space.mesh
        dx = ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(self.degree))
        return loads.body_force(self.f, v, material.hypothesis_on(mesh), dx)


def _boundary(body: matched_body.Body) -> npt.NDArray[np.int32]:
    """Our nodes on the boundary."""
    tdim = body.mesh.topology.dim
    body.mesh.topology.create_connectivity(tdim - 1, tdim)
    return fem.locate_dofs_topological(body.V, tdim - 1, exterior_facet_indices(body.mesh.topology))


def _ours(body: matched_body.Body, steel: materials.LinearElastic) -> FloatArray:
    V, dim = body.V, body.gdim
    target = fem.Function(V)
    target.interpolate(lambda x: np.array(exact(x, dim)))
    u = fem.Function(V, name="u")
    bcs = [fem.dirichletbc(target, _boundary(body))]
    source = _Source(_source(body, steel), 2 * body.degree + 2)
    StaticProblem(u, steel, bcs=bcs, loads=[cast(Load, source)]).solve()
    x = ufl.SpatialCoordinate(body.mesh)
    e = u - ufl.as_vector(exact(x, dim, ufl.sin, ufl.cos))
    dx = ufl.Measure("dx", domain=body.mesh, metadata=quadrature.metadata(2 * body.degree + 3))
    square = [fem.assemble_scalar(ffcx_form(ufl.inner(a, a) * dx)) for a in (e, ufl.grad(e))]
    return np.sqrt(square)


def _theirs(body: matched_body.Body) -> list[float]:
    """Errors of the hand-written solver with the same source, interpolated at its nodes with an error O(h^(p+1))."""
    dim, model = body.gdim, body.model
    x = model.field_points
    source = _numeric_source(body)
    unit = impact_reference.Material(1.0, 0.3, 1.0, body.hypothesis)
    mass = impact_reference.Model(
        body.points, body.cells, body.cell, unit, degree=body.degree, geometry_degree=body.geometry_degree
    ).mass()
    boundary = _boundary(body)
    fixed = body.order[(dim * boundary[:, None] + np.arange(dim)).ravel()]
    values = np.array(exact(x.T, dim)).T.ravel()
    u = model.solve_static(fixed, values[fixed], mass.dot(source)).u.reshape(-1, dim)
    rule = f"gauss_jacobi:{2 * body.degree + 3}"
    points, weights = impact_reference.quadrature(body.cell, rule)
    N, dN = impact_reference.shape_functions(body.cell, body.degree, points)
    G, dG = impact_reference.shape_functions(body.cell, body.geometry_degree, points)
    X, U = body.points[body.cells], u[model.field_cells]
    positions = np.einsum("qn,cni->cqi", G, X)
    J = np.einsum("qnd,cni->cqid", dG, X)
    gradient = np.einsum("qnd,cni,cqdj->cqij", dN, U, np.linalg.inv(J))
    volume = weights * np.abs(np.linalg.det(J))
    difference = np.einsum("qn,cni->cqi", N, U) - np.moveaxis(
        np.array(exact(np.moveaxis(positions, -1, 0), dim)), 0, -1
    )
    step = 1e-6  # central differences: their error of 1e-10 is far below the errors of the solutions
    slopes = []
    for j in range(dim):
        up, down = positions.copy(), positions.copy()
        up[..., j] += step
        down[..., j] -= step
        pair = [np.moveaxis(np.array(exact(np.moveaxis(p, -1, 0), dim)), 0, -1) for p in (up, down)]
        slopes.append((pair[0] - pair[1]) / (2 * step))
    slope = np.stack(slopes, axis=-1)
    return [
        np.sqrt(np.sum(volume * np.sum(difference**2, axis=-1))),
        np.sqrt(np.sum(volume * np.sum((gradient - slope) ** 2, axis=(-1, -2)))),
    ]


def _numeric_source(body: matched_body.Body) -> FloatArray:
    """The source at the nodes of the hand-written solver, evaluated from the expression of UFL."""
    V = body.V
    f = fem.Function(V)
    f.interpolate(
        fem.Expression(_source(body, cast(materials.LinearElastic, body.material)), compat.interpolation_points(V))
    )
    return body.to_theirs(f.x.array)


def _plot(results: Results, folder: Path) -> Path:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 4, figsize=(16, 8), constrained_layout=True)
    for axis, ((cell, degree, hypothesis), (sizes, errors)) in zip(axes.ravel(), results.items()):
        for k, (label, marker, colour) in enumerate(
            (
                ("UFL, L2", "o", "C0"),
                ("UFL, H1", "s", "C1"),
                ("hand-written, L2", "x", "k"),
                ("hand-written, H1", "+", "k"),
            )
        ):
            style = {"linestyle": "-" if k < 2 else "none", "marker": marker, "markersize": 9, "fillstyle": "none"}
            axis.loglog(sizes, errors[:, k], color=colour, label=label, **style)
        for power, norm in ((degree + 1, 0), (degree, 1)):
            guide = 0.6 * errors[-1, norm] * (sizes[-1] / sizes) ** power
            axis.loglog(sizes, guide, ":", color="0.4", label=f"slope {power}")
        axis.set_title(f"{cell}, degree {degree}, {hypothesis.replace('_', ' ')}", fontsize=11)
        axis.set_xlabel("cells per side")
        axis.set_ylabel("error norm (block side 1)")
        axis.set_xticks(sizes, [str(n) for n in sizes])
        axis.minorticks_off()
        axis.grid(True, alpha=0.25)
        axis.legend(fontsize=7, loc="lower left")
    path = folder / "order.png"
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path
