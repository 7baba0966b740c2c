# SPDX-License-Identifier: MIT
"""The wheel of a rail joint: its hub, its mass, its motion of rolling."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh, MeshTags, compute_midpoints, meshtags
from mpi4py import MPI

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact.common.types import FloatArray, IntArray
from .parameters import HUB, RailJoint

BORE = 0.1  # radius of the bore [m]
HUB_TAGS = (8, 9)  # tags of the cells of the hub's upper and lower half
RIM_TAG = 2  # tag of the other cells


class Wheel:
    """Geometry and motion of the wheel in the configuration of the mesh.

    The rim is meshed finer below than above; two densities of the hub's halves give the wheel its mass and a centre of
    mass on its axle.

    Args:
        data: the joint.
        mesh: the mesh.
        cell_tags: its cells' tags, the wheel with RIM_TAG.

    Attributes:
        centre: of the wheel, (3) [m].
        axis: unit vector about which it turns forward, (3).
        turn: angle by which the fine zone is turned forward of the lowest point [rad].
        cell_tags: as given, the hub's halves with HUB_TAGS.
        densities: by tag [kg/m^3].
    """

    def __init__(self, data: RailJoint, mesh: Mesh, cell_tags: MeshTags) -> None:
        tilt = math.atan(data.cone)
        self._data, self._mesh = data, mesh
        self.axis = np.array((0.0, math.cos(tilt), -math.sin(tilt)))
        self._up = np.array((0.0, math.sin(tilt), math.cos(tilt)))
        self.centre = np.array((data.begin, 0.0, 0.0)) + data.wheel_radius * self._up
        self.turn = 0.5 * (data.end - data.begin) / data.wheel_radius
        self.cell_tags = self._tag_hub(cell_tags)
        self.densities = {RIM_TAG: data.density, **self._balance()}

    @property
    def spin(self) -> float:
        """Angular velocity of rolling [rad/s]."""
        return self._data.speed / self._data.wheel_radius

    def _upward(self, right: Any, up: Any) -> Any:
        """Coordinate along the plane of symmetry of the mesh of the wheel, which is turned with its fine zone."""
        return math.cos(self.turn) * up - math.sin(self.turn) * right

    def _in_plane(self, arm: Any) -> tuple[Any, Any]:
        """Coordinates forward and upward, normal to the axle, of vectors from the centre."""
        return arm[0], sum(float(self._up[k]) * arm[k] for k in (1, 2))

    def _tag_hub(self, tags: MeshTags) -> MeshTags:
        cells, values = tags.indices, tags.values.copy()
        arm = compute_midpoints(self._mesh, 3, cells) - self.centre
        right, up = self._in_plane(arm.T)
        hub = (values == RIM_TAG) & (np.hypot(right, up) < HUB)
        values[hub] = np.where(self._upward(right, up)[hub] > 0, *HUB_TAGS)
        return meshtags(self._mesh, 3, cells, values)

    def _balance(self) -> dict[int, float]:
        """Densities of the hub's halves. Collective."""
        data, mesh = self._data, self._mesh
        lever, moments = self._upward(*self._in_plane(self.arm())), {}
        for tag in (RIM_TAG, *HUB_TAGS):
            dx = ufl.Measure("dx", domain=mesh, subdomain_data=self.cell_tags)(tag)
            parts = [fem.assemble_scalar(ffcx_form(f * dx)) for f in (fem.Constant(mesh, np.float64(1.0)), lever)]
            moments[tag] = mesh.comm.allreduce(np.array(parts), MPI.SUM)
        wanted = np.array([data.wheel_mass / data.sides, 0.0]) - data.density * moments[RIM_TAG]
        found = np.linalg.solve(np.column_stack([moments[t] for t in HUB_TAGS]), wanted)
        if np.any(found <= 0.0):
            rim = data.sides * data.density * moments[RIM_TAG][0]
            raise ValueError(
                f"wheel_mass is {data.wheel_mass:g} kg: the rim alone weighs {rim:.0f} kg, and the hub must balance "
                "what its finer cells weigh; give a larger wheel_mass, or more cells"
            )
        return {tag: float(density) for tag, density in zip(HUB_TAGS, found)}

    @property
    def cells(self) -> IntArray:
        """Cells of the wheel on this rank."""
        return self.cell_tags.indices[np.isin(self.cell_tags.values, (RIM_TAG, *HUB_TAGS))]

    def indicator(self) -> fem.Function:
        """One on the cells of the wheel, zero on others. Collective."""
        W = fem.functionspace(self._mesh, ("DG", 0))
        out = fem.Function(W, name="on_wheel")
        out.x.array[W.dofmap.list[self.cells, 0]] = 1.0
        out.x.scatter_forward()
        return out

    def arm(self) -> Any:
        """Vector from the centre to a place, in UFL [m]."""
        return ufl.SpatialCoordinate(self._mesh) - ufl.as_vector(self.centre.tolist())

    def turning(self) -> Any:
        """Velocity of turning about the axle, in UFL [m/s]."""
        return self.spin * ufl.cross(ufl.as_vector(self.axis.tolist()), self.arm())

    def centrifugal(self) -> Any:
        """Centrifugal acceleration, in UFL [m/s^2]."""
        axis, arm = ufl.as_vector(self.axis.tolist()), self.arm()
        return self.spin**2 * (arm - ufl.dot(axis, arm) * axis)

    def bore_ends(self, x: FloatArray) -> Any:
        """Mask of places: highest and lowest points of the bore as it was meshed, in the middle plane.

        Args:
            x: places, (3, n) [m].
        """
        arm = x - self.centre[:, None]
        right, up = self._in_plane(arm)
        along = math.cos(self.turn) * right + math.sin(self.turn) * up
        middle = np.abs(self.axis @ arm) < 1e-6
        return middle & (np.abs(along) < 1e-6) & (np.abs(np.abs(self._upward(right, up)) - BORE) < 1e-6)
