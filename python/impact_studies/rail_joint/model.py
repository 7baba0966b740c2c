# SPDX-License-Identifier: MIT
"""Finite elements of a rail joint: mesh, materials, supports, loads and contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.mesh import MeshTags, compute_midpoints, meshtags
from mpi4py import MPI

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact import meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.contact import ContactPair, Tie
from dolfinx_impact.io.run_folder import vertex_average
from dolfinx_impact.foundation import Foundation
from dolfinx_impact.loads import BodyForce, Traction
from dolfinx_impact.materials import LinearElastic, MaterialMap, StVenantKirchhoff
from dolfinx_impact.plasticity import ArmstrongFrederick, J2Plasticity
from dolfinx_impact.common.types import BoolArray, FloatArray
from .parameters import MARGIN, PAD_LENGTH, WHEEL_WIDTH, RailJoint
from .wheel import Wheel

PATH_TAG = 10  # cells of the rails near the path, which may yield
REACH = 4.0  # depth and half-width of that zone in half-axes of the contact
# Steps of cells that may yield, and of the wheel, over those of linear cells: measured.
YIELDING_COST, WHEEL_COST = 6.0, 1.5
HORIZONTAL = 0.5  # stiffness of the fastening along and across the rail, over that of the pad


class JointModel:
    """Wheel, rails, end post, joint bars and track.

    Args:
        data: the joint.
        comm: communicator.
        partitioner: of the mesh's cells, as in dolfinx.mesh.create_mesh; None: DOLFINx's.

    Attributes:
        data: as given.
        mesh: the mesh.
        tags: numbers of its tags by name.
        facet_tags, cell_tags: of surfaces and bodies.
        V: displacement space.
        wheel: geometry and motion of the wheel.
        rail_law: elastic law of the rails away from the path.
        path_law: law of the rails near the path.
        material: all laws by cell tag.
        bcs: supports of all stages.
        press: load of the suspension on the wheel.
        track: pads below the rails.
        ties: what holds parts with meshes of their own.
    """

    def __repr__(self) -> str:
        return f"JointModel({self.num_cells} cells, {self.data!r})"

    def __init__(self, data: RailJoint, comm: MPI.Intracomm = MPI.COMM_WORLD, partitioner: Any = None) -> None:
        self.data, self.comm = data, comm
        made = meshes.make(
            "insulated_joint_3d", comm, partitioner=partitioner, weight=None if partitioner else self._cost,
            rail_length=data.rail_length,
            crown_radius=data.crown_radius, head_profile=data.head_profile or None, gap=data.gap,
            bar_length=data.bar_length, bar=data.bar, glue=data.glue, h=data.cell_size, coarse=data.largest_cells,
            path=(data.begin, data.end), margin=MARGIN * data.hertz.a, symmetry="none" if data.whole else "half",
            wheel_x=data.begin, wheel_radius=data.wheel_radius,
            wheel_width=WHEEL_WIDTH, cone=data.cone, fillet=data.fillet, tied=data.tied, tied_size=data.tied_size,
        )  # fmt: skip
        self.mesh, self.facet_tags, self.tags = made.mesh, made.facet_tags, made.tags
        self.num_cells = self.mesh.topology.index_map(3).size_global
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (3,)))
        self.wheel = Wheel(data, self.mesh, made.cell_tags)
        self.cell_tags = self._tag_path(self.wheel.cell_tags)
        self._set_materials()
        self.bcs = [] if data.whole else [self._held("symmetry_y", 1)]
        hub = ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facet_tags)(self.tags["hub"])
        area = comm.allreduce(fem.assemble_scalar(ffcx_form(fem.Constant(self.mesh, np.float64(1.0)) * hub)), MPI.SUM)
        self.press = Traction(self.facet_tags, self.tags["hub"], (0.0, 0.0, -data.load / data.sides / area))
        self.track = self._track()
        self.ties = self._ties()

    def _near_path(self, middles: FloatArray) -> BoolArray:
        """Mask of midpoints of cells, (n, 3), above and below the running surface near the path."""
        data, reach = self.data, REACH * self.data.hertz.a
        x, y, z = middles.T
        near: BoolArray = (x > data.begin - reach) & (x < data.end + reach) & (np.abs(y) < reach) & (z > -reach)
        return near

    def _cost(self, middles: FloatArray) -> FloatArray:
        """Time of a step for cells with these midpoints, (n, 3) -> (n), over that of a linear cell."""
        cost = np.where(middles[:, 2] > 0.0, WHEEL_COST, 1.0)
        if not math.isinf(self.data.yield_stress):
            cost[self._near_path(middles) & (middles[:, 2] < 0.0)] = YIELDING_COST
        return cost

    def _tag_path(self, tags: MeshTags) -> MeshTags:
        """Cells of the rails near the path get a tag of their own where the rail may yield."""
        values = tags.values.copy()
        if math.isinf(self.data.yield_stress):
            return tags
        near = self._near_path(compute_midpoints(self.mesh, 3, tags.indices))
        rails = np.isin(values, (self.tags["master_body"], self.tags["second_rail"]))
        values[near & rails] = PATH_TAG
        return meshtags(self.mesh, 3, tags.indices, values)

    def _set_materials(self) -> None:
        data, post = self.data, self.data.post
        self.rail_law = LinearElastic(data.E, data.nu, data.density)
        turning = {tag: StVenantKirchhoff(data.E, data.nu, d) for tag, d in self.wheel.densities.items()}
        laws: dict[int, Any] = {
            self.tags["master_body"]: self.rail_law,
            self.tags["second_rail"]: self.rail_law,
            self.tags["joint_bar"]: self.rail_law,
            self.tags["end_post"]: LinearElastic(post.E, post.nu, post.density),
            self.tags["glue"]: LinearElastic(data.glue_modulus, 0.35, 1500.0),
            **turning,
        }
        self.path_law: LinearElastic | J2Plasticity = self.rail_law
        if not math.isinf(data.yield_stress):
            kinematic = ArmstrongFrederick(data.hardening_modulus, data.recovery) if data.hardening_modulus else None
            self.path_law = J2Plasticity(
                data.E, data.nu, data.density, yield_stress=data.yield_stress, hardening=0.0, kinematic=kinematic
            )
            laws[PATH_TAG] = self.path_law
        self.material = MaterialMap(self.cell_tags, laws)

    def _held(self, side: str, direction: int) -> fem.DirichletBC:
        dofs = fem.locate_dofs_topological(self.V.sub(direction), 2, self.facet_tags.find(self.tags[side]))
        return fem.dirichletbc(default_scalar_type(0.0), dofs, self.V.sub(direction))

    def upright(self) -> list[fem.DirichletBC]:
        """No motion forward of the bore's highest and lowest points, nor sideways of a whole wheel: what keeps it from
        rolling away in statics. Equilibrium does not need it."""
        out = []
        for direction in (0, 1) if self.data.whole else (0,):
            W, _ = self.V.sub(direction).collapse()
            dofs = fem.locate_dofs_geometrical((self.V.sub(direction), W), self.wheel.bore_ends)
            out.append(fem.dirichletbc(fem.Function(W), dofs, self.V.sub(direction)))
        return out

    def parked(self) -> list[fem.DirichletBC]:
        """The wheel is held as a whole: lifted off, it has neither load nor displacement."""
        dofs = np.unique(self.V.dofmap.list[self.wheel.cells])
        return [fem.dirichletbc(np.zeros(3, dtype=default_scalar_type), dofs, self.V)]

    def _ties(self) -> list[Tie]:
        """Ties of the parts that are meshed apart: the softer ones, of larger cells, are slaves."""
        bars = ("bars", "bar_face", "web")
        posts = [("end post left", "post_left", "joint_left"), ("end post right", "post_right", "joint_right")]
        sides = {"none": [], "bars": [bars], "all": [bars, *posts]}[self.data.tied]
        tags = self.tags
        return [Tie(ContactPair(self.facet_tags, tags[s], tags[m], name=name)) for name, s, m in sides]

    def _track(self) -> Foundation:
        """Pads below the foot at the sleepers, or the same stiffness spread along the rail."""
        data = self.data
        width = 2 * 0.075 if data.whole else 2 * 0.075 / data.sides
        seats = data.pad_stiffness / data.sides, data.pad_damping / data.sides
        x = ufl.SpatialCoordinate(self.mesh)[0]
        if data.support == "winkler":
            here: Any = 1.0 / (data.sleepers * width)
        else:
            # Distance from the nearest sleeper; the joint is half way between two.
            from_joint = ufl.algebra.Abs(x) / data.sleepers
            number = from_joint - 0.5
            nearest = sum(
                ufl.conditional(ufl.lt(ufl.algebra.Abs(number - k) * data.sleepers, 0.5 * PAD_LENGTH), 1.0, 0.0)
                for k in range(int(data.rail_length / data.sleepers + 0.5) + 1)
            )
            here = nearest / (PAD_LENGTH * width)
        directions = ufl.as_vector((HORIZONTAL, HORIZONTAL, 1.0))
        stiffness, damping = (seat * here * directions for seat in seats)
        return Foundation(self.facet_tags, self.tags["bottom"], stiffness, damping=damping)

    def centrifugal(self) -> BodyForce:
        """Centrifugal forces of the turning wheel, for equilibrium in the frame that moves with it."""
        return BodyForce(self.wheel.indicator() * self.wheel.centrifugal())

    def pair(self, friction: float) -> ContactPair:
        """Wheel and running surface.

        Args:
            friction: coefficient [1].
        """
        return ContactPair(
            self.facet_tags, self.tags["slave_surface"], self.tags["master_surface"], friction=friction,
            name="wheel and rail", smooth=self.data.smooth,
        )  # fmt: skip

    def rolling_velocity(self, u: fem.Function) -> fem.Function:
        """Velocities of steady rolling: the dent stays below the wheel while the material passes through it.

        With x = c(t) + y + u(y) of the wheel, y turning about c: V + w + grad u w; on the rail -V du/dx. Collective.

        Args:
            u: displacement [m].
        """
        w, on_wheel = self.wheel.turning(), self.wheel.indicator()
        along, gradient = ufl.as_vector([self.data.speed, 0.0, 0.0]), ufl.grad(u)
        v = on_wheel * (along + w + gradient * w) - (1.0 - on_wheel) * gradient * along
        out = fem.Function(self.V, name="velocity")
        rows = out.x.array.reshape(-1, 3)
        for i in range(3):
            rows[:, i] = vertex_average(v[i], self.mesh, "component").x.array
        for bc in self.bcs:
            out.x.array[bc.dof_indices()[0]] = 0.0
        return out


__all__ = ["PATH_TAG", "JointModel"]
