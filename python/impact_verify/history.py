# SPDX-License-Identifier: MIT
"""Level history: explicit runs of 500 steps on both sides, docs/explicit/scheme.md; state and energies of every step.

Every run with contact is repeated from other initial states and with other steps, so that a difference between the
contact rules of the two sides cannot stay hidden by chance.
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias, cast

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh, MeshTags
from impact_reference import ExplicitResult
from impact_reference.array_types import TimeValues

from dolfinx_impact import contact, materials
from dolfinx_impact.amplitude import PrescribedMotion
from dolfinx_impact.common.types import BoolArray, FloatArray, IntArray
from dolfinx_impact.materials import _Material
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.run_history import ENERGIES
from dolfinx_impact.added_mass import AddedMass
from dolfinx_impact.foundation import Foundation
from dolfinx_impact.loads import BodyForce, Load
from . import bodies, operator
from .contact_bodies import BOTTOM, MASTER, SLAVE, ObstaclePair, TwoBodies, two_bodies
from .nodes import TheirRule
from .report import Report

STEPS = 500
TOLERANCE = 1e-9
REASON = "round-off of 500 steps, which waves and contact carry on"
# Seeds of the variations of every run with contact, by dimension (with some of them, nodes turn away from facets that
# they are about to touch). Steps by dimension and degree: enough for two impacts with a rotation between them.
VARIATION_SEEDS = {2: (1, 2, 3, 26), 3: (4, 5)}  # 26: a node turns away from the master between two searches
VARIATION_STEPS = {(2, 1): 250, (2, 2): 500, (3, 1): 120, (3, 2): 120}

# Velocities [L/T] at positions [L], both of shape (num_nodes, gdim), in our order.
VelocityField: TypeAlias = Callable[[FloatArray], FloatArray]


@dataclass
class Run:
    """A body with its initial velocity, supports, loads and damping.

    Args:
        name: name in the rows.
        body: bodies of both sides.
        velocity: initial velocity as a function of the positions of our nodes [L/T].
        contact: "penalty", "kinematic" or "" for no contact.
        options: keyword arguments of the contact.
        fixed_nodes: our nodes with prescribed displacements.
        motion: displacement of these nodes along the last axis as a function of time; None for zero [L].
        gravity: acceleration, shape (gdim) [L/T^2], and amplitude over time [1].
        obstacle: displacement of the rigid obstacle as a function of time; None for zero [L].
        damping: Rayleigh damping alpha [1/T] and beta [T].
        viscosity: linear and quadratic bulk viscosity; None for none [1].
        scheme: "half_step" or "classical".
        step_fraction: time step over the stable step [1].
        foundation: stiffness [F/L^3] and damping [F T/L^3] of a Foundation under the facets SLAVE on our side; the
            other side's model has it already (`on_foundation`).
        added_mass: mass on the facets SLAVE on our side; the other side's model has it already [M].
        smooth: of a smooth master, function of positions, shape (gdim or more, n), that gives normals, (gdim, n).
    """

    name: str
    body: TwoBodies
    velocity: VelocityField
    contact: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    fixed_nodes: IntArray | tuple[int, ...] = ()
    motion: Callable[[float], float] | None = None
    gravity: tuple[FloatArray, Callable[[float], float]] | None = None
    obstacle: Callable[[float], FloatArray] | None = None
    damping: tuple[float, float] = (0.0, 0.0)
    viscosity: tuple[float, float] | None = None
    scheme: str = "half_step"
    step_fraction: float = 0.8
    foundation: tuple[Any, Any] | None = None
    added_mass: float | None = None
    smooth: Callable[[FloatArray], FloatArray] | None = None


class RandomVariation:
    """Random variation of a run: time step, rotation of the upper body, direction of its velocity, and its spin.

    Args:
        seed: seed of the random numbers; None leaves a run unchanged.
    """

    def __init__(self, seed: int | None = None) -> None:
        self.seed = seed
        rng = np.random.default_rng(seed)
        self.step_fraction = None if seed is None else rng.uniform(0.7, 0.9)
        self.angles, self.direction, self.spin = rng.uniform(-1, 1, (3, 3)) * [[0.3], [0.5], [0.3]]
        self.phases = rng.uniform(0, 2 * np.pi, 3)

    def rotate_upper_body(self, domain: Mesh, top: Callable[[FloatArray], FloatArray] | None = None) -> None:
        """Rotate the upper body about its centre and keep its least height above the lower body.

        The body falls from the same gap then, and touches before it has turned or moved far.

        Args:
            domain: mesh of two bodies, which is changed.
            top: height of the lower body's upper face as a function of positions, shape (n, 3) to (n); None: the face
                is level [L].
        """
        if self.seed is None:
            return
        dim = domain.geometry.dim
        x, upper = domain.geometry.x, _upper_nodes(domain)
        cells = domain.geometry.dofmap[upper[domain.geometry.dofmap].all(axis=1)]

        def height() -> float:
            # Facets may be nearer than their nodes where the lower body is curved: in the middle, or nearly there.
            places = 0.5 * (x[cells[:, :, None]] + x[cells[:, None, :]]).reshape(-1, 3)
            above = places[:, dim - 1] - (0.0 if top is None else top(places))
            return float(above.min())

        low, centre = height(), x[upper].mean(axis=0)
        x[upper, :dim] = ((x[upper] - centre) @ _rotation(self.angles, dim).T + centre)[:, :dim]
        x[upper, dim - 1] += low - height()

    def apply(self, case: Run) -> Run:
        """Vary the time step and the initial velocity of a run.

        Args:
            case: run.

        Returns:
            Run with another step, and a velocity that is rotated and has spin and waves added.
        """
        if self.seed is None:
            return case

        def velocity(positions: FloatArray) -> FloatArray:
            dim = positions.shape[1]
            v = case.velocity(positions)
            size = max(np.abs(v).max(), 0.02)
            moving = np.any(v != 0.0, axis=1)
            x = np.pad(positions, ((0, 0), (0, 3 - dim)))
            v = (np.pad(v, ((0, 0), (0, 3 - dim))) @ _rotation(self.direction, dim).T)[:, :dim]
            axis = self.spin if dim == 3 else [0.0, 0.0, self.spin[2]]
            if moving.any():
                v[moving] += np.cross(axis, x[moving] - x[moving].mean(axis=0))[:, :dim]
            v += 0.05 * size * np.sin(positions @ np.ones((dim, dim)) * 3 + self.phases[:dim])
            v[np.asarray(case.fixed_nodes, dtype=np.int64)] = 0.0
            return v

        name = f"{case.name}, variation {self.seed}"
        return replace(case, name=name, velocity=velocity, step_fraction=cast(float, self.step_fraction))


def _rotation(angles: FloatArray, dim: int) -> FloatArray:
    """Rotation matrix of a vector of angles; in the plane about the third axis only."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angles if dim == 3 else [0.0, 0.0, angles[2]]).as_matrix()


def run(report: Report, progress: bool | None = None) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for cell, degree, make in RUNS:
        if report.wants(cell, degree):
            for case in make(cell, degree):
                compare(report, case)
            for case in varied_runs(cell, degree, make):
                compare(report, case, VARIATION_STEPS[case.body.gdim, degree])


def varied_runs(cell: str, degree: int, make: "MakeRuns", seeds: Sequence[int] | None = None) -> Iterator[Run]:
    """Random variations of runs with contact.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        make: function of cell, degree and variation that makes runs.
        seeds: seeds of the variations; None takes those of the level.

    Yields:
        Varied runs.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    for seed in VARIATION_SEEDS[dim] if seeds is None else seeds:
        variation = RandomVariation(seed)
        yield from (variation.apply(case) for case in make(cell, degree, variation) if case.contact)


# --- bodies ----------------------------------------------------------------------------------------------------------


def _body(
    domain: Mesh,
    tags: MeshTags,
    degree: int,
    hypothesis: str,
    law: str = "linear_elastic",
    friction: float = 0.0,
    rigid: ObstaclePair | None = None,
    nu: float = 0.3,
) -> TwoBodies:
    material = operator.LAWS[law](1.0, nu, 1.0, hypothesis)
    strain = operator.stiffness_rule(domain, degree, hypothesis, law)
    rules: dict[str, TheirRule] | None = None
    if strain is not None:  # masses keep their default rule
        rules = {"stiffness": strain, "finite_strain": strain}
    return TwoBodies(domain, tags, degree, material, friction, rigid, law=law, rule=rules)


GAP = 0.002  # least distance between two bodies at the start [L]


def _is_upper(positions: FloatArray) -> BoolArray:
    """Nodes of the upper body, which is the slave, shape (num_nodes).

    The threshold is in the middle of the gap, because the height of the lower body's top is 1 only up to round-off,
    which depends on the processor.
    """
    return positions[:, -1] > 1.0 + 0.5 * GAP


def _open_gap(domain: Mesh, gap: float) -> BoolArray:
    """Lift the upper body, so that round-off does not decide which nodes are in contact; returns its nodes."""
    upper = _upper_nodes(domain)
    domain.geometry.x[upper, domain.geometry.dim - 1] += gap
    return upper


def _upper_nodes(domain: Mesh) -> BoolArray:
    """Nodes of the mesh that belong to the upper body, by the centres of the cells, shape (num_nodes)."""
    x, dofmap = domain.geometry.x, domain.geometry.dofmap
    upper = np.zeros(len(x), dtype=bool)
    upper[np.unique(dofmap[x[dofmap][:, :, domain.geometry.dim - 1].mean(axis=1) > 1.0])] = True
    return upper


def falling(down: float, along: float = 0.0) -> VelocityField:
    """Velocities of two bodies: the upper one falls and moves along the first axis.

    Args:
        down: downward velocity [L/T].
        along: velocity along the first axis [L/T].

    Returns:
        Function of the positions of the nodes.
    """

    def velocity(positions: FloatArray) -> FloatArray:
        v = np.zeros_like(positions)
        v[_is_upper(positions)] = [along] + [0.0] * (positions.shape[1] - 2) + [-down]
        return v

    return velocity


def bars(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """Two bars that meet end to end: one row of cells with nu = 0, and several rows with nu = 0.3.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for rows, nu, kind in ((1, 0.0, "penalty"), (1, 0.0, "kinematic"), (3, 0.3, "penalty"), (3, 0.3, "kinematic")):
        domain, tags = two_bodies(cell, (rows, 12), (rows, 9), start=(0.04,), length=(0.92,))  # no edges coincide
        _open_gap(domain, 0.003)
        variation.rotate_upper_body(domain)
        body = _body(domain, tags, degree, "plane_strain", nu=nu)
        yield Run(f"two bars, {rows} rows, {kind}", body, falling(0.02), kind)


def disc(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A disc that falls on a block at an angle, with friction: it starts to roll.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    methods: tuple[tuple[str, dict[str, Any]], ...]
    methods = (("penalty", {}), ("penalty", {"balanced": True}), ("kinematic", {}))
    for kind, options in methods:
        domain, tags = two_bodies(cell, (9, 4), (8, 8), start=(0.2,), length=(0.5,))
        x, upper = domain.geometry.x, _open_gap(domain, 0.0)
        a, b = (x[upper, 0] - 0.45) / 0.25, (x[upper, 1] - 1.25) / 0.25
        x[upper, 0] = 0.45 + 0.25 * a * np.sqrt(1 - b**2 / 2)
        x[upper, 1] = 1.252 + 0.25 * b * np.sqrt(1 - a**2 / 2)
        variation.rotate_upper_body(domain)
        body = _body(domain, tags, degree, "plane_strain", friction=0.3)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        name = f"disc on a block, {'balanced ' if options else ''}{kind}"
        yield Run(name, body, falling(0.03, 0.02), kind, options, fixed_nodes=low)


def blocks(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A block thrown on another one in space, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, law in (("penalty", "neo_hookean"), ("kinematic", "linear_elastic")):
        domain, tags = two_bodies(cell, (4, 3, 2), (3, 2, 2), start=(0.17, 0.13))
        x, upper = domain.geometry.x, _open_gap(domain, GAP)
        x[upper, 2] += 0.1 * ((x[upper, :2] - 0.5) ** 2).sum(axis=1)  # round below
        variation.rotate_upper_body(domain)
        body = _body(domain, tags, degree, "3d", law, friction=0.2)
        yield Run(f"block on a block, {law.replace('_', '-')}, {kind}", body, falling(0.05, 0.03), kind)


def smooth_hill(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A block thrown on a round one that turns, whose surface is smooth, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    lower, upper_cells = ((7, 3), (5, 3)) if dim == 2 else ((3, 3, 2), (2, 2, 2))

    def squared(x: FloatArray) -> FloatArray:
        """Squared distance from the vertical axis [L^2]."""
        return ((x[:, : dim - 1] - 0.5) ** 2).sum(axis=1)

    def top(x: FloatArray) -> FloatArray:
        return 1.0 - 0.5 * squared(x)

    def normals(x: FloatArray) -> FloatArray:
        return np.vstack([x[: dim - 1] - 0.5, np.ones((1, x.shape[1]))])

    def velocity(positions: FloatArray) -> FloatArray:
        v = falling(0.05, 0.03)(positions)
        turning, x = ~_is_upper(positions), positions - 0.5
        v[turning, 0], v[turning, dim - 1] = 0.1 * x[turning, dim - 1], -0.1 * x[turning, 0]
        return v

    methods: list[tuple[str, dict[str, Any]]]
    methods = [("penalty", {})] if dim == 2 else []
    for kind, options in (*methods, ("penalty", {"balanced": True}), ("kinematic", {})):
        domain, tags = two_bodies(cell, lower, upper_cells, start=(0.21, 0.17))
        x, upper = domain.geometry.x, _open_gap(domain, GAP)
        x[upper, dim - 1] += 0.2 * squared(x[upper])
        x[~upper, dim - 1] *= top(x[~upper])  # the top's normal is (x, y, 1), from the axis
        variation.rotate_upper_body(domain, top)
        body = _body(domain, tags, degree, "3d" if dim == 3 else "plane_strain", friction=0.3)
        name = f"body on a smooth hill, {'balanced ' if options else ''}{kind}"
        yield Run(name, body, velocity, kind, options, smooth=normals)


def overhang(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A block thrown over the edge of another one: some nodes pass beside the edge and return below the surface.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    for kind in ("penalty", "kinematic"):
        domain, tags = two_bodies(cell, (9, 4) if plane else (4, 4, 2), (5, 4) if plane else (3, 3, 2),
                                  start=(0.66,) * (1 if plane else 2), length=(0.6,) * (1 if plane else 2))  # fmt: skip
        _open_gap(domain, GAP)
        variation.rotate_upper_body(domain)
        body = _body(domain, tags, degree, "plane_strain" if plane else "3d", "neo_hookean", friction=0.2)
        yield Run(f"block over an end, {kind}", body, falling(0.1, -0.05), kind)


def coarse_slave(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A coarse ring on a finer one, with friction: slave nodes are much heavier than the master nodes they meet.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind in ("penalty", "kinematic"):
        domain, tags = two_bodies(cell, (14, 10), (3, 2), start=(0.11,), length=(0.75,))
        domain.geometry.x[:, 0] += 0.3
        _open_gap(domain, GAP)
        variation.rotate_upper_body(domain)
        body = _body(domain, tags, degree, "axisymmetric", friction=0.2)
        yield Run(f"coarse ring on a fine one, {kind}", body, falling(0.03, 0.01), kind)


def rigid(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Run]:
    """A body of revolution thrown on a rigid plane, and a block hit by a moving rigid cylinder.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain = distorted_block.block(cell, 5)
    domain.geometry.x[:, 0] += 0.2
    for kind in ("penalty", "kinematic"):
        point, normal = np.array([0.0, -0.01]), np.array([0.0, 1.0])
        plane = contact.RigidPlane(point, normal), impact_reference.RigidPlane(point, normal)
        body = _body(domain, _face_tags(domain, 0.0), degree, "axisymmetric", friction=0.0, rigid=plane)
        yield Run(f"ring on a rigid plane, {kind}", body, lambda x: np.tile([0.0, -0.05], (len(x), 1)), kind)
    domain = distorted_block.block(cell, 6)
    for kind in ("penalty", "kinematic"):
        center = np.array([0.47, 1.805])
        cylinder = contact.RigidCylinder(center, 0.8), impact_reference.RigidCylinder(center, 0.8)
        body = _body(domain, _face_tags(domain, 1.0), degree, "plane_strain", friction=0.3, rigid=cylinder)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        yield Run(
            f"block under a rigid cylinder that moves, {kind}", body, lambda x: np.zeros_like(x), kind, fixed_nodes=low,
            obstacle=lambda t: np.array([0.01 * t, -0.03 * np.sin(t / 4)]),
        )  # fmt: skip


def on_foundation(body: TwoBodies, stiffness: Any, damping: Any) -> tuple[Any, Any]:
    """Put the other side's model on springs and dashpots under the facets SLAVE.

    Args:
        body: both sides; its model is changed for good.
        stiffness: of Foundation [F/L^3].
        damping: of Foundation [F T/L^3].

    Returns:
        Stiffness and damping, for `Run.foundation`.
    """
    body.model.facet_rule = bodies.foundation_rule(body)
    body.model.add_foundation(body.their_facets(body.tags, SLAVE), stiffness, damping)
    return stiffness, damping


def _face_tags(domain: Mesh, height: float) -> MeshTags:
    """Facets of the horizontal face at a height, 0 or 1, are the slave; those of the other face are the bottom."""
    dim = domain.geometry.dim
    facets = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], height))
    other = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1.0 - height))
    both = np.concatenate([facets, other])
    order = np.argsort(both)
    values = np.repeat([SLAVE, BOTTOM], [len(facets), len(other)]).astype(np.int32)
    return mesh.meshtags(domain, dim - 1, both[order], values[order])


def without_contact(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Run]:
    """A body without contact: schemes, damping, viscosity, loads and prescribed motion.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    domain = distorted_block.block(cell, 4 if plane else 2)
    body = {law: _body(domain, _face_tags(domain, 0.0), degree, "plane_strain" if plane else "3d", law)
            for law in ("linear_elastic", "neo_hookean")}  # fmt: skip
    positions = body["linear_elastic"].V.tabulate_dof_coordinates()
    low = np.flatnonzero(np.isclose(positions[:, body["linear_elastic"].gdim - 1], 0.0))

    def shaken(x: FloatArray) -> FloatArray:
        v = np.zeros_like(x)
        v[:, 0] = 0.05 * x[:, -1]
        v[:, -1] = -0.1 * x[:, -1] ** 2
        v[low] = 0.0
        return v

    down = np.zeros(body["linear_elastic"].gdim)
    down[-1] = -0.1
    gravity = (down, lambda t: 1.0 - np.cos(2 * t))
    yield Run("shaken", body["linear_elastic"], shaken, fixed_nodes=low)
    yield Run("classical scheme, damped", body["linear_elastic"], shaken, fixed_nodes=low, damping=(0.2, 0.0),
              scheme="classical", gravity=gravity)  # fmt: skip
    for law in body:
        yield Run(
            f"damped, {law.replace('_', '-')}",
            body[law],
            shaken,
            fixed_nodes=low,
            damping=(0.1, 0.004),
            gravity=gravity,
        )
        yield Run(f"viscous, {law.replace('_', '-')}", body[law], shaken, viscosity=(0.06, 1.2), step_fraction=0.7)
    yield Run(
        "support that moves", body["linear_elastic"], shaken, fixed_nodes=low, motion=lambda t: 0.02 * np.sin(3 * t)
    )
    yield from founded(domain, degree, shaken, gravity)


def founded(domain: Mesh, degree: int, velocity: VelocityField, gravity: Any) -> Iterator[Run]:
    """A body that stands on springs and dashpots alone: along the normal, and along the coordinates.

    Args:
        domain: mesh of the body.
        degree: degree of the displacement, 1 or 2.
        velocity: initial velocity.
        gravity: as in Run.

    Yields:
        Runs.
    """
    hypothesis = "plane_strain" if domain.geometry.dim == 2 else "3d"
    along = np.array([0.3, 0.5, 0.4])[: domain.geometry.dim]
    rayleigh: dict[str, Any] = {"damping": (0.1, 0.004)}
    for law, stiffness, damping, more in (
        ("linear_elastic", 0.4, 0.0, {}),
        ("linear_elastic", along, 0.2, rayleigh),
        ("neo_hookean", 0.4, 0.1 * along, {}),
    ):
        body = _body(domain, _face_tags(domain, 0.0), degree, hypothesis, law)
        foundation = on_foundation(body, stiffness, damping)
        added = 0.7 if np.ndim(damping) else None
        if added is not None:
            body.model.add_mass(body.their_facets(body.tags, SLAVE), added)
        what = "normal springs" if np.ndim(stiffness) == 0 else "springs"
        if np.any(damping):
            what += " and dashpots"
        name = f"body on {what}{', with mass' if added else ''}, {law.replace('_', '-')}"
        yield Run(name, body, velocity, gravity=gravity, foundation=foundation, added_mass=added, **more)


MakeRuns: TypeAlias = Callable[..., Iterator[Run]]  # of cell, degree and variation
RUNS: tuple[tuple[str, int, MakeRuns], ...] = (
    ("quadrilateral", 1, bars),
    ("triangle", 1, bars),
    ("quadrilateral", 2, bars),
    ("quadrilateral", 1, disc),
    ("hexahedron", 1, blocks),
    ("tetrahedron", 1, blocks),
    ("quadrilateral", 1, smooth_hill),
    ("triangle", 1, smooth_hill),
    ("hexahedron", 1, smooth_hill),
    ("tetrahedron", 1, smooth_hill),
    ("quadrilateral", 1, overhang),
    ("hexahedron", 1, overhang),
    ("tetrahedron", 2, overhang),
    ("quadrilateral", 1, coarse_slave),
    ("triangle", 2, coarse_slave),
    ("quadrilateral", 1, rigid),
    ("quadrilateral", 1, without_contact),
    ("triangle", 2, without_contact),
    ("hexahedron", 1, without_contact),
    ("tetrahedron", 2, without_contact),
)


# --- both sides ------------------------------------------------------------------------------------------------------


def loads_of(case: Run) -> list[Load]:
    """Loads of a run on our side.

    Args:
        case: run.
    """
    loads: list[Load] = [] if case.gravity is None else [BodyForce(case.gravity[0], amplitude=case.gravity[1])]
    if case.added_mass is not None:
        loads.append(AddedMass(case.body.tags, SLAVE, case.added_mass))
    return loads if case.foundation is None else [*loads, Foundation(case.body.tags, SLAVE, *case.foundation)]


def ours(case: Run, steps: int) -> tuple[ExplicitProblem, float, tuple[FloatArray, FloatArray]]:
    """Make a run on our side.

    Args:
        case: run.
        steps: number of steps.

    Returns:
        Problem, time step [T], and displacements [L] and velocities [L/T] of all time levels, shape
        (num_levels, num_dofs) each.
    """
    body = case.body
    V, u = body.V, fem.Function(body.V, name="u")
    v = fem.Function(V)
    v.x.array[:] = case.velocity(V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    bcs: list[fem.DirichletBC | PrescribedMotion] = []
    if len(case.fixed_nodes):
        nodes = np.asarray(case.fixed_nodes, dtype=np.int32)
        if case.motion is None:
            bcs = [fem.dirichletbc(np.zeros(body.gdim), nodes, V)]
        else:
            bcs = [PrescribedMotion(fem.dirichletbc(np.eye(body.gdim)[-1], nodes, V), case.motion)]
    contacts = []
    if case.contact:
        kind = contact.Penalty if case.contact == "penalty" else contact.Kinematic
        if body.rigid:
            motion = case.obstacle
            body.rigid[0].motion = None if motion is None else lambda t: np.pad(motion(t), (0, 3 - body.gdim))
        contacts = [kind(body.pair(everywhere=False, smooth=case.smooth or False), **case.options)]
    problem = ExplicitProblem(
        u, cast(_Material, body.material), velocity=v, bcs=bcs, loads=loads_of(case), contact=contacts,
        scheme=case.scheme, damping=materials.Rayleigh(*case.damping), bulk_viscosity=case.viscosity,
    )  # fmt: skip
    dt = case.step_fraction * problem.stable_step()
    states: list[tuple[FloatArray, FloatArray]] = []  # the first call of the callback has the initial state
    with warnings.catch_warnings():
        # Both sides have the same springs: that they are soft does not matter here, nor that nodes which return below
        # the surface beside which they have passed find them under load and gain energy.
        warnings.filterwarnings("ignore", "under load .* is penetration")
        warnings.filterwarnings("ignore", "the run gains energy")
        problem.advance(
            steps * dt, dt=dt, progress=False,
            callback=lambda p: states.append((p.u.x.array.copy(), p.velocity.x.array.copy())),
        )  # fmt: skip
    u_levels, v_levels = (np.array(s) for s in zip(*states))
    return problem, dt, (u_levels, v_levels)


def theirs(case: Run, dt: float, steps: int) -> ExplicitResult:
    """Make a run on the other side.

    Args:
        case: run.
        dt: time step [T].
        steps: number of steps.

    Returns:
        States, energies and contact histories.
    """
    body = case.body
    v0 = np.empty(len(body.order))
    v0[body.order] = case.velocity(body.V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    fixed_dofs = (np.asarray(case.fixed_nodes, dtype=int)[:, None] * body.gdim + np.arange(body.gdim)).ravel()
    values: TimeValues = 0.0
    motion = case.motion
    if motion is not None:
        along_last_axis = (fixed_dofs % body.gdim == body.gdim - 1).astype(float)
        values = lambda t: along_last_axis * motion(t)  # noqa: E731
    loads = None
    if case.gravity is not None:
        loads = [(body.model.body_force(np.asarray(case.gravity[0])), case.gravity[1])]
    contacts = []
    if case.contact:
        kind = impact_reference.NodalPenalty if case.contact == "penalty" else impact_reference.NodalKinematic
        slave = body.their_facets(body.tags, SLAVE)
        options = dict(case.options)
        if body.rigid:
            master: Any = body.rigid[1]
            options["motion"] = case.obstacle
        else:
            master = body.their_facets(body.tags, MASTER)
        if case.smooth is not None:
            x = body.mesh.geometry.x[master]
            normals = case.smooth(x.reshape(-1, 3).T[: body.gdim]).T
            options["master_normals"] = normals.reshape(*master.shape, body.gdim)
        contacts = [kind(slave, master, body.friction, **options)]
    return body.model.run_explicit(
        dt, steps, v0=v0, fixed_dofs=body.order[fixed_dofs], values=values, loads=loads, alpha=case.damping[0],
        beta=case.damping[1], scheme=case.scheme, viscosity=case.viscosity, contacts=contacts,
    )  # fmt: skip


def compare(report: Report, case: Run, steps: int = STEPS) -> None:
    """Add the rows of one run: displacements, velocities, contact forces and energies of all time levels.

    Args:
        report: report to add to.
        case: run.
        steps: number of steps.
    """
    body = case.body
    problem, dt, (u, v) = ours(case, steps)
    other = theirs(case, dt, steps)
    pairs: dict[str, tuple[FloatArray, FloatArray]] = {"displacement": (u, other.u[:, body.order])}
    if case.contact != "kinematic":  # its forces, and with them this velocity, are known one step later
        pairs["velocity"] = (v, other.v[:, body.order])
    energies = dict(zip(ENERGIES, problem.energy_history[:, 1:].T))
    for name, values in energies.items():
        their_values = other.energies[name][:steps]
        if np.any(their_values) or np.any(values):
            pairs[f"{name} energy"] = (np.asarray(values), their_values)
    if case.contact:
        total = other.contacts[0].total[:steps]
        pairs["contact force"] = (problem.force_history[0], total)
    size = max(np.abs(other.energies["kinetic"]).max(), np.abs(other.energies["internal"]).max())
    for what, (a, b) in pairs.items():
        scale = size if what.endswith("energy") else np.abs(b).max()
        add(report, case, what, np.asarray(a), np.asarray(b), scale)


def add(report: Report, case: Run, what: str, a: FloatArray, b: FloatArray, scale: float) -> None:
    """Add one row: the largest difference over a scale.

    Args:
        report: report to add to.
        case: run.
        what: quantity that is compared.
        a: our values, shape (num_levels, ...).
        b: values of the other side, shape (num_levels, ...).
        scale: largest entry of b; for energies the largest energy of the run.
    """
    body = case.body
    difference: float
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
