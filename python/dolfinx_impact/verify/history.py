# SPDX-License-Identifier: MIT
"""Level history: explicit runs of 500 steps on both sides, docs/explicit/scheme.md; every step's state and energies.

Every run with contact is repeated from other starts, with other steps, so that no lucky number hides a rule that
differs.
"""

from dataclasses import dataclass, field, replace

import impact_reference
import numpy as np
from dolfinx import fem, mesh

from .. import contact, materials
from ..amplitude import PrescribedMotion
from ..dynamics.explicit import ExplicitProblem
from ..loads import BodyForce
from ..dynamics.run_history import ENERGIES
from . import bodies, operator
from .contact_bodies import BOTTOM, SLAVE, TwoBodies, two_bodies

STEPS = 500
TOLERANCE = 1e-9
REASON = "round-off of 500 steps, which waves and contact carry on"
# Seeds of the other starts of every run with contact, by dimension (with some of them, nodes turn away from facets that
# they are about to touch); and steps by dimension and degree, until the bodies have met, turned and met again.
OTHER_STARTS = {2: (1, 2, 3, 26), 3: (4, 5)}  # 26: a node turns away from the master between two searches
OTHER_STEPS = {(2, 1): 250, (2, 2): 500, (3, 1): 120, (3, 2): 120}


@dataclass
class Run:
    """A body and how it starts, is held, loaded and damped."""

    name: str
    body: TwoBodies
    velocity: object  # function of places (num_nodes, gdim), in our order -> (num_nodes, gdim) [L/T]
    contact: str = ""  # "penalty", "kinematic" or none
    options: dict = field(default_factory=dict)  # of the contact
    held: tuple = ()  # our nodes
    motion: object = None  # function of time: displacement of `held` along the last axis [L]
    gravity: object = None  # (acceleration [L/T^2], amplitude)
    obstacle: object = None  # function of time [L]
    damping: tuple = (0.0, 0.0)
    viscosity: tuple = None
    scheme: str = "half_step"
    part: float = 0.8  # of the stable step


class Start:
    """Another start of a run, by chance: the step, the attitude of the upper body, its velocity and spin. The same seed
    gives the same start.

    Args:
        seed: number; None: the run as it is written down.
    """

    def __init__(self, seed=None):
        self.seed = seed
        rng = np.random.default_rng(seed)
        self.part = None if seed is None else rng.uniform(0.7, 0.9)
        self.angles, self.course, self.spin = rng.uniform(-1, 1, (3, 3)) * [[0.3], [0.5], [0.3]]
        self.phases = rng.uniform(0, 2 * np.pi, 3)

    def turn(self, domain):
        """Turn the upper body about its middle; it stays as high above the lower one."""
        if self.seed is None:
            return
        dim = domain.geometry.dim
        x, upper = domain.geometry.x, _nodes_of_upper(domain)
        low, middle = x[upper, dim - 1].min(), x[upper].mean(axis=0)
        x[upper, :dim] = ((x[upper] - middle) @ _rotation(self.angles, dim).T + middle)[:, :dim]
        x[upper, dim - 1] += low - x[upper, dim - 1].min()

    def of(self, case):
        """The run with its step, and its velocities turned, with spin and waves."""
        if self.seed is None:
            return case

        def velocity(places):
            dim = places.shape[1]
            v = case.velocity(places)
            size = max(np.abs(v).max(), 0.02)
            moving = np.any(v != 0.0, axis=1)
            x = np.pad(places, ((0, 0), (0, 3 - dim)))
            v = (np.pad(v, ((0, 0), (0, 3 - dim))) @ _rotation(self.course, dim).T)[:, :dim]
            axis = self.spin if dim == 3 else [0.0, 0.0, self.spin[2]]
            if moving.any():
                v[moving] += np.cross(axis, x[moving] - x[moving].mean(axis=0))[:, :dim]
            v += 0.05 * size * np.sin(places @ np.ones((dim, dim)) * 3 + self.phases[:dim])
            v[list(case.held)] = 0.0
            return v

        return replace(case, name=f"{case.name}, start {self.seed}", velocity=velocity, part=self.part)


def _rotation(angles, dim):
    """By a vector of angles; in the plane about the third axis only."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angles if dim == 3 else [0.0, 0.0, angles[2]]).as_matrix()


def run(report, progress=None):
    """Add the rows of all runs to a report."""
    for cell, degree, make in RUNS:
        if report.wants(cell, degree):
            for case in make(cell, degree):
                compare(report, case)
            for case in other_starts(cell, degree, make):
                compare(report, case, OTHER_STEPS[case.body.gdim, degree])


def other_starts(cell, degree, make, seeds=None):
    """Runs with contact from other starts.

    Args:
        seeds: of the starts; None: those of the level.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    for seed in OTHER_STARTS[dim] if seeds is None else seeds:
        start = Start(seed)
        yield from (start.of(case) for case in make(cell, degree, start) if case.contact)


# --- bodies ----------------------------------------------------------------------------------------------------------


def _body(domain, tags, degree, hypothesis, law="linear_elastic", friction=0.0, rigid=None, nu=0.3):
    material = operator.LAWS[law](1.0, nu, 1.0, hypothesis)
    strain = operator._rule(domain, degree, hypothesis, law)
    rules = None if strain is None else {"stiffness": strain, "finite_strain": strain}  # masses with rules of their own
    return TwoBodies(domain, tags, degree, material, friction, rigid, law=law, rule=rules)


GAP = 0.002  # the least distance between two bodies before anything moves [L]


def _upper(places):
    """Nodes of the upper body, which is the slave. Told apart in the middle of the gap: heights of the lower body's top
    are 1 to round-off only, which depends on the processor."""
    return places[:, -1] > 1.0 + 0.5 * GAP


def _lift(domain, gap):
    """Open a gap between the bodies, so that round-off does not decide what touches."""
    upper = _nodes_of_upper(domain)
    domain.geometry.x[upper, domain.geometry.dim - 1] += gap
    return upper


def _nodes_of_upper(domain):
    """Nodes of the mesh that belong to the upper body, by the centres of the cells: (num_nodes) bool."""
    x, dofmap = domain.geometry.x, domain.geometry.dofmap
    upper = np.zeros(len(x), dtype=bool)
    upper[np.unique(dofmap[x[dofmap][:, :, domain.geometry.dim - 1].mean(axis=1) > 1.0])] = True
    return upper


def falling(down, along=0.0):
    """Velocities of two bodies of which the upper one comes down, and moves along the first axis."""

    def velocity(places):
        v = np.zeros_like(places)
        v[_upper(places)] = [along] + [0.0] * (places.shape[1] - 2) + [-down]
        return v

    return velocity


def bars(cell, degree, start=Start()):
    """Two bars that meet end on: one row of cells, and several with nu = 0.3."""
    for rows, nu, kind in ((1, 0.0, "penalty"), (1, 0.0, "kinematic"), (3, 0.3, "penalty"), (3, 0.3, "kinematic")):
        domain, tags = two_bodies(cell, (rows, 12), (rows, 9), start=(0.04,), length=(0.92,))  # not edge on edge
        _lift(domain, 0.003)
        start.turn(domain)
        body = _body(domain, tags, degree, "plane_strain", nu=nu)
        yield Run(f"two bars, {rows} rows, {kind}", body, falling(0.02), kind)


def disc(cell, degree, start=Start()):
    """A disc that falls on a block at an angle, with friction: it comes to roll."""
    for kind, options in (("penalty", {}), ("penalty", {"balanced": True}), ("kinematic", {})):
        domain, tags = two_bodies(cell, (9, 4), (8, 8), start=(0.2,), length=(0.5,))
        x, upper = domain.geometry.x, _lift(domain, 0.0)
        a, b = (x[upper, 0] - 0.45) / 0.25, (x[upper, 1] - 1.25) / 0.25
        x[upper, 0] = 0.45 + 0.25 * a * np.sqrt(1 - b**2 / 2)
        x[upper, 1] = 1.252 + 0.25 * b * np.sqrt(1 - a**2 / 2)
        start.turn(domain)
        body = _body(domain, tags, degree, "plane_strain", friction=0.3)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        name = f"disc on a block, {'balanced ' if options else ''}{kind}"
        yield Run(name, body, falling(0.03, 0.02), kind, options, held=low)


def blocks(cell, degree, start=Start()):
    """A block thrown on another one in space, with friction, neo-Hookean."""
    for kind, law in (("penalty", "neo_hookean"), ("kinematic", "linear_elastic")):
        domain, tags = two_bodies(cell, (4, 3, 2), (3, 2, 2), start=(0.17, 0.13))
        x, upper = domain.geometry.x, _lift(domain, GAP)
        x[upper, 2] += 0.1 * ((x[upper, :2] - 0.5) ** 2).sum(axis=1)  # round below
        start.turn(domain)
        body = _body(domain, tags, degree, "3d", law, friction=0.2)
        yield Run(f"block on a block, {law.replace('_', '-')}, {kind}", body, falling(0.05, 0.03), kind)


def overhang(cell, degree, start=Start()):
    """A block thrown over the end of another one: nodes over the rim, beside it, and come in below it as it turns."""
    plane = cell in ("triangle", "quadrilateral")
    for kind in ("penalty", "kinematic"):
        domain, tags = two_bodies(cell, (9, 4) if plane else (4, 4, 2), (5, 4) if plane else (3, 3, 2),
                                  start=(0.66,) * (1 if plane else 2), length=(0.6,) * (1 if plane else 2))  # fmt: skip
        _lift(domain, GAP)
        start.turn(domain)
        body = _body(domain, tags, degree, "plane_strain" if plane else "3d", "neo_hookean", friction=0.2)
        yield Run(f"block over an end, {kind}", body, falling(0.1, -0.05), kind)


def coarse(cell, degree, start=Start()):
    """A ring on a finer one, with friction: slaves much heavier than the masters they meet."""
    for kind in ("penalty", "kinematic"):
        domain, tags = two_bodies(cell, (14, 10), (3, 2), start=(0.11,), length=(0.75,))
        domain.geometry.x[:, 0] += 0.3
        _lift(domain, GAP)
        start.turn(domain)
        body = _body(domain, tags, degree, "axisymmetric", friction=0.2)
        yield Run(f"coarse ring on a fine one, {kind}", body, falling(0.03, 0.01), kind)


def rigid(cell, degree, start=None):
    """A body of revolution thrown on a rigid plane, and a block hit by a rigid cylinder that moves."""
    domain = bodies.block(cell, 5)
    domain.geometry.x[:, 0] += 0.2
    for kind in ("penalty", "kinematic"):
        pair = [m.RigidPlane(np.array([0.0, -0.01]), np.array([0.0, 1.0])) for m in (contact, impact_reference)]
        body = _body(domain, _face(domain, 0.0), degree, "axisymmetric", friction=0.0, rigid=pair)
        yield Run(f"ring on a rigid plane, {kind}", body, lambda x: np.tile([0.0, -0.05], (len(x), 1)), kind)
    domain = bodies.block(cell, 6)
    for kind in ("penalty", "kinematic"):
        center = np.array([0.47, 1.805])
        pair = [m.RigidCylinder(center, 0.8) for m in (contact, impact_reference)]
        body = _body(domain, _face(domain, 1.0), degree, "plane_strain", friction=0.3, rigid=pair)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        yield Run(
            f"block under a rigid cylinder that moves, {kind}", body, lambda x: np.zeros_like(x), kind, held=low,
            obstacle=lambda t: np.array([0.01 * t, -0.03 * np.sin(t / 4)]),
        )  # fmt: skip


def _face(domain, height):
    dim = domain.geometry.dim
    facets = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], height))
    other = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1.0 - height))
    both = np.concatenate([facets, other])
    order = np.argsort(both)
    values = np.repeat([SLAVE, BOTTOM], [len(facets), len(other)]).astype(np.int32)
    return mesh.meshtags(domain, dim - 1, both[order], values[order])


def alone(cell, degree, start=None):
    """A body without contact: schemes, damping, viscosity, loads and prescribed motion."""
    plane = cell in ("triangle", "quadrilateral")
    domain = bodies.block(cell, 4 if plane else 2)
    body = {law: _body(domain, _face(domain, 0.0), degree, "plane_strain" if plane else "3d", law)
            for law in ("linear_elastic", "neo_hookean")}  # fmt: skip
    places = body["linear_elastic"].V.tabulate_dof_coordinates()
    low = np.flatnonzero(np.isclose(places[:, body["linear_elastic"].gdim - 1], 0.0))

    def shaken(x):
        v = np.zeros_like(x)
        v[:, 0] = 0.05 * x[:, -1]
        v[:, -1] = -0.1 * x[:, -1] ** 2
        v[low] = 0.0
        return v

    down = np.zeros(body["linear_elastic"].gdim)
    down[-1] = -0.1
    gravity = (down, lambda t: 1.0 - np.cos(2 * t))
    yield Run("shaken", body["linear_elastic"], shaken, held=low)
    yield Run("classical scheme, damped", body["linear_elastic"], shaken, held=low, damping=(0.2, 0.0),
              scheme="classical", gravity=gravity)  # fmt: skip
    for law in body:
        yield Run(
            f"damped, {law.replace('_', '-')}", body[law], shaken, held=low, damping=(0.1, 0.004), gravity=gravity
        )
        yield Run(f"viscous, {law.replace('_', '-')}", body[law], shaken, viscosity=(0.06, 1.2), part=0.7)
    yield Run("support that moves", body["linear_elastic"], shaken, held=low, motion=lambda t: 0.02 * np.sin(3 * t))


RUNS = (
    ("quadrilateral", 1, bars),
    ("triangle", 1, bars),
    ("quadrilateral", 2, bars),
    ("quadrilateral", 1, disc),
    ("hexahedron", 1, blocks),
    ("tetrahedron", 1, blocks),
    ("quadrilateral", 1, overhang),
    ("hexahedron", 1, overhang),
    ("tetrahedron", 2, overhang),
    ("quadrilateral", 1, coarse),
    ("triangle", 2, coarse),
    ("quadrilateral", 1, rigid),
    ("quadrilateral", 1, alone),
    ("triangle", 2, alone),
    ("hexahedron", 1, alone),
    ("tetrahedron", 2, alone),
)


# --- both sides ------------------------------------------------------------------------------------------------------


def ours(case, steps):
    """Our run; returns the problem and the displacements and velocities of all time levels."""
    body = case.body
    V, u = body.V, fem.Function(body.V, name="u")
    places = V.tabulate_dof_coordinates()[:, : body.gdim]
    v = fem.Function(V)
    v.x.array[:] = case.velocity(places).ravel()
    bcs = []
    if len(case.held):
        nodes = np.asarray(case.held, dtype=np.int32)
        if case.motion is None:
            bcs = [fem.dirichletbc(np.zeros(body.gdim), nodes, V)]
        else:
            bcs = [PrescribedMotion(fem.dirichletbc(np.eye(body.gdim)[-1], nodes, V), case.motion)]
    loads = [] if case.gravity is None else [BodyForce(case.gravity[0], amplitude=case.gravity[1])]
    contacts = []
    if case.contact:
        kind = contact.Penalty if case.contact == "penalty" else contact.Kinematic
        if body.rigid:
            motion = case.obstacle
            body.rigid[0].motion = None if motion is None else lambda t: np.pad(motion(t), (0, 3 - body.gdim))
        contacts = [kind(body.pair(everywhere=False), **case.options)]
    problem = ExplicitProblem(
        u, body.material, velocity=v, bcs=bcs, loads=loads, contact=contacts, scheme=case.scheme,
        damping=materials.Rayleigh(*case.damping), bulk_viscosity=case.viscosity,
    )  # fmt: skip
    dt = case.part * problem.stable_step()
    states = []  # the callback's first is the start
    problem.advance(
        steps * dt, dt=dt, progress=False,
        callback=lambda p: states.append((p.u.x.array.copy(), p.velocity.x.array.copy())),
    )  # fmt: skip
    return problem, dt, [np.array(s) for s in zip(*states)]


def theirs(case, dt, steps):
    """The hand-written solver's run."""
    body = case.body
    places = body.V.tabulate_dof_coordinates()[:, : body.gdim]
    v0 = np.empty(len(body.order))
    v0[body.order] = case.velocity(places).ravel()
    held = (np.asarray(case.held, dtype=int)[:, None] * body.gdim + np.arange(body.gdim)).ravel()
    values = 0.0
    if case.motion is not None:
        last = (held % body.gdim == body.gdim - 1).astype(float)
        values = lambda t: last * case.motion(t)  # noqa: E731
    loads = None
    if case.gravity is not None:
        loads = [(body.model.body_force(np.asarray(case.gravity[0])), case.gravity[1])]
    contacts = []
    if case.contact:
        kind = impact_reference.NodalPenalty if case.contact == "penalty" else impact_reference.NodalKinematic
        slave = body.their_facets(body.tags, SLAVE)
        if body.rigid:
            master, motion = body.rigid[1], {"motion": case.obstacle}
        else:
            master, motion = body.their_facets(body.tags, 2), {}
        contacts = [kind(slave, master, body.friction, **case.options, **motion)]
    return body.model.run_explicit(
        dt, steps, v0=v0, fixed_dofs=body.order[held], values=values, loads=loads, alpha=case.damping[0],
        beta=case.damping[1], scheme=case.scheme, viscosity=case.viscosity, contacts=contacts,
    )  # fmt: skip


def compare(report, case, steps=STEPS):
    """Rows of one run: displacements, velocities, contact forces and energies of all time levels."""
    body = case.body
    problem, dt, (u, v) = ours(case, steps)
    other = theirs(case, dt, steps)
    pairs = {"displacement": (u, other.u[:, body.order])}
    if case.contact != "kinematic":  # which knows its forces, and with them this velocity, one step later only
        pairs["velocity"] = (v, other.v[:, body.order])
    energies = dict(zip(ENERGIES, problem.energy_history[:, 1:].T))
    for name, values in energies.items():
        theirs_of_it = other.energies[name][:steps]
        if np.any(theirs_of_it) or np.any(values):
            pairs[f"{name} energy"] = (values, theirs_of_it)
    if case.contact:
        total = other.contacts[0].total[:steps]
        pairs["contact force"] = (problem.force_history[0], total)
    size = max(np.abs(other.energies["kinetic"]).max(), np.abs(other.energies["internal"]).max())
    for what, (a, b) in pairs.items():
        scale = size if what.endswith("energy") else np.abs(b).max()
        add(report, case, what, np.asarray(a), np.asarray(b), scale)


def add(report, case, what, a, b, scale):
    """One row: the largest difference against the largest entry (energies: the run's largest)."""
    body = case.body
    if a.shape != b.shape:
        difference, note = np.inf, f"UFL side {a.shape} values, hand-written side {b.shape}"
    elif not scale > 0.0:
        difference, note = np.inf, "nothing happens on the hand-written side"
    else:
        error = np.where(np.isnan(a - b), np.inf, np.abs(a - b))
        k = np.unravel_index(np.argmax(error), error.shape)
        difference = error[k] / scale
        note = f"step {int(k[0])}: UFL {a[k]:.15g}, hand-written {b[k]:.15g}"
    element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
    name = f"{what} of the {case.name}"
    form = f"explicit.{case.contact or 'free'}"
    report.add("history", form, *element, difference, TOLERANCE, REASON, name, note)
