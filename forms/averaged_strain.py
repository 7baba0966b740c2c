# SPDX-License-Identifier: MIT
"""Linear tetrahedra and triangles whose bending is right: a share of the whole strain is averaged at the nodes.

docs/averaged_pressure.md has the reasons. The volumetric part U of the energy belongs to the nodes as in
averaged_pressure.py, and so does a share b of the rest,

    W(u) = integral of (1 - b) psi_rest(u) dx + sum over a of V_a (U(m_a) + b psi_rest(F_a)),

with the means F_a of the displacement's gradient at the nodes: the alpha finite element method (Nguyen-Thoi &
Nguyen-Xuan 2010) with another split, a kind of stabilised nodal integration (Puso & Solberg 2006). The means of a node
are the components of a vector. As each of them is a mean over the same cells, all that averaged_pressure.py says of one
holds for each.
"""

from __future__ import annotations

from typing import Any

import ufl

from . import averaged_pressure, materials
from .averaged_pressure import over_vertices

# Share of the rest at the nodes. Cells alone (0) are too stiff in bending, nodes alone (1) too soft and without
# stiffness against modes that alternate from cell to cell. With 0.6 both common divisions of cubes into tetrahedra bend
# within 2 % with 6 cubes through the thickness, for nu = 0.3 and 0.499: the table of docs/averaged_pressure.md.
SHARE = 0.6


def symmetric_components(dim: int) -> list[tuple[int, int]]:
    """Places of the components of a symmetric tensor in a vector of means: normal ones first, then xy, yz, xz.

    Args:
        dim: 2 or 3.
    """
    return [(i, i) for i in range(dim)] + ([(0, 1)] if dim == 2 else [(0, 1), (1, 2), (0, 2)])


def gradient_components(u: Any) -> list[Any]:
    """Components of the displacement's gradient in a vector of means, row by row.

    Args:
        u: displacement.
    """
    H, dim = ufl.grad(u), len(u)
    return [H[i, j] for i in range(dim) for j in range(dim)]


def cells_shear_modulus(mu: Any) -> Any:
    """Shear modulus of what is left for the cells of the rest [F/L^2].

    Args:
        mu: shear modulus of the material [F/L^2].
    """
    return (1 - SHARE) * mu


def moduli_at_nodes(lmbda: float, mu: float) -> tuple[float, float]:
    """Lame's constants of the stress of the nodes' means of a strain or gradient [F/L^2].

    Args:
        lmbda: Lame's first constant of the material [F/L^2].
        mu: its shear modulus [F/L^2].
    """
    return lmbda, SHARE * mu


class LinearElastic(materials.LinearElastic):
    """Small strain, sigma = lambda tr(e_h) I + 2 mu (b e_h + (1 - b) eps) with the nodes' means e_h of eps.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of averaged_pressure.HYPOTHESES.
        mean: e_h, a vector of degree 1 with the components `symmetric_components` [1].
    """

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis)
        self.mean = mean

    @staticmethod
    def num_means(dim: int) -> int:
        """Number of means of a node."""
        return len(symmetric_components(dim))

    def measure(self, u: Any) -> Any:
        """What is averaged [1]."""
        eps = ufl.sym(ufl.grad(u))
        return ufl.as_vector([eps[i, j] for i, j in symmetric_components(len(u))])

    def _strain_of(self, mean: Any) -> Any:
        """Strain of a node's means, 3 x 3."""
        dim = 3 if len(mean) == 6 else 2
        at = {frozenset(place): k for k, place in enumerate(symmetric_components(dim))}
        eps = ufl.as_tensor([[mean[at[frozenset((i, j))]] for j in range(dim)] for i in range(dim)])
        return materials.in_space(eps, self.hypothesis)

    def energy_density(self, u: Any) -> Any:
        def at_node(mean: Any) -> Any:
            eps = self._strain_of(mean)
            return self.lmbda / 2 * ufl.tr(eps) ** 2 + SHARE * self.mu * ufl.inner(eps, eps)

        eps = self.strain(u)
        return (1 - SHARE) * self.mu * ufl.inner(eps, eps) + over_vertices(at_node, self.mean)

    def stress(self, u: Any) -> Any:
        eps = self._strain_of(self.mean)
        at_nodes = self.lmbda * ufl.tr(eps) * ufl.Identity(3) + 2 * SHARE * self.mu * eps
        return 2 * (1 - SHARE) * self.mu * self.strain(u) + at_nodes

    def stress_derivative(self, u: Any, du: Any) -> Any:
        """As if each cell had the means of its own: an upper bound, by Jensen's inequality."""
        return super().stress(du)


class NeoHookean(materials.NeoHookean):
    """P = mu (1 - b) (F - F^-T) + mu b (mean over the vertices of F_a - F_a^-T) + lambda m_h F^-T with the nodes' means
    F_a of F and m_h of ln J; the rest as of LinearElastic.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of averaged_pressure.HYPOTHESES.
        mean: means of a node, a vector of degree 1: components of grad u, row by row, then ln J [1].
    """

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis)
        self.mean = mean

    @staticmethod
    def num_means(dim: int) -> int:
        """Number of means of a node."""
        return dim * dim + 1

    def measure(self, u: Any) -> Any:
        """What is averaged [1]."""
        log_J = ufl.ln(ufl.det(ufl.Identity(len(u)) + ufl.grad(u)))
        return ufl.as_vector([*gradient_components(u), log_J])

    def _gradient_of(self, mean: Any) -> Any:
        """Deformation gradient of a node's means, 3 x 3."""
        dim = 3 if len(mean) == 10 else 2
        H = ufl.as_tensor([[mean[dim * i + j] for j in range(dim)] for i in range(dim)])
        return ufl.Identity(3) + materials.in_space(H, self.hypothesis)

    def _state(self, u: Any) -> tuple[Any, Any, Any]:
        return ufl.Identity(3) + self.gradient(u), self.mean[len(self.mean) - 1], None

    def _rest(self, F: Any) -> Any:
        return self.mu / 2 * (ufl.inner(F, F) - 3) - self.mu * ufl.ln(ufl.det(F))

    def energy_density(self, u: Any) -> Any:
        def at_node(mean: Any) -> Any:
            return self.lmbda / 2 * mean[len(mean) - 1] ** 2 + SHARE * self._rest(self._gradient_of(mean))

        F = ufl.Identity(3) + self.gradient(u)
        return (1 - SHARE) * self._rest(F) + over_vertices(at_node, self.mean)

    def stress(self, u: Any) -> Any:
        def at_node(mean: Any) -> Any:
            F = self._gradient_of(mean)
            return F - ufl.inv(F).T

        F, log_J, _ = self._state(u)
        inverse, mu = ufl.inv(F).T, self.mu
        nodes = SHARE * mu * over_vertices(at_node, self.mean)
        return (1 - SHARE) * mu * (F - inverse) + self.lmbda * log_J * inverse + nodes

    def stress_derivative(self, u: Any, du: Any) -> Any:
        """As if each cell had the means of its own, in the nodes' deformed shapes: an upper bound where the derivative
        at the nodes' mean gradients is positive, by Jensen's inequality."""
        dF = self.gradient(du)

        def turned(F: Any) -> Any:
            inverse = ufl.inv(F).T
            return inverse * dF.T * inverse

        F, log_J, _ = self._state(u)
        inverse, mu = ufl.inv(F).T, self.mu
        nodes = over_vertices(lambda mean: turned(self._gradient_of(mean)), self.mean)
        shear = mu * dF + mu * ((1 - SHARE) * turned(F) + SHARE * nodes)
        return shear - self.lmbda * log_J * turned(F) + self.lmbda * ufl.inner(inverse, dF) * inverse


LAWS: dict[str, Any] = {law.name: law for law in (LinearElastic, NeoHookean)}


# --- the same, split into what cells and nodes do by themselves -------------------------------------------------------
# A mean of a gradient is linear in the displacement. Where forces of its stress are added node by node, by the matrix
# that gives the means (operators/LinearSums.h), no kernel reads it.


class CellsOfLinearElastic(materials.LinearElastic):
    """sigma = 2 mu (1 - b) eps: what is left of LinearElastic for the cells.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of averaged_pressure.HYPOTHESES.
    """

    def __init__(self, E: Any, nu: Any, hypothesis: str) -> None:
        super().__init__(E, nu, hypothesis)
        self.lmbda, self.mu = 0, cells_shear_modulus(self.mu)


class CellsOfNeoHookean(averaged_pressure.NeoHookean):
    """P = mu (1 - b) (F - F^-T) + lambda m_h F^-T with the nodes' means m_h of ln J: what is left of NeoHookean for the
    cells. Arguments are those of averaged_pressure.NeoHookean."""

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis, mean)
        self.mu = cells_shear_modulus(self.mu)


class NodesOfNeoHookean(materials.NeoHookean):
    """What nodes average for P = mu b (F_a - F_a^-T): components of grad u, row by row.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        hypothesis: one of averaged_pressure.HYPOTHESES.
        mean: their means, a vector of degree 1 [1].
    """

    linear = True  # in the displacement: the means

    def __init__(self, E: Any, nu: Any, hypothesis: str, mean: Any) -> None:
        super().__init__(E, nu, hypothesis)
        self.mean = mean

    @staticmethod
    def num_means(dim: int) -> int:
        return dim * dim

    def measure(self, u: Any) -> Any:
        return ufl.as_vector(gradient_components(u))


# For each law that of the cells and that of the nodes.
SPLIT: dict[str, tuple[Any, Any]] = {
    "linear_elastic": (CellsOfLinearElastic, LinearElastic),
    "neo_hookean": (CellsOfNeoHookean, NodesOfNeoHookean),
}
