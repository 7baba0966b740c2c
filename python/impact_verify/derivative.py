# SPDX-License-Identifier: MIT
"""Level f: each tangent is the derivative of its residual, each residual of its energy (Taylor remainders)."""

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace

from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact import materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import loads, quadrature
from . import matched_body
from .catalogue import Element
from .report import Report

STEPS = 2.0 ** -np.arange(3, 8)
TOLERANCE = 0.1
REASON = "slope of the remainder over steps of 1/8 to 1/128 against 2"


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    kinds = (materials.LinearElastic, materials.StVenantKirchhoff, materials.NeoHookean)
    for cell, degree, hypothesis in (
        ("triangle", 2, "plane_strain"),
        ("quadrilateral", 1, "plane_stress"),
        ("quadrilateral", 2, "axisymmetric"),
        ("tetrahedron", 1, "3d"),
        ("hexahedron", 2, "3d"),
    ):
        if not report.wants(cell, degree):
            continue
        domain = distorted_block.block(cell, 2)
        if hypothesis == "axisymmetric":
            domain.geometry.x[:, 0] += 0.5
        V = fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))
        for kind in kinds:
            _law(report, V, kind(1.0, 0.3, 1.0, hypothesis), (cell, degree, 1, hypothesis))
        _pressure(report, V, (cell, degree, 1, hypothesis))


def slope(remainders: FloatArray) -> float:
    """Least-squares slope of log(remainder) over log(step).

    Args:
        remainders: remainder at each of STEPS, shape (num_steps).

    Returns:
        Slope [1]; NaN where a remainder is NaN, infinite or zero.
    """
    if not np.all(np.isfinite(remainders) & (remainders > 0)):
        return np.nan
    return np.polyfit(np.log(STEPS), np.log(remainders), 1)[0]


def _state(V: FunctionSpace) -> tuple[Function, Function]:
    """Displacement u and a random direction d."""
    rng = np.random.default_rng(7)
    dim = V.mesh.geometry.dim
    u, d = fem.Function(V, name="u"), fem.Function(V, name="d")
    u.interpolate(lambda x: 0.05 * np.array([np.sin(2 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
    d.x.array[:] = 0.02 * rng.uniform(-1, 1, len(d.x.array))
    return u, d


def _remainders(
    value: Callable[[], float | FloatArray], derivative: Callable[[], float | FloatArray], u: Function, d: Function
) -> tuple[FloatArray, float]:
    """Norms of value(u + step d) - value(u) - step derivative, and the size of value and derivative."""
    start = u.x.array.copy()
    first, direction = value(), derivative()
    out = []
    for step in STEPS:
        u.x.array[:] = start + step * d.x.array
        out.append(np.linalg.norm(np.atleast_1d(value() - first - step * direction)))
    u.x.array[:] = start
    scale = np.linalg.norm(np.atleast_1d(first)) + np.linalg.norm(np.atleast_1d(direction))
    return np.array(out), float(scale)


def _add(report: Report, form: str, element: Element, remainders: FloatArray, scale: float, name: str) -> None:
    linear = np.max(remainders) < 1e-13 * scale * 10
    difference = 0.0 if linear else abs(slope(remainders) - 2)
    reason = "remainder is zero to round-off: a linear form" if linear else REASON
    note = f"remainders {', '.join(f'{r:.3g}' for r in remainders)} at steps {STEPS[0]} to {STEPS[-1]}"
    report.add("derivative", form, *element, difference, TOLERANCE, reason, name, note)


def _law(report: Report, V: FunctionSpace, material: matched_body.Material, element: Element) -> None:
    u, d = _state(V)
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    energy = operators.Energy(operators.strain_energy_form(u, material))
    force = operators.InternalForce(operators.internal_force_form(u, v, material))
    action = operators.InternalForce(ufl.action(operators.tangent_form(u, du, v, material), d))
    law = material.law_class.name
    remainders, scale = _remainders(energy.value, lambda: force.apply().array @ d.x.array, u, d)
    _add(report, f"{law}.energy", element, remainders, scale, "force is the energy's derivative")
    remainders, scale = _remainders(lambda: force.apply().array.copy(), lambda: action.apply().array.copy(), u, d)
    _add(report, f"{law}.force", element, remainders, scale, "tangent is the force's derivative")


def _pressure(report: Report, V: FunctionSpace, element: Element) -> None:
    u, d = _state(V)
    cell, degree, _, hypothesis = element
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    metadata = quadrature.metadata(quadrature.facet_degree(cell, degree, 1, hypothesis) + 2 * degree)
    ds = ufl.Measure("ds", domain=V.mesh, metadata=metadata)
    p = fem.Constant(V.mesh, np.float64(1.0))
    load = operators.InternalForce(loads.follower_pressure(p, u, v, hypothesis, ds))
    tangent = loads.follower_pressure_tangent(p, u, du, v, hypothesis, ds)
    action = operators.InternalForce(ufl.action(tangent, d))
    remainders, scale = _remainders(lambda: load.apply().array.copy(), lambda: action.apply().array.copy(), u, d)
    _add(report, "follower_pressure", element, remainders, scale, "tangent is the load's derivative")
