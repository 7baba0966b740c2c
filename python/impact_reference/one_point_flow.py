# SPDX-License-Identifier: MIT
"""Quadrilaterals and hexahedra with one point, whose hourglass modes flow with J2 plasticity.

The mean law is a J2Point of the mean strain. The modes' strains, of a plate across each axis and of the mode
xi eta zeta, come from the shape vectors gamma of one_point.py; their derivatives by the nodes' displacements, the
matrix B of the modes, from complex steps: no derivative is written down. Reference coordinates run from -1 to 1: means
of xi^2 are 1/3, and full plastic moments Y/2, and Y/4 of xi eta.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import rules
from ._reference import Material
from .array_types import AnyArray, ArrayLike, FloatArray, floats, integers
from .free_motion import BodyForces, FreeMotion, lumped_mass, move_freely
from .one_point import hourglass_vectors, uniform_gradient
from .plasticity import J2Answer, J2Parameters, J2Point

COMPLEX_STEP = 1e-30
NO_FLOW = 1e-12  # of E, as the smallest stiffness along the flow


@dataclass
class FlowingCell:
    """What a cell has at a displacement.

    Attributes:
        force: internal force, shape (gdim n) [F].
        energy: elastic energy, that of the hourglass modes included [F L].
        hourglass: elastic energy of the hourglass modes [F L].
        answer: of the mean law.
        plastic: plastic strains of the modes, shape (12) or in the plane (2) [1].
    """

    force: FloatArray
    energy: float
    hourglass: float
    answer: J2Answer
    plastic: FloatArray


class OnePointPlastic:
    """A cell with one point and its committed history.

    Args:
        cell_type: "quadrilateral" or "hexahedron".
        X: nodes in the order of `reference_nodes`, shape (n, gdim) [L].
        parameters: the law, of linear isotropic hardening.
        slope: slope of the yield stress [F/L^2].
        hypothesis: "3d", "plane_strain" or "plane_stress".
        strain: "small" or "simo".
    """

    def __init__(
        self, cell_type: str, X: ArrayLike, parameters: J2Parameters, slope: float, hypothesis: str, strain: str
    ) -> None:
        nodes = floats(X)
        self._parameters, self._slope, self._hypothesis, self._small = parameters, slope, hypothesis, strain == "small"
        self._dim = nodes.shape[1]
        self._volume, self._b = uniform_gradient(cell_type, nodes)
        self._gamma = hourglass_vectors(cell_type, nodes, self._b)
        _, dN = rules.shape_functions(cell_type, 1, np.zeros((1, self._dim)))
        self._axes = dN[0].T @ nodes
        self.point = J2Point(parameters, 1, strain, "plane_stress" if hypothesis == "plane_stress" else "3d")
        self.plastic: FloatArray = np.zeros(12 if self._dim == 3 else 2)

    def _modes(self, u: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Strains of the modes, real or complex, and the present axes as rows."""
        axes = self._axes if self._small else self._axes + self._axes @ (u.T @ self._b).T
        q = self._gamma @ u
        squares = np.einsum("ik,ik->i", axes, axes)
        if self._dim == 2:
            along = axes @ q[0]
            return np.array([along[1] / squares[1], along[0] / squares[0]]), axes
        found = []
        with_normal = {(0, 1): 0, (1, 2): 1, (0, 2): 2}
        for normal in range(3):
            i, j = [a for a in range(3) if a != normal]
            qi, qj = (q[with_normal[min(a, normal), max(a, normal)]] for a in (i, j))
            shear = (axes[i] @ qj + axes[j] @ qi) / np.sqrt(squares[i] * squares[j])
            found += [axes[i] @ qi / squares[i], axes[j] @ qj / squares[j], shear]
        return np.array([*found, *(axes[i] @ q[3] / squares[i] for i in range(3))]), axes

    def _stiffness(self) -> FloatArray:
        """Moments over elastic strains of the modes, per volume."""
        E, nu = self._parameters.E, self._parameters.nu
        if self._dim == 2:
            return np.eye(2) * (E if self._hypothesis == "plane_stress" else E / (1 - nu**2)) / 3
        D = np.zeros((12, 12))
        plate = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        for k in range(3):
            D[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = plate / 3
            D[9 + k, 9 + k] = E / 9
        return D

    def _equivalent(self, moment: FloatArray) -> float:
        """Von Mises' equivalent of all moments, in units of one of a plate."""
        if self._dim == 2:
            nu = self._parameters.nu
            share = 1.0 if self._hypothesis == "plane_stress" else 1 - nu + nu**2
            return float(np.sqrt(share * np.sum(moment**2)))
        mises = np.array([[1, -0.5, 0], [-0.5, 1, 0], [0, 0, 3]])
        plates = sum(m @ mises @ m for m in moment[:9].reshape(3, 3))
        return float(np.sqrt(plates + 4 * np.sum(moment[9:] ** 2)))

    def _along(self, flow: FloatArray, axes: FloatArray) -> FloatArray:
        """Strain rates of a unit flow in each plate, (num_plates, num_strains)."""
        unit = axes / np.linalg.norm(axes, axis=1)[:, None]
        local = unit @ flow[: self._dim, : self._dim] @ unit.T
        if self._dim == 2:
            return np.diag([local[1, 1], local[0, 0]])
        rates = np.zeros((3, 12))
        for normal in range(3):
            i, j = [a for a in range(3) if a != normal]
            rates[normal, 3 * normal : 3 * normal + 3] = local[i, i], local[j, j], 2 * local[i, j]
        return rates

    def evaluate(self, u: ArrayLike) -> FlowingCell:
        """Trial from the committed history.

        Args:
            u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        """
        d, law = self._dim, self._parameters
        moved = floats(u).reshape(-1, d)
        H = np.zeros((3, 3))
        H[:d, :d] = moved.T @ self._b
        F = np.eye(3) + H
        before = self.point.history
        answer = self.point.evaluate((H + H.T) / 2 if self._small else F, with_tangent=False)
        stress, step = answer.stress[0], float(answer.history.plastic_strain[0] - before.plastic_strain[0])
        if not self._small and self._hypothesis == "plane_stress":
            F[2, 2] = answer.history.thickness[0]
        true = stress if self._small else stress @ F.T
        deviator = true - np.trace(true) / 3 * np.eye(3)
        q = np.sqrt(1.5 * np.sum(deviator**2))
        # Share of the trial stress that the radial return leaves.
        stiff = 3.0
        if not self._small:
            stiff = np.linalg.det(F) ** (-2 / 3) * np.trace(F @ before.plastic_strain_tensor[0] @ F.T)
        left = q / (q + law.E / (2 * (1 + law.nu)) * stiff * step) if step > 0 else 1.0
        limit = float(law.yield_stress(before.plastic_strain)[0])

        strain, axes = self._modes(moved)
        D, hardening = self._stiffness(), max(self._slope, 0.0) / law.E
        trial = strain - self.plastic
        relative = trial - hardening * self.plastic
        reduced = relative.copy()
        if step > 0:
            for rate in self._along(1.5 * deviator / q, axes):
                wanted = rate @ D @ relative / (rate @ D @ rate + NO_FLOW * law.E)
                reduced -= np.clip(wanted, -step, step) * rate
        reduced *= left
        size = self._equivalent(D @ reduced)
        if size > limit / 2:
            reduced *= limit / 2 / size
        flowed = (relative - reduced) / (1 + hardening)
        elastic = trial - flowed
        moment = D @ elastic

        n = moved.shape[0]
        B = np.zeros((len(strain), n * d))
        for column in range(n * d):
            turned = moved.astype(complex)
            turned[divmod(column, d)] += COMPLEX_STEP * 1j
            B[:, column] = self._modes(turned)[0].imag / COMPLEX_STEP
        force = self._volume * ((self._b @ stress[:d, :d].T).ravel() + B.T @ moment)
        hourglass = 0.5 * self._volume * float(elastic @ moment)
        energy = self._volume * float(answer.energy[0]) + hourglass
        return FlowingCell(force, energy, hourglass, answer, self.plastic + flowed)

    def commit(self, cell: FlowingCell) -> None:
        """Make the history of a trial the committed one."""
        self.point.commit(cell.answer)
        self.plastic = cell.plastic


@dataclass
class FlowingRun(FreeMotion):
    """End of a motion of a body of such cells.

    Attributes:
        plastic_strain: equivalent plastic strain of the cells, shape (num_cells) [1].
    """

    plastic_strain: FloatArray


def run_one_point_plastic(
    points: FloatArray,
    cells: ArrayLike,
    cell_type: str,
    material: Material,
    parameters: J2Parameters,
    slope: float,
    strain: str,
    velocity: FloatArray,
    dt: float,
    num_steps: int,
) -> FlowingRun:
    """Free motion of a body by central differences with lumped mass; the history is committed at every time level.

    Args:
        points: nodes, shape (num_nodes, gdim) [L].
        cells: nodes of the cells in the order of `reference_nodes`, shape (num_cells, n).
        cell_type: "quadrilateral" or "hexahedron".
        material: density and hypothesis; its law does not count.
        parameters: the law, of linear isotropic hardening.
        slope: slope of the yield stress [F/L^2].
        strain: "small" or "simo".
        velocity: initial velocity, shape (num_nodes, gdim) [L/T].
        dt: step [T].
        num_steps: number of steps [1].

    Returns:
        FlowingRun.
    """
    connectivity = integers(cells, "cells", 2)
    bodies = [
        OnePointPlastic(cell_type, points[cell], parameters, slope, material.hypothesis, strain)
        for cell in connectivity
    ]

    def forces(u: FloatArray) -> BodyForces:
        out = BodyForces(np.zeros_like(points), 0.0, 0.0)
        for number, body in enumerate(bodies):
            cell = connectivity[number]
            found = body.evaluate(u[cell])
            body.commit(found)
            out.force[cell] += found.force.reshape(len(cell), -1)
            out.internal += found.energy
            out.hourglass += found.hourglass
        return out

    end = move_freely(lumped_mass(points, cells, cell_type, material), velocity, forces, dt, num_steps)
    strains = np.array([float(body.point.history.plastic_strain[0]) for body in bodies])
    return FlowingRun(end.displacement, end.internal, end.hourglass, strains)
