# SPDX-License-Identifier: MIT
"""Bodies with J2 plasticity: trial evaluations, static paths and explicit runs with a committed history."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _reference
from .array_types import ArrayLike, FloatArray, floats, integers, vector
from .explicit import ExplicitResult, run_explicit
from .discretisation import Discretisation
from .newmark import NewmarkResult, run_newmark
from .plasticity import J2History, J2Parameters, dilatation_name
from .sparse import Csr


@dataclass
class PlasticStates:
    """States at the ends of the steps of `PlasticBody.solve_static`; the first axis counts the steps."""

    u: FloatArray  # (num_steps, num_dofs) [L]
    force: FloatArray  # internal (num_steps, num_dofs) [F]
    reactions: FloatArray  # internal force less load on fixed dofs, zero elsewhere (num_steps, num_dofs) [F]
    energy: FloatArray  # elastic (num_steps) [F L]
    work: FloatArray  # plastic, since the start (num_steps) [F L]
    iterations: list[int]  # Newton's, of every step
    residuals: list[float]  # relative, at the end of every step [1]


class PlasticBody:
    """A model whose cells obey J2 plasticity, with the committed history of their points.

    Rows of a history are the points of the cells, cell by cell, in the order of the rule (`points`, `weights`).

    Args:
        model: the body; its materials are linear elastic, with the E and nu of the laws. It gives cells, hypothesis,
            masses, loads and contact surfaces.
        laws: the law of all cells, or laws by tag. Cells of other tags stay elastic (small strain only).
        strain: "small", "simo" or "hencky".
        mean_dilatation: B-bar or F-bar in the cells with a law, as in `element_plastic`.
        averaged_pressure: average all but 0.1 % of the volumetric part at the nodes (docs/averaged_pressure.md):
            tetrahedra and triangles of degree 1; there is no tangent then.

    Raises:
        ValueError: elastic constants that differ, tags that no cell has, plane stress with mean dilatation.
    """

    def __init__(
        self,
        model: Discretisation,
        laws: J2Parameters | Mapping[int, J2Parameters],
        strain: str = "small",
        mean_dilatation: bool | str = False,
        averaged_pressure: bool = False,
    ) -> None:
        self.model, self.strain, self.mean_dilatation = model, strain, mean_dilatation
        if isinstance(laws, J2Parameters):
            laws = {tag: laws for tag in model.materials}
        self.laws = dict(laws)
        self.points, self.weights = model._rule("stiffness" if strain == "small" else "finite_strain")
        by_tag = {int(tag): law._parameters for tag, law in self.laws.items()}
        theta = dilatation_name(mean_dilatation)
        self._body = _reference.PlasticBody(model._model, self.points, self.weights, by_tag, strain, theta)
        if averaged_pressure:
            self._body.average_pressure()

    @property
    def history(self) -> J2History:
        """Committed history, num_points = num_cells * len(weights). Assign to it to start from another one."""
        return J2History._of(self._body.history)

    @history.setter
    def history(self, history: J2History) -> None:
        self._body.set_history(history._arrays())

    def _evaluate(self, u: ArrayLike, with_tangent: bool = False) -> Any:  # an object of the compiled module
        return self._body.evaluate(vector(u), with_tangent)

    def internal_force(self, u: ArrayLike) -> FloatArray:
        """Internal force of a trial from the committed history.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Force, shape (num_dofs) [F].
        """
        return self._evaluate(u).force

    def tangent(self, u: ArrayLike) -> Csr:
        """Derivative of `internal_force`, consistent with the return mapping.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Tangent, not symmetric if the back stress has recall, shape (num_dofs, num_dofs) [F/L].
        """
        return Csr(*self._evaluate(u, True).tangent)

    def stress(self, u: ArrayLike) -> FloatArray:
        """Stress of a trial: Cauchy's in small strain, 1st Piola-Kirchhoff in finite strain; zero in elastic cells.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Stress, shape (num_cells, points per cell, 3, 3) [F/L^2].
        """
        return self._evaluate(u).stress.reshape(len(self.model.cells), -1, 3, 3)

    def energy(self, u: ArrayLike) -> float:
        """Elastic energy of a trial.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Energy [F L].
        """
        return self._evaluate(u).energy

    def work(self, u: ArrayLike) -> float:
        """Plastic work of the points since their start, up to a trial, by the trapezoidal rule.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Work [F L].
        """
        return self._evaluate(u).work

    def trial_history(self, u: ArrayLike) -> J2History:
        """History that `commit` would store.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            History of all points.
        """
        return J2History._of(self._evaluate(u).history)

    def commit(self, u: ArrayLike) -> None:
        """Make the history of a trial the committed one.

        Args:
            u: displacements, shape (num_dofs) [L].
        """
        self._body.commit(self._evaluate(u))

    def solve_static(
        self,
        fixed_dofs: ArrayLike,
        values: ArrayLike = 0.0,
        loads: ArrayLike | None = None,
        num_steps: int | None = None,
        u0: ArrayLike | None = None,
        load0: ArrayLike | None = None,
        tolerance: float = 1e-10,
        max_iterations: int = 25,
    ) -> PlasticStates:
        """Static path: Newton's method in every step, the history is committed at its end. A step that fails is halved.

        Args:
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            values: their displacements at the ends of the steps: one number, shape (num_fixed) for all steps, or
                (num_steps, num_fixed) [L].
            loads: at the ends of the steps: None, shape (num_dofs) for all steps, or (num_steps, num_dofs) [F].
            num_steps: number of steps; None takes it from the shapes, or one.
            u0: displacements that belong to the committed history, shape (num_dofs); None for zero [L].
            load0: load that u0 is in equilibrium with, shape (num_dofs); None for zero [F].
            tolerance: bound on the free residual, relative to |internal force| + |load| [1].
            max_iterations: bound on Newton's iterations.

        Returns:
            States at the ends of the steps.

        Raises:
            RuntimeError: rigid motions are free, or no convergence: the committed history is the last good one then.
            ValueError: arguments that do not fit.
        """
        fixed, n = integers(fixed_dofs, "fixed_dofs", 1), self.model.num_dofs
        values, zero = floats(values), np.zeros(n)
        loads = zero if loads is None else floats(loads)
        if num_steps is None:
            num_steps = max([a.shape[0] for a in (values, loads) if a.ndim == 2], default=1)
        loads = np.broadcast_to(loads, (num_steps, n)).copy()
        u, force, energy, work, iterations, residuals = self._body.solve(
            fixed,
            zero if u0 is None else vector(u0),
            zero if load0 is None else vector(load0),
            np.broadcast_to(values, (num_steps, fixed.size)).copy(),
            loads,
            float(tolerance),
            int(max_iterations),
        )
        reactions = np.zeros_like(force)
        reactions[:, fixed] = (force - loads)[:, fixed]
        return PlasticStates(u, force, reactions, energy, work, iterations, residuals)

    def run_explicit(self, dt: ArrayLike, num_steps: int | None = None, **arguments: Any) -> ExplicitResult:
        """Explicit dynamics from the committed history, which is committed at every time level.

        Energy "internal" is the stored elastic one, "plastic" what the work of the internal forces leaves.

        Args:
            dt: time step; or all steps, shape (num_steps) [T].
            num_steps: number of steps; None where `dt` has all steps.
            arguments: as in `Model.run_explicit`; beta must be 0.

        Returns:
            States, energies, contact histories and the histories of the points.

        Raises:
            ValueError: data that do not fit.
            RuntimeError: the run overflows.
        """
        return run_explicit(self.model, dt, num_steps, plastic=self._body, **arguments)

    def run_newmark(self, dt: ArrayLike, num_steps: int | None = None, **arguments: Any) -> NewmarkResult:
        """Implicit dynamics from the committed history, which is committed at the end of every step.

        Energy "internal" is the stored elastic one, "plastic" what the work of the internal forces leaves.

        Args:
            dt: time step; or all steps, shape (num_steps) [T].
            num_steps: number of steps; None where `dt` has all steps.
            arguments: as in `impact_reference.newmark.run_newmark`.

        Returns:
            States, energies, contact history and plastic strains of all time levels.

        Raises:
            ValueError: data that do not fit.
            RuntimeError: Newton's method does not converge.
        """
        return run_newmark(self.model, dt, num_steps, plastic=self._body, **arguments)
