# SPDX-License-Identifier: MIT
"""Level d: rigid body modes and lowest natural frequencies; SLEPc against the hand-written eigensolver."""

import numpy as np
import ufl
from petsc4py import PETSc

from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact import _cpp, materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import elasticity, inertia, quadrature
from . import matched_body
from .report import Report

TOLERANCE = 1e-8
REASON = "both eigensolvers stop at residuals of 1e-10 and less"
NUM_RIGID = {"3d": 6, "plane_strain": 3, "plane_stress": 3, "axisymmetric": 1}


def run(report: Report, progress: bool = True, num_elastic: int = 4) -> None:
    """Add the rows of this level: free bodies, whose rigid body modes come first.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
        num_elastic: number of elastic frequencies to compare.
    """
    for cell, degree, hypothesis in (
        ("triangle", 2, "plane_stress"),
        ("quadrilateral", 1, "plane_strain"),
        ("quadrilateral", 2, "axisymmetric"),
        ("tetrahedron", 2, "3d"),
        ("hexahedron", 1, "3d"),
        ("hexahedron", 2, "3d"),
    ):
        if not report.wants(cell, degree):
            continue
        _free_body(report, cell, degree, hypothesis, num_elastic)


def _free_body(report: Report, cell: str, degree: int, hypothesis: str, num_elastic: int) -> None:
    domain = distorted_block.block(cell, 3)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += 0.5
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    # On simplices both sides integrate exactly, each with its own rules. Elsewhere both take the rule of the mass, so
    # that the hand-written model can use it for every integral.
    simplex = cell in quadrature.SIMPLICES
    mass_degree = quadrature.mass_degree(cell, degree, 1, hypothesis)
    used = quadrature.stiffness_degree(cell, degree, 1, hypothesis) if simplex else mass_degree
    rule = None if simplex else f"gauss_jacobi:{mass_degree}"
    body = matched_body.Body(domain, degree, steel, rule=rule)
    V = body.V
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    law = steel.law(domain)
    dx = ufl.Measure("dx", domain=domain, metadata=quadrature.metadata(used))
    mass_dx = ufl.Measure("dx", domain=domain, metadata=quadrature.metadata(mass_degree))
    stiffness = operators.Tangent(elasticity.tangent(None, u, v, law, dx))
    mass = operators.Tangent(inertia.mass(u, v, steel.density_constant(domain), hypothesis, mass_dx))
    count = NUM_RIGID[hypothesis] + num_elastic
    ours = _slepc(stiffness.assemble(), mass.assemble(), count)
    theirs, _ = body.model.frequencies(count)
    element = (cell, degree, 1, hypothesis)
    rigid = NUM_RIGID[hypothesis]
    scale = max(ours[-1], theirs[-1])  # an elastic frequency of both sides, unless one side has far too many zeros
    for side, w in (("UFL", ours), ("hand-written", theirs)):
        zeros = int(np.sum(w < 1e-4 * scale))
        text = f"{side} side: {zeros} of {rigid}"
        note = f"lowest frequencies {', '.join(f'{x:.3g}' for x in w)}"
        report.add("spectrum", "rigid_modes", *element, abs(zeros - rigid), 0, "a count", text, note)
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = np.abs(ours[rigid:] / theirs[rigid:] - 1)
    k = int(np.argmax(np.where(np.isnan(errors), np.inf, errors)))
    note = f"elastic frequency {k + 1}: UFL {ours[rigid + k]:.15g}, hand-written {theirs[rigid + k]:.15g}"
    report.add("spectrum", "frequencies", *element, errors[k], TOLERANCE, REASON, f"lowest {num_elastic} elastic", note)


def _slepc(K: PETSc.Mat, M: PETSc.Mat, count: int) -> FloatArray:
    """Lowest angular frequencies by shift-and-invert with a small negative shift [1/T]."""
    return np.sqrt(np.maximum(_cpp.solve.lowest_eigenvalues(K, M, count, -1e-2, 1e-13), 0.0))
