# SPDX-License-Identifier: MIT
"""Central differences as docs/explicit/scheme.md states them: the loop, its histories and its stable step."""

from dataclasses import dataclass

import numpy as np

from . import _reference
from .contact import RigidCylinder, RigidPlane, RigidSphere, _obstacle
from .model import _floats, _integers, _vector

ENERGIES = (
    "kinetic",
    "internal",
    "contact",
    "friction",
    "impact",
    "damping",
    "viscosity",
    "external",
    "total",
    "drift",
)


class _Nodal:
    def __init__(self, slave, master, friction, search_distance, motion):
        self.slave, self.master, self.friction = slave, master, float(friction)
        self.search_distance = np.nan if search_distance is None else float(search_distance)
        self.motion = motion
        self.rigid = isinstance(master, (RigidPlane, RigidSphere, RigidCylinder))
        if motion is not None and not self.rigid:
            raise ValueError("motion is for rigid masters; a deformable one moves with its nodes")

    def _arguments(self, model, times, lumping):
        d = model.points.shape[1]
        facets = np.zeros((0, 1), dtype=np.int64) if self.rigid else _integers(self.master, "master", 2)
        obstacle = [_obstacle(self.master, d)] if self.rigid else []
        motion = self.master.displacement if self.rigid and self.motion is None else self.motion
        displacement = _levels(0.0 if motion is None else motion, times, d, "motion")
        mass = model.mass(lumped=True, scheme=lumping)
        slave = _integers(self.slave, "slave", 2)
        return model._model, slave, facets, obstacle, self.search_distance, mass, displacement


class NodalPenalty(_Nodal):
    """Node-to-surface penalty contact of docs/explicit/penalty.md, for `Model.run_explicit`.

    slave, master: facets (m, nodes), as in `Contact`; master may be a RigidPlane, RigidSphere or RigidCylinder.
    friction: Coulomb's coefficient [1]. penalty [F/L^3]: None takes stiffnesses from masses and the step. balanced:
    once in each direction with half the stiffness. search_distance [L]: masters further away do not count, nor
    further than twice a step's motion of node and master against each other; None takes the longest distance between
    corners of any facet. motion [L]: of a rigid master, (gdim), a function of t, or a table (times, (n, gdim)); None
    takes master.displacement throughout. Running raises ValueError for facets that are repeated or not on the boundary.
    """

    def __init__(self, slave, master, friction=0.0, penalty=None, balanced=False, search_distance=None, motion=None):
        super().__init__(slave, master, friction, search_distance, motion)
        if penalty is not None and not penalty > 0:
            raise ValueError(f"penalty is {penalty!r}: it must be positive, or None")
        self.penalty, self.balanced = penalty, bool(balanced)

    def _bind(self, model, times, lumping):
        arguments = self._arguments(model, times, lumping)
        return _reference.NodalPenalty(*arguments, self.friction, float(self.penalty or 0), self.balanced)


class NodalKinematic(_Nodal):
    """Kinematic contact of docs/explicit/kinematic.md, for `Model.run_explicit`.

    Arguments as in NodalPenalty, and sweeps.
    """

    def __init__(self, slave, master, friction=0.0, sweeps=3, search_distance=None, motion=None):
        super().__init__(slave, master, friction, search_distance, motion)
        self.sweeps = int(sweeps)

    def _bind(self, model, times, lumping):
        return _reference.NodalKinematic(*self._arguments(model, times, lumping), self.friction, self.sweeps)


@dataclass
class ContactHistory:
    """What a contact did; the first axis counts the states kept. Status: 0 open, 1 stick, 2 slip (or no friction)."""

    total: np.ndarray  # on the slave (num_states, gdim) [F]
    force: np.ndarray  # nodal, on both bodies (num_states, num_dofs) [F]
    nodes: np.ndarray  # of the slave: field nodes (num_slave_nodes)
    gap: np.ndarray  # penalty: at t_n; kinematic: what is left at t_(n+1); inf without master (num_states, nodes) [L]
    status: np.ndarray  # (num_states, num_slave_nodes)
    traction: np.ndarray  # friction's force on a slave node (num_states, num_slave_nodes, gdim) [F]
    slip: np.ndarray  # since it closed (num_states, num_slave_nodes, gdim) [L]


@dataclass
class ExplicitResult:
    """Answer of `Model.run_explicit`; the first axis counts the states kept, the initial one is the first."""

    time: np.ndarray  # (num_states) [T]
    u: np.ndarray  # (num_states, num_dofs) [L]
    v: np.ndarray  # at the time levels, (3.75) (num_states, num_dofs) [L/T]
    a: np.ndarray  # (num_states, num_dofs) [L/T^2]
    v_half: np.ndarray  # half a step later (num_states, num_dofs) [L/T]
    support: np.ndarray  # on prescribed dofs, zero elsewhere (num_states, num_dofs) [F]
    energies: dict  # of arrays (num_states) [F L]: see ENERGIES; drift [1]
    contacts: list  # a ContactHistory of each contact


def _levels(table, times, width, what):
    """Values at time levels, shape (len(times), width): a constant, a function of t, or (times, values), linear."""
    if callable(table):
        rows = [np.broadcast_to(_floats(table(t)), (width,)) for t in times]
        return np.array(rows).reshape(len(times), width)
    if isinstance(table, tuple):
        at, values = _floats(table[0]), _floats(table[1])
        if at.ndim != 1 or values.shape[:1] != at.shape or np.any(np.diff(at) <= 0):
            raise ValueError(
                f"{what}: a table needs increasing times (n) and n values, found {at.shape}, {values.shape}"
            )
        columns = np.broadcast_to(values.reshape(len(at), -1), (len(at), width))
        result = [np.interp(times, at, column) for column in columns.T]
        return np.ascontiguousarray(np.array(result).reshape(width, len(times)).T)
    return np.broadcast_to(_floats(table), (len(times), width)).copy()


def _loads(loads, times, num_dofs):
    """Rows of loads and their amplitudes (len(times), num_loads)."""
    if loads is None:
        loads = []
    elif isinstance(loads, np.ndarray) and loads.ndim == 1:
        loads = [loads]
    pairs = [load if isinstance(load, tuple) else (load, 1.0) for load in loads]
    vectors = np.array([_vector(vector) for vector, _ in pairs]).reshape(len(pairs), num_dofs)
    amplitudes = [_levels(amplitude, times, 1, "load")[:, 0] for _, amplitude in pairs]
    return vectors, np.ascontiguousarray(np.array(amplitudes).reshape(len(pairs), len(times)).T)


def _scheme(scheme):
    if scheme not in ("half_step", "classical"):
        raise ValueError(f"unknown scheme {scheme!r}: use 'half_step' or 'classical'")
    return scheme == "classical"


def run_explicit(
    model,
    dt,
    num_steps=None,
    *,
    u0=None,
    v0=None,
    fixed_dofs=(),
    values=0.0,
    loads=None,
    alpha=0.0,
    beta=0.0,
    scheme="half_step",
    viscosity=None,
    contacts=(),
    lumping="auto",
    every=1,
):
    """See `Model.run_explicit`."""
    steps = _vector(dt)
    if num_steps is not None:
        if steps.size not in (1, num_steps):
            raise ValueError(f"dt has {steps.size} steps, but num_steps is {num_steps}")
        steps = np.broadcast_to(steps, (num_steps,)).copy()
    classical = _scheme(scheme)
    # As the loop adds them up.
    times = np.cumsum(np.concatenate([[0.0], steps, steps[-1:]]))
    fixed = np.asarray(fixed_dofs, dtype=np.int64).reshape(-1)
    vectors, amplitudes = _loads(loads, times[:-1], model.num_dofs)
    zero = np.zeros(model.num_dofs)
    b1, b2 = (0.0, 0.0) if viscosity is None else viscosity
    bound = [contact._bind(model, times, lumping) for contact in contacts]
    result = _reference.run_explicit(
        model._model,
        *model._strain_rule(),
        *model._rule("mass"),
        lumping,
        steps,
        zero if u0 is None else _vector(u0),
        zero if v0 is None else _vector(v0),
        fixed,
        _levels(values, times, fixed.size, "values"),
        vectors,
        amplitudes,
        float(alpha),
        float(beta),
        classical,
        float(b1),
        float(b2),
        int(every),
        bound,
    )
    energies = dict(zip(ENERGIES, result.energies.T.copy()))
    histories = []
    for contact, raw in zip(bound, result.contacts):
        shape = raw.gap.shape + (model.points.shape[1],)
        nodes = np.array(contact.nodes, dtype=np.int64)
        traction, slip = raw.traction.reshape(shape), raw.slip.reshape(shape)
        histories.append(ContactHistory(raw.total, raw.force, nodes, raw.gap, raw.status, traction, slip))
    r = result
    return ExplicitResult(r.time, r.u, r.v, r.a, r.half, r.support, energies, histories)


def stable_step(
    model, method="element", alpha=0.0, beta=0.0, scheme="half_step", fixed_dofs=(), contacts=(), u=None, lumping="auto"
):
    """See `Model.stable_step`."""
    u = np.zeros(model.num_dofs) if u is None else _vector(u)
    bound = [contact._bind(model, np.zeros(2), lumping) for contact in contacts if isinstance(contact, NodalPenalty)]
    if method == "length":
        frequency = 2 / _reference.passage(model._model)
    elif method == "element":
        rules = *model._rule("stiffness"), *model._rule("mass")
        frequency = _reference.cell_frequency(model._model, *rules, lumping)
    elif method == "eigenvalue":
        K, mass = model.stiffness(), model.mass(lumped=True, scheme=lumping)
        fixed = np.asarray(fixed_dofs, dtype=np.int64).reshape(-1)
        springs = [contact.springs(u) for contact in bound]
        frequency = _reference.highest_frequency(K.indptr, K.indices, K.data, springs, mass, fixed)
    else:
        raise ValueError(f"unknown method {method!r}: use 'length', 'element' or 'eigenvalue'")
    if method != "eigenvalue":
        frequency = np.sqrt(frequency**2 + sum(contact.added_frequency(u) for contact in bound))
    damped = 0.0 if _scheme(scheme) else (alpha / frequency + beta * frequency) / 2
    return 2 / frequency * (np.sqrt(1 + damped**2) - damped)
