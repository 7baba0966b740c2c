# SPDX-License-Identifier: MIT
"""Rows of the level material: the consistent tangent is the derivative of the internal forces, also beside the corner.

Forces have a corner where a point begins to yield: there the tangent jumps. Away from it the Taylor remainder is of
order 2. Across it, the forces are the integral of the tangent, taken on either side of the corner.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem

from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.plasticity import ArmstrongFrederick, J2Plasticity, Voce
from dolfinx_impact.statics.material_body import MaterialBody
from .derivative import REASON, STEPS, slope
from .derivative import TOLERANCE as SLOPE_TOLERANCE
from .report import Report

E, NU, Y = 2.0, 0.3, 0.01
TOLERANCE = 1e-8
INTEGRAL = "Gauss integrals of a smooth tangent on either side of the corner, found to 1e-12 by bisection"

# name, cell, degree, hypothesis, finite strain, other arguments of the law
BODIES = (
    ("voce", "tetrahedron", 2, "3d", True, {"hardening": Voce(0.015, 40.0, 0.002)}),
    ("linear", "quadrilateral", 1, "axisymmetric", True, {"hardening": 0.1}),
    ("armstrong_frederick", "hexahedron", 1, "3d", False, {"kinematic": ArmstrongFrederick(0.6, 30.0)}),
    ("armstrong_frederick", "hexahedron", 1, "3d", True, {"kinematic": ArmstrongFrederick(0.6, 30.0)}),
    ("prager", "quadrilateral", 1, "axisymmetric", True, {"kinematic": 0.1}),
    ("voce", "quadrilateral", 2, "plane_strain", True,
     {"hardening": Voce(0.015, 40.0, 0.002), "average": "linear"}),
    ("linear", "hexahedron", 2, "3d", False, {"hardening": 0.1, "average": "linear"}),
    ("voce", "quadrilateral", 1, "plane_stress", False, {"hardening": Voce(0.015, 40.0, 0.002), "kinematic": 0.1}),
    ("linear", "triangle", 2, "plane_stress", True, {"hardening": 0.1}),
    ("voce_armstrong_frederick", "quadrilateral", 1, "plane_stress", True,
     {"hardening": Voce(0.015, 40.0, 0.002), "kinematic": ArmstrongFrederick(0.6, 30.0)}),
)  # fmt: skip


class TangentOfBody:
    """Internal forces of a block and the action of their tangent, from a history that is not virgin.

    Args:
        cell: cell.
        degree: degree of the displacement.
        hypothesis: hypothesis of the material.
        finite: whether strains are finite.
        law: other arguments of J2Plasticity.
    """

    def __init__(self, cell: str, degree: int, hypothesis: str, finite: bool, law: dict[str, object]) -> None:
        domain = distorted_block.block(cell, 1)
        if hypothesis == "axisymmetric":
            domain.geometry.x[:, 0] += 0.5
        self.dim = domain.geometry.dim
        self.V = fem.functionspace(domain, ("Lagrange", degree, (self.dim,)))
        self.u = fem.Function(self.V, name="u")
        options: Any = {**law, "finite_strain": finite, "hypothesis": hypothesis}
        steel = J2Plasticity(E, NU, 1.0, Y, **options)
        self.body = MaterialBody(self.u, steel)

    def force(self, u: FloatArray) -> FloatArray:
        """Internal forces at a displacement, over all degrees of freedom [F].

        Args:
            u: displacement over all degrees of freedom [L].
        """
        self.u.x.array[:] = u
        found: FloatArray = self.body.in_cpp().residual().array.copy()
        return found

    def action(self, u: FloatArray, d: FloatArray) -> FloatArray:
        """Tangent at a displacement times a direction [F].

        Args:
            u: displacement over all degrees of freedom [L].
            d: direction over all degrees of freedom [L].
        """
        self.force(u)
        K = self.body.tangent.assemble()
        x, y = K.createVecs()
        x.array[:] = d
        K.mult(x, y)
        found: FloatArray = y.array.copy()
        x.destroy()
        y.destroy()
        return found

    def homogeneous(self, size: float) -> FloatArray:
        """Displacement with one gradient everywhere: a stretch along the last axis, and shear.

        Args:
            size: size of the gradient [1].
        """
        x = self.V.tabulate_dof_coordinates()[:, : self.dim]
        A = np.zeros((self.dim, self.dim))
        A[-1, -1], A[0, -1], A[0, 0] = 1.0, 0.4, -0.3
        if self.dim == 2:
            A[0, 0] = 0.0
        return size * np.asarray((x @ A.T).ravel())

    def increment(self, u: FloatArray) -> FloatArray:
        """Change of the equivalent plastic strain at all points in a step to a displacement [1].

        Args:
            u: displacement over all degrees of freedom [L].
        """
        self.force(u)
        assert self.body.force is not None
        points = self.body.force.history
        return np.asarray(points.values("plastic_strain", trial=True) - points.values("plastic_strain")).ravel()


def taylor(
    report: Report, name: str, cell: str, degree: int, hypothesis: str, finite: bool, law: dict[str, object]
) -> None:
    """Add the row of the Taylor remainder in a step in which all points go on yielding.

    Args:
        report: report to add to.
        name: name of the law.
        cell: cell.
        degree: degree of the displacement.
        hypothesis: hypothesis of the material.
        finite: whether strains are finite.
        law: other arguments of J2Plasticity.
    """
    body = TangentOfBody(cell, degree, hypothesis, finite, law)
    size = 0.1 if finite else 4.0 * Y / E
    body.force(body.homogeneous(size))
    body.body.in_cpp().accept_step()
    start = body.homogeneous(1.6 * size)
    d = size * np.random.default_rng(7).uniform(-0.3, 0.3, len(start))
    first, direction = body.force(start), body.action(start, d)
    remainders = np.array([np.linalg.norm(body.force(start + s * d) - first - s * direction) for s in STEPS])
    note = f"remainders {', '.join(f'{r:.3g}' for r in remainders)} at steps {STEPS[0]} to {STEPS[-1]}"
    form = f"j2.{'finite' if finite else 'small'}.{name}"
    what = "tangent is the force's derivative"
    difference = abs(slope(remainders) - 2)
    report.add("material", form, cell, degree, 1, hypothesis, difference, SLOPE_TOLERANCE, REASON, what, note)


def corner(
    report: Report, name: str, cell: str, degree: int, hypothesis: str, finite: bool, law: dict[str, object]
) -> None:
    """Add the row of the forces across the corner between elastic and plastic steps.

    Args:
        report: report to add to.
        name: name of the law.
        cell: cell.
        degree: degree of the displacement.
        hypothesis: hypothesis of the material.
        finite: whether strains are finite.
        law: other arguments of J2Plasticity.
    """
    body = TangentOfBody(cell, degree, hypothesis, finite, law)
    end = 4.0 * Y / E
    d = body.homogeneous(1.0)
    low, high = 0.0, end
    while high - low > 1e-12 * end:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if np.any(body.increment(middle * d) > 0.0) else (middle, high)
    together = bool(np.all(body.increment(high * (1.0 + 1e-9) * d) > 0.0))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    integral = np.zeros_like(d)
    for a, b in ((0.0, low), (high, end)):
        for x, w in zip(nodes, weights):
            integral += 0.5 * (b - a) * w * body.action((0.5 * (a + b) + 0.5 * (b - a) * x) * d, d)
    forces = body.force(end * d) - body.force(0.0 * d)
    difference = float(np.abs(integral - forces).max() / np.abs(forces).max()) if together else np.inf
    form = f"j2.{'finite' if finite else 'small'}.{name}"
    note = f"yields at {high / end:.3f} of the way{'' if together else ', not at all points together'}"
    what = "forces across the corner are the tangent's integral"
    report.add("material", form, cell, degree, 1, hypothesis, difference, TOLERANCE, INTEGRAL, what, note)


def run(report: Report) -> None:
    """Add the rows of the tangent.

    Args:
        report: report to add to.
    """
    for case in BODIES:
        if report.wants(case[1], case[2]):
            taylor(report, *case)
            if case[3] != "axisymmetric":  # where points yield one after the other
                corner(report, *case)
