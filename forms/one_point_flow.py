# SPDX-License-Identifier: MIT
"""One point with hourglass control for laws with internal variables; docs/one_point.md derives it.

The law sees the mean gradient of a cell. Strains e_k of the hourglass modes are those of a plate across each axis k,
(e_i, e_j, gamma) times z_k, and e_123,i z_j z_k, as in one_point.py. They have a plastic part that is history, and
moments per volume

    m_k = 1/12 D (e_k - e_k^p),    m_123,i = 1/144 E (e_123,i - e_123,i^p)

with the matrix D of a plate in plane stress. A step in which the law flows by da along n, at the flow stress Y, goes
through three parts, each in closed form:

1. along n, fibres flow together with the mean, as long as those at the faces do not stop: |d e_k^p| <= 2 da n;
2. across n, the linearised radial return leaves the share Y/(Y + 3 mu da) of them;
3. the moments end at those of sections that flow all through, Y/4 of a plate and Y/16 of a twist: with von Mises'
   equivalent q, sum_k q(m_k)^2 + 16 sum_i m_123,i^2 is (Y/4)^2 at most.

In finite strain the modes are measured by the present lengths of the axes a_i = mean(F) x_i.
"""

import math
from dataclasses import dataclass
from typing import Any

import ufl

from .inelastic import Flow, Kinematics, PointResponse, Symbols, Update, elastic_work
from .materials import Law
from .one_point import CELLS, HYPOTHESES, SQUARE, OnePointCell, pair

HOURGLASS_STRAIN = "hourglass_strain"  # plastic part of the strains of the modes, a vector [1]
PLATE_LIMIT, TWIST_LIMIT = 1 / 4, 1 / 16  # means of |z| over z in (-1/2, 1/2) and of |z_j z_k|: full plastic moments
FACE = 1 / 2  # distance of the faces of a plate from its middle plane
NO_FLOW = 1e-12  # of E: keeps the division by the stiffness along n finite where n has no part in the plate
ROUND_OFF = 1e-14  # of the flow stress: keeps the direction of a zero stress finite


def num_strains(dim: int) -> int:
    """Number of strains of the hourglass modes in a dimension."""
    return 12 if dim == 3 else 2


class OnePointResponse:
    """A law with internal variables on cells with one point: its history, and that of the hourglass modes.

    Args:
        law: the law.
        dim: dimension [1].
    """

    def __init__(self, law: PointResponse, dim: int) -> None:
        self.law, self.unknown = law, law.unknown
        self.history: dict[str, tuple[int, ...]] = {**law.history, HOURGLASS_STRAIN: (num_strains(dim),)}

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any) -> Update:
        """What the law alone computes."""
        own = {name: value for name, value in history.items() if name != HOURGLASS_STRAIN}
        return self.law.respond(strain, own, unknown)


@dataclass
class OnePointUpdate(Update):
    """What a cell with one point computes. `stress` and `strain` are those of the mean gradient.

    Attributes:
        modes: moments and axes of the hourglass modes.
    """

    modes: "ModeForces | None" = None


@dataclass
class ModeForces:
    """Forces on the hourglass modes per volume, and what turning and stretching axes add to the stress.

    Attributes:
        on_modes: vectors by mode [F/L].
        on_mean: dim x dim, or None in small strain [F/L^2].
    """

    on_modes: dict[Any, Any]
    on_mean: Any


class Modes:
    """Strains of the hourglass modes of a displacement.

    Args:
        cell: mean gradients and modes of the cells.
        u: displacement [L].
        finite_strain: whether the axes move with the body.
    """

    def __init__(self, cell: OnePointCell, u: Any, finite_strain: bool) -> None:
        self._cell, self._moves = cell, finite_strain
        self._h = cell.hourglass(u)
        gradient = cell.mean_gradient(u)
        self.axes = [a + gradient * a for a in cell.axes] if finite_strain else cell.axes
        if finite_strain:
            # One division: the reciprocal of the product.
            lengths = [ufl.sqrt(ufl.dot(a, a)) for a in self.axes]
            reciprocal = 1 / math.prod(lengths)
            self._r = [math.prod(lengths[:i] + lengths[i + 1 :]) * reciprocal for i in range(len(lengths))]
            self.s = [r**2 for r in self._r]
        else:
            self.s = [1 / ufl.dot(a, a) for a in self.axes]
            self._r = [ufl.sqrt(s) for s in self.s]
        self.strain = self._strains(self.axes, self._h)

    @property
    def keys(self) -> list[Any]:
        """Names of the strains in the order of the history: (k, i) and, in space, (k, None) of the shear for each plate
        k, then (None, i) of the twists."""
        dim, found = self._cell.dim, []
        for k in range(dim):
            found += [(k, i) for i in range(dim) if i != k] + ([(k, None)] if dim == 3 else [])
        return found + ([(None, i) for i in range(3)] if dim == 3 else [])

    def shear_scale(self, k: int) -> Any:
        """Factor of the shear of plate k, 1/(|a_i| |a_j|) of its two axes."""
        i, j = (a for a in range(3) if a != k)
        return self._r[i] * self._r[j]

    def _strains(self, axes: Any, h: Any) -> dict[Any, Any]:
        """Scaled products of axes and modes; of the present ones the strains."""
        found, dim = {}, self._cell.dim
        for k, i in self.keys:
            if k is None:
                found[k, i] = ufl.dot(axes[i], h[None]) * self.s[i]
            elif i is None:
                a, b = (m for m in range(dim) if m != k)
                found[k, i] = (ufl.dot(axes[a], h[pair(b, k)]) + ufl.dot(axes[b], h[pair(a, k)])) * self.shear_scale(k)
            else:
                found[k, i] = ufl.dot(axes[i], h[pair(i, k)]) * self.s[i]
        return found

    def derivative(self, v: Any) -> dict[Any, Any]:
        """Derivative of `strain` in the direction v."""
        found = self._strains(self.axes, self._cell.hourglass(v))
        if not self._moves:
            return found
        gradient = self._cell.mean_gradient(v)
        change = [gradient * a for a in self._cell.axes]
        more = self._strains(change, self._h)
        shorter = [ufl.dot(a, c) * s for a, c, s in zip(self.axes, change, self.s)]
        for k, i in self.keys:
            if i is None:
                a, b = (m for m in range(3) if m != k)
                more[k, i] -= self.strain[k, i] * (shorter[a] + shorter[b])
            else:
                more[k, i] -= 2 * self.strain[k, i] * shorter[i]
        return {key: value + more[key] for key, value in found.items()}

    def forces(self, moment: dict[Any, Any]) -> ModeForces:
        """Forces that do the work of moments.

        Args:
            moment: conjugates of the strains per volume, by key [F/L^2].
        """
        dim, axes, h = self._cell.dim, self.axes, self._h
        products: dict[Any, Any] = {}  # factors of a_i . h_m by mode m and axis i
        stretched = [ufl.as_ufl(0) for _ in range(dim)]
        for k, i in self.keys:
            m = moment[k, i]
            if i is None:
                a, b = (n for n in range(3) if n != k)
                shear = m * self.shear_scale(k)
                for axis, other in ((a, b), (b, a)):
                    key = pair(other, k), axis  # in the shear of two plates
                    products[key] = products.get(key, 0) + shear
                    stretched[axis] = stretched[axis] + m * self.strain[k, i]
            else:
                products[None if k is None else pair(i, k), i] = m * self.s[i]
                stretched[i] = stretched[i] + 2 * m * self.strain[k, i]
        on_modes = {
            mode: sum((products[mode, i] * axes[i] for i in range(dim) if (mode, i) in products), ufl.zero(dim))
            for mode in h
        }
        if not self._moves:
            return ModeForces(on_modes, None)
        on_mean = 0
        for i in range(dim):
            on_axis = sum((products[mode, i] * h[mode] for mode in h if (mode, i) in products), ufl.zero(dim))
            on_mean = on_mean + ufl.outer(on_axis - stretched[i] * self.s[i] * axes[i], self._cell.axes[i])
        return ModeForces(on_modes, on_mean)


class OnePointKinematics(Kinematics):
    """Mean strains of cells for a law with internal variables, and their hourglass modes, which flow with it.

    Args:
        mesh: UFL mesh of quadrilaterals or hexahedra of degree 1.
        elastic: elastic part of the law, LinearElastic, whose hypothesis is that of the body.
        finite_strain: whether the law sees the deformation gradient instead of the small strain.

    Raises:
        ValueError: other cells or hypotheses.
    """

    def __init__(self, mesh: Any, elastic: Law, finite_strain: bool) -> None:
        if mesh.ufl_coordinate_element().cell_type.name not in CELLS or elastic.hypothesis not in HYPOTHESES:
            raise ValueError(
                f"one point with hourglass control is for {' and '.join(CELLS)} cells and the hypotheses "
                f"{', '.join(HYPOTHESES)}"
            )
        super().__init__(elastic.hypothesis, finite_strain)
        self.elastic, self.cell = elastic, OnePointCell(mesh)
        E, nu = elastic.E, elastic.nu
        self._plate = E if elastic.hypothesis == "plane_stress" else E / (1 - nu**2)

    def gradient(self, u: Any) -> Any:
        """Mean of the displacement gradient over the cell, 3 x 3."""
        g, dim = self.cell.mean_gradient(u), self.cell.dim
        return ufl.as_tensor([[g[i, j] if max(i, j) < dim else 0 for j in range(3)] for i in range(3)])

    def modes(self, u: Any) -> Modes:
        """Hourglass modes of a displacement."""
        return Modes(self.cell, u, self.finite_strain)

    def respond(self, response: PointResponse, u: Any, symbols: Symbols) -> OnePointUpdate:
        """As Kinematics.respond, with the hourglass modes.

        Raises:
            ValueError: the law does not say at which stress it flows.
        """
        history = dict(symbols.history)
        strain = self.strain(u)
        own = response.respond(strain, history, symbols.unknown)
        if own.flow is None:
            raise ValueError(
                "integration='reduced' needs the stress at which a law flows, where its hourglass modes give way: "
                "return MaterialUpdate(..., flow=MaterialFlow(stress=Y, increment=da)) with the flow stress Y [F/L^2] "
                "and the increment da of the equivalent plastic strain [1], or take integration='full'"
            )
        modes = self.modes(u)
        before = {key: history[HOURGLASS_STRAIN][n] for n, key in enumerate(modes.keys)}
        trial = {key: modes.strain[key] - before[key] for key in modes.keys}
        direction = own.flow.direction
        if direction is None:
            direction = self._direction(own, strain)
        plastic = self._return(modes, trial, before, own.flow, direction)
        left = {key: trial[key] - plastic[key] for key in modes.keys}
        moment = self._moments(left)
        energy = sum(moment[key] * left[key] for key in modes.keys) / 2
        outputs = {**own.outputs, HOURGLASS_STRAIN: ufl.as_vector([before[key] + plastic[key] for key in modes.keys])}
        return OnePointUpdate(
            own.stress, outputs, self.cell.integrand(self.cell.volume * (own.stored + energy)), own.residual, own.start,
            own.scale, strain=own.strain, start_error=own.start_error, modes=modes.forces(moment),
        )  # fmt: skip

    def hourglass_density(self, u: Any, plastic: Any) -> Any:
        """Integrand of the elastic energy of the hourglass modes.

        Args:
            u: displacement [L].
            plastic: plastic part of their strains, in the order of `Modes.keys` [1].
        """
        modes = self.modes(u)
        left = {key: modes.strain[key] - plastic[n] for n, key in enumerate(modes.keys)}
        moment = self._moments(left)
        return self.cell.integrand(self.cell.volume * sum(moment[key] * left[key] for key in left) / 2)

    def _direction(self, update: Update, strain: Any) -> Any:
        """Flow direction along the deviator of the stress."""
        stress = update.stress * strain.T if self.finite_strain else update.stress
        s = ufl.dev(stress)
        return 1.5 / ufl.sqrt(1.5 * ufl.inner(s, s) + (ROUND_OFF * update.flow.stress) ** 2) * s

    def _plate_moments(self, strain: dict[Any, Any], k: int) -> dict[Any, Any]:
        """Moments of plate k per volume of elastic strains."""
        dim, law = self.cell.dim, self.elastic
        others = [i for i in range(dim) if i != k]
        moment = {}
        for i in others:
            coupled = sum(law.nu * strain[k, j] for j in others if j != i)
            moment[k, i] = SQUARE * self._plate * (strain[k, i] + coupled)
        if dim == 3:
            moment[k, None] = SQUARE * law.mu * strain[k, None]
        return moment

    def _moments(self, strain: dict[Any, Any]) -> dict[Any, Any]:
        """Moments per volume of elastic strains."""
        moment: dict[Any, Any] = {}
        for k in range(self.cell.dim):
            moment |= self._plate_moments(strain, k)
            if self.cell.dim == 3:
                moment[None, k] = SQUARE**2 * self.elastic.E * strain[None, k]
        return moment

    def _equivalent_square(self, moment: dict[Any, Any], k: int) -> Any:
        """Square of von Mises' equivalent of the moment of plate k. In plane strain that across the plane, nu times the
        one in it, counts."""
        if self.cell.dim == 3:
            i, j = (a for a in range(3) if a != k)
            a, b, c = moment[k, i], moment[k, j], moment[k, None]
            return a * a + b * b - a * b + 3 * (c * c)
        nu = self.elastic.nu
        share = 1 if self.hypothesis == "plane_stress" else 1 - nu + nu**2
        return share * moment[k, 1 - k] ** 2

    def _along(self, modes: Modes, direction: Any, k: int) -> dict[Any, Any]:
        """Part of a direction of flow in plate k."""
        dim, axes = self.cell.dim, modes.axes
        others = [i for i in range(dim) if i != k]
        turned = {i: [sum(direction[m, n] * axes[i][n] for n in range(dim)) for m in range(dim)] for i in others}

        def product(i: int, j: int) -> Any:
            return sum(axes[i][m] * turned[j][m] for m in range(dim))

        found = {(k, i): product(i, i) * modes.s[i] for i in others}
        if dim == 3:
            i, j = others
            found[k, None] = 2 * product(i, j) * modes.shear_scale(k)
        return found

    def _return(
        self, modes: Modes, trial: dict[Any, Any], before: dict[Any, Any], flow: Flow, direction: Any
    ) -> dict[Any, Any]:
        """Plastic increments of the strains of the modes.

        Args:
            modes: the modes.
            trial: their elastic strains, if the step is elastic.
            before: their plastic strains.
            flow: flow of the law.
            direction: its direction.
        """
        law, Y, dim = self.elastic, flow.stress, self.cell.dim
        left = Y / (Y + 3 * law.mu * flow.increment) if flow.left is None else flow.left
        most = flow.increment / FACE
        along = [self._along(modes, direction, k) for k in range(dim)]
        of_along = [self._plate_moments(along[k], k) for k in range(dim)]
        # With back moments of hardening/E D e^p / 12, as of linear kinematic hardening.
        hardening = ufl.max_value(flow.slope, 0) / law.E
        relative = {key: trial[key] - hardening * before[key] for key in modes.keys}
        moment = self._moments(relative)
        stiffness = [sum(a[key] * m[key] for key in a) + NO_FLOW * law.E for a, m in zip(along, of_along)]
        # One division: the reciprocal of the product.
        reciprocal = 1 / math.prod(stiffness)
        step: dict[Any, Any] = {}  # along the flow
        for k in range(dim):
            others = math.prod(stiffness[:k] + stiffness[k + 1 :])
            wanted = sum(along[k][key] * moment[key] for key in along[k]) * (others * reciprocal)
            flowing = ufl.max_value(ufl.min_value(wanted, most), -most)
            parts = {key: flowing * value for key, value in along[k].items()}
            if flow.yields is not None:
                parts = {key: ufl.conditional(flow.yields, value, 0) for key, value in parts.items()}
            step |= parts
            change = self._plate_moments(parts, k)
            moment |= {key: moment[key] - change[key] for key in parts}
        square = sum(self._equivalent_square(moment, k) for k in range(dim))
        if dim == 3:
            square += (PLATE_LIMIT / TWIST_LIMIT) ** 2 * sum(moment[None, i] ** 2 for i in range(dim))
        share = left * _limited(left**2 * square, PLATE_LIMIT * Y)
        shorter = 1 / (1 + hardening)
        return {key: shorter * ((1 - share) * relative[key] + share * step.get(key, 0)) for key in modes.keys}

    def virtual_work(self, u: Any, v: Any, update: Update) -> Any:
        """Integrand of the virtual work of an update of `respond`."""
        assert isinstance(update, OnePointUpdate) and update.modes is not None
        return self.cell.virtual_work(update.stress, update.modes.on_modes, update.modes.on_mean, v)

    def elastic_tangent(self, u: Any, du: Any, v: Any) -> Any:
        """Integrand of the stiffness of the elastic solid in the deformed shape, that of its modes included."""
        work = elastic_work(u, du, v, self.elastic, self)
        modes = self.modes(u)
        moment, virtual = self._moments(modes.derivative(du)), modes.derivative(v)
        work += sum(moment[key] * virtual[key] for key in modes.keys)
        return self.cell.integrand(self.cell.volume * work)


def _limited(square: Any, limit: Any) -> Any:
    """Factor, 1 at most, by which a moment is reduced whose equivalent must not exceed a limit."""
    beyond = ufl.gt(square, limit**2)
    return ufl.conditional(beyond, limit / ufl.sqrt(ufl.conditional(beyond, square, limit**2)), 1)
