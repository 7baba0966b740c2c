# SPDX-License-Identifier: MIT
"""Level d: rigid modes and lowest natural frequencies; SLEPc on the UFL side against the other's own."""

import numpy as np
import ufl
from slepc4py import SLEPc

from .. import materials
from ..assembly import operators
from ..forms import elasticity, inertia, quadrature
from . import bodies

TOLERANCE = 1e-8
REASON = "both eigensolvers stop at residuals of 1e-10 and less"
NUM_RIGID = {"3d": 6, "plane_strain": 3, "plane_stress": 3, "axisymmetric": 1}


def run(report, progress=True, num_elastic=4):
    """Add the rows of this level: free bodies, so that the rigid modes come first."""
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


def _free_body(report, cell, degree, hypothesis, num_elastic):
    domain = bodies.block(cell, 3)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += 0.5
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    # Simplices: both sides integrate exactly, each with its own rules. Elsewhere one rule is named to both; the mass's
    # degree, so that the hand-written model may use it for everything.
    simplex = cell in quadrature.SIMPLICES
    mass_degree = quadrature.mass_degree(cell, degree, 1, hypothesis)
    used = quadrature.stiffness_degree(cell, degree, 1, hypothesis) if simplex else mass_degree
    rule = None if simplex else f"gauss_jacobi:{mass_degree}"
    body = bodies.Body(domain, degree, steel, rule=rule)
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
    scale = max(ours[-1], theirs[-1])  # elastic on both sides, unless one has far too many zeros
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


def _slepc(K, M, count):
    """Lowest angular frequencies by shift-and-invert about a small negative shift."""
    solver = SLEPc.EPS().create(K.comm)
    solver.setOperators(K, M)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(-1e-2)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    factor = transform.getKSP()
    factor.setType("preonly")
    factor.getPC().setType("lu")
    factor.getPC().setFactorSolverType("mumps")
    solver.setDimensions(count, max(2 * count, 20))
    solver.setTolerances(1e-13, 500)
    solver.solve()
    if solver.getConverged() < count:
        raise RuntimeError(f"SLEPc found {solver.getConverged()} of {count} eigenvalues")
    values = np.sort([solver.getEigenvalue(i).real for i in range(solver.getConverged())])[:count]
    solver.destroy()
    return np.sqrt(np.maximum(values, 0.0))
