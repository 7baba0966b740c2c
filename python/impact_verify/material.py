# SPDX-License-Identifier: MIT
"""Level material: J2 plasticity at points, random strain histories through kernels and through the hand-written law.

Every history has a simplex of its own, whose nodes are moved so that its strain is the one wanted. The kernels return
nodal forces f_a; the stress of the cell follows from them, P = sum_a f_a (x) X_a / V.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import basix.ufl
import impact_reference as ref
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.assembly.body_forms import body_forms
from dolfinx_impact.assembly.material_history import MaterialHistory
from dolfinx_impact.assembly.operators import InternalForce
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import plasticity as law
from dolfinx_impact.plasticity import ArmstrongFrederick, J2Plasticity, Table, Voce
from . import material_tangent
from .report import Report

E, NU, Y = 207e9, 0.3, 780e6  # steel [Pa, 1, Pa]
NUM_HISTORIES, NUM_STEPS = 1000, 50
TOLERANCE = 1e-10
VARIABLES = (law.PLASTIC_STRAIN, law.PLASTIC_TENSOR, law.BACK_STRESS, law.THICKNESS_STRAIN)
REASON = "round-off of 50 steps, local equations solved to 1e-12"


@dataclass(frozen=True)
class Case:
    """A law, as both sides take it.

    Attributes:
        name: name in the report.
        ours: arguments of J2Plasticity.
        theirs: arguments of impact_reference.J2Parameters.
    """

    name: str
    ours: dict[str, Any]
    theirs: dict[str, Any]


CASES = (
    Case("linear", dict(hardening=Y), dict(yield_stress=Y, hardening=Y)),
    Case("voce", dict(hardening=Voce(1.5 * Y, 40.0, 0.2 * Y)),
         dict(yield_stress=Y, hardening=0.2 * Y, saturation_stress=1.5 * Y, saturation_rate=40.0)),
    Case("table", dict(hardening=Table([0.0, 0.004, 0.02], [Y, 1.2 * Y, 1.5 * Y])),
         dict(table=[[0.0, 0.004, 0.02], [Y, 1.2 * Y, 1.5 * Y]])),
    Case("prager", dict(hardening=0.5 * Y, kinematic=20e9), dict(yield_stress=Y, hardening=0.5 * Y, kinematic=20e9)),
    Case("armstrong_frederick", dict(kinematic=ArmstrongFrederick(60e9, 300.0)),
         dict(yield_stress=Y, kinematic=60e9, recall=300.0)),
    Case("softening", dict(hardening=Voce(0.6 * Y, 40.0, -0.02 * Y)),
         dict(yield_stress=Y, hardening=-0.02 * Y, saturation_stress=0.6 * Y, saturation_rate=40.0)),
)  # fmt: skip


class Simplices:
    """Simplices that share no node, with the displacement of a homogeneous gradient in each.

    Args:
        gdim: dimension, 2 or 3.
        num_cells: number of simplices [1].
    """

    def __init__(self, gdim: int, num_cells: int) -> None:
        corner = np.vstack([np.zeros(gdim), np.eye(gdim)])
        x = np.tile(corner, (num_cells, 1))  # all at one place: coordinates of any size would cost digits
        cells = np.arange(len(x), dtype=np.int64).reshape(num_cells, gdim + 1)
        shape = "triangle" if gdim == 2 else "tetrahedron"
        element = basix.ufl.element("Lagrange", shape, 1, shape=(gdim,))
        self.mesh = mesh.create_mesh(MPI.COMM_SELF, cells, x=x, e=ufl.Mesh(element))
        self.space = fem.functionspace(self.mesh, ("Lagrange", 1, (gdim,)))
        self.u = fem.Function(self.space, name="u")
        self.dofs = self.space.dofmap.list[:num_cells]
        nodes = self.space.tabulate_dof_coordinates()[:, :gdim]
        self.x = nodes[self.dofs]
        self.x -= self.x[:, :1]
        self.volume = np.abs(np.linalg.det(self.x[:, 1:])) / (2.0 if gdim == 2 else 6.0)
        self.gdim = gdim

    def move(self, gradient: FloatArray) -> None:
        """Set the displacement.

        Args:
            gradient: displacement gradient of each cell, (num_cells, 3, 3), of which the first gdim components count.
        """
        g = gradient[:, : self.gdim, : self.gdim]
        self.u.x.array.reshape(-1, self.gdim)[self.dofs] = np.einsum("cij,caj->cai", g, self.x)

    def stress(self, forces: FloatArray) -> FloatArray:
        """Stress of each cell from the nodal forces.

        Args:
            forces: nodal forces over all degrees of freedom [F].

        Returns:
            Stress conjugate to the displacement gradient, (num_cells, gdim, gdim) [F/L^2].
        """
        f = forces.reshape(-1, self.gdim)[self.dofs]
        return np.einsum("cai,caj->cij", f, self.x) / self.volume[:, None, None]


def stretch_paths(rng: np.random.Generator, num: int, gdim: int, finite: bool) -> FloatArray:
    """Random walks of displacement gradients, (NUM_STEPS, num, 3, 3).

    Small strains walk through some ten yield strains; finite ones through stretches of some tens of per cent.

    Args:
        rng: random numbers.
        num: number of histories [1].
        gdim: dimension, 2 or 3.
        finite: whether strains are finite.
    """
    size = 0.02 if finite else 1.5 * Y / E
    steps = rng.normal(scale=size, size=(NUM_STEPS, num, 3, 3))
    if gdim == 2:
        steps[:, :, 2, :] = steps[:, :, :, 2] = 0.0
    return np.cumsum(steps, axis=0)


def rotations(rng: np.random.Generator, num: int, gdim: int) -> FloatArray:
    """Random rotations, (NUM_STEPS, num, 3, 3); in the plane about its normal.

    Args:
        rng: random numbers.
        num: number of histories [1].
        gdim: dimension, 2 or 3.
    """
    angles = rng.uniform(-np.pi, np.pi, size=(NUM_STEPS, num))
    axes = rng.normal(size=(NUM_STEPS, num, 3))
    if gdim == 2:
        axes[..., :2] = 0.0
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    K = np.zeros((NUM_STEPS, num, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        K[..., i, j], K[..., j, i] = -axes[..., k], axes[..., k]
    return np.eye(3) + np.sin(angles)[..., None, None] * K + (1 - np.cos(angles))[..., None, None] * (K @ K)


def strain_paths(rng: np.random.Generator, num: int, gdim: int, finite: bool) -> FloatArray:
    """Paths of `stretch_paths`; of finite strain every state is rotated at random.

    Args:
        rng: random numbers.
        num: number of histories [1].
        gdim: dimension, 2 or 3.
        finite: whether strains are finite.
    """
    path = stretch_paths(rng, num, gdim, finite)
    if not finite:
        return path
    return rotations(rng, num, gdim) @ (np.eye(3) + path) - np.eye(3)


def unpack(name: str, values: FloatArray, gdim: int, finite: bool) -> FloatArray:
    """History of the kernels as full tensors, as the hand-written solver has them.

    Args:
        name: name of the variable.
        values: values of one point per cell, (num_cells, num_components).
        gdim: dimension.
        finite: whether the law is of finite strain.
    """
    if name in (law.PLASTIC_STRAIN, law.THICKNESS_STRAIN):
        return values[:, 0]
    out = np.zeros((len(values), 3, 3))
    finite = finite and name == law.PLASTIC_TENSOR  # which is not deviatoric
    normal = 3 if finite else 2
    for i in range(normal):
        out[:, i, i] = values[:, i]
    if normal == 2:
        out[:, 2, 2] = -values[:, 0] - values[:, 1]
    shear = ((0, 1), (1, 2), (0, 2)) if gdim == 3 else ((0, 1),)
    for k, (i, j) in enumerate(shear):
        out[:, i, j] = out[:, j, i] = values[:, normal + k]
    return out + np.eye(3) if finite else out


class Points:
    """The law of a case in the kernels, at one point in each of many simplices.

    Args:
        case: the law.
        hypothesis: "3d", "plane_strain" or "plane_stress".
        finite: whether the law is of finite strain.
        num: number of simplices [1].

    Attributes:
        gdim: dimension.
        names: names of the internal variables.
    """

    def __init__(self, case: Case, hypothesis: str, finite: bool, num: int) -> None:
        self.gdim, self.finite, self._num = 3 if hypothesis == "3d" else 2, finite, num
        self._cells = Simplices(self.gdim, num)
        steel = J2Plasticity(
            E=E, nu=NU, density=1.0, yield_stress=Y, finite_strain=finite, hypothesis=hypothesis, **case.ours
        )
        forms = body_forms(self._cells.u, steel)
        self._force = InternalForce(forms.internal, law=forms.laws)
        assert forms.parts is not None
        self._history = MaterialHistory(forms.parts, self._force.history)
        self._values = self._force.vector().array
        self.names = [name for name in self._history if name in VARIABLES]

    def step(self, gradient: FloatArray) -> FloatArray:
        """Go to a displacement gradient and commit the history.

        Args:
            gradient: displacement gradient of each simplex, (num, 3, 3) [1].

        Returns:
            Stress, Cauchy's or the first Piola-Kirchhoff one, (num, gdim, gdim) [F/L^2].
        """
        self._cells.move(gradient)
        self._values[:] = 0.0
        self._force.assemble(self._values)
        self._force.history.commit()
        return self._cells.stress(self._values)

    def variable(self, name: str) -> FloatArray:
        """Committed internal variable, full tensors, (num) or (num, 3, 3).

        Args:
            name: name of the variable.
        """
        return unpack(name, self._history[name].values[:, 0].reshape(self._num, -1), self.gdim, self.finite)


def their_variable(history: ref.J2History, name: str) -> FloatArray:
    """Internal variable of the hand-written law, (num) or (num, 3, 3).

    Args:
        history: its history.
        name: name of the variable in the kernels.
    """
    found: FloatArray = np.log(history.thickness) if name == law.THICKNESS_STRAIN else getattr(history, name)
    return found


def compare(case: Case, hypothesis: str, finite: bool, seed: int = 3, num: int = NUM_HISTORIES) -> dict[str, float]:
    """Largest differences over all steps of random histories.

    Args:
        case: the law.
        hypothesis: "3d", "plane_strain" or "plane_stress".
        finite: whether the law is of finite strain.
        seed: seed of the random histories.
        num: number of histories [1].

    Returns:
        Differences of "stress" (relative to the yield stress) and of each history variable (relative to its largest
        value) [1]; and "yielding", the share of steps in which a point yields [1].
    """
    ours = Points(case, hypothesis, finite, num)
    gdim = ours.gdim
    points = ref.J2Point(ref.J2Parameters(E, NU, **case.theirs), num, "simo" if finite else "small", hypothesis)
    worst = dict.fromkeys(("stress", *ours.names), 0.0)
    size = dict.fromkeys(ours.names, 0.0)
    yielding = 0.0
    for gradient in strain_paths(np.random.default_rng(seed), num, gdim, finite):
        stress = ours.step(gradient)
        before = points.history.plastic_strain.copy()
        strain = np.eye(3) + gradient if finite else 0.5 * (gradient + gradient.transpose(0, 2, 1))
        answer = points.evaluate(strain, with_tangent=False)
        worst["stress"] = _worse(worst["stress"], float(np.abs(stress - answer.stress[:, :gdim, :gdim]).max()) / Y)
        points.commit(answer)
        yielding += float(np.mean(points.history.plastic_strain > before)) / NUM_STEPS
        for name in ours.names:
            expected = their_variable(points.history, name)
            size[name] = max(size[name], float(np.abs(expected).max()))
            worst[name] = _worse(worst[name], float(np.abs(ours.variable(name) - expected).max()))
    for name in ours.names:
        worst[name] /= size[name]
    return {**worst, "yielding": yielding}


def _worse(a: float, b: float) -> float:
    """The larger number; NaN if one is NaN."""
    return b if not b <= a else a


def dissipation(case: Case, hypothesis: str, finite: bool, seed: int = 4, num: int = NUM_HISTORIES) -> float:
    """How negative the dissipation of a step becomes, by the second law on what the kernels return.

    Small strain: the work of the stress at the end of the step, less the changes of the energies that are stored
    elastically, s:s/(4 mu) + p^2/(2 kappa), and by the back stress, 3/(4 C) beta:beta. Both are convex, so that a step
    of backward Euler dissipates, whatever its size. Finite strain: what the elastic energy, mu/2 tr be_bar, and that of
    the back stress lose from the trial state, in which the stress has done its work without any flow, to the end of the
    step.

    Args:
        case: the law.
        hypothesis: "3d" or "plane_strain", in finite strain also "plane_stress".
        finite: whether the law is of finite strain.
        seed: seed of the random histories.
        num: number of histories [1].

    Returns:
        Minus the least dissipation of a step, relative to the largest one [1].
    """
    ours = Points(case, hypothesis, finite, num)
    mu, kappa = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
    kinematic = case.ours.get("kinematic", 0.0)
    C = kinematic.modulus if isinstance(kinematic, ArmstrongFrederick) else kinematic
    strain_0: FloatArray = np.zeros((num, 3, 3))
    stored_0: FloatArray = np.zeros(num)
    hardened_0: FloatArray = np.zeros(num)
    plastic_0 = ours.variable(law.PLASTIC_TENSOR)
    least, largest = np.inf, 0.0
    for gradient in strain_paths(np.random.default_rng(seed), num, ours.gdim, finite):
        stress = ours.step(gradient)
        plastic = ours.variable(law.PLASTIC_TENSOR)
        hardened: FloatArray = np.zeros(num)
        if C:
            back = ours.variable(law.BACK_STRESS)
            hardened = 0.75 / C * contract(back, back)
        if finite:
            F = np.eye(3) + gradient
            if law.THICKNESS_STRAIN in ours.names:
                F[:, 2, 2] = np.exp(ours.variable(law.THICKNESS_STRAIN))
            J = np.linalg.det(F)
            scale = J[:, None, None] ** (-2.0 / 3.0)
            lost = scale * F @ (plastic_0 - plastic) @ F.transpose(0, 2, 1)
            found = mu / 2 * np.trace(lost, axis1=1, axis2=2) - (hardened - hardened_0)
        else:
            strain = 0.5 * (gradient + gradient.transpose(0, 2, 1))
            p = kappa * np.trace(strain, axis1=1, axis2=2)
            s = 2 * mu * (deviator(strain) - plastic)
            whole = s + p[:, None, None] * np.eye(3)
            whole[:, : ours.gdim, : ours.gdim] = stress
            stored = contract(s, s) / (4 * mu) + p**2 / (2 * kappa) + hardened
            found = contract(whole, strain - strain_0) - (stored - stored_0)
            strain_0, stored_0 = strain, stored
        plastic_0, hardened_0 = plastic, hardened
        if not np.all(np.isfinite(found)):
            return np.nan
        least, largest = min(least, float(found.min())), max(largest, float(found.max()))
    return max(0.0, -least) / largest


def objectivity(case: Case, hypothesis: str, seed: int = 5, num: int = NUM_HISTORIES) -> dict[str, float]:
    """Differences between random histories of finite strain and the same histories seen from frames that turn.

    Args:
        case: the law.
        hypothesis: "3d", "plane_strain" or "plane_stress".
        seed: seed of the random histories and rotations.
        num: number of histories [1].

    Returns:
        Largest differences of "stress", turned back, relative to the yield stress, and of each internal variable,
        relative to its largest value [1].
    """
    still, turned = Points(case, hypothesis, True, num), Points(case, hypothesis, True, num)
    rng = np.random.default_rng(seed)
    path = stretch_paths(rng, num, still.gdim, True)
    turns = rotations(rng, num, still.gdim)
    worst = dict.fromkeys(("stress", *still.names), 0.0)
    size = dict.fromkeys(still.names, 0.0)
    for k in range(NUM_STEPS):
        gradient, R = path[k], turns[k]
        Q = R[:, : still.gdim, : still.gdim]
        a, b = still.step(gradient), turned.step(R @ (np.eye(3) + gradient) - np.eye(3))
        worst["stress"] = _worse(worst["stress"], float(np.abs(Q @ a - b).max()) / Y)
        for name in still.names:
            expected = still.variable(name)
            size[name] = max(size[name], float(np.abs(expected).max()))
            worst[name] = _worse(worst[name], float(np.abs(turned.variable(name) - expected).max()))
    return {name: value / size.get(name, 1.0) for name, value in worst.items()}


def deviator(t: FloatArray) -> FloatArray:
    """Deviators of tensors, (num, 3, 3)."""
    return t - np.trace(t, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)


def contract(a: FloatArray, b: FloatArray) -> FloatArray:
    """a : b of tensors (num, 3, 3), (num)."""
    return np.einsum("cij,cij->c", a, b)


def run(report: Report, progress: bool = True, num: int = NUM_HISTORIES) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
        num: number of random histories [1].
    """
    for hypothesis in ("3d", "plane_strain", "plane_stress"):
        cell = "tetrahedron" if hypothesis == "3d" else "triangle"
        if not report.wants(cell, 1):
            continue
        for case in CASES:
            for finite in (False, True):
                _rows(report, case, hypothesis, finite, (cell, 1, 1, hypothesis), num)
    material_tangent.run(report)


def _rows(
    report: Report, case: Case, hypothesis: str, finite: bool, element: tuple[str, int, int, str], num: int
) -> None:
    """Add the rows of one law at random histories."""
    form = f"j2.{'finite' if finite else 'small'}.{case.name}"
    found = compare(case, hypothesis, finite, num=num)
    yielding = found.pop("yielding")
    note = f"{num} histories of {NUM_STEPS} steps, yielding in {100 * yielding:.0f} % of them"
    for name, difference in found.items():
        report.add("material", form, *element, difference, TOLERANCE, REASON, name, note)
    if finite or hypothesis != "plane_stress":  # the small strain across the plane, which works there, is no result
        negative = dissipation(case, hypothesis, finite, num=num)
        report.add("material", form, *element, negative, TOLERANCE, REASON, "dissipation is never negative", note)
    if finite:
        for name, difference in objectivity(case, hypothesis, num=num).items():
            report.add("material", form, *element, difference, TOLERANCE, REASON, f"{name} in frames that turn", note)
