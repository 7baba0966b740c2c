# SPDX-License-Identifier: MIT
"""A sector of a wheel on a length of rail, pressed together by a load, in steady rolling."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact import meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.types import ArrayLike, FilePath, FloatArray
from dolfinx_impact.contact import ContactPair, Lagrange
from dolfinx_impact.materials import LinearElastic, StVenantKirchhoff
from dolfinx_impact.rolling.motions import Spin, Translation
from dolfinx_impact.rolling.rolling_problem import RollingProblem
from dolfinx_impact.rolling.rolling_contact import RollingContact
from dolfinx_impact.statics.static_problem import StaticProblem
from .parameters import WheelOnRail

ACCURACY = 1e-4  # of the load: what the approach is searched to


class CreepModel:
    """Finite elements of a WheelOnRail, under its load.

    Args:
        data: wheel and rail.
        whole: both sides of the plane y = 0, as lateral and spin creep need; else one half.
        comm: communicator.
        law: of both bodies: LinearElastic, or of finite strain, which an explicit run needs.

    Attributes:
        data: as given.
        hertz: contact by the theory of Hertz.
        sides: 1, or 2 of which one is computed: forces count so often.
        problem: RollingProblem with friction, under the load; at first it rolls freely.
        free_creep: of free rolling, against omega = speed/radius [1].
        u: displacement [m].
        wheel: Spin of the wheel.
    """

    def __init__(
        self,
        data: WheelOnRail,
        whole: bool = False,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
        law: type[LinearElastic] | type[StVenantKirchhoff] = LinearElastic,
    ) -> None:
        self.data, self.hertz, self.sides = data, data.hertz, 1 if whole else 2
        made = meshes.make(
            "rolling_contact_3d", comm, radius=data.radius, crown_radius=data.crown_radius,
            wheel_crown_radius=data.wheel_crown_radius, a=self.hertz.a, b=self.hertz.b, cells=data.cells,
            reach=data.reach, symmetry="none" if whole else "half", path=data.path,
        )  # fmt: skip
        tags, fdim = made.tags, 2
        V = fem.functionspace(made.mesh, ("Lagrange", 1, (3,)))
        self.u, self._hub = fem.Function(V, name="displacement"), fem.Function(V)
        self._axle = fem.locate_dofs_topological(V, fdim, made.facet_tags.find(tags["hub"]))
        bottom = fem.locate_dofs_topological(V, fdim, made.facet_tags.find(tags["bottom"]))
        bcs = [fem.dirichletbc(self._hub, self._axle), fem.dirichletbc(np.zeros(3), bottom, V)]
        if not whole:
            across = fem.locate_dofs_topological(V.sub(1), fdim, made.facet_tags.find(tags["symmetry_y"]))
            bcs.append(fem.dirichletbc(fem.Constant(V.mesh, np.float64(0.0)), across, V.sub(1)))
        self._bcs, self._steel, self._made = bcs, law(data.E, data.nu, density=data.density), made
        self.wheel = Spin((0.0, 0.0, data.radius), (0.0, 1.0, 0.0), data.speed / data.radius)
        self._press(self.rolling(0.0))
        self.problem = self.rolling(data.friction)
        self.problem.solve(torque=0.0)
        self.free_creep = self.problem.omega * data.radius / data.speed - 1.0

    def _pair(self, friction: float) -> ContactPair:
        tags = self._made.tags
        return ContactPair(self._made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=friction)

    def rolling(self, friction: float) -> RollingProblem:
        """Another problem of the same displacement and spin, not solved. Collective.

        Args:
            friction: coefficient [1].
        """
        tags = self._made.tags
        motions: dict[int, Spin | Translation] = {
            tags["slave_body"]: self.wheel,
            tags["master_body"]: Translation((-self.data.speed, 0.0, 0.0)),
        }
        contact = [Lagrange(self._pair(friction))]
        return RollingProblem(self.u, self._steel, self._made.cell_tags, motions, contact=contact, bcs=self._bcs)

    def standing(self) -> StaticProblem:
        """The same bodies and displacement without friction, at rest, not solved. Collective."""
        return StaticProblem(self.u, self._steel, bcs=self._bcs, contact=[Lagrange(self._pair(0.0))])

    @property
    def num_unknowns(self) -> int:
        """Displacements, of all ranks."""
        return 3 * int(self.u.function_space.dofmap.index_map.size_global)

    @property
    def identity(self) -> dict[str, float | str]:
        """All that tells this wheel from another, by name; files of curves have it."""
        return {**self.data.values(), "half": "y > 0" if self.sides == 2 else "both", "law": type(self._steel).__name__}

    @property
    def contact(self) -> RollingContact:
        """The contact with friction and its results."""
        found = self.problem.contact[0]
        assert isinstance(found, RollingContact)
        return found

    @property
    def peak_pressure(self) -> float:
        """Largest contact pressure, of all ranks [Pa]. Collective."""
        return float(self.contact.comm.allreduce(float(self.contact.pressure.max(initial=0.0)), MPI.MAX))

    def _press(self, frictionless: RollingProblem) -> None:
        """Find the approach that bears the load, without friction, by the secant method. Collective."""
        found: list[tuple[float, float]] = []
        approach, load = self.hertz.approach, self.data.load
        while not found or abs(found[-1][1] - load) > ACCURACY * load:
            if len(found) == 12:
                raise RuntimeError(
                    f"no approach was found that bears {load:.6g} N; the last bears {found[-1][1]:.6g} N"
                )
            self._hub.x.array.reshape(-1, 3)[self._axle] = (0.0, 0.0, -approach)
            frictionless.solve()
            force = frictionless.contact[0].force
            assert force is not None
            found.append((approach, self.sides * float(force[2])))
            if not found[-1][1] > 0.0 or (len(found) > 1 and found[-1][1] == found[-2][1]):
                raise RuntimeError(
                    f"no approach was found that bears {load:.6g} N: {approach:.6g} m make {found[-1][1]:.6g} N; give "
                    "more cells, a smaller speed or another load"
                )
            if len(found) == 1:
                approach *= (load / found[0][1]) ** (2.0 / 3.0)
            else:
                (d0, f0), (d1, f1) = found[-2:]
                approach = d1 + (load - f1) * (d1 - d0) / (f1 - f0)

    def curve(
        self,
        creep: ArrayLike | None = None,
        lateral: ArrayLike | None = None,
        spin: ArrayLike | None = None,
        file: FilePath | None = None,
        progress: bool = True,
    ) -> dict[str, FloatArray]:
        """Steady states for a sequence of creepages, as RollingProblem.sweep. Call it once. Collective.

        Creepages count from free rolling: the rail takes the wheel in a little, so that it turns as one of another
        radius does.

        Args:
            creep: longitudinal, of the wheel against the rail, (n) or one number [1].
            lateral: (n) or one number [1].
            spin: (n) or one number [1/m].
            file: HDF5 file that is written after every point, and gone on from. It has all parameters; the file of
                another wheel is refused.
            progress: show a progress bar on rank 0.

        Returns:
            Arrays by name: creep, lateral, spin, omega (n) [1/s], force (n, 3) on the wheel [N], torque (n) [N m], of
            the whole wheel; ratio (n): tangential force over friction times normal force [1].

        Raises:
            ValueError: the file belongs to another wheel or curve; on all ranks.
            RuntimeError: no equilibrium was found, or the file cannot be read or written; on all ranks.
        """
        found = self.problem.sweep(creep, lateral, spin, file, progress, identity=self.identity)
        force = self.sides * found["force"]
        if self.sides == 2:
            force[:, 1] = 0.0
        ratio = np.hypot(force[:, 0], force[:, 1]) / (self.data.friction * force[:, 2])
        return {**found, "force": force, "torque": self.sides * found["torque"], "ratio": ratio}


__all__ = ["CreepModel", "WheelOnRail"]
