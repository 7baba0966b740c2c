# SPDX-License-Identifier: MIT
"""Wheels that roll, on both sides: meshes, supports and flows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import basix.ufl
import impact_reference
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh, MeshTags
from impact_reference.rolling import Motion
from mpi4py import MPI

from dolfinx_impact import compat, contact
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.forms import quadrature
from dolfinx_impact.materials import _Material
from dolfinx_impact.rolling.motions import Spin, Translation
from dolfinx_impact.rolling.rolling_problem import RollingProblem
from . import operator
from .contact_bodies import MASTER, SLAVE, ObstaclePair, TwoBodies, grid_of_box, rule
from .nodes import TheirRule

WHEEL, RAIL = 1, 2
VIOLATION = 1e-12  # at which our side stops, of contact and friction; of tractions it is 1e-10, below what rows allow
HUB = 0.3  # radius [L]
TURN = 0.013  # of the mesh about the axis, so that no tie is decided by round-off [1]
OMEGA = 0.15  # [1/T]


def _disc(cell: str, n: int, layers: int) -> tuple[FloatArray, IntArray]:
    """A disc of radius 1, or a cylinder about the y axis of width 0.4, from a square: lines of constant maximum norm
    become circles."""
    counts = (n, layers, n) if layers else (n, n)
    low, high = (np.array([-1.0, 0.0, -1.0]), np.array([1.0, 0.4, 1.0])) if layers else (-np.ones(2), np.ones(2))
    points, cells = grid_of_box(cell, low, high, counts, 1)
    x = points[:, [0, -1]]
    longest, length = np.abs(x).max(axis=1), np.linalg.norm(x, axis=1)
    x = x * np.divide(longest, length, out=np.ones_like(length), where=length > 0)[:, None]
    c, s = np.cos(TURN), np.sin(TURN)
    points = points.copy()
    points[:, [0, -1]] = x @ np.array([[c, -s], [s, c]])
    return points, cells


def wheel(cell: str, n: int, layers: int = 0, rail: Sequence[int] = ()) -> tuple[Mesh, MeshTags, MeshTags]:
    """Mesh of a wheel with the axis z (plane) or y (space), above a rail or alone.

    Args:
        cell: cell of the mesh.
        n: cells across the wheel.
        layers: cells along the axis; 0 in the plane.
        rail: cells of the rail along each axis; none: no rail.

    Returns:
        Mesh on this rank, tags of its cells (WHEEL, RAIL) and of its facets (SLAVE: lower part of the tread, MASTER:
        upper face of the rail).
    """
    points, cells = _disc(cell, n, layers)
    dim = points.shape[1]
    if rail:
        low, high = np.array([-0.83, -0.2, -1.7]), np.array([0.8, 0.7, -1.001])
        keep = [0, 2] if dim == 2 else [0, 1, 2]
        under, more = grid_of_box(cell, low[keep], high[keep], rail, 1)
        points, cells = np.vstack([points, under]), np.vstack([cells, more + len(points)])
    element = basix.ufl.element("Lagrange", cell, 1, shape=(dim,))
    domain = mesh.create_mesh(MPI.COMM_SELF, np.asarray(cells, dtype=np.int64), x=points, e=ufl.Mesh(element))
    middle = domain.geometry.x[compat.geometry_dofmap(domain)].mean(axis=1)
    body = np.where(middle[:, dim - 1] > -1.0, WHEEL, RAIL).astype(np.int32)
    cell_tags = mesh.meshtags(domain, dim, np.arange(len(body), dtype=np.int32), body)

    def tread(x: FloatArray) -> Any:
        return (np.hypot(x[0], x[dim - 1]) > 0.999) & (x[dim - 1] < -0.8) & (x[dim - 1] > -1.0005)

    facets = mesh.locate_entities_boundary(domain, dim - 1, tread)
    top = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], -1.001))
    every, tags = np.concatenate([facets, top]), np.repeat([SLAVE, MASTER], [len(facets), len(top)])
    order = np.argsort(every)
    return domain, cell_tags, mesh.meshtags(domain, dim - 1, every[order], tags[order].astype(np.int32))


def their_rules(domain: Mesh, hypothesis: str, law: str) -> dict[str, TheirRule]:
    """Rules of the other side for stiffness and inertia; on simplices both sides integrate inertia exactly.

    Args:
        domain: mesh.
        hypothesis: hypothesis of the material.
        law: name of the law.

    Returns:
        Rules by purpose.
    """
    cell = domain.topology.cell_name()
    stiffness = operator.stiffness_rule(domain, 1, hypothesis, law)
    simplex = cell in quadrature.SIMPLICES
    mass = None if simplex else f"gauss_jacobi:{quadrature.mass_degree(cell, 1, 1, hypothesis)}"
    return {"stiffness": stiffness, "finite_strain": stiffness, "mass": mass}


@dataclass
class RollingCase:
    """A wheel on a rigid plane or on a rail, on both sides.

    Args:
        name: name in the rows.
        cell: cell.
        hypothesis: hypothesis of the material.
        n: cells across the wheel.
        layers: cells along the axis.
        rail: cells of the rail along each axis; none: a rigid plane.
        friction: Coulomb's friction coefficient [1].
        creeps: longitudinal and lateral creepage of each stage: the wheel's tread is faster by their share of omega
            times radius, and moves sideways by their share [1].
        depth: displacement of plane or hub into the contact [L].
        law: name of the law.
        density: density [M/L^3].
    """

    name: str
    cell: str
    hypothesis: str
    n: int
    layers: int = 0
    rail: Sequence[int] = ()
    friction: float = 0.0
    creeps: Sequence[tuple[float, float]] = ((0.0, 0.0),)
    depth: float = 0.012
    law: str = "linear_elastic"
    density: float = 1.0
    body: TwoBodies = field(init=False)
    cell_tags: MeshTags = field(init=False)

    def __post_init__(self) -> None:
        domain, self.cell_tags, facet_tags = wheel(self.cell, self.n, self.layers, self.rail)
        dim = domain.geometry.dim
        planes: ObstaclePair | None = None
        if not self.rail:
            point, up = -np.eye(dim)[-1], np.eye(dim)[-1]
            planes = contact.RigidPlane(point, up), impact_reference.RigidPlane(point, up)
        material = operator.LAWS[self.law](1.0, 0.3, self.density, self.hypothesis)
        rules = their_rules(domain, self.hypothesis, self.law)
        self.body = TwoBodies(domain, facet_tags, 1, material, self.friction, planes, law=self.law, rule=rules)

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.body.gdim

    @property
    def axis(self) -> FloatArray:
        """Axis about which the tread moves along x at the bottom, shape (3)."""
        return np.array([0.0, 0.0, 1.0]) if self.dim == 2 else np.array([0.0, -1.0, 0.0])

    def speed(self, stage: int) -> FloatArray:
        """Velocity of plane or rail in a stage.

        Args:
            stage: number of the stage.

        Returns:
            Velocity, shape (gdim) [L/T].
        """
        along, across = self.creeps[stage]
        velocity = np.zeros(self.dim)
        velocity[0] = OMEGA * (1.0 - along)
        if self.dim == 3:
            velocity[1] = -OMEGA * across
        return velocity

    def set_speed(self, stage: int, motions: list[Any]) -> None:
        """Give rail or plane its place and velocity in a stage: the rail on our side, the plane's place on both.

        Args:
            stage: number of the stage.
            motions: motions of wheel and rail on our side.
        """
        if self.body.rigid is None:
            motions[1].velocity = self.speed(stage)
            return
        ours, theirs = self.body.rigid
        ours.displacement = theirs.displacement = self.depth * np.eye(self.dim)[-1]
        ours.velocity = np.pad(self.speed(stage), (0, 3 - self.dim))

    def supports(self) -> tuple[list[fem.DirichletBC], IntArray, FloatArray]:
        """Hub, and lower face of the rail.

        Returns:
            Boundary conditions of our side; and our prescribed degrees of freedom with their values, for the other.
        """
        V, dim = self.body.V, self.dim
        x = V.tabulate_dof_coordinates()
        hub = np.flatnonzero(np.hypot(x[:, 0], x[:, dim - 1]) < HUB).astype(np.int32)
        down = np.zeros(dim)
        if self.rail:
            down[-1] = -self.depth
        bcs, values = [fem.dirichletbc(down, hub, V)], np.zeros((len(x), dim))
        values[hub] = down
        nodes = hub
        if self.rail:
            base = np.flatnonzero(x[:, dim - 1] < -1.699).astype(np.int32)
            bcs.append(fem.dirichletbc(np.zeros(dim), base, V))
            nodes = np.concatenate([hub, base])
        dofs: IntArray = (dim * nodes.astype(np.int64)[:, None] + np.arange(dim)).ravel()
        return bcs, dofs, values.ravel()[dofs]

    def ours(self, with_contact: bool = True) -> tuple[RollingProblem, list[Any]]:
        """Problem of our side.

        Args:
            with_contact: whether there is contact.

        Returns:
            Problem, with everything of the first stage, and the motions of wheel and rail.
        """
        body, motions = self.body, [Spin(np.zeros(self.dim), self.axis, OMEGA)]
        by_tag: dict[int, Any] = {WHEEL: motions[0]}
        if self.rail:
            by_tag[RAIL] = Translation(self.speed(0))
        contacts = [contact.Lagrange(body.pair(), quadrature_degree=7)] if with_contact else []
        body.u.x.array[:] = 0.0
        bcs, *_ = self.supports()
        problem = RollingProblem(
            body.u, cast(_Material, body.material), self.cell_tags, by_tag, contact=contacts, bcs=bcs,
            options={"contact_tolerance": VIOLATION} if contacts else None,
        )  # fmt: skip
        return problem, list(by_tag.values())

    def theirs(self, stage: int = 0) -> impact_reference.RollingModel:
        """Model of the other side.

        Args:
            stage: number of the stage.

        Returns:
            Rolling model.
        """
        motions: dict[int, Motion] = {WHEEL: impact_reference.Spinning(np.zeros(self.dim), OMEGA, self.axis)}
        if self.rail:
            motions[RAIL] = impact_reference.Translating(self.speed(stage))
        return impact_reference.RollingModel(self.body.model, motions, self.cell_tags.values)

    def their_contact(self) -> impact_reference.Contact:
        """Contact of the other side.

        Returns:
            Contact with the same surfaces, rules and friction.
        """
        body = self.body
        return body.theirs(rule(body.facet, 4) if body.rigid else rule(body.segment, 7))
