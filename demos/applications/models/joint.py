# SPDX-License-Identifier: MIT
"""Model of rail_joint_plane: wheel, rails and their state of rolling, in the plane."""

import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem
from dolfinx.mesh import compute_midpoints, meshtags

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.assembly import operators
from dolfinx_impact.io.run_folder import vertex_average

RADIUS, BORE, HUB = 0.46, 0.1, 0.15  # of the wheel, its bore, its hub with all that is fixed to it [m]
E, NU, DENSITY = 207e9, 0.3, 7800.0  # steel [Pa], [1], [kg/m^3]
HUBS = (8, 9)  # tags of the cells of its upper and lower half


class Rolling:
    """A wheel that rolls towards the joint of two rails.

    Args:
        comm: communicator.
        load: on the wheel, per length of axle [N/m]. mass: of wheel and hub, likewise [kg/m].
        speed: [m/s]. begin, end: place of the wheel's centre at the start and at the end, joint at 0 [m].
        h, gap, corner, step and `size`: of the mesh recipe [m].
        continuous: end post of rail steel, glued: a rail without a joint on the same kind of mesh.
        friction: Coulomb's coefficient [1]. chi: penalty of the contact [Pa/m].
    """

    def __init__(self, comm, load, mass, speed, begin, end, h, gap, corner, step, continuous, friction, chi, **size):
        self.comm, self.load, self.speed, self.begin = comm, load, speed, begin
        self.chi, self.friction = chi, friction
        self.turn = 0.5 * (end - begin) / RADIUS
        made = meshes.make(
            "rail_joint_2d", comm, wheel=True, wheel_x=begin, wheel_radius=RADIUS, hub_radius=BORE, gap=gap, h=h,
            end_post="glued" if continuous else "none", **({} if continuous else {"corner": corner, "step": step}),
            wheel_turn=self.turn, **size,
        )  # fmt: skip
        self.mesh, self.facet_tags, self.tags = made.mesh, made.facet_tags, made.tags
        self.num_cells = self.mesh.topology.index_map(2).size_global
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.u, self.velocity = fem.Function(self.V, name="displacement"), fem.Function(self.V, name="velocity")
        self._tag_hub(made.cell_tags)
        rail = di.LinearElastic(E, NU, DENSITY, hypothesis="plane_strain")
        densities = {2: DENSITY, **self._balance(mass)}
        self.rail = rail
        self.turning = {t: di.StVenantKirchhoff(E, NU, d, hypothesis=rail.hypothesis) for t, d in densities.items()}
        parts = {self.tags[name]: rail for name in ("master_body", "second_rail", "end_post") if name in self.tags}
        self.material = di.MaterialMap(self.cell_tags, {**parts, **self.turning})
        held = fem.locate_dofs_topological(self.V, 1, self.facet_tags.find(self.tags["bottom"]))
        self.bcs = [fem.dirichletbc(np.zeros(2), held, self.V)]
        pair_tags = {"slave": self.tags["slave_surface"], "master": self.tags["master_surface"]}
        self.pair = lambda friction: di.ContactPair(self.facet_tags, **pair_tags, friction=friction)
        bore = ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facet_tags)(self.tags["hub"])
        area = comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(self.mesh, 1.0) * bore)), MPI.SUM)
        self.press = di.Traction(self.facet_tags, self.tags["hub"], (0.0, -load / area))

    def _tag_hub(self, tags):
        """The wheel's cells near its bore get tags of their own, above and below the centre as it was meshed."""
        cells, values = tags.indices, tags.values.copy()
        middle = compute_midpoints(self.mesh, 2, cells)
        right, up = middle[:, 0] - self.begin, middle[:, 1] - RADIUS
        hub = (values == 2) & (np.hypot(right, up) < HUB)
        values[hub] = np.where(self._upward(right, up)[hub] > 0, *HUBS)
        self.cell_tags = meshtags(self.mesh, 2, cells, values)
        W = fem.functionspace(self.mesh, ("DG", 0))
        self.on_wheel = fem.Function(W)
        self.on_wheel.x.array[W.dofmap.list[cells, 0]] = np.isin(values, (2, *HUBS))
        self.on_wheel.x.scatter_forward()

    def _upward(self, right, up):
        """Coordinate along the wheel's axis of symmetry, which was turned with its fine zone."""
        return np.cos(self.turn) * up - np.sin(self.turn) * right

    def _balance(self, mass):
        """Densities of the hub's halves: the wheel has its mass, and its centre of mass in its centre.

        The rim is a polygon, finer below than above: without this it would be out of balance by some per cent of the
        load at this speed.
        """
        (arm, _), moments = self.arm(), {}
        lever = self._upward(arm[0], arm[1])
        for tag in (2, *HUBS):
            dx = ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags)(tag)
            parts = [fem.assemble_scalar(fem.form(f * dx)) for f in (fem.Constant(self.mesh, 1.0), lever)]
            moments[tag] = self.comm.allreduce(np.array(parts), MPI.SUM)
        wanted = np.array([mass, 0.0]) - DENSITY * moments[2]
        return dict(zip(HUBS, np.linalg.solve(np.column_stack([moments[t] for t in HUBS]), wanted).tolist()))

    def _upright(self):
        """No motion along x of the bore's highest and lowest points."""

        def ends(x):
            right, up = x[0] - self.begin, x[1] - RADIUS
            along = np.cos(self.turn) * right + np.sin(self.turn) * up
            return (np.abs(along) < 1e-6) & (np.abs(np.abs(self._upward(right, up)) - BORE) < 1e-6)

        W, _ = self.V.sub(0).collapse()
        dofs = fem.locate_dofs_geometrical((self.V.sub(0), W), ends)
        return fem.dirichletbc(fem.Function(W), dofs, self.V.sub(0))

    def arm(self):
        """Vector from the wheel's centre in the reference configuration, and the velocity of turning about it."""
        x = ufl.SpatialCoordinate(self.mesh)
        right, up, spin = x[0] - self.begin, x[1] - RADIUS, self.speed / RADIUS
        return ufl.as_vector([right, up]), spin * ufl.as_vector([up, -right])

    def press_down(self):
        """Statics in the wheel's frame: load and centrifugal forces. Two points of the bore keep the wheel from turning
        and from rolling away; equilibrium does not need them, they carry nothing."""
        v, (arm, _) = ufl.TestFunction(self.V), self.arm()
        residual = operators.internal_force_form(self.u, v, self.material) - self.press.form(self.u, v, self.material)
        dx = ufl.Measure("dx", domain=self.mesh, subdomain_data=self.cell_tags)
        for tag, law in self.turning.items():
            residual -= law.density * (self.speed / RADIUS) ** 2 * ufl.inner(arm, v) * dx(tag)
        bcs = [*self.bcs, self._upright()]
        problem = di.StaticProblem(
            self.u, residual=residual, bcs=bcs, contact=[di.Penalty(self.pair(0.0), penalty=self.chi)]
        )
        problem.solve(steps=2)
        return problem.contact[0]

    def set_rolling(self):
        """Velocities of steady rolling: the deformation stays where the wheel is while the material turns through it.

        With x = c(t) + y + u(y), y turning about c: V + w + grad u w on the wheel, -V du/dx on the rail.
        """
        _, w = self.arm()
        along = ufl.as_vector([self.speed, 0.0])
        field = ufl.grad(self.u)
        moving = ufl.conditional(ufl.gt(self.on_wheel, 0.5), 1.0, 0.0)
        v = moving * (along + w + field * w) - (1 - moving) * field * along
        rows = self.velocity.x.array.reshape(-1, 2)
        for i in range(2):
            rows[:, i] = vertex_average(v[i], self.mesh, "component").x.array
        for bc in self.bcs:
            rows.reshape(-1)[bc.dof_indices()[0]] = 0.0

    def mises(self):
        """Von Mises stress at the nodes [Pa], of the Cauchy stress."""
        both = [material.von_mises(self.u) for material in (self.turning[2], self.rail)]
        return vertex_average(ufl.conditional(ufl.gt(self.on_wheel, 0.5), *both), self.mesh, "von_mises")

    def explicit(self, balanced=True):
        """The explicit problem from this state on."""
        return di.ExplicitProblem(
            self.u, self.material, velocity=self.velocity, bcs=self.bcs, loads=[self.press],
            contact=[di.Penalty(self.pair(self.friction), penalty=self.chi, balanced=balanced)],
        )  # fmt: skip
