# SPDX-License-Identifier: MIT
"""Level a: element matrices and vectors on random, distorted and curved cells, at every SIMD width."""

import multiprocessing

import basix
import numpy as np
from mpi4py import MPI

from ..forms import registry
from ..assembly.jit import compile_form
from . import catalogue, nodes

TOLERANCE = 1e-12
REASON = "round-off of at most 1e4 operations on numbers of order one"


def built(case):
    """The form of the catalogue with the rule that makes it comparable; returns (Built, rule of the other side)."""
    name, cell, degree, geometry_degree, hypothesis = case
    ours, theirs = catalogue.rules(*case)
    return registry.build(name, cell, degree, geometry_degree, hypothesis, rule=ours), theirs


def _compile(case):
    form, _ = built(case)
    compile_form(form.form, form.names, MPI.COMM_SELF)
    return case


def compile_all(cases, progress=True, processes=2):
    """Compile what is not in the cache yet, several at a time."""
    from rich.progress import Progress

    with (
        Progress(disable=not progress, transient=True) as bar,
        multiprocessing.get_context("spawn").Pool(processes) as pool,
    ):
        task = bar.add_task("compiling kernels", total=len(cases))
        for _ in pool.imap_unordered(_compile, cases, chunksize=2):
            bar.advance(task)


def _their_rule(theirs, degree, cell, integral_type):
    """Rule for the other side; "points" stands for Basix's symmetric rule, handed over as points and weights."""
    if isinstance(theirs, dict):
        return theirs.get(integral_type)
    if theirs is None or isinstance(theirs, (tuple, list)) or theirs != "points":
        return theirs
    facet = {"triangle": "interval", "tetrahedron": "triangle"}
    return basix.make_quadrature(getattr(basix.CellType, cell if integral_type == "cell" else facet[cell]), degree)


def _pack(kernel, compiled, names, values, fields):
    """Arrays w and c of a kernel from values by the names the form gives; a cached kernel may carry other names."""
    w = np.zeros(sum(c["num_dofs"] for c in kernel.coefficients))
    for c in kernel.coefficients:
        name = names[compiled.coefficients[c["position"]]]
        w[c["offset"] : c["offset"] + c["num_dofs"]] = np.ravel(fields[name])
    c = np.zeros(sum(k["size"] for k in kernel.constants))
    for k, constant in zip(kernel.constants, compiled.constants):
        c[k["offset"] : k["offset"] + k["size"]] = np.ravel(values[names[constant]])
    return w, c


def aligned(size):
    """Zeroed array of doubles on a 64-byte boundary."""
    buffer = np.zeros(size + 8)
    start = (-buffer.ctypes.data // 8) % 8
    return buffer[start : start + size]


def tabulate(kernel, cells, w, c, entity, lanes):
    """Element tensors of several cells through kernel calls of `lanes` cells; shapes (n, ...)."""
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


def difference(case, count=100, seed=2026, kernels=None, names=None, theirs=None, values=None, distortion=0.12):
    """Largest difference over `count` random cells, relative to the largest entry of the cell's tensor.

    Args:
        case: (name, cell, degree, geometry_degree, hypothesis).
        kernels, names, theirs, values: Compiled, names and constants of a user's own form instead of the catalogue's,
            and the rule for the other side.

    Returns:
        (difference, entry text): the entry is the worst one, in our order.
    """
    name, cell, degree, geometry_degree, hypothesis = case
    rng = np.random.default_rng([seed, *map(ord, "".join(map(str, case)))])
    used = None
    if kernels is None:
        form, rule = built(case)
        kernels, names = compile_form(form.form, form.names, MPI.COMM_SELF), form.names
        theirs, used = rule, form.degree
    dim = registry.CELLS[cell]
    components = 1 if name.startswith("poisson") else dim
    field_order = nodes.dofs(cell, degree, components)
    geometry_order = nodes.permutation(cell, geometry_degree)
    values = {**catalogue.parameters(rng, name, dim), **(values or {})}
    cells = [nodes.random_cell(rng, cell, geometry_degree, hypothesis, distortion) for _ in range(count)]
    # Strains of some ten per cent: finite-strain laws are nonlinear there, and no cell turns inside out.
    sizes = [0.08 / degree**2 * np.ptp(x, axis=0).min() for x in cells]
    fields = [
        {f: size * rng.uniform(-1, 1, len(field_order)) for f in ("u", "velocity", "acceleration")} for size in sizes
    ]
    worst, where = 0.0, ""
    for kernel in kernels.kernels:
        w, c = zip(*(_pack(kernel, kernels, names, values, f) for f in fields))
        their_rule = _their_rule(theirs, used, cell, kernel.integral_type)
        facets = range(nodes.num_facets(cell)) if kernel.integral_type == "exterior_facet" else [None]
        for facet in facets:
            # Every cell of a cell integral; the facets share the cells between them.
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
                for a, b in zip(got, expected):
                    if name == "nodal_mass":  # shares of the cell's mass: the other side scales them to the exact mass
                        a = a * (b.sum() / a.sum())
                    error = np.abs(a - b) / max(np.max(np.abs(b)), 1e-300)
                    k = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
                    if not error[k] <= worst:
                        worst = float(error[k])
                        where = entry(k, kernel.shape, components, kernel.rank, lanes, facet, a[k], b[k])
    return worst, where


def entry(k, shape, components, rank, lanes, facet, ours, theirs):
    """Text that says which entry of an element tensor parts."""
    place = []
    if rank > 0:
        place.append(divmod(k // (shape[1] if rank > 1 else 1), components))
    if rank > 1:
        place.append(divmod(k % shape[1], components))
    names = [f"node {n} component {c}" for n, c in place]
    at = " against ".join(names) if names else "value"
    facet_text = "" if facet is None else f", local facet {facet}"
    return f"{at}{facet_text}, {lanes} lanes: UFL {ours:.15g}, hand-written {theirs:.15g}"


def run(report, cases, count=100, progress=True):
    """Add a row per case."""
    from rich.progress import Progress

    with Progress(disable=not progress, transient=True) as bar:
        task = bar.add_task("element level", total=len(cases))
        for case in cases:
            try:
                worst, where = difference(case, count)
            except (ValueError, RuntimeError) as e:  # one side refuses: a failure of this row, not the end of the run
                worst, where = float("nan"), f"{type(e).__name__}: {e}"
            report.add("element", case[0], *case[1:], worst, TOLERANCE, REASON, "element tensor", where)
            bar.advance(task)
