# SPDX-License-Identifier: MIT
"""Implicit scenarios of the level history: Newmark's family of schemes, penalty and multipliers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.own_forms import distorted_block
from ..contact_bodies import two_bodies
from .explicit_runs import founded
from .placed_bodies import (
    at_rest,
    block_under_body,
    block_under_cam,
    block_under_cylinder,
    body_of,
    cam_angle,
    cam_angle_in_plane,
    cylinder_motion,
    disc_on_block,
    falling,
    nodes_at_bottom,
    open_gap,
    pulsating_gravity,
    ring_mesh,
    ring_on_plane,
    round_block_on_block,
    shaken,
    standing_block,
    thrown_down,
)
from .scenario import Accuracy, Implicit, MakeScenarios, Scenario
from .variation import RandomVariation

# Seeds and steps of the variations of runs of two bodies, by dimension.
VARIATION_SEEDS = {2: (1, 2), 3: (1,)}
VARIATION_STEPS = {2: 100, 3: 60}


def varied_runs(cell: str, degree: int, make: MakeScenarios, seeds: Sequence[int] | None = None) -> Iterator[Scenario]:
    """Random variations of runs of two bodies.

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
            if case.contact and not case.body.rigid:
                yield replace(variation.apply(case), steps=VARIATION_STEPS[dim])


def swinging(positions: FloatArray) -> FloatArray:
    """Velocities of a rigid body that turns about the origin in the plane of the first and the last axis.

    Args:
        positions: places of nodes, shape (num_nodes, gdim) [L].
    """
    v = np.zeros_like(positions)
    v[:, 0], v[:, -1] = 0.3 * positions[:, -1], -0.3 * positions[:, 0]
    return v


def without_contact(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A clamped body: schemes, masses, damping, loads, a support that moves; one hinged at a corner, which swings.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain, body = standing_block(cell, degree)
    linear, large = body["linear_elastic"], body["neo_hookean"]
    low = nodes_at_bottom(linear)
    corner = np.flatnonzero(np.all(np.isclose(linear.V.tabulate_dof_coordinates(), 0.0), axis=1))
    gravity = pulsating_gravity(linear.gdim)
    clamped: dict[str, Any] = {"fixed_nodes": low}
    loaded: dict[str, Any] = {**clamped, "gravity": gravity}
    damped: dict[str, Any] = {**loaded, "damping": (0.1, 0.004)}
    hht = {"hht": -0.1}
    yield Scenario("shaken block", linear, shaken, Implicit(), **clamped)
    yield Scenario("damped block under a load, generalised-alpha", linear, shaken, Implicit({"rho_inf": 0.6}), **damped)
    for k, case in enumerate(founded(domain, degree, shaken, gravity)):
        yield replace(case, name=f"{case.name}, HHT" if k else case.name, scheme=Implicit(hht if k else {}))
    yield Scenario("hinged block that swings, neo-Hookean", large, swinging, Implicit({"rho_inf": 0.8}),
                   fixed_nodes=corner)  # fmt: skip
    if domain.geometry.dim == 3:
        return
    by_error = Implicit({"rho_inf": 0.7}, dt=0.06, error=1e-4)
    yield Scenario("block under a load, steps by their error", large, shaken, by_error, **loaded)
    yield Scenario("shaken block, HHT, lumped", linear, shaken, Implicit(hht, lumping="auto"), **clamped)
    yield Scenario(
        "support that moves, first order", linear, shaken, Implicit({"beta": 0.3025, "gamma": 0.6}), **clamped,
        motion=lambda t: 0.02 * np.sin(3 * t),
    )  # fmt: skip
    yield Scenario("damped block under a load, neo-Hookean, lumped", large, shaken, Implicit(lumping="auto"), **damped)


def bars(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """Two bars that meet end to end.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, impact in (("penalty", "mass_redistribution"), ("penalty", "none"), ("lagrange", "mass_redistribution")):
        domain, tags = two_bodies(cell, (2, 8), (2, 5), start=(0.04,), length=(0.92,))  # no edges coincide
        open_gap(domain, 0.003)
        variation.rotate_upper_body(domain)
        body = body_of(domain, tags, degree, "plane_strain")
        name = f"two bars, {kind}{'' if impact != 'none' else ', masses kept'}"
        yield Scenario(name, body, falling(0.02), Implicit({"rho_inf": 0.8}, impact=impact), kind)


def adjusted(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """Two bars that meet by the layer between them.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    domain, tags = two_bodies(cell, (2, 8), (2, 5), start=(0.04,), length=(0.92,))
    open_gap(domain, 0.013)
    variation.rotate_upper_body(domain)
    body = body_of(domain, tags, degree, "plane_strain")
    body.adjustment = {"offset": 0.01}
    yield Scenario("two bars with a layer, penalty", body, falling(0.02), Implicit({"rho_inf": 0.8}), "penalty")


def disc(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """A disc that falls on a block at an angle, with friction: it starts to roll.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, lumping in (("penalty", None), ("lagrange", None), ("lagrange", "auto")):
        body = disc_on_block(cell, degree, 6, variation.rotate_upper_body)
        name = f"disc on a block, {kind}{', lumped' if lumping else ''}"
        scheme = Implicit({"rho_inf": 0.8}, lumping, dt=0.04)
        yield Scenario(name, body, falling(0.03, 0.02), scheme, kind, fixed_nodes=nodes_at_bottom(body))


def blocks(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """A block thrown on another one in space, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    methods = (("penalty", "neo_hookean"), ("lagrange", "linear_elastic"))
    for kind, law in methods if cell == "hexahedron" else methods[:1]:
        body = round_block_on_block(cell, degree, ((3, 2, 2), (2, 2, 2)), law, variation.rotate_upper_body)
        name = f"block on a block, {law.replace('_', '-')}, {kind}"
        yield Scenario(name, body, falling(0.05, 0.03), Implicit({"rho_inf": 0.7}), kind)


def rigid(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A body of revolution thrown on a rigid plane, and a block hit by a moving rigid cylinder, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain = ring_mesh(cell)
    for kind in ("penalty", "lagrange"):
        body = ring_on_plane(domain, degree)
        yield Scenario(f"ring on a rigid plane, {kind}", body, thrown_down, Implicit({"hht": -0.2}), kind)
    domain = distorted_block.block(cell, 6)
    for kind, friction in (("penalty", 0.3), ("lagrange", 0.3), ("lagrange", 0.0)):
        body = block_under_cylinder(domain, degree, friction)
        yield Scenario(
            f"block under a rigid cylinder that moves, {kind}{'' if friction else ', smooth'}", body, at_rest,
            Implicit({"rho_inf": 0.5}), kind, fixed_nodes=nodes_at_bottom(body), obstacle=cylinder_motion,
        )  # fmt: skip


RIGID = Accuracy(1e-7, "the rigid body's equilibrium, to 1e-8 of the forces in each of the steps")


def cam(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Scenario]:
    """A rigid cylinder, in space a ball, turns about a point beside its centre, as prescribed or moved by forces.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    domain = distorted_block.block(cell, 5 if plane else 2)
    body = block_under_cam(domain, degree, 0.3)
    low = nodes_at_bottom(body)
    for kind in ("penalty", "lagrange"):
        yield Scenario(
            f"block under a rigid cam, {kind}", body, at_rest, Implicit({"rho_inf": 0.7}, dt=0.2), kind,
            fixed_nodes=low, obstacle=lambda t: -0.02 * np.sin(t / 4) * np.eye(body.gdim)[-1],
            angle=cam_angle_in_plane if plane else cam_angle, steps=60 if kind == "penalty" else 20,
        )  # fmt: skip
    runs: list[tuple[str, float, dict[str, float]]] = [("penalty", 0.3, {"rho_inf": 0.8})]
    if plane:
        runs += [("penalty", 0.0, {}), ("lagrange", 0.3, {"rho_inf": 0.8})]
    for kind, friction, parameters in runs:
        body = block_under_body(domain, degree, friction)
        yield Scenario(
            f"block under a rigid body, {kind}{'' if friction else ', smooth'}", body, at_rest,
            Implicit(parameters, dt=0.1), kind, fixed_nodes=low, steps=20, agreement=RIGID,
        )  # fmt: skip


RUNS: tuple[tuple[str, int, MakeScenarios], ...] = (
    ("quadrilateral", 1, without_contact),
    ("triangle", 2, without_contact),
    ("hexahedron", 1, without_contact),
    ("tetrahedron", 2, without_contact),
    ("quadrilateral", 1, bars),
    ("quadrilateral", 1, adjusted),
    ("triangle", 1, bars),
    ("quadrilateral", 2, bars),
    ("quadrilateral", 1, disc),
    ("hexahedron", 1, blocks),
    ("tetrahedron", 1, blocks),
    ("quadrilateral", 1, rigid),
    ("quadrilateral", 1, cam),
    ("hexahedron", 1, cam),
)
