# SPDX-License-Identifier: MIT
"""Bodies of scenarios: one that stands or flies alone, one and a rigid obstacle, two that are about to meet."""

from collections.abc import Callable
from typing import Any

import impact_reference
import numpy as np
from dolfinx import mesh
from dolfinx.mesh import Mesh, MeshTags

from dolfinx_impact import compat, contact
from dolfinx_impact.common.types import BoolArray, FloatArray, IntArray
from dolfinx_impact.own_forms import distorted_block
from .. import matched_body, operator
from ..contact_bodies import BOTTOM, SLAVE, ObstaclePair, TwoBodies, two_bodies
from ..nodes import TheirRule
from .scenario import VelocityField


def body_of(
    domain: Mesh,
    tags: MeshTags,
    degree: int,
    hypothesis: str,
    law: str = "linear_elastic",
    friction: float = 0.0,
    rigid: ObstaclePair | None = None,
    nu: float = 0.3,
) -> TwoBodies:
    """Both sides of a mesh, with E = 1 and density 1.

    Args:
        domain: mesh on one rank.
        tags: tags of its facets.
        degree: degree of the displacement, 1 or 2.
        hypothesis: of the material.
        law: name of the law.
        friction: coefficient [1].
        rigid: our obstacle and the other side's; None: the lower body is the master.
        nu: Poisson's ratio [1].
    """
    material = operator.LAWS[law](1.0, nu, 1.0, hypothesis)
    strain = operator.stiffness_rule(domain, degree, hypothesis, law)
    rules: dict[str, TheirRule] | None = None
    if strain is not None:  # masses keep their default rule
        rules = {"stiffness": strain, "finite_strain": strain}
    return TwoBodies(domain, tags, degree, material, friction, rigid, law=law, rule=rules)


GAP = 0.002  # least distance between two bodies at the start [L]


def is_upper(positions: FloatArray) -> BoolArray:
    """Nodes of the upper body, which is the slave.

    The threshold is in the middle of the gap, because the height of the lower body's top is 1 only up to round-off,
    which depends on the processor.

    Args:
        positions: places of nodes, shape (num_nodes, gdim) [L].

    Returns:
        Mask, shape (num_nodes).
    """
    return positions[:, -1] > 1.0 + 0.5 * GAP


def open_gap(domain: Mesh, gap: float) -> BoolArray:
    """Lift the upper body, so that round-off does not decide which nodes are in contact.

    Args:
        domain: mesh of two bodies, which is changed.
        gap: how far it is lifted [L].

    Returns:
        Mask of its nodes, shape (num_nodes).
    """
    upper = upper_nodes(domain)
    domain.geometry.x[upper, domain.geometry.dim - 1] += gap
    return upper


def upper_nodes(domain: Mesh) -> BoolArray:
    """Nodes of the mesh that belong to the upper body, by the centres of the cells.

    Args:
        domain: mesh of two bodies.

    Returns:
        Mask, shape (num_nodes).
    """
    x, dofmap = domain.geometry.x, compat.geometry_dofmap(domain)
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
        v[is_upper(positions)] = [along] + [0.0] * (positions.shape[1] - 2) + [-down]
        return v

    return velocity


def on_foundation(body: TwoBodies, stiffness: Any, damping: Any) -> tuple[Any, Any]:
    """Put the other side's model on springs and dashpots under the facets SLAVE.

    Args:
        body: both sides; its model is changed for good.
        stiffness: of Foundation [F/L^3].
        damping: of Foundation [F T/L^3].

    Returns:
        Stiffness and damping, for `Scenario.foundation`.
    """
    body.model.facet_rule = matched_body.foundation_rule(body)
    body.model.add_foundation(body.their_facets(body.tags, SLAVE), stiffness, damping)
    return stiffness, damping


def face_tags(domain: Mesh, height: float) -> MeshTags:
    """Facets of the horizontal face at a height are the slave; those of the other face are the bottom.

    Args:
        domain: mesh of the unit square or cube.
        height: 0 or 1 [L].
    """
    dim = domain.geometry.dim
    facets = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], height))
    other = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1.0 - height))
    both = np.concatenate([facets, other])
    order = np.argsort(both)
    values = np.repeat([SLAVE, BOTTOM], [len(facets), len(other)]).astype(np.int32)
    return mesh.meshtags(domain, dim - 1, both[order], values[order])


def disc_on_block(cell: str, degree: int, cells: int, rotate: Callable[[Mesh], None]) -> TwoBodies:
    """A disc above a block, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        cells: cells across the disc.
        rotate: function that rotates the upper body of the mesh, RandomVariation.rotate_upper_body.
    """
    domain, tags = two_bodies(cell, (9, 4), (cells, cells), start=(0.2,), length=(0.5,))
    x, upper = domain.geometry.x, open_gap(domain, 0.0)
    a, b = (x[upper, 0] - 0.45) / 0.25, (x[upper, 1] - 1.25) / 0.25
    x[upper, 0] = 0.45 + 0.25 * a * np.sqrt(1 - b**2 / 2)
    x[upper, 1] = 1.252 + 0.25 * b * np.sqrt(1 - a**2 / 2)
    rotate(domain)
    return body_of(domain, tags, degree, "plane_strain", friction=0.3)


def round_block_on_block(
    cell: str,
    degree: int,
    cells: tuple[tuple[int, ...], tuple[int, ...]],
    law: str,
    rotate: Callable[[Mesh], None],
) -> TwoBodies:
    """A block that is round below, above another one in space, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        cells: cells along the sides of the lower and of the upper body.
        law: name of the law.
        rotate: function that rotates the upper body of the mesh, RandomVariation.rotate_upper_body.
    """
    domain, tags = two_bodies(cell, *cells, start=(0.17, 0.13))
    x, upper = domain.geometry.x, open_gap(domain, GAP)
    x[upper, 2] += 0.1 * ((x[upper, :2] - 0.5) ** 2).sum(axis=1)  # round below
    rotate(domain)
    return body_of(domain, tags, degree, "3d", law, friction=0.2)


def ring_mesh(cell: str) -> Mesh:
    """Mesh of a body of revolution.

    Args:
        cell: cell.
    """
    domain = distorted_block.block(cell, 5)
    domain.geometry.x[:, 0] += 0.2
    return domain


def ring_on_plane(domain: Mesh, degree: int) -> TwoBodies:
    """A body of revolution above a rigid plane.

    Args:
        domain: mesh of the body.
        degree: degree of the displacement, 1 or 2.
    """
    point, normal = np.array([0.0, -0.01]), np.array([0.0, 1.0])
    plane = contact.RigidPlane(point, normal), impact_reference.RigidPlane(point, normal)
    return body_of(domain, face_tags(domain, 0.0), degree, "axisymmetric", rigid=plane)


def block_under_cylinder(domain: Mesh, degree: int, friction: float) -> TwoBodies:
    """A block under a rigid cylinder.

    Args:
        domain: mesh of the block.
        degree: degree of the displacement, 1 or 2.
        friction: coefficient [1].
    """
    center = np.array([0.47, 1.805])
    cylinder = contact.RigidCylinder(center, 0.8), impact_reference.RigidCylinder(center, 0.8)
    return body_of(domain, face_tags(domain, 1.0), degree, "plane_strain", friction=friction, rigid=cylinder)


def block_under_ball(domain: Mesh, degree: int, friction: float) -> TwoBodies:
    """A block under a rigid ball, in the plane a disc, that falls on it with spin and weight.

    Args:
        domain: mesh of the block.
        degree: degree of the displacement, 1 or 2.
        friction: coefficient [1].
    """
    dim, radius, mass = domain.geometry.dim, 0.8, 2.0
    inertia = mass * radius**2 * (0.4 if dim == 3 else 0.5)
    center = np.array([0.47, 0.44, 1.803] if dim == 3 else [0.47, 1.803])
    velocity, force = np.zeros(dim), np.zeros(dim)
    velocity[0], velocity[-1], force[-1] = 0.02, -0.04, -0.002
    spin = np.array([0.02, -0.03, 0.01]) if dim == 3 else np.array([0.0, 0.0, -0.03])
    round_body = contact.RigidSphere if dim == 3 else contact.RigidCylinder
    ours = contact.RigidBody(
        round_body(center, radius), mass=mass, inertia=inertia, velocity=velocity, spin=spin, force=force
    )
    ball: Any = ours, impact_reference.RigidBall(center, radius, mass, inertia, velocity, spin, force)
    hypothesis = "3d" if dim == 3 else "plane_strain"
    return body_of(domain, face_tags(domain, 1.0), degree, hypothesis, friction=friction, rigid=ball)


def block_under_cam(domain: Mesh, degree: int, friction: float) -> TwoBodies:
    """A block under a rigid cylinder, in space a ball, that turns about a point beside its centre.

    Args:
        domain: mesh of the block.
        degree: degree of the displacement, 1 or 2.
        friction: coefficient [1].
    """
    dim, radius = domain.geometry.dim, 0.8
    center = np.array([0.47, 0.44, 1.803] if dim == 3 else [0.47, 1.803])
    pivot = center + np.array([0.05, -0.07, 0.02] if dim == 3 else [0.05, 0.02])
    round_body = ("RigidSphere", "RigidCylinder")[3 - dim]
    ours, theirs = (getattr(module, round_body)(center, radius) for module in (contact, impact_reference))
    ours.pivot = theirs.pivot = pivot
    hypothesis = "3d" if dim == 3 else "plane_strain"
    return body_of(domain, face_tags(domain, 1.0), degree, hypothesis, friction=friction, rigid=(ours, theirs))


def cam_angle(t: float) -> FloatArray:
    """Rotation vector of a cam in space, (3) [1].

    Args:
        t: time [T].
    """
    return np.array([0.02 * np.sin(t / 3), 0.05 * np.sin(t / 4), -0.03 * np.sin(t / 5)])


def cam_angle_in_plane(t: float) -> FloatArray:
    """Rotation vector of a cam in the plane, (3) [1].

    Args:
        t: time [T].
    """
    return np.array([0.0, 0.0, 0.06 * np.sin(t / 4)])


def block_under_body(domain: Mesh, degree: int, friction: float) -> TwoBodies:
    """A block under a rigid cylinder, in space a ball, whose centre of mass is beside its own; it falls with spin under
    its weight and a torque.

    Args:
        domain: mesh of the block.
        degree: degree of the displacement, 1 or 2.
        friction: coefficient [1].
    """
    body = block_under_cam(domain, degree, friction)
    assert body.rigid is not None
    dim, shape, obstacle = body.gdim, *body.rigid
    velocity, force, torque, spin = np.zeros(dim), np.zeros(dim), np.zeros(3), np.array([0.0, 0.0, -0.03])
    velocity[0], velocity[-1], force[-1], torque[2] = 0.02, -0.04, -0.002, 0.0005
    inertia = np.diag([0.5, 0.7, 0.6])
    if dim == 3:
        spin[:2] = 0.02, -0.04
        inertia[0, 1] = inertia[1, 0] = 0.05
    moved: dict[str, Any] = {"mass": 2.0, "inertia": inertia, "velocity": velocity, "spin": spin, "force": force}
    ours = contact.RigidBody(shape, centre=shape.pivot, torque=torque, **moved)
    both: Any = ours, obstacle
    body.rigid = both
    body.moving = impact_reference.RigidBody(obstacle, torque=torque, **moved)
    return body


def cylinder_motion(t: float) -> FloatArray:
    """Displacement of the cylinder, (2) [L].

    Args:
        t: time [T].
    """
    return np.array([0.01 * t, -0.03 * np.sin(t / 4)])


def nodes_at_bottom(body: TwoBodies) -> IntArray:
    """Our nodes whose last coordinate is zero, (n).

    Args:
        body: bodies of both sides.
    """
    return np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, body.gdim - 1], 0.0))


def at_rest(positions: FloatArray) -> FloatArray:
    """No velocity.

    Args:
        positions: places of nodes, shape (num_nodes, gdim) [L].
    """
    return np.zeros_like(positions)


def shaken(positions: FloatArray) -> FloatArray:
    """Velocities that grow with the height, (num_nodes, gdim) [L/T].

    Args:
        positions: places of nodes, shape (num_nodes, gdim) [L].
    """
    v = np.zeros_like(positions)
    v[:, 0] = 0.05 * positions[:, -1]
    v[:, -1] = -0.1 * positions[:, -1] ** 2
    return v


def pulsating_gravity(gdim: int) -> Any:
    """Acceleration along the last axis, and its amplitude over time: for `Scenario.gravity`.

    Args:
        gdim: dimension.
    """
    down = np.zeros(gdim)
    down[-1] = -0.1
    return down, lambda t: 1.0 - np.cos(2 * t)


def thrown_down(positions: FloatArray) -> FloatArray:
    """Velocity of a body in the plane that falls, (num_nodes, 2) [L/T].

    Args:
        positions: places of nodes, shape (num_nodes, 2) [L].
    """
    return np.tile([0.0, -0.05], (len(positions), 1))


def standing_block(cell: str, degree: int) -> tuple[Mesh, dict[str, TwoBodies]]:
    """A block that stands alone, of two materials.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.

    Returns:
        Its mesh, and both sides by the name of the law.
    """
    plane = cell in ("triangle", "quadrilateral")
    domain = distorted_block.block(cell, 4 if plane else 2)
    tags, hypothesis = face_tags(domain, 0.0), "plane_strain" if plane else "3d"
    laws = ("linear_elastic", "neo_hookean")
    return domain, {law: body_of(domain, tags, degree, hypothesis, law) for law in laws}
