# SPDX-License-Identifier: MIT
"""Steady rolling in the ALE frame, docs/rolling.md: bodies stand while their material flows through them.

Friction is that of the steady slip velocity. With the velocity V = w + (Grad u) w of the material at surface nodes, the
derivative taken upstream, the slip velocity at a slave node is what static contact calls slip, of velocities in place
of increments. Coulomb's law: s = 0 where the traction is within its bound, else the traction is against s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Union

import numpy as np

from . import _reference, streamlines
from .array_types import ArrayLike, FloatArray, IntArray, floats, integers, vector
from .contact import Contact, ContactSolution, _State
from .discretisation import Discretisation
from .sparse import Csr


@dataclass
class Spinning:
    """Material that turns about a fixed axis.

    Args:
        centre: point of the axis, shape (gdim) [L].
        omega: angular velocity [1/T].
        axis: direction of the axis, shape (3); z or -z in the plane [1].
    """

    centre: ArrayLike
    omega: float
    axis: ArrayLike = (0.0, 0.0, 1.0)

    @property
    def vector(self) -> FloatArray:
        """Angular velocity, shape (3) [1/T]."""
        return self.omega * self.unit

    @property
    def unit(self) -> FloatArray:
        """Unit vector along the axis, shape (3) [1]."""
        axis = vector(self.axis)
        return floats(axis / np.linalg.norm(axis))


@dataclass
class Translating:
    """Material that moves straight on.

    Args:
        velocity: velocity, shape (gdim) [L/T].
    """

    velocity: ArrayLike


Motion = Union[Spinning, Translating]


@dataclass
class RollingSolution:
    """Steady state. Values of contact are per field node."""

    u: FloatArray  # (num_dofs) [L]
    reactions: FloatArray  # on fixed dofs, zero elsewhere (num_dofs) [F]
    contact_force: FloatArray  # on all bodies (num_dofs) [F]
    multipliers: FloatArray  # lambda_j (num_nodes, gdim) [F/L^2]
    pressure: FloatArray  # (num_nodes) [F/L^2]
    traction: FloatArray  # tangential (num_nodes, gdim) [F/L^2]
    gap: FloatArray  # inf without multiplier (num_nodes) [L]
    slip_velocity: FloatArray  # of the slave against the master, zero without multiplier (num_nodes, gdim) [L/T]
    status: IntArray  # 0 open, 1 stick, 2 slip (num_nodes)
    torque: float  # driving torque on the first spinning body; nan without one [F L]
    friction_power: float  # what friction dissipates [F L/T]
    omega: float = float("nan")  # of the first spinning body [1/T]
    state: _State | None = None  # for `start`


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of the last axes with zeros appended to three components, cut to the components of b.

    Args:
        a: vectors of three components, shape (..., 3).
        b: vectors, shape (..., gdim).

    Returns:
        Products, shape (..., gdim).
    """
    gdim = b.shape[-1]
    padded = np.zeros((*b.shape[:-1], 3))
    padded[..., :gdim] = b
    return floats(np.cross(a, padded)[..., :gdim])


class RollingModel:
    """Bodies of a model through which the material flows steadily.

    Args:
        model: the bodies.
        motions: motion of every body by its tag.
        cell_tags: tag of every cell, shape (num_cells); None: all cells belong to the only body.

    Raises:
        ValueError: cells without a motion, axes of the plane that are not z.
    """

    def __init__(
        self, model: Discretisation, motions: Mapping[int, Motion], cell_tags: ArrayLike | None = None
    ) -> None:
        self.model, self.motions = model, dict(motions)
        self.gdim: int = model.field_points.shape[1]
        tags = list(self.motions)
        given = np.full(len(model.cells), tags[0]) if cell_tags is None else integers(cell_tags, "cell_tags", 1)
        unknown = set(np.unique(given)) - set(tags)
        if unknown or len(given) != len(model.cells):
            raise ValueError(f"{len(given)} cells carry tags, {sorted(unknown)} of them have no motion")
        self._body: IntArray = np.array([tags.index(int(tag)) for tag in given], dtype=np.int64)
        self._body_of_node: IntArray = np.zeros(len(model.field_points), dtype=np.int64)
        for cell, body in zip(model.field_cells, self._body):
            self._body_of_node[cell] = body
        for motion in self.motions.values():
            if isinstance(motion, Spinning) and self.gdim == 2 and abs(motion.unit[2]) != 1.0:
                raise ValueError(f"the axis of a body of the plane is z or -z, found {motion.axis}")

    def _flows(self) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        nothing: FloatArray = np.zeros(0)
        flows: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        for motion in self.motions.values():
            if isinstance(motion, Spinning):
                spin = motion.vector if self.gdim == 3 else motion.vector[2:]
                flows.append((spin, vector(motion.centre), nothing))
            else:
                flows.append((nothing, nothing, vector(motion.velocity)))
        return flows

    def matrices(self) -> tuple[Csr, Csr, FloatArray]:
        """Matrices of the flow.

        Returns:
            G, shape (num_dofs, num_dofs) [M/T], W, of the same shape [M/T^2], and the centrifugal load, shape
            (num_dofs) [F].
        """
        gyroscopic, inertia, load = self._compiled()
        return Csr(*gyroscopic.arrays), Csr(*inertia.arrays), load

    def _compiled(self) -> tuple[_reference.Csr, _reference.Csr, FloatArray]:
        rule = self.model._rule("mass")
        return _reference.flow_matrices(self.model._model, *rule, self._body.tolist(), self._flows())

    def flow(self) -> FloatArray:
        """Flow of the undeformed material at the nodes.

        Returns:
            w, shape (num_nodes, gdim) [L/T].
        """
        w = np.zeros_like(self.model.field_points)
        for body, motion in enumerate(self.motions.values()):
            at = self._body_of_node == body
            if isinstance(motion, Spinning):
                w[at] = cross(motion.vector, self.model.field_points[at] - vector(motion.centre))
            else:
                w[at] = vector(motion.velocity)
        return w

    def first_spin(self) -> tuple[int, Spinning]:
        """First body that spins.

        Returns:
            Its number and motion.

        Raises:
            ValueError: no body spins.
        """
        for body, motion in enumerate(self.motions.values()):
            if isinstance(motion, Spinning):
                return body, motion
        raise ValueError("no body spins")

    def moment(self, force: FloatArray, u: FloatArray, fixed_dofs: ArrayLike = ()) -> float:
        """Moment of forces on the first spinning body about its axis, at the deformed places.

        The axis moves in each direction by the average displacement of the body's supports in it.

        Args:
            force: nodal forces, shape (num_dofs) [F].
            u: displacements, shape (num_dofs) [L].
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).

        Returns:
            Moment [F L].
        """
        body, spin = self.first_spin()
        at = self._body_of_node == body
        centre = vector(spin.centre).copy()
        fixed = integers(fixed_dofs, "fixed_dofs", 1)
        for direction in range(self.gdim):
            supports = [dof for dof in np.unique(fixed) if dof % self.gdim == direction and at[dof // self.gdim]]
            if supports:
                centre[direction] += np.mean(u[supports])
        arm, f = np.zeros((at.sum(), 3)), np.zeros((at.sum(), 3))
        arm[:, : self.gdim] = (self.model.field_points + u.reshape(-1, self.gdim))[at] - centre
        f[:, : self.gdim] = force.reshape(-1, self.gdim)[at]
        return float(np.sum(np.cross(arm, f) @ spin.unit))

    def frequencies(self, n: int, fixed_dofs: ArrayLike = (), u: ArrayLike | None = None) -> FloatArray:
        """Frequencies of s^2 M + s G + K - W about a state, all by dense matrices.

        With A = diag(M, K - W) = L L^T and s = i omega the problem is that of a Hermitian matrix.

        Args:
            n: number of frequencies, of smallest modulus.
            fixed_dofs: degrees of freedom without displacement, shape (num_fixed).
            u: displacements of the state, shape (num_dofs); None for zero [L].

        Returns:
            Frequencies sorted by modulus, negative for waves that travel against the flow, shape (n) [1/T].

        Raises:
            RuntimeError: stiffness minus W is not positive definite.
        """
        model = self.model
        free = np.setdiff1d(np.arange(model.num_dofs), integers(fixed_dofs, "fixed_dofs", 1))
        tangent = model.tangent(np.zeros(model.num_dofs) if u is None else vector(u)).toarray()
        gyroscopic, inertia, _ = self.matrices()
        every = (tangent - inertia.toarray(), gyroscopic.toarray(), model.mass().toarray())
        K, G, M = (A[np.ix_(free, free)] for A in every)
        turned = (every[2] @ self._turning())[np.ix_(free, free)]
        try:
            Lm, Lk = np.linalg.cholesky(M), np.linalg.cholesky(K)
        except np.linalg.LinAlgError as error:
            raise RuntimeError("the mass or stiffness minus W is not positive definite") from error
        gyro = np.linalg.solve(Lm, np.linalg.solve(Lm, G.T).T)  # Lm^-1 G Lm^-T
        coupling = np.linalg.solve(Lm, Lk)
        N = len(free)
        skew = np.zeros((2 * N, 2 * N))
        skew[:N, :N], skew[:N, N:], skew[N:, :N] = -gyro, -coupling, coupling.T
        values, vectors = np.linalg.eigh(-1j * skew)
        modes = np.linalg.solve(Lk.T, vectors[N:])
        positive = np.flatnonzero(values > 0.0)[:n]
        signed = []
        spins = [abs(motion.omega) for motion in self.motions.values() if isinstance(motion, Spinning)]
        least = 0.5 * max(spins, default=0.0)
        for k in positive:
            a, b = modes[:, k].real, modes[:, k].imag
            # Twice the imaginary part of x^H D x with D the derivative along the flow less the turn of vectors.
            along = a @ (G - 2.0 * turned) @ b
            # A wave has a whole number of lengths around its body: with less than half of one it has no direction.
            signed.append(-values[k] if along > least * (a @ M @ a + b @ M @ b) else values[k])
        return np.array(signed)

    def _turning(self) -> FloatArray:
        """Matrix of Omega x v at the nodes, shape (num_dofs, num_dofs)."""
        blocks = np.zeros((len(self.motions), self.gdim, self.gdim))
        for body, motion in enumerate(self.motions.values()):
            if isinstance(motion, Spinning):
                blocks[body] = cross(motion.vector, np.eye(self.gdim)).T
        count = len(self._body_of_node)
        result = np.zeros((count, self.gdim, count, self.gdim))
        nodes = np.arange(count)
        result[nodes, :, nodes, :] = blocks[self._body_of_node]
        return result.reshape(count * self.gdim, -1)

    def along(self, contact: Contact) -> Csr:
        """Derivative along the flow at the nodes of both contact surfaces.

        Args:
            contact: contact of the bodies.

        Returns:
            Matrix between nodes, the same for every component, shape (num_nodes, num_nodes) [1/T].
        """
        w = self.flow()
        B = streamlines.derivative(self.model, contact.slave_facets, w)
        if len(contact.master_facets):
            B = streamlines.add(B, streamlines.derivative(self.model, contact.master_facets, w))
        return B

    def velocity(self, contact: Contact, u: ArrayLike) -> FloatArray:
        """Velocity of the material at the nodes of both contact surfaces; the flow w elsewhere.

        Args:
            contact: contact of the bodies.
            u: displacements, shape (num_dofs) [L].

        Returns:
            V, shape (num_nodes, gdim) [L/T].
        """
        B = self.along(contact)
        nodal = vector(u).reshape(-1, self.gdim)
        return self.flow() + np.column_stack([B.dot(nodal[:, c].copy()) for c in range(self.gdim)])

    def solve(
        self,
        fixed_dofs: ArrayLike,
        values: ArrayLike = 0.0,
        load: ArrayLike | None = None,
        contact: Contact | None = None,
        *,
        master_velocity: ArrayLike = 0.0,
        creepage: ArrayLike = 0.0,
        basis: str = "dual",
        start: RollingSolution | None = None,
        steps: int = 1,
        tolerance: float = 1e-13,
        max_iterations: int = 60,
    ) -> RollingSolution:
        """Steady state: without friction first, then with it, which is raised in steps where it does not converge.

        Args:
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            values: their displacements: one number, or shape (num_fixed) [L].
            load: external force, without that of the spin, shape (num_dofs); None for zero [F].
            contact: contact of the bodies, with friction or not; None for none.
            master_velocity: velocity of a rigid master, shape (gdim) [L/T].
            creepage: velocity that slave nodes have beside that of the flow, shape (num_nodes, gdim), or that of all
                [L/T].
            basis: basis of the multipliers.
            start: solution to start from; None for the undeformed bodies.
            steps: number of load steps of the frictionless part.
            tolerance: bound on the relative residual [1].
            max_iterations: bound on Newton's iterations.

        Returns:
            Solution.

        Raises:
            RuntimeError: no convergence.
        """
        model = self.model
        fixed = integers(fixed_dofs, "fixed_dofs", 1)
        at_fixed = np.broadcast_to(floats(values), fixed.shape).copy()
        _, inertia, total = self._compiled()
        total = total if load is None else total + vector(load)
        bodies = _reference.RollingBodies(model._model, *model._strain_rule(), inertia)
        if contact is None:
            zero = np.zeros(model.num_dofs) if start is None else start.u
            u, reactions, *_ = bodies.solve(model._model, zero, fixed, at_fixed, total, max_iterations, tolerance)
            return self._without_contact(u, reactions)
        V0 = self.flow()
        V0[np.unique(contact.slave_facets)] += floats(creepage)
        fastest = float(np.max(np.linalg.norm(V0[np.unique(contact.slave_facets)], axis=1)))
        time = float(np.ptp(model.points, axis=0).max()) / fastest if fastest > 0.0 else 1.0
        B = self.along(contact)
        obstacle = np.broadcast_to(floats(master_velocity), (self.gdim,)).astype(float)
        flow = time * V0.ravel(), B.indptr, B.indices, time * B.data, time * obstacle

        def solved(friction: float, state: _State | None, number: int) -> ContactSolution:
            assert contact is not None
            compiled = contact._compiled(friction)
            arguments = (
                state,
                fixed,
                at_fixed,
                total,
                contact._displacement(),
                contact._angle(),
                number,
                max_iterations,
                tolerance,
            )
            result = compiled.step_rolling(bodies, *contact.segment_rule(), basis, *arguments, *flow)
            after, force, reactions, iterations, residuals, _, pressure, gap, status = result
            nothing = np.zeros((len(pressure), self.gdim))
            return ContactSolution(
                after[0], pressure, nothing, gap, status, force, reactions, iterations, residuals,
                multipliers=after[8], state=after,
            )  # fmt: skip

        found = None
        if start is not None and start.state is not None:
            try:
                found = solved(contact.friction, start.state, steps)
            except RuntimeError:
                pass  # the way from the undeformed bodies is longer, but surer
        if found is None:
            first = contact._start(None)
            found = solved(0.0, first, steps)
            if contact.friction > 0.0:
                found = self._with_friction(solved, contact.friction, found)
        return self._result(contact, found, V0, B, obstacle, basis, fixed)

    @staticmethod
    def _with_friction(
        solved: Callable[[float, _State | None, int], ContactSolution], friction: float, smooth: ContactSolution
    ) -> ContactSolution:
        """Raise the coefficient of friction from zero."""
        for parts in (1, 4, 16, 64):
            found = smooth
            try:
                for part in range(1, parts + 1):
                    found = solved(friction * part / parts, found.state, 1)
                return found
            except RuntimeError:
                if parts == 64:
                    raise
        raise AssertionError("not reached")

    def _without_contact(self, u: FloatArray, reactions: FloatArray) -> RollingSolution:
        count = len(self.model.field_points)
        zero, vectors, none = np.zeros(count), np.zeros((count, self.gdim)), np.zeros(count, dtype=np.int64)
        spins = any(isinstance(motion, Spinning) for motion in self.motions.values())
        omega = self.first_spin()[1].omega if spins else float("nan")
        return RollingSolution(
            u, reactions, np.zeros_like(u), vectors, zero, vectors, np.full(count, np.inf), vectors, none,
            0.0 if spins else float("nan"), 0.0, omega,
        )  # fmt: skip

    def _result(
        self,
        contact: Contact,
        found: ContactSolution,
        V0: FloatArray,
        B: Csr,
        obstacle: FloatArray,
        basis: str,
        fixed: IntArray,
    ) -> RollingSolution:
        u, z = found.u, found.multipliers
        assert z is not None
        nodal = u.reshape(-1, self.gdim)
        V = V0 + np.column_stack([B.dot(nodal[:, c].copy()) for c in range(self.gdim)])
        back = replace(contact.no_history(), u=u - V.ravel(), displacement=contact._displacement() - obstacle)
        m = contact.mortar(u, basis, z, back)
        part = m.participates
        n = m.normals
        slip, traction = np.zeros_like(V), z - np.sum(z * n, axis=1)[:, None] * n
        slip[part] = (m.moved - np.sum(m.moved * n, axis=1)[:, None] * n)[part] / m.cover[part, None]
        power = -float(np.sum(np.where(part, m.cover, 0.0) * np.sum(traction * slip, axis=1)))
        smooth = self._without_contact(u, found.reactions)
        spins = not np.isnan(smooth.torque)
        return replace(
            smooth,
            contact_force=found.contact_force,
            multipliers=z,
            pressure=found.pressure,
            traction=traction,
            gap=found.gap,
            slip_velocity=slip,
            status=found.status,
            torque=-self.moment(found.contact_force, u, fixed) if spins else float("nan"),
            friction_power=power,
            state=found.state,
        )

    def solve_torque(
        self, torque: float, fixed_dofs: ArrayLike, *, relative: float = 1e-12, **arguments: Any
    ) -> RollingSolution:
        """Steady state for a given driving torque: the angular velocity of the first spinning body is unknown.

        The secant method, with the bisection of an interval as soon as one is known. The motion keeps the result.

        Args:
            torque: driving torque [F L].
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            relative: change of the angular velocity at which the iteration ends [1].
            arguments: of `solve`.

        Returns:
            Solution, with its `omega`.

        Raises:
            RuntimeError: no convergence.
        """
        _, spin = self.first_spin()
        found: RollingSolution | None = arguments.pop("start", None)

        def missing(omega: float) -> float:
            nonlocal found
            spin.omega = omega
            found = self.solve(fixed_dofs, start=found, **arguments)
            return found.torque - torque

        old, new = spin.omega, spin.omega * (1.0 + 1e-5)
        f_old, f_new = missing(old), missing(new)
        low: float | None = None
        high: float | None = None  # angular velocities with too little and too much torque
        for _ in range(100):
            for omega, f in ((old, f_old), (new, f_new)):
                low, high = (omega, high) if f < 0.0 else (low, omega)
            if f_new == 0.0 or f_new == f_old:
                break
            trial = new - f_new * (new - old) / (f_new - f_old)
            if low is not None and high is not None and not min(low, high) < trial < max(low, high):
                trial = (low + high) / 2
            if abs(trial - new) <= relative * abs(new):
                break
            old, f_old, new = new, f_new, trial
            f_new = missing(new)
        else:
            raise RuntimeError("the angular velocity for the torque was not found in 100 solutions")
        assert found is not None
        return found
