# SPDX-License-Identifier: MIT
"""Explicit scenarios of the level history, docs/explicit/scheme.md."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from dolfinx.mesh import Mesh

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.own_forms import distorted_block
from ..contact_bodies import SLAVE, two_bodies
from .general_runs import touching
from .placed_bodies import (
    GAP,
    at_rest,
    block_under_ball,
    block_under_cam,
    cam_angle,
    cam_angle_in_plane,
    block_under_cylinder,
    body_of,
    cylinder_motion,
    disc_on_block,
    face_tags,
    falling,
    is_upper,
    nodes_at_bottom,
    on_foundation,
    open_gap,
    pulsating_gravity,
    ring_mesh,
    ring_on_plane,
    round_block_on_block,
    shaken,
    standing_block,
    thrown_down,
)
from .scenario import Accuracy, Explicit, MakeScenarios, Scenario, VelocityField
from .variation import RandomVariation

# Seeds of the variations of every run with contact, by dimension (with some of them, nodes turn away from facets that
# they are about to touch). Steps by dimension and degree: enough for two impacts with a rotation between them.
VARIATION_SEEDS = {2: (1, 2, 3, 26), 3: (4, 5)}  # 26: a node turns away from the master between two searches
VARIATION_STEPS = {(2, 1): 250, (2, 2): 500, (3, 1): 120, (3, 2): 120}

# Of runs whose element forces are in float. A force of linear elasticity sees about 40 roundings of 6e-8 of the largest
# one, 2.4e-6; neo-Hooke's is of the deformation gradient, whose round-off is a part of one: 2.4e-6 over strains near
# 0.05. No more than the sum over all steps can come of it.
FLOAT_STEPS = 50
IN_FLOAT = {
    "linear_elastic": Accuracy(1.2e-4, "round-off of float, 40 times 6e-8 in a force, of 50 steps"),
    "neo_hookean": Accuracy(2.4e-3, "round-off of float over strains of 0.05, 40 times 6e-8 in a force, of 50 steps"),
}


def varied_runs(cell: str, degree: int, make: MakeScenarios, seeds: Sequence[int] | None = None) -> Iterator[Scenario]:
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
        for case in make(cell, degree, variation):
            if case.contact:
                yield replace(variation.apply(case), steps=VARIATION_STEPS[dim, degree])


def bars(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
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
        open_gap(domain, 0.003)
        variation.rotate_upper_body(domain)
        body = body_of(domain, tags, degree, "plane_strain", nu=nu)
        yield Scenario(f"two bars, {rows} rows, {kind}", body, falling(0.02), contact=kind)


def disc(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
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
        body = disc_on_block(cell, degree, 8, variation.rotate_upper_body)
        name = f"disc on a block, {'balanced ' if options else ''}{kind}"
        yield Scenario(
            name, body, falling(0.03, 0.02), contact=kind, options=options, fixed_nodes=nodes_at_bottom(body)
        )


def adjusted(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """Bodies whose gaps are not the distances of their meshes: bars with a layer between them, and a disc on a block
    whose nodes have all the same gap at the start.

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
        balanced = "balanced " if options else ""
        domain, tags = two_bodies(cell, (3, 12), (3, 9), start=(0.04,), length=(0.92,))
        open_gap(domain, 0.013)
        variation.rotate_upper_body(domain)
        body = body_of(domain, tags, degree, "plane_strain", nu=0.3)
        body.adjustment = {"offset": 0.01}
        yield Scenario(f"two bars with a layer, {balanced}{kind}", body, falling(0.02), contact=kind, options=options)
        disc = disc_on_block(cell, degree, 8, variation.rotate_upper_body)
        disc.adjustment = {"clearance": 0.005}
        yield Scenario(
            f"disc with a clearance, {balanced}{kind}", disc, falling(0.03, 0.02), contact=kind, options=options,
            fixed_nodes=nodes_at_bottom(disc),
        )  # fmt: skip


def blocks(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """A block thrown on another one in space, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, law in (("penalty", "neo_hookean"), ("kinematic", "linear_elastic")):
        body = round_block_on_block(cell, degree, ((4, 3, 2), (3, 2, 2)), law, variation.rotate_upper_body)
        name = f"block on a block, {law.replace('_', '-')}, {kind}"
        yield Scenario(name, body, falling(0.05, 0.03), contact=kind)


def smooth_hill(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
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
        turning, x = ~is_upper(positions), positions - 0.5
        v[turning, 0], v[turning, dim - 1] = 0.1 * x[turning, dim - 1], -0.1 * x[turning, 0]
        return v

    methods: list[tuple[str, dict[str, Any]]]
    methods = [("penalty", {})] if dim == 2 else []
    for kind, options in (*methods, ("penalty", {"balanced": True}), ("kinematic", {})):
        domain, tags = two_bodies(cell, lower, upper_cells, start=(0.21, 0.17))
        x, upper = domain.geometry.x, open_gap(domain, GAP)
        x[upper, dim - 1] += 0.2 * squared(x[upper])
        x[~upper, dim - 1] *= top(x[~upper])  # the top's normal is (x, y, 1), from the axis
        variation.rotate_upper_body(domain, top)
        body = body_of(domain, tags, degree, "3d" if dim == 3 else "plane_strain", friction=0.3)
        name = f"body on a smooth hill, {'balanced ' if options else ''}{kind}"
        yield Scenario(name, body, velocity, contact=kind, options=options, smooth=normals)


def overhang(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
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
        open_gap(domain, GAP)
        variation.rotate_upper_body(domain)
        body = body_of(domain, tags, degree, "plane_strain" if plane else "3d", "neo_hookean", friction=0.2)
        yield Scenario(f"block over an end, {kind}", body, falling(0.1, -0.05), contact=kind)


def coarse_slave(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
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
        open_gap(domain, GAP)
        variation.rotate_upper_body(domain)
        body = body_of(domain, tags, degree, "axisymmetric", friction=0.2)
        yield Scenario(f"coarse ring on a fine one, {kind}", body, falling(0.03, 0.01), contact=kind)


def rigid(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A body of revolution thrown on a rigid plane, and a block hit by a moving rigid cylinder.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain = ring_mesh(cell)
    for kind in ("penalty", "kinematic"):
        body = ring_on_plane(domain, degree)
        yield Scenario(f"ring on a rigid plane, {kind}", body, thrown_down, contact=kind)
    domain = distorted_block.block(cell, 6)
    for kind in ("penalty", "kinematic"):
        body = block_under_cylinder(domain, degree, 0.3)
        yield Scenario(
            f"block under a rigid cylinder that moves, {kind}", body, at_rest, contact=kind,
            fixed_nodes=nodes_at_bottom(body), obstacle=cylinder_motion,
        )  # fmt: skip


def rigid_ball(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A rigid ball that forces move falls on a block, with spin, weight and friction; in the plane a disc.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    body = block_under_ball(distorted_block.block(cell, 6 if cell in ("triangle", "quadrilateral") else 3), degree, 0.3)
    for options in ({}, {"penalty": 2.0}):
        name = f"block under a rigid ball{', given penalty' if options else ''}"
        yield Scenario(name, body, at_rest, contact="penalty", options=options, fixed_nodes=nodes_at_bottom(body))


def cam(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A rigid cylinder, in space a ball, that turns about a point beside its centre presses on a block and rubs it.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    body = block_under_cam(distorted_block.block(cell, 6 if plane else 3), degree, 0.3)
    yield Scenario(
        "block under a rigid cam, penalty", body, at_rest, contact="penalty", fixed_nodes=nodes_at_bottom(body),
        obstacle=lambda t: -0.03 * np.sin(t / 4) * np.eye(body.gdim)[-1],
        angle=cam_angle_in_plane if plane else cam_angle, steps=250 if plane else 60,
    )  # fmt: skip


def without_contact(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A body without contact: schemes, damping, viscosity, loads and prescribed motion.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain, body = standing_block(cell, degree)
    linear, low = body["linear_elastic"], nodes_at_bottom(body["linear_elastic"])

    def clamped(x: FloatArray) -> FloatArray:
        v = shaken(x)
        v[low] = 0.0
        return v

    gravity = pulsating_gravity(linear.gdim)
    viscous = Explicit(viscosity=(0.06, 1.2))
    yield Scenario("shaken", linear, clamped, fixed_nodes=low)
    yield Scenario("classical scheme, damped", linear, clamped, Explicit("classical"), fixed_nodes=low,
                   damping=(0.2, 0.0), gravity=gravity)  # fmt: skip
    for law in body:
        name = law.replace("_", "-")
        yield Scenario(f"damped, {name}", body[law], clamped, fixed_nodes=low, damping=(0.1, 0.004), gravity=gravity)
        yield Scenario(f"viscous, {name}", body[law], clamped, viscous, step_fraction=0.7)
        if linear.gdim == 3 and linear.geometry_degree == 1:
            yield Scenario(f"mixed precision, {name}", body[law], clamped, Explicit(precision="mixed"),
                           fixed_nodes=low, steps=FLOAT_STEPS, agreement=IN_FLOAT[law])  # fmt: skip
    yield Scenario("support that moves", linear, clamped, fixed_nodes=low, motion=lambda t: 0.02 * np.sin(3 * t))
    yield from founded(domain, degree, clamped, gravity)


def founded(domain: Mesh, degree: int, velocity: VelocityField, gravity: Any) -> Iterator[Scenario]:
    """A body that stands on springs and dashpots alone: along the normal, and along the coordinates.

    Args:
        domain: mesh of the body.
        degree: degree of the displacement, 1 or 2.
        velocity: initial velocity.
        gravity: as in Scenario.

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
        body = body_of(domain, face_tags(domain, 0.0), degree, hypothesis, law)
        foundation = on_foundation(body, stiffness, damping)
        added = 0.7 if np.ndim(damping) else None
        if added is not None:
            body.model.add_mass(body.their_facets(body.tags, SLAVE), added)
        what = "normal springs" if np.ndim(stiffness) == 0 else "springs"
        if np.any(damping):
            what += " and dashpots"
        name = f"body on {what}{', with mass' if added else ''}, {law.replace('_', '-')}"
        yield Scenario(name, body, velocity, gravity=gravity, foundation=foundation, added_mass=added, **more)


RUNS: tuple[tuple[str, int, MakeScenarios], ...] = (
    ("quadrilateral", 1, bars),
    ("triangle", 1, bars),
    ("quadrilateral", 2, bars),
    ("quadrilateral", 1, disc),
    ("quadrilateral", 1, adjusted),
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
    ("quadrilateral", 1, rigid_ball),
    ("hexahedron", 1, rigid_ball),
    ("quadrilateral", 1, cam),
    ("hexahedron", 1, cam),
    ("quadrilateral", 1, touching),
    ("triangle", 1, touching),
    ("hexahedron", 1, touching),
    ("tetrahedron", 1, touching),
    ("quadrilateral", 1, without_contact),
    ("triangle", 2, without_contact),
    ("hexahedron", 1, without_contact),
    ("tetrahedron", 2, without_contact),
)
