# SPDX-License-Identifier: MIT
"""Internal variables that flow with the material along streamlines of quadrature points; docs/rolling.md."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from ..common.types import BoolArray, FloatArray, IntArray
from ..forms import plasticity
from ..materials import MaterialMap
from ..plasticity import J2Plasticity
from ..statics.material_body import MaterialBody
from ..statics.static_problem import Report, StaticProblem
from .flow import Flow
from .motions import Spin
from .point_lines import PointLines
from .turned_tensors import rotations, turned

STILL = 1e-12  # change of internal variables, relative to the largest, at which they are carried to the end
ROUND_OFF = 1e-14  # of the largest: a point that changes its history by less does not change it
MOST_ROUNDS = 200
REPEATS = 1e-5  # change in a turn, relative to the largest, below which turns repeat
MOST_TURNS = 100
RESULTS = (plasticity.THICKNESS_STRAIN,)  # follow from strain and other variables: nothing is carried with them


class Transport:
    """Carries internal variables with the flow: each point starts from what its neighbour upstream has found.

    The steady state of a material point's path is that of the points along its streamline, taken as its places at
    successive times: the law's update at a point starts from the history at the point before. What enters the mesh is
    as the material was at the beginning. Circles close: a turn begins with the history that the turn before has left.

    Args:
        problem: static problem with internal variables.
        flow: flow of its bodies.

    Attributes:
        turn_changes: change of the internal variables in each turn of the last `solve`, relative to the largest; empty
            if no streamline closes.

    Raises:
        ValueError: no streamlines of points; on all ranks.
    """

    def __init__(self, problem: StaticProblem, flow: Flow) -> None:
        body = problem.body
        assert isinstance(body, MaterialBody) and body.force is not None and body.history is not None
        self._problem, self._flow, self._parts, self._history = problem, flow, body.parts, body.history
        self._comm = problem.space.mesh.comm
        self._points = body.force.history
        self._names = self._points.state_names
        self._carried = [name for name in self._names if name not in RESULTS]
        # Without isotropic hardening nothing depends on the equivalent plastic strain, which grows in every turn.
        laws = [part.material for part in self._parts]
        counts = any(not isinstance(m, J2Plasticity) or m.hardening != 0.0 for m in laws)
        self._telling = [name for name in self._carried if counts or name != plasticity.PLASTIC_STRAIN]
        self._virgin = self._gathered()
        self._senses: list[FloatArray] = []
        self._finite = any(m.finite_strain for m in laws)
        self.turn_changes: list[float] = []
        self.update()
        self._start, self._before = self._virgin, self._virgin
        self._tensors = self._kinds()

    def update(self) -> None:
        """Find the streamlines for the present directions of flow. Collective.

        Raises:
            ValueError: the points make no streamlines; on all ranks.
        """
        senses = [
            np.sign(np.atleast_1d(m.omega)) if isinstance(m, Spin) else m.velocity / np.linalg.norm(m.velocity)
            for m in self._flow.motions.values()
            if np.any(m.rate)
        ]
        if len(senses) == len(self._senses) and all(np.array_equal(a, b) for a, b in zip(senses, self._senses)):
            return
        space = next(iter(self._history.values())).function().function_space
        bodies = [(self._cells(tag), motion) for tag, motion in self._flow.motions.items() if np.any(motion.rate)]
        lines = PointLines(space, bodies)
        if lines.fault:
            raise ValueError(lines.fault)
        self._lines, self._senses, self._placed = lines, senses, False
        self._changes: BoolArray = np.zeros(lines.count, dtype=bool)

    @property
    def closes(self) -> bool:
        """Does a streamline end where it begins?"""
        return self._lines.closes

    def _cells(self, tag: int) -> IntArray:
        """Owned cells of a motion that have internal variables."""
        cells = self._flow.cells_of(tag)
        cells = cells[cells < self._points.num_cells]
        found = [cells if p.tag is None else np.intersect1d(cells, self._tagged(p.tag)) for p in self._parts]
        return np.unique(np.concatenate([cells[:0], *found]))

    def _tagged(self, tag: int) -> IntArray:
        """Cells of a part of the material map, owned and ghosts."""
        material = self._problem.material
        assert isinstance(material, MaterialMap)
        return material.cell_tags.find(tag)

    def _kinds(self) -> list[tuple[str, IntArray, int, bool]]:
        """Tensors among the variables: name, points of all ranks, number of components, and whether of a deviator."""
        found = []
        per, first = self._points.num_points, int(self._lines.mine[0]) if len(self._lines.mine) else 0
        for part in self._parts:
            if not isinstance(part.material, J2Plasticity):
                continue  # spinning ones have numbers alone (inputs.py)
            cells: IntArray = np.arange(self._points.num_cells)
            if part.tag is not None:
                tagged = self._tagged(part.tag)
                cells = tagged[tagged < self._points.num_cells]
            points = np.concatenate(self._comm.allgather((first + per * cells[:, None] + np.arange(per)).ravel()))
            for name, shape in part.response.history.items():
                if shape:
                    deviator = name != plasticity.PLASTIC_TENSOR or not part.material.finite_strain
                    found.append((name, points.astype(np.int64), shape[0], deviator))
        return found

    # --- values ------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, FloatArray]:
        """Copy of the internal variables."""
        return {name: self._points.values(name).copy() for name in self._names}

    def restore(self, state: dict[str, FloatArray]) -> None:
        """Bring internal variables back.

        Args:
            state: as `state` returned it.
        """
        for name, values in state.items():
            self._points.set_values(name, values)

    def _gathered(self, trial: bool = False) -> dict[str, FloatArray]:
        """Internal variables of the points of all ranks, (count, components). Collective."""
        out = {}
        for name in self._names:
            values = self._points.values(name, trial=trial)
            out[name] = np.vstack(self._comm.allgather(values.reshape(-1, values.shape[-1])))
        return out

    def _set(self, everywhere: dict[str, FloatArray]) -> None:
        """Set the internal variables of this rank's points from those of all."""
        shape = (self._points.num_cells, self._points.num_points, -1)
        for name, values in everywhere.items():
            own = values[self._lines.mine]
            self._points.set_values(name, own.reshape(*shape[:2], values.shape[1]))

    def _entering(self, state: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """What each point starts from: the state of the point upstream, turned with the material.

        Args:
            state: of all points.
        """
        source, earlier = self._lines.sources(self._changes)
        inner = source >= 0
        out = {}
        for name in self._names:
            values = np.where(earlier[:, None], self._before[name][source], state[name][source])
            out[name] = np.where(inner[:, None], values, self._virgin[name])
        angle = np.where(inner, self._lines.angle - self._lines.angle[source], 0.0)
        if np.any(angle):
            Q = rotations(self._lines.axis, angle)
            for name, points, width, deviator in self._tensors:
                out[name][points, :width] = turned(out[name][points, :width], Q[points], deviator)
        return out

    # --- steady state ------------------------------------------------------------------------------------------------

    def solve(self, equilibrium: Callable[[bool], Report], turns: int | None = None) -> Report:
        """Find displacement and history together. Collective.

        Rounds of equilibrium with the history upstream of each point frozen, by Newton's method with the exact tangent
        of that problem, and of history carried along the streamlines at the displacements found. Where streamlines
        close, this is done for one turn of the body after the other.

        Args:
            equilibrium: solves for the displacement; the argument says whether it is the first round.
            turns: number of turns; None: until they repeat.

        Returns:
            Report of the first round, with the iterations of the others.

        Raises:
            RuntimeError: history and displacement do not settle, or turns do not repeat; on all ranks.
        """
        self._before, self.turn_changes = self._gathered(), []
        report: Report | None = None
        for turn in itertools.count(1):
            report = self._turn(equilibrium, report)
            if not self.closes:
                return report
            state = self._gathered()
            self.turn_changes.append(self._difference(state, self._before, self._telling, self._lines.exits))
            self._before = state
            if turn == turns or (turns is None and self.turn_changes[-1] < REPEATS):
                return report
            if turns is None and turn == MOST_TURNS:
                raise RuntimeError(
                    f"after {turn} turns of the body its internal variables still change by "
                    f"{self.turn_changes[-1]:.1e} of the largest in a turn: plastic strain goes on (ratcheting), or "
                    "hardens slowly; there is no steady state near: give the number of turns"
                )
        raise AssertionError("not reached")

    def _turn(self, equilibrium: Callable[[bool], Report], report: Report | None) -> Report:
        """Displacement and history of one turn, or of a flow that comes in at the inlet. Collective."""
        for number in range(MOST_ROUNDS):
            start = self._start
            self._carry()
            same = self._difference(self._start, start, self._carried) < STILL
            found = equilibrium(report is None)
            settled = number > 0 and (same or sum(found.iterations) == 0)
            if report is None:
                report = found
            else:
                report.iterations.extend(found.iterations)
                report.residual_norms.extend(found.residual_norms)
            if settled:
                return report
            if self.closes and not self._placed:
                self._place_seams()
        raise RuntimeError(
            f"displacements and history of the flow did not settle in {MOST_ROUNDS} rounds: is the load more than the "
            "body can bear in steady flow?"
        )

    def _place_seams(self) -> None:
        """Let turns begin opposite to where the material flows plastically, as soon as it does. Collective."""
        state, flowing = self._gathered(), np.zeros(self._lines.count)
        for name in self._carried:
            flowing += np.abs(state[name] - self._start[name]).sum(axis=1)
        if np.any(flowing):
            self._lines.place_seams(flowing)
            self._placed = True

    def _carry(self) -> None:
        """History along the streamlines at the present displacements, from inlet or seam to outlet. Collective.

        Points where the history does not change are passed over, so that each evaluation brings what flows to the next
        point that flows, wherever it is.
        """
        state, start = self._gathered(), None
        for _ in range(self._lines.longest + 2):
            entering = self._entering(state)
            if start is not None and self._difference(entering, start, self._carried) < STILL:
                return
            start = self._start = entering
            self._set(start)
            self._problem.assemble_residual()
            state = self._gathered(trial=True)
            self._changes[:] = False
            for name in self._carried:
                size = float(np.abs(state[name]).max(initial=0.0))
                if name == plasticity.PLASTIC_TENSOR and self._finite:
                    size = max(size, 1.0)  # of C_p^-1, of which the unit tensor is taken away
                self._changes |= np.any(np.abs(state[name] - start[name]) > ROUND_OFF * size, axis=1)

    def _difference(
        self,
        new: dict[str, FloatArray],
        old: dict[str, FloatArray],
        names: Sequence[str],
        at: IntArray | slice = slice(None),
    ) -> float:
        """Largest change of some variables at some points over their largest values."""
        largest = 0.0
        for name in names:
            change = float(np.abs(new[name] - old[name])[at].max(initial=0.0))
            size = float(np.abs(new[name]).max(initial=0.0))
            largest = max(largest, change / size if size > 0.0 else 0.0)
        return largest
