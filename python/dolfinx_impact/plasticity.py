# SPDX-License-Identifier: MIT
"""Elasto-plastic materials with checked parameters; their physics is in forms/plasticity.py."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx import default_scalar_type, fem
from dolfinx.fem import Constant
from dolfinx.mesh import Mesh

from .common.arguments import number
from .common.fixed import Fixed, read_only
from .common.types import FloatArray
from .forms import hardening
from .forms import plasticity as laws
from .inelastic import InelasticMaterial
from .materials import FULL


class Voce(Fixed):
    """Isotropic hardening that saturates: Y(alpha) = Y0 + H alpha + (Y_s - Y0) (1 - exp(-rate alpha)).

    Args:
        saturation: yield stress Y_s that the exponential term ends at, positive; below Y0 the material softens [F/L^2].
        rate: its rate, positive [1].
        modulus: H of a linear term; negative: the material softens in the end [F/L^2].

    Raises:
        TypeError: a value is not a number.
        ValueError: a value outside its range.
    """

    def __init__(self, saturation: float, rate: float, modulus: float = 0.0) -> None:
        self.saturation = number("saturation", saturation, 0.0, " [F/L^2]")
        self.rate = number("rate", rate, 0.0, " [1]")
        self.modulus = number("modulus", modulus, unit=" [F/L^2]")

    def __repr__(self) -> str:
        return f"Voce(saturation={self.saturation}, rate={self.rate}, modulus={self.modulus})"


class Table(Fixed):
    """Isotropic hardening by a table: the yield stress is linear between the points and constant beyond the last.

    Args:
        strains: equivalent plastic strains, ascending from 0, (n), at least two [1].
        stresses: yield stresses at them, positive, (n); the first is the material's yield stress. Where they descend
            the material softens [F/L^2].

    Raises:
        TypeError: the values are not numbers.
        ValueError: another shape, strains that do not ascend from 0, or stresses that are not positive.
    """

    def __init__(self, strains: Sequence[float], stresses: Sequence[float]) -> None:
        self.strains, self.stresses = _column("strains", strains), _column("stresses", stresses)
        if len(self.strains) != len(self.stresses) or len(self.strains) < 2:
            raise ValueError(
                f"a hardening table needs as many stresses as strains, two or more; found {len(self.stresses)} and "
                f"{len(self.strains)}"
            )
        if self.strains[0] != 0.0 or np.any(np.diff(self.strains) <= 0.0):
            raise ValueError(f"strains are {self.strains.tolist()}: they must ascend from 0")
        if np.any(self.stresses <= 0.0):
            raise ValueError(f"stresses are {self.stresses.tolist()}: they must be positive [F/L^2]")

    def __repr__(self) -> str:
        return f"Table({self.strains.tolist()}, {self.stresses.tolist()})"


class ArmstrongFrederick(Fixed):
    """Kinematic hardening with recovery: d beta = 2/3 C d eps_p - gamma beta d alpha; it saturates at C/gamma.

    Args:
        modulus: C, positive [F/L^2].
        recovery: gamma, not negative; 0: linear kinematic hardening [1].

    Raises:
        TypeError: a value is not a number.
        ValueError: a value outside its range.
    """

    def __init__(self, modulus: float, recovery: float = 0.0) -> None:
        self.modulus = number("modulus", modulus, 0.0, " [F/L^2]")
        self.recovery = number("recovery", recovery, unit=" [1]")
        if self.recovery < 0.0:
            raise ValueError(f"recovery is {self.recovery}: it must not be negative [1]")

    def __repr__(self) -> str:
        return f"ArmstrongFrederick(modulus={self.modulus}, recovery={self.recovery})"


def _column(name: str, values: Sequence[float]) -> FloatArray:
    """A checked sequence of finite numbers."""
    try:
        array: FloatArray = read_only(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a sequence of numbers, found {values!r:.60}") from None
    if array.ndim != 1 or not np.all(np.isfinite(array)):
        raise ValueError(f"{name} must be one row of finite numbers")
    return array


class J2Plasticity(InelasticMaterial):
    """Elasto-plastic solid: von Mises' yield condition, associated flow (Simo & Hughes 1998, box 3.2 and box 9.1).

    Args:
        E: Young's modulus, positive [F/L^2].
        nu: Poisson's ratio, between -1 and 0.5, both excluded [1].
        density: None where no mass is asked for [M/L^3].
        yield_stress: yield stress of the virgin material, positive [F/L^2].
        hardening: isotropic hardening: a number, the slope of yield stress over equivalent plastic strain [F/L^2];
            Voce; or Table, whose first stress is the yield stress. Slopes below zero soften: problems warn that the
            result depends on the mesh, and a yield stress that has fallen to zero is an error of the run.
        kinematic: kinematic hardening: None; a number C, the linear law [F/L^2]; or ArmstrongFrederick. In finite
            strain the history "back_stress" is turned back by the rotation of the deformation gradient.
        finite_strain: whether strains are finite: the multiplicative law, exact under rotations of any size.
        average: whether the dilatation is averaged over each cell (B-bar, in finite strain F-bar); "linear": projected
            on the linear functions of each cell; "auto": averaged on quadrilaterals and hexahedra of degree 1,
            projected on those of degree 2, which lock without.
        hypothesis: "3d" (default on 3D meshes), "plane_strain", "plane_stress", "axisymmetric". In plane stress of
            finite strain the history "thickness_strain" is the logarithm of the stretch across the plane.
        integration: "full"; "reduced", one point in quadrilaterals and hexahedra of degree 1, whose hourglass modes
            flow with the law, in explicit problems (docs/one_point.md); or "averaged_pressure", the mean stress by
            averages at the nodes, for tetrahedra and triangles of degree 1 that do not lock
            (docs/averaged_pressure.md).

    Attributes:
        steepest_softening: the least slope of the yield stress if it is negative, or 0 [F/L^2].

    Raises:
        TypeError: a value of another type.
        ValueError: a value outside its range; the message says which and what to do.
    """

    def __init__(
        self,
        E: float,
        nu: float,
        density: float | None = None,
        yield_stress: float | None = None,
        hardening: float | Voce | Table = 0.0,
        kinematic: float | ArmstrongFrederick | None = None,
        finite_strain: bool = False,
        average: bool | str = "auto",
        hypothesis: str | None = None,
        integration: str = FULL,
    ) -> None:
        super().__init__(E, nu, density, hypothesis, integration)
        if yield_stress is None and isinstance(hardening, Table):
            yield_stress = float(hardening.stresses[0])
        if yield_stress is None:
            raise ValueError("J2Plasticity needs a yield_stress [F/L^2]")
        self.yield_stress = number("yield_stress", yield_stress, 0.0, " [F/L^2]")
        self.hardening = hardening
        if isinstance(hardening, Table):
            if not np.isclose(hardening.stresses[0], self.yield_stress, rtol=1e-12):
                raise ValueError(
                    f"yield_stress is {self.yield_stress}, the table begins at {hardening.stresses[0]}: leave one out"
                )
        elif not isinstance(hardening, Voce):
            self.hardening = number("hardening", hardening, unit=" [F/L^2]")
        self.steepest_softening = self._steepest_softening()
        _, mu = self.lame
        if self.steepest_softening <= -3.0 * mu:
            raise ValueError(
                f"the yield stress falls with the slope {self.steepest_softening:.6g}: it must stay above "
                f"-3 mu = {-3.0 * mu:.6g} [F/L^2], or the point itself snaps back and its stress is not unique, "
                "whatever the mesh"
            )
        if kinematic is not None and not isinstance(kinematic, ArmstrongFrederick):
            kinematic = ArmstrongFrederick(kinematic)
        self.kinematic = kinematic
        self.finite_strain = bool(finite_strain)
        if average not in (True, False, "linear", "auto"):
            raise ValueError(f"average is {average!r}: use True, False, 'linear' or 'auto'")
        self.average = average

    def __repr__(self) -> str:
        return (
            f"J2Plasticity(E={self.E}, nu={self.nu}, density={self.density}, yield_stress={self.yield_stress}, "
            f"hardening={self.hardening!r}, kinematic={self.kinematic!r}, finite_strain={self.finite_strain}, "
            f"average={self.average!r}, hypothesis={self.hypothesis!r}{self._repr_of_integration()})"
        )

    def _steepest_softening(self) -> float:
        """The least slope of the yield stress if it is negative, or 0 [F/L^2]."""
        h = self.hardening
        if isinstance(h, Table):
            slopes = np.diff(h.stresses) / np.diff(h.strains)
        elif isinstance(h, Voce):  # the slope is monotone: it is least at one of the ends
            slopes = np.array([h.modulus, h.modulus + h.rate * (h.saturation - self.yield_stress)])
        else:
            slopes = np.array([h])
        return min(0.0, float(slopes.min()))

    def _constants_of(self, mesh: Mesh, name: str, values: FloatArray) -> Constant:
        """A vector of constants of a mesh."""
        key = (mesh.ufl_id() if hasattr(mesh, "ufl_id") else id(mesh), name)
        if key not in self._constants:
            self._constants[key] = fem.Constant(mesh, np.asarray(values, dtype=default_scalar_type))
        return self._constants[key]

    def response(self, mesh: Mesh) -> laws.J2:
        """That of forms/plasticity.py, with parameters as constants of the mesh."""

        def constant(name: str, value: float) -> Any:
            return self.constant(mesh, name, value)

        # The order of the constants is that of forms/catalogue/plasticity.py, whose kernels come with the package.
        E, nu = constant("E", self.E), constant("nu", self.nu)
        Y = constant("yield_stress", self.yield_stress)
        isotropic: Any
        if isinstance(self.hardening, Voce):
            isotropic = hardening.VoceHardening(
                Y,
                constant("saturation", self.hardening.saturation),
                constant("rate", self.hardening.rate),
                constant("hardening", self.hardening.modulus),
                self.hardening.modulus < 0.0,
            )
        elif isinstance(self.hardening, Table):
            isotropic = hardening.TableHardening(
                self._constants_of(mesh, "table_strains", self.hardening.strains),
                self._constants_of(mesh, "table_stresses", self.hardening.stresses),
            )
        else:
            isotropic = hardening.LinearHardening(Y, constant("hardening", self.hardening), self.hardening < 0.0)
        kinematic = None
        if self.kinematic is not None:
            recovery = constant("recovery", self.kinematic.recovery) if self.kinematic.recovery > 0.0 else None
            kinematic = hardening.KinematicHardening(constant("back_modulus", self.kinematic.modulus), recovery)
        plane_stress = self.hypothesis == "plane_stress"
        return laws.J2(E, nu, mesh.geometry.dim, isotropic, kinematic, self.finite_strain, plane_stress)
