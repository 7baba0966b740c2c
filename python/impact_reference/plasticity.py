# SPDX-License-Identifier: MIT
"""J2 plasticity at points and in one cell, by backward Euler (Simo & Hughes 1998; de Souza Neto, Peric & Owen 2008).

Yield function f = sqrt(3/2) |dev sigma - beta| - Y(a) with associated flow; a is the equivalent plastic strain, beta
the back stress of Armstrong and Frederick, d beta = 2/3 C d eps_p - gamma beta da (gamma = 0: Prager). The strain is

- "small": history is the plastic strain, the answer Cauchy's stress and its derivative by the strain;
- "simo": finite, Simo's multiplicative law (Simo & Hughes Box 9.1, but with det(be_bar) = 1);
- "hencky": finite, logarithmic strain and exponential map (de Souza Neto et al. ch. 14).

Both finite laws take F and answer with the 1st Piola-Kirchhoff stress and its derivative by F; their history is C_p^-1,
and the back stress turns with the rotation of F. Evaluations are trials: they leave the history they start from as it
is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import _reference, rules
from .array_types import ArrayLike, FloatArray, Rule, floats

# As the compiled module has them: plastic, equivalent, back stress, stress, work, thickness.
_Histories = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


class J2Parameters:
    """Isotropic elasticity, J2 yield surface and hardening.

    Y(a) = Y0 + H a + (Yinf - Y0)(1 - exp(-delta a)), or a table.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        yield_stress: Y0 [F/L^2]; None where `table` is given.
        hardening: H [F/L^2].
        saturation_stress: Yinf of Voce's law; None for no saturation [F/L^2].
        saturation_rate: delta of Voce's law [1].
        table: equivalent plastic strains that increase from 0 [1] and yield stresses [F/L^2], shape (2, n); linear
            between its points, constant beyond the last.
        kinematic: modulus C of the back stress [F/L^2].
        recall: gamma of Armstrong and Frederick's law [1].

    Raises:
        ValueError: a value outside its range, a table that does not increase, softening steeper than -3 G.
    """

    def __init__(
        self,
        E: float,
        nu: float,
        yield_stress: float | None = None,
        hardening: float = 0.0,
        saturation_stress: float | None = None,
        saturation_rate: float = 0.0,
        table: ArrayLike | None = None,
        kinematic: float = 0.0,
        recall: float = 0.0,
    ) -> None:
        if (yield_stress is None) == (table is None):
            raise ValueError("give either yield_stress or table")
        if (saturation_stress is None) != (saturation_rate == 0.0):
            raise ValueError("saturation_stress and saturation_rate go together")
        if table is not None and (hardening != 0.0 or saturation_stress is not None):
            raise ValueError("a table has all of the isotropic hardening: leave out hardening and saturation")
        strains: list[float] = []
        stresses: list[float] = []
        if table is not None:
            rows = floats(table)
            if rows.ndim != 2 or rows.shape[0] != 2 or rows.shape[1] == 0:
                raise ValueError(f"table must have shape (2, n) with n > 0, found {rows.shape}")
            strains, stresses = list(rows[0]), list(rows[1])
        self.E, self.nu = float(E), float(nu)
        self._parameters = _reference.J2Parameters(
            self.E,
            self.nu,
            0.0 if yield_stress is None else float(yield_stress),
            float(hardening),
            0.0 if saturation_stress is None else float(saturation_stress),
            float(saturation_rate),
            strains,
            stresses,
            float(kinematic),
            float(recall),
        )

    def yield_stress(self, equivalent: ArrayLike) -> FloatArray:
        """Isotropic part of the hardening.

        Args:
            equivalent: equivalent plastic strain, any shape [1].

        Returns:
            Y, same shape [F/L^2].
        """
        a = floats(equivalent)
        return self._parameters.yield_stress(np.atleast_1d(a).reshape(-1)).reshape(a.shape)


@dataclass
class J2History:
    """Internal variables of points."""

    plastic_strain: FloatArray  # equivalent plastic strain a (num_points) [1]
    plastic_strain_tensor: FloatArray  # eps_p, in finite strain C_p^-1 (num_points, 3, 3) [1]
    back_stress: FloatArray  # beta, in finite strain turned back by the rotation of F (num_points, 3, 3) [F/L^2]
    stress: FloatArray  # of the history's state, Kirchhoff's turned back likewise (num_points, 3, 3) [F/L^2]
    work: FloatArray  # int sigma : d eps_p per reference volume, trapezoidal rule (num_points) [F/L^2]
    thickness: FloatArray  # stretch across the plane in plane stress of finite strain, else 1 (num_points) [1]

    @classmethod
    def virgin(cls, num_points: int, strain: str = "small") -> J2History:
        """History of points that never yielded.

        Args:
            num_points: number of points.
            strain: "small", "simo" or "hencky".

        Returns:
            History.
        """
        return cls._of(_reference.j2_virgin(int(num_points), strain))

    @classmethod
    def _of(cls, arrays: _Histories) -> J2History:
        plastic, equivalent, back, stress, work, thickness = arrays
        tensors = [rows.reshape(-1, 3, 3) for rows in (plastic, back, stress)]
        return cls(equivalent, tensors[0], tensors[1], tensors[2], work, thickness)

    def _arrays(self) -> _Histories:
        tensors = (self.plastic_strain_tensor, self.back_stress, self.stress)
        plastic, back, stress = (floats(rows).reshape(-1, 9) for rows in tensors)
        return plastic, floats(self.plastic_strain), back, stress, floats(self.work), floats(self.thickness)


@dataclass
class J2Answer:
    """Answer of points to a strain."""

    stress: FloatArray  # Cauchy's in small strain, 1st Piola-Kirchhoff in finite strain (num_points, 3, 3) [F/L^2]
    tangent: FloatArray  # its derivative by strain or F, T_ijkl = dS_ij/dF_kl (num_points, 3, 3, 3, 3) [F/L^2]
    history: J2History  # at the end of the step
    energy: FloatArray  # elastic, per reference volume (num_points) [F/L^2]
    dissipation: FloatArray  # of the step: Y da + 3 gamma/(2 C) beta : beta da (num_points) [F/L^2]


class J2Point:
    """Points with a committed history.

    Args:
        parameters: the law.
        num_points: number of points.
        strain: "small", "simo" or "hencky".
        hypothesis: "3d" (or "plane_strain", "axisymmetric", which are the same here), or "plane_stress": strain_33 or
            F_33 is not read then but follows from stress_33 = 0, and the tangent is condensed.

    Raises:
        ValueError: unknown names.
    """

    def __init__(
        self, parameters: J2Parameters, num_points: int = 1, strain: str = "small", hypothesis: str = "3d"
    ) -> None:
        self.parameters, self.strain, self.hypothesis = parameters, strain, hypothesis
        self.history = J2History.virgin(num_points, strain)

    def evaluate(self, strain: ArrayLike, with_tangent: bool = True) -> J2Answer:
        """Trial answer to a strain at the end of the step that begins with the committed history.

        Args:
            strain: total strain, in finite strain F, shape (num_points, 3, 3) or (3, 3) for all points [1].
            with_tangent: False leaves the tangent empty.

        Returns:
            Stress, tangent, new history, energy and dissipation.

        Raises:
            ValueError: shapes that do not fit, det F <= 0, a material that has softened to nothing.
        """
        n = len(self.history.plastic_strain)
        rows = np.ascontiguousarray(np.broadcast_to(floats(strain), (n, 3, 3))).reshape(n, 9)
        stress, tangent, history, energy, dissipation = _reference.j2_points(
            self.parameters._parameters, self.strain, self.hypothesis, rows, self.history._arrays(), with_tangent
        )
        return J2Answer(
            stress.reshape(n, 3, 3),
            tangent.reshape(-1, 3, 3, 3, 3),
            J2History._of(history),
            energy,
            dissipation,
        )

    def commit(self, answer: J2Answer) -> None:
        """Make the history of an answer the committed one.

        Args:
            answer: result of `evaluate`.
        """
        self.history = answer.history


@dataclass
class PlasticElement:
    """Result of `element_plastic`."""

    force: FloatArray  # internal (gdim n) [F]
    tangent: FloatArray  # its derivative (gdim n, gdim n), empty if not asked for [F/L]
    history: J2History  # at the end of the step, by points
    stress: FloatArray  # as in J2Answer (num_points, 3, 3) [F/L^2]
    energy: float  # elastic [F L]
    work: float  # plastic, since the start [F L]
    dissipation: float  # of the step [F L]


def dilatation_name(mean_dilatation: bool | str) -> str:
    """Name of what takes the place of the dilatation: False "pointwise", True "mean", others as they are."""
    if isinstance(mean_dilatation, str):
        return mean_dilatation
    return "mean" if mean_dilatation else "pointwise"


def element_plastic(
    cell_type: str,
    X: ArrayLike,
    parameters: J2Parameters,
    u: ArrayLike,
    history: J2History | None = None,
    *,
    hypothesis: str = "3d",
    strain: str = "small",
    mean_dilatation: bool | str = False,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
    with_tangent: bool = True,
) -> PlasticElement:
    """Internal force of a cell with J2 plasticity.

    Mean dilatation is B-bar in small strain, eps_bar = dev eps + <tr eps>/3 I (Hughes 1980), and F-bar in finite
    strain, F_bar = (<J>/J)^(1/3) F (Simo, Taylor & Pister 1985), with all three components in every hypothesis. <.> is
    the mean by the reference volumes of the points (2 pi r det J times weight if axisymmetric), or the linear function
    of position that fits best. Forces are conjugate to the variation of eps_bar or F_bar.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        parameters: the law.
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        history: at the start of the step; None for points that never yielded.
        hypothesis: "3d", "plane_strain", "plane_stress" or "axisymmetric".
        strain: "small", "simo" or "hencky".
        mean_dilatation: replace the dilatation by its mean over the cell, or with "linear" by the linear function that
            fits it best (least squares).
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).
        with_tangent: False leaves the tangent empty.

    Returns:
        Force, tangent, new history, stress and energies.

    Raises:
        ValueError: data that do not fit, det F <= 0.
    """
    purpose = "stiffness" if strain == "small" else "finite_strain"
    axisymmetric = hypothesis == "axisymmetric"
    points, weights = rules.points_and_weights(cell_type, rule, purpose, degree, geometry_degree, axisymmetric)
    before = J2History.virgin(len(weights), strain) if history is None else history
    force, tangent, after, stress, energy, work, dissipation = _reference.element_plastic(
        cell_type,
        degree,
        geometry_degree,
        points,
        weights,
        floats(X),
        parameters._parameters,
        strain,
        hypothesis,
        dilatation_name(mean_dilatation),
        floats(u).reshape(-1),
        before._arrays(),
        with_tangent,
    )
    return PlasticElement(force, tangent, J2History._of(after), stress.reshape(-1, 3, 3), energy, work, dissipation)
