# SPDX-License-Identifier: MIT
"""Level a: element matrices and vectors on random, distorted and curved cells, at every SIMD width."""

import multiprocessing
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, cast

import basix
import numpy as np
import ufl
from mpi4py import MPI

from dolfinx_impact.assembly.jit import Compiled, compile_form
from dolfinx_impact.common.progress_bar import transient_bar
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import registry
from . import catalogue, nodes
from .catalogue import Case
from .report import Report

TOLERANCE = 1e-12
REASON = "round-off of at most 1e4 operations on numbers of order one"
# Names of a form's constants and coefficients.
Names: TypeAlias = Mapping["ufl.Constant | ufl.Coefficient", str]


def build_form(case: Case) -> tuple[registry.Built, str | None]:
    """Build a form of the catalogue with the rule that makes the two sides comparable.

    Args:
        case: name, cell, degree, geometry_degree and hypothesis.

    Returns:
        The form, and the name of the other side's rule.
    """
    name, cell, degree, geometry_degree, hypothesis = case
    ours, theirs = catalogue.rules(*case)
    return registry.build(name, cell, degree, geometry_degree, hypothesis, rule=ours), theirs


def _compile(case: Case) -> Case:
    form, _ = build_form(case)
    compile_form(form.form, form.names, MPI.COMM_SELF)
    return case


def compile_all(cases: Sequence[Case], progress: bool = True, processes: int = 2) -> None:
    """Compile the forms that are not in the cache yet, several at a time.

    Args:
        cases: forms of the catalogue with their elements.
        progress: show a progress bar.
        processes: number of processes.
    """
    with (
        transient_bar(progress) as bar,
        multiprocessing.get_context("spawn").Pool(processes) as pool,
    ):
        task = bar.add_task("compiling kernels", total=len(cases))
        for _ in pool.imap_unordered(_compile, cases, chunksize=2):
            bar.advance(task)


def _their_rule(
    theirs: nodes.TheirRule | Mapping[str, nodes.TheirRule], degree: int | None, cell: str, integral_type: str
) -> nodes.TheirRule:
    """Rule for the other side; "points" stands for Basix's symmetric rule, handed over as points and weights."""
    if isinstance(theirs, Mapping):
        return theirs.get(integral_type)
    if theirs is None or isinstance(theirs, (tuple, list)) or theirs != "points":
        return theirs
    facet = {"triangle": "interval", "tetrahedron": "triangle"}
    shape = getattr(basix.CellType, cell if integral_type == "cell" else facet[cell])
    return basix.make_quadrature(shape, cast(int, degree))  # known for the forms of the catalogue, which say "points"


def pack(
    kernel: Any, compiled: Compiled, names: Names, values: Mapping[str, Any], fields: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Arrays w and c of a kernel from values by the names of the form; a cached kernel may have other names."""
    w = np.zeros(sum(c["num_dofs"] for c in kernel.coefficients))
    for c in kernel.coefficients:
        name = names[compiled.coefficients[c["position"]]]
        # A modulus may be a function that is constant in each cell.
        w[c["offset"] : c["offset"] + c["num_dofs"]] = np.ravel(fields[name] if name in fields else values[name])
    c = np.zeros(sum(k["size"] for k in kernel.constants))
    for k in kernel.constants:
        c[k["offset"] : k["offset"] + k["size"]] = np.ravel(values[names[compiled.constants[k["position"]]]])
    return w, c


def aligned(size: int) -> FloatArray:
    """Zeroed array of doubles on a 64-byte boundary.

    Args:
        size: number of entries.

    Returns:
        Array, shape (size).
    """
    buffer = np.zeros(size + 8)
    start = (-buffer.ctypes.data // 8) % 8
    return buffer[start : start + size]


def tabulate(
    kernel: Any, cells: Sequence[FloatArray], w: Sequence[FloatArray], c: FloatArray, entity: int, lanes: int
) -> FloatArray:
    """Element tensors of several cells.

    Args:
        kernel: compiled kernel of dolfinx_impact._cpp.
        cells: geometry nodes of every cell, shape (num_geometry_nodes, gdim) [L].
        w: packed coefficients of every cell.
        c: packed constants.
        entity: local number of the facet; 0 for integrals over cells.
        lanes: number of cells per kernel call.

    Returns:
        Flattened element tensors, shape (num_cells, tensor size).
    """
    count, size = len(cells), kernel.shape[0] * kernel.shape[1]
    out = np.empty((count, size))
    for start in range(0, count, lanes):
        pick = [min(start + lane, count - 1) for lane in range(lanes)]
        x = np.zeros((lanes, cells[0].shape[0], 3))
        x[:, :, : cells[0].shape[1]] = [cells[p] for p in pick]
        arrays = []
        for a in (np.zeros((lanes, size)), np.array([w[p] for p in pick]), x.reshape(lanes, -1)):
            packed = aligned(a.size)
            packed[:] = a.T.ravel()
            arrays.append(packed)
        kernel.tabulate(arrays[0], arrays[1], c, arrays[2], entity, lanes)
        tensors = arrays[0].reshape(size, lanes).T
        out[start : start + lanes] = tensors[: min(lanes, count - start)]
    return out


def difference(
    case: Case,
    count: int = 100,
    seed: int = 2026,
    kernels: Compiled | None = None,
    names: Names | None = None,
    theirs: nodes.TheirRule | Mapping[str, nodes.TheirRule] = None,
    values: Mapping[str, Any] | None = None,
    distortion: float = 0.12,
) -> tuple[float, str]:
    """Largest difference of element tensors over random cells.

    Args:
        case: name, cell, degree, geometry_degree and hypothesis.
        count: number of random cells.
        seed: seed of the random numbers.
        kernels: compiled form of a user; None takes the form of the catalogue.
        names: names of the user's constants and coefficients; None with the form of the catalogue.
        theirs: rule of the other side for the user's form, or rules by type of integral.
        values: constants that replace random ones, by name.
        distortion: largest motion of a cell's nodes over its size [1].

    Returns:
        Difference relative to the largest entry of the cell's tensor [1], and a text with the worst entry in our order.
    """
    name, cell, degree, geometry_degree, hypothesis = case
    rng = np.random.default_rng([seed, *map(ord, "".join(map(str, case)))])
    used = None
    if kernels is None:
        form, rule = build_form(case)
        kernels, names = compile_form(form.form, form.names, MPI.COMM_SELF), form.names
        theirs, used = rule, form.degree
    form_names = cast(Names, names)  # given with the kernels of a user
    dim = registry.CELLS[cell]
    components = 1 if name.startswith("poisson") else dim
    field_order = nodes.dofs(cell, degree, components)
    geometry_order = nodes.permutation(cell, geometry_degree)
    values = {**catalogue.parameters(rng, name, dim), **(values or {})}
    cells = [nodes.random_cell(rng, cell, geometry_degree, hypothesis, distortion) for _ in range(count)]
    # Strains of about ten per cent: finite-strain laws are nonlinear there, and every Jacobian stays positive.
    sizes = [0.08 / degree**2 * np.ptp(x, axis=0).min() for x in cells]
    fields = [
        {f: size * rng.uniform(-1, 1, len(field_order)) for f in ("u", "velocity", "acceleration")} for size in sizes
    ]
    worst, where = 0.0, ""
    for kernel in kernels.kernels:
        w, c = zip(*(pack(kernel, kernels, form_names, values, f) for f in fields))
        their_rule = _their_rule(theirs, used, cell, kernel.integral_type)
        facets: Sequence[int | None] = [None]
        if kernel.integral_type == "exterior_facet":
            facets = range(nodes.num_facets(cell))
        for facet in facets:
            # A cell integral takes every cell; the local facets divide the cells among them.
            some = range(count) if facet is None else range(facet, count, len(facets))
            vertices = None if facet is None else nodes.facet_vertices(cell, facet)
            expected = []
            for i in some:
                X = nodes.to_theirs(cells[i], geometry_order)
                mine = {f: nodes.to_theirs(v, field_order) for f, v in fields[i].items()}
                tensor = catalogue.evaluate(name, case[1:], X, values, mine, their_rule, vertices)
                for _ in range(kernel.rank):
                    tensor = np.moveaxis(tensor, 0, -1)[..., field_order]
                expected.append(np.ravel(tensor))
            for lanes in kernel.widths:
                got = tabulate(kernel, [cells[i] for i in some], [w[i] for i in some], c[0], facet or 0, lanes)
                for row, b in enumerate(expected):
                    a: FloatArray = got[row]
                    if name == "nodal_mass":  # the other side scales the nodal masses to the exact mass of the cell
                        a = np.asarray(a * (b.sum() / a.sum()))
                    error: FloatArray = np.abs(a - b) / max(np.max(np.abs(b)), 1e-300)
                    k = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
                    if not error[k] <= worst:
                        worst = float(error[k])
                        where = entry(k, kernel.shape, components, kernel.rank, lanes, facet, a[k], b[k])
    return worst, where


def entry(
    k: int,
    shape: tuple[int, int],
    components: int,
    rank: int,
    lanes: int,
    facet: int | None,
    ours: float,
    theirs: float,
) -> str:
    """Text about one entry of an element tensor.

    Args:
        k: index of the entry in the flattened tensor.
        shape: shape of the tensor.
        components: number of components per node.
        rank: rank of the form, 0, 1 or 2.
        lanes: number of cells per kernel call.
        facet: local number of the facet; None for integrals over cells.
        ours: our value.
        theirs: value of the other side.

    Returns:
        Nodes, components, facet, number of lanes and both values.
    """
    place = []
    if rank > 0:
        place.append(divmod(k // (shape[1] if rank > 1 else 1), components))
    if rank > 1:
        place.append(divmod(k % shape[1], components))
    indices = [f"node {n} component {c}" for n, c in place]
    at = " against ".join(indices) if indices else "value"
    facet_text = "" if facet is None else f", local facet {facet}"
    return f"{at}{facet_text}, {lanes} lanes: UFL {ours:.15g}, hand-written {theirs:.15g}"


def run(report: Report, cases: Sequence[Case], count: int = 100, progress: bool = True) -> None:
    """Add the rows of this level, one per case.

    Args:
        report: report to add to.
        cases: forms of the catalogue with their elements.
        count: number of random cells per case.
        progress: show a progress bar.
    """
    with transient_bar(progress) as bar:
        task = bar.add_task("element level", total=len(cases))
        for case in cases:
            try:
                worst, where = difference(case, count)
            except (ValueError, RuntimeError) as e:  # one side refuses: this row fails, the run continues
                worst, where = float("nan"), f"{type(e).__name__}: {e}"
            report.add("element", case[0], *case[1:], worst, TOLERANCE, REASON, "element tensor", where)
            bar.advance(task)
