# SPDX-License-Identifier: MIT
"""Bodies that fly at each other: velocities at the start, momenta, and the history of a contact's force."""

import numpy as np
from contact_model import Model
from dolfinx import fem

import dolfinx_impact as di
from dolfinx_impact.theory import waves

BOTH = ("Penalty", "Kinematic")


def enforce(method, pair, **options):
    """A contact by the method's name."""
    return getattr(di, method)(pair, **options)


class Impact(Model):
    """A Model whose bodies are thrown.

    Attributes:
        velocity: function at the start [L/T].
    """

    def __init__(self, recipe, law, degree=1, **parameters):
        super().__init__(recipe, law, degree, **parameters)
        self.velocity = fem.Function(self.V)
        self.cell_tags = getattr(recipe, "cell_tags", None)
        self.X = self.V.tabulate_dof_coordinates()[:, : self.gdim]

    def body(self, condition):
        """Nodes whose place in the reference configuration satisfies a condition on coordinates."""
        return np.flatnonzero(condition(self.X.T))

    def throw(self, nodes, velocity, spin=0.0, center=(0.0, 0.0)):
        """Velocity of nodes; in the plane also a spin about a centre [L/T; 1/T; L]."""
        v = self.velocity.x.array.reshape(-1, self.gdim)
        v[nodes] = velocity
        if spin:
            r = self.X[nodes] - np.asarray(center)
            v[nodes] += spin * np.column_stack([-r[:, 1], r[:, 0]])

    def explicit(self, *contacts, **options):
        return di.ExplicitProblem(
            self.u, self.law, velocity=self.velocity, bcs=self.bcs, loads=self.loads, contact=list(contacts), **options
        )

    def implicit(self, *contacts, **options):
        return di.NewmarkProblem(
            self.u, self.law, velocity=self.velocity, bcs=self.bcs, loads=self.loads, contact=list(contacts), **options
        )


def momentum(problem, nodes):
    """Sum of mass times velocity over nodes, (gdim)."""
    gdim = problem.space.mesh.geometry.dim
    p = (problem.mass.array * problem.velocity.x.array).reshape(-1, gdim)
    return p[nodes].sum(axis=0)


def mass(problem, nodes):
    gdim = problem.space.mesh.geometry.dim
    return problem.mass.array.reshape(-1, gdim)[nodes, 0].sum()


def spin(problem, nodes):
    """Angular momentum about the mass centre, moment of inertia about it (plane; as they are now)."""
    m = problem.mass.array.reshape(-1, 2)[nodes, 0]
    x = (problem.space.tabulate_dof_coordinates()[:, :2] + problem.u.x.array.reshape(-1, 2))[nodes]
    v = problem.velocity.x.array.reshape(-1, 2)[nodes]
    r, w = x - m @ x / m.sum(), v - m @ v / m.sum()
    return m @ (r[:, 0] * w[:, 1] - r[:, 1] * w[:, 0]), m @ np.sum(r**2, axis=1)


class History:
    """Callback that keeps times and contact forces; forces belong to the time before the last half step.

    Attributes:
        chi: largest stiffness per area that springs have had; zero in kinematic contact [F/L^3].
    """

    def __init__(self, number=0, component=0):
        self.number, self.component, self._rows, self.chi = number, component, [], 0.0

    def __call__(self, problem):
        contact = problem.contact[self.number]
        self._rows.append((problem.time, contact.force[self.component]))
        self.chi = max(self.chi, float(np.max(contact.stiffness / contact.weight, initial=0.0)))

    @property
    def times(self):
        return np.array(self._rows)[:, 0]

    @property
    def forces(self):
        return np.array(self._rows)[:, 1]

    def span(self, level=0.0):
        """First and last time at which the force's size is above a level."""
        on = np.flatnonzero(np.abs(self.forces) > level)
        return self.times[on[0]], self.times[on[-1]]

    def mean(self, begin, end):
        """Mean force over the middle 80 % of a span of time, as impulse over time."""
        low, high = begin + 0.1 * (end - begin), end - 0.1 * (end - begin)
        impulse = np.concatenate([[0.0], np.cumsum(np.diff(self.times) * (self.forces[1:] + self.forces[:-1]) / 2)])
        return (np.interp(high, self.times, impulse) - np.interp(low, self.times, impulse)) / (high - low)

    @property
    def dt(self):
        return np.diff(self.times[-2:])[0]


def expected_pulse(release_time, lag, echo, dt, courant):
    """What a contact of bars must show, and how far it may be off: dict of (value, off), times relative to the contact.

    Springs: theory.waves.contact_pulse. Without: the release's front comes early by dispersion, the end of contact by
    less than its width (200 cells' way: 2 L). Forces begin and end in a step: one off times and impulse at either end.

    Args:
        release_time: 2 L/c [T]. lag: of the springs, zero without [T]. echo: of contact_pulse. dt: step [T].
        courant: c dt/h, which makes release_time c/h cells of the way.
    """
    step, way = dt / release_time, courant * release_time / dt  # the latter in cells
    if lag:
        t = np.linspace(0.0, 1.9 * release_time, 40001)
        pulse, width = waves.contact_pulse(t, release_time, lag, echo), 0.0
        over = np.flatnonzero(pulse > 0.5)
        begin, end, impulse = t[over[0]], t[over[-1]], np.sum(pulse) * t[1]
        begin, end, impulse = begin / release_time, end / release_time, impulse / release_time
    else:
        width = waves.front_width(way, 1.0, courant) / way
        # With echo 1 the front falls to zero only far behind: half of it is early, half of it late.
        begin, end, impulse = 0.0, 1.0, 1.0 - (waves.early_release(echo) if echo > 1 else 0.0) * width
    return {
        "begin": (begin, 2 * step),
        "end": (end, 2 * step + width),
        "impulse": (impulse, step + (width if echo <= 1 else 0.0)),
    }
