# SPDX-License-Identifier: MIT
"""Bodies that move by large parts of a facet in a step: contact acts up to one facet, an error is raised beyond.

See on_ranks.py.
"""

import numpy as np
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD
METHODS = (di.Penalty, di.Kinematic)
SPEEDS = (0.1, 0.36, 0.72, 0.99)  # of the relative motion in a step, in facets
H = 0.25  # edge of a cell
CELLS = {2: "quadrilateral", 3: "hexahedron"}


class Plates:
    """Two plates of one cell's thickness, the upper one, the slave, somewhat narrower.

    Args:
        rigid: the master is a plane in place of the lower plate's face. held: the lower plate does not move.
        gap: in cells. offset: of the upper plate along the first axis [L]. thick: cells across the lower plate.
    """

    def __init__(self, dim, rigid=False, held=False, gap=0.3, offset=None, thick=1, comm=COMM):
        self.dim, self.comm = dim, comm
        wide, narrow = (8, 3)[dim - 2], (5, 2)[dim - 2]
        place = 0.07 if offset is None else offset
        made = meshes.make(
            "two_blocks", comm, cell=CELLS[dim], gap=gap * H, lower=(wide * H,) * (dim - 1) + (thick * H,),
            upper=(narrow * H,) * (dim - 1) + (H,), lower_cells=(wide,) * (dim - 1) + (thick,),
            upper_cells=(narrow,) * (dim - 1) + (1,), offset=place if dim == 2 else (place, 0.09),
        )  # fmt: skip
        self.V = V = fem.functionspace(made.mesh, ("Lagrange", 1, (dim,)))
        self.X = V.tabulate_dof_coordinates()[:, :dim]
        top = thick * H
        self.upper = self.X[:, -1] > top + 0.5 * gap * H
        up = (0.0,) * (dim - 1) + (1.0,)
        master = di.RigidPlane((0.0,) * (dim - 1) + (top,), up) if rigid else made.tags["master_surface"]
        self.pair = di.ContactPair(made.facet_tags, made.tags["slave_surface"], master)
        self.law = di.LinearElastic(1.0, 0.0, 1.0, "3d" if dim == 3 else "plane_strain")
        nodes = np.flatnonzero(~self.upper).astype(np.int32)
        self.bcs = [fem.dirichletbc(np.zeros(dim), nodes, V)] if held or rigid else []
        # Facets' diameters: of the plane they are the slave's, which are as large.
        self.facet = H * (1.0 if dim == 2 else np.sqrt(2.0))

    def problem(self, method, facets, direction=None):
        """The upper plate moves by `facets` in a step of the automatic length: down, unless a direction is given."""
        velocity = fem.Function(self.V)
        problem = di.ExplicitProblem(fem.Function(self.V), self.law, velocity=velocity, bcs=self.bcs)
        self.dt = 0.9 * problem.stable_step()
        speed = facets * self.facet / self.dt
        v = velocity.x.array.reshape(-1, self.dim)
        v[self.upper] = speed * (np.array([0.0] * (self.dim - 1) + [-1.0]) if direction is None else direction)
        return di.ExplicitProblem(
            fem.Function(self.V), self.law, velocity=velocity, bcs=self.bcs, contact=[method(self.pair)]
        )

    def mean(self, problem, what, body):
        """Mean of a function over the nodes of a body. Collective."""
        n = self.V.dofmap.index_map.size_local
        m = np.where(body[:n], problem.mass.array.reshape(-1, self.dim)[:n, 0], 0.0)
        sums = self.comm.allreduce(np.append(m @ what.x.array.reshape(-1, self.dim)[:n], m.sum()), MPI.SUM)
        return sums[:-1] / sums[-1]

    def momentum(self, problem):
        """Of both plates. Collective."""
        n = self.V.dofmap.index_map.size_local * self.dim
        p = problem.mass.array[:n] * problem.velocity.x.array[:n]
        return self.comm.allreduce(p.reshape(-1, self.dim).sum(axis=0), MPI.SUM)


def check_up_to_a_facet_in_a_step_is_held_back():
    """Plates end up apart, on the sides they came from, momentum kept; at every speed, also where the step's end is
    half a facet and more below the surface, and where the other face of the plate is nearer."""
    for dim in (2, 3):
        for method in METHODS:
            for kind in ({}, {"held": True}, {"rigid": True})[: 3 if COMM.size == 1 else 1]:
                for facets in SPEEDS if dim == 2 and COMM.size == 1 else SPEEDS[1::2]:
                    for gap in (0.3, 0.05) if facets > 0.9 and COMM.size == 1 else (0.3,):
                        case = dim, method.__name__, kind, facets, gap
                        plates = Plates(dim, gap=gap, **kind)
                        problem = plates.problem(method, facets)
                        start = plates.mean(problem, problem.velocity, plates.upper)[-1]
                        before = plates.momentum(problem)
                        problem.advance((30 + 6 / facets) * plates.dt, dt=plates.dt, progress=False)
                        v = [plates.mean(problem, problem.velocity, b)[-1] for b in (plates.upper, ~plates.upper)]
                        u = [plates.mean(problem, problem.u, b)[-1] for b in (plates.upper, ~plates.upper)]
                        assert v[0] > v[1], ("they part", case, v)
                        assert u[0] - u[1] > -(gap + 0.5) * H, ("on their own sides", case, u)
                        assert v[0] - v[1] > 0.4 * abs(start), ("most of the speed is turned round", case, v, start)
                        if not kind:
                            after = plates.momentum(problem)
                            assert np.abs(after - before).max() < 1e-12 * np.abs(before).max(), case


def check_beyond_a_facet_in_a_step_is_an_error():
    """On all ranks, with the node's place and a step that will do; the problem is back where it was good."""
    for dim in (2, 3):
        for method in METHODS:
            for kind in ({}, {"rigid": True}):
                cases = ((1.2, 0.3), (1.5, 0.3), (3.0, 2.5), (7.0, 5.0))
                for facets, gap in cases[:: 4 - dim if COMM.size == 1 else 3]:
                    case = dim, method.__name__, kind, facets
                    plates = Plates(dim, gap=gap, **kind)
                    problem = plates.problem(method, facets)
                    try:
                        problem.advance(20 * plates.dt, dt=plates.dt, progress=False)
                        said = "nothing"
                    except RuntimeError as error:
                        said = str(error)
                    assert len(set(COMM.allgather(said))) == 1
                    assert "a slave node went through the master" in said and "node " in said, (case, said)
                    assert f"this one came by {facets:.3g}" in said, (case, said)
                    place = np.array(said.split(" at [")[1].split("]")[0].split(","), dtype=float)
                    lowest = plates.X[plates.upper, -1].min(initial=np.inf)
                    assert np.isclose(place[-1], COMM.allreduce(lowest, MPI.MIN))
                    assert np.all(np.isfinite(problem.u.x.array)) and problem.time < 10 * plates.dt
                    better = float(said.split("steps below ")[1].split(" ")[0])
                    assert np.isclose(better, 0.9 * plates.dt / facets, rtol=0.01)


def check_the_step_that_is_advised_will_do():
    plates = Plates(2, held=True)
    problem = plates.problem(di.Kinematic, 1.5)
    problem.advance(30 * plates.dt, dt=0.55 * plates.dt, progress=False)
    assert plates.mean(problem, problem.velocity, plates.upper)[-1] > 0.0


def check_a_fast_body_that_misses_raises_nothing():
    """Past the end of the plate and away from it, several facets in a step."""
    for dim in (2, 3):
        for method in METHODS:
            for offset, direction in ((9.0 * H, (0.0,) * (dim - 1) + (-1.0,)), (-0.5, (1.0,) + (0.0,) * (dim - 1))):
                for facets in (0.9, 3.0)[: 3 - COMM.size]:
                    plates = Plates(dim, offset=offset)
                    problem = plates.problem(method, facets, np.array(direction))
                    problem.advance(12 * plates.dt, dt=plates.dt, progress=False)
                    v = problem.velocity.x.array.reshape(-1, dim)[plates.upper]
                    assert np.allclose(v, facets * plates.facet / plates.dt * np.array(direction), rtol=1e-12)
                    assert not problem.contact[0].force.any()


def check_from_far_away():
    """A body that starts many facets away and comes by nearly one in a step is found in time, also after a checkpoint's
    new search, with a short search distance."""
    for method in METHODS:
        plates = Plates(2, held=True, gap=7.3)
        plates.pair = di.ContactPair(
            plates.pair.facet_tags, plates.pair.slave, plates.pair.master, search_distance=0.2 * H
        )
        problem = plates.problem(method, 0.95)
        for k in range(14):
            problem.advance((k + 1) * plates.dt, dt=plates.dt, progress=False)
            problem._cpp_object.integrator.saved_state()  # searches anew, as a checkpoint does
        problem.advance(40 * plates.dt, dt=plates.dt, progress=False)
        assert plates.mean(problem, problem.velocity, plates.upper)[-1] > 0.0, method
