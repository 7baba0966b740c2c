# SPDX-License-Identifier: MIT
"""Linear tetrahedra and triangles that do not lock: the volumetric strain is averaged at the nodes.

docs/averaged_pressure.md has the reasons.

The energy of a body is split into a volumetric part U and the rest. Of a measure m of the change of volume, tr(eps) in
small strain, ln J or J in finite strain, each node a has the mean over its patch of cells,

    m_a = (sum of the cells' integrals of m(u) N_a dx) / V_a,    V_a = integral of N_a dx,

and the energy is that of the rest in the cells and of the volumetric part at the nodes (Bonet & Burton 1998),

    W(u) = integral of psi_rest(u) dx + sum over a of V_a U(m_a).

Its derivative is that of the plain element with the nodes' pressures p_a = U'(m_a) in the place of the cell's own,

    dW(v) = integral of (stress_rest : grad v + sum over a of N_a p_a dm(v)) dx.

The means are a function m_h of degree 1 in the forms here. In a cell of constant strain, where one point integrates,
the sum over a is the mean of the cell's nodes; of a law whose U is a square of m, it is U'(m_h).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, runtime_checkable

import ufl

from . import materials
from .inelastic import Kinematics, PointResponse, Symbols, Update
from .materials import weight

CELLS = ("triangle", "tetrahedron")
HYPOTHESES = ("3d", "plane_strain")
# Part of the bulk modulus that plastic cells keep for their own dilatation. See docs/averaged_pressure.md.
OWN_SHARE = 0.001


def check(cell: str, degree: int, geometry_degree: int, hypothesis: str, integration: str) -> None:
    """Raise ValueError unless averages at the nodes are for these cells.

    Args:
        cell: name of the cell.
        degree: degree of the displacement [1].
        geometry_degree: degree of the geometry [1].
        hypothesis: one of materials.HYPOTHESES.
        integration: what asks for averages, "averaged_pressure" or "averaged_strain".
    """
    if cell not in CELLS or degree != 1 or geometry_degree != 1:
        raise ValueError(
            f'integration="{integration}" is for tetrahedra and triangles of degree 1; these are {cell} cells of '
            f'degree {degree}, of geometry degree {geometry_degree}: use integration="full"'
        )
    if hypothesis not in HYPOTHESES:
        raise ValueError(
            f'integration="{integration}" is for {" and ".join(HYPOTHESES)}, the hypothesis is {hypothesis!r}: use '
            'integration="full"'
        )


def vertex_values(mean: Any) -> list[Any]:
    """Values of a function of degree 1 at the vertices of a cell, as expressions at its midpoint.

    Args:
        mean: the function, a scalar or a vector.
    """
    mesh = ufl.domain.extract_unique_domain(mean)
    slope = ufl.dot(ufl.grad(mean), ufl.Jacobian(mesh))  # differences from the first vertex
    n = slope.ufl_shape[-1]
    first = mean - sum((slope[..., i] for i in range(1, n)), slope[..., 0]) / (n + 1)
    return [first] + [first + slope[..., i] for i in range(n)]


def over_vertices(of: Callable[[Any], Any], mean: Any) -> Any:
    """Mean over the vertices of a cell of what a function gives for the value of `mean` there.

    Args:
        of: function of a value.
        mean: function of degree 1, a scalar or a vector.
    """
    values = vertex_values(mean)
    return sum(of(value) for value in values) / len(values)


class LinearElastic(materials.LinearElastic):
    """Small strain, sigma = lambda m_h I + 2 mu eps with the nodes' means m_h of tr(eps).

    The cells keep the bulk modulus 2 mu / 3 of their own strain: it stiffens modes of alternating dilatations, which
    the nodes do not see, and does not lock, as it stays small when nu goes to 1/2.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of HYPOTHESES.
        mean: m_h, a function of degree 1 [1].
    """

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis)
        self.mean = mean

    @staticmethod
    def num_means(dim: int) -> int:
        """Number of means of a node."""
        return 1

    def measure(self, u: Any) -> Any:
        """What is averaged [1]."""
        return ufl.tr(self.gradient(u))

    def energy_density(self, u: Any) -> Any:
        eps = self.strain(u)
        return self.mu * ufl.inner(eps, eps) + self.lmbda / 2 * over_vertices(lambda m: m**2, self.mean)

    def stress(self, u: Any) -> Any:
        # Over the cell's Jacobian, by whose reciprocal strains of the cell are multiplied and means are not: kernels
        # then divide while they compute the sum, and multiply by the quotient last.
        volume = ufl.JacobianDeterminant(ufl.domain.extract_unique_domain(u))
        share = self.lmbda / (2 * self.mu)
        return 2 * self.mu / volume * (volume * self.strain(u) + share * self.mean * volume * ufl.Identity(3))

    def stress_derivative(self, u: Any, du: Any) -> Any:
        """As if each cell had the means of its own: an upper bound, by Jensen's inequality."""
        return super().stress(du)


class NeoHookean(materials.NeoHookean):
    """P = mu (F - F^-T) + lambda m_h F^-T with the nodes' means m_h of ln J; the rest as of LinearElastic.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of HYPOTHESES.
        mean: m_h, a function of degree 1 [1].
    """

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis)
        self.mean = mean

    @staticmethod
    def num_means(dim: int) -> int:
        """Number of means of a node."""
        return 1

    def _state(self, u: Any) -> tuple[Any, Any, Any]:
        return ufl.Identity(3) + self.gradient(u), self.mean, None

    def measure(self, u: Any) -> Any:
        """What is averaged [1]."""
        return ufl.ln(ufl.det(ufl.Identity(3) + self.gradient(u)))

    def energy_density(self, u: Any) -> Any:
        F = ufl.Identity(3) + self.gradient(u)
        rest = self.mu / 2 * (ufl.inner(F, F) - 3) - self.mu * self.measure(u)
        return rest + self.lmbda / 2 * over_vertices(lambda m: m**2, self.mean)

    # `stress_derivative` is inherited: as if each cell had the means of its own, an upper bound.


LAWS = {law.name: law for law in (LinearElastic, NeoHookean)}


def average(measure: Any, test: Any, hypothesis: str, dx: Any) -> Any:
    """Integral of a measure, or with the measure 1 of a volume, for each node: numerator and denominator of its mean.

    Args:
        measure: of the change of volume.
        test: test function of degree 1; of a vector of means one with a component for each.
        hypothesis: one of HYPOTHESES.
        dx: measure of the cells.
    """
    if test.ufl_shape:
        tested = ufl.inner(ufl.as_vector([1] * len(test)) if measure == 1 else measure, test)
    else:
        tested = measure * test
    return tested * weight(ufl.domain.extract_unique_domain(test), hypothesis) * dx


# --- laws with internal variables ------------------------------------------------------------------------------------


@runtime_checkable
class VolumetricResponse(Protocol):
    """What the averages ask of a law with internal variables: the part U of its elastic energy that a change of volume
    alone stores, in terms of tr(eps), in finite strain of J."""

    def volume_energy(self, values: Sequence[Any]) -> Any:
        """Mean of U over some values [F L/L^3]."""
        ...

    def volume_pressure(self, values: Sequence[Any]) -> Any:
        """Mean of the derivative of U over some values: the mean stress, in finite strain Cauchy's [F/L^2]."""
        ...


class AveragedKinematics(Kinematics):
    """Strains of a law with internal variables; all but OWN_SHARE of its mean stress follows from the nodes' means.

    Plastic flow leaves the deviator of a cell little stiffness against modes of alternating dilatations. A small part
    of the bulk modulus stays in the cell for it, as in stabilised nodal integration (Puso & Solberg 2006).

    Args:
        hypothesis: one of HYPOTHESES.
        finite_strain: whether the law sees the deformation gradient instead of the small strain.
        mean: m_h, means of tr(eps), in finite strain of J, a function of degree 1 [1].
    """

    def __init__(self, hypothesis: str, finite_strain: bool, mean: Any) -> None:
        super().__init__(hypothesis, finite_strain)
        self.mean = mean

    def respond(self, response: PointResponse, u: Any, symbols: Symbols) -> Update:
        """As Kinematics.respond; the elastic energy is that of the nodes, too.

        Raises:
            ValueError: the law does not say what its volumetric part is.
        """
        if not isinstance(response, VolumetricResponse):
            raise ValueError(
                'integration="averaged_pressure" needs a law that gives its volumetric part by itself '
                '(forms/averaged_pressure.py: VolumetricResponse): use integration="full"'
            )
        own = response.respond(self.strain(u), dict(symbols.history), symbols.unknown)
        nodes, here = vertex_values(self.mean), [self.dilatation(u)]
        change = response.volume_pressure(nodes) - response.volume_pressure(here)
        stored = response.volume_energy(nodes) - response.volume_energy(here)
        change, stored = (1 - OWN_SHARE) * change, own.stored + (1 - OWN_SHARE) * stored
        if not self.finite_strain:
            stress = own.stress + change * ufl.Identity(3)
        else:
            F = ufl.Identity(3) + self.gradient(u)
            change = ufl.det(F) * change
            parts = own.kirchhoff
            if parts is not None and parts.piola is own.piola:
                stress = (parts.rest + (own.mean + change) * ufl.Identity(3)) * parts.inverse.T
            else:
                stress = own.stress + change * ufl.inv(F).T
        return Update(stress, own.outputs, stored, own.residual, own.start, own.scale, start_error=own.start_error)
