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

from ..assembly.body_forms import body_forms
from ..assembly.history import MaterialHistory
from ..assembly.operators import InternalForce
from ..common.types import FloatArray
from ..forms import plasticity as law
from ..plasticity import ArmstrongFrederick, J2Plasticity, Table, Voce
from .report import Report

E, NU, Y = 207e9, 0.3, 780e6  # steel [Pa, 1, Pa]
NUM_HISTORIES, NUM_STEPS = 1000, 50
TOLERANCE = 1e-10
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
)  # fmt: skip


class Simplices:
    """Disjoint simplices with the displacement of a homogeneous gradient in each.

    Args:
        gdim: dimension, 2 or 3.
        num_cells: number of simplices [1].
    """

    def __init__(self, gdim: int, num_cells: int) -> None:
        corner = np.vstack([np.zeros(gdim), np.eye(gdim)])
        x = (corner[None] + 3.0 * np.arange(num_cells)[:, None, None] * np.eye(gdim)[0]).reshape(-1, gdim)
        cells = np.arange(len(x), dtype=np.int64).reshape(num_cells, gdim + 1)
        shape = "triangle" if gdim == 2 else "tetrahedron"
        element = basix.ufl.element("Lagrange", shape, 1, shape=(gdim,))
        self.mesh = mesh.create_mesh(MPI.COMM_SELF, cells, x, ufl.Mesh(element))
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


def strain_paths(rng: np.random.Generator, num: int, gdim: int, finite: bool) -> FloatArray:
    """Random walks of displacement gradients, (NUM_STEPS, num, 3, 3).

    Small strains walk through some ten yield strains; finite ones through stretches of some tens of per cent, and then
    every state is rotated at random.
    """
    size = 0.02 if finite else 1.5 * Y / E
    steps = rng.normal(scale=size, size=(NUM_STEPS, num, 3, 3))
    if gdim == 2:
        steps[:, :, 2, :] = steps[:, :, :, 2] = 0.0
    path = np.cumsum(steps, axis=0)
    if not finite:
        return path
    angles = rng.uniform(-np.pi, np.pi, size=(NUM_STEPS, num))
    axes = rng.normal(size=(NUM_STEPS, num, 3))
    if gdim == 2:
        axes[..., :2] = 0.0
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    K = np.zeros((NUM_STEPS, num, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        K[..., i, j], K[..., j, i] = -axes[..., k], axes[..., k]
    R = np.eye(3) + np.sin(angles)[..., None, None] * K + (1 - np.cos(angles))[..., None, None] * (K @ K)
    return R @ (np.eye(3) + path) - np.eye(3)


def unpack(name: str, values: FloatArray, gdim: int, finite: bool) -> FloatArray:
    """History of the kernels as full tensors, as the hand-written solver has them.

    Args:
        name: name of the variable.
        values: values of one point per cell, (num_cells, num_components).
        gdim: dimension.
        finite: whether the law is of finite strain.
    """
    if name == law.PLASTIC_STRAIN:
        return values[:, 0]
    out = np.zeros((len(values), 3, 3))
    normal = 3 if finite else 2
    for i in range(normal):
        out[:, i, i] = values[:, i]
    if normal == 2:
        out[:, 2, 2] = -values[:, 0] - values[:, 1]
    shear = ((0, 1), (1, 2), (0, 2)) if gdim == 3 else ((0, 1),)
    for k, (i, j) in enumerate(shear):
        out[:, i, j] = out[:, j, i] = values[:, normal + k]
    return out + np.eye(3) if finite else out


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
    gdim = 3 if hypothesis == "3d" else 2
    cells = Simplices(gdim, num)
    steel = J2Plasticity(
        E=E, nu=NU, density=1.0, yield_stress=Y, finite_strain=finite, hypothesis=hypothesis, **case.ours
    )
    forms = body_forms(cells.u, steel)
    force = InternalForce(forms.internal, law=forms.laws)
    assert forms.parts is not None
    history = MaterialHistory(forms.parts, force.history)
    points = ref.J2Point(ref.J2Parameters(E, NU, **case.theirs), num, "simo" if finite else "small", hypothesis)
    values = force.vector().array
    names = list(history)
    worst = dict.fromkeys(("stress", *names), 0.0)
    size = dict.fromkeys(names, 0.0)
    yielding = 0.0
    for gradient in strain_paths(np.random.default_rng(seed), num, gdim, finite):
        cells.move(gradient)
        values[:] = 0.0
        force.assemble(values)
        before = points.history.plastic_strain.copy()
        strain = np.eye(3) + gradient if finite else 0.5 * (gradient + gradient.transpose(0, 2, 1))
        answer = points.evaluate(strain, with_tangent=False)
        stress = answer.stress[:, :gdim, :gdim]
        worst["stress"] = max(worst["stress"], float(np.abs(cells.stress(values) - stress).max()) / Y)
        points.commit(answer)
        force.history.commit()
        yielding += float(np.mean(points.history.plastic_strain > before)) / NUM_STEPS
        for name in names:
            found = unpack(name, history[name].values[:, 0].reshape(num, -1), gdim, finite)
            expected = getattr(points.history, name)
            size[name] = max(size[name], float(np.abs(expected).max()))
            worst[name] = max(worst[name], float(np.abs(found - expected).max()))
    for name in names:
        worst[name] /= size[name]
    return {**worst, "yielding": yielding}


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for hypothesis in ("3d", "plane_strain", "plane_stress"):
        cell = "tetrahedron" if hypothesis == "3d" else "triangle"
        if not report.wants(cell, 1):
            continue
        for case in CASES:
            for finite in (False, True):
                if finite and (hypothesis == "plane_stress" or "kinematic" in case.ours):
                    continue
                found = compare(case, hypothesis, finite)
                yielding = found.pop("yielding")
                note = f"{NUM_HISTORIES} histories of {NUM_STEPS} steps, yielding in {100 * yielding:.0f} % of them"
                for name, difference in found.items():
                    form = f"j2.{'finite' if finite else 'small'}.{case.name}"
                    report.add("material", form, cell, 1, 1, hypothesis, difference, TOLERANCE, REASON, name, note)
