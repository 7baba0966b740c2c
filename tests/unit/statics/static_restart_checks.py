# SPDX-License-Identifier: MIT
"""Static problems that are saved between two solves and go on in another one. See on_ranks.py."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD


MADE = {}


def blocks(comm):
    """A block above a longer one. One mesh for all problems of a communicator: DOLFINx may number another otherwise."""
    if comm.handle not in MADE:
        size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (7, 3), "upper_cells": (5, 3)}
        MADE[comm.handle] = meshes.make("two_blocks", comm, **size)
    return MADE[comm.handle]


class Two:
    """Two blocks: the lower one is held, the upper one pressed down, then sheared.

    Args:
        comm: communicator.
        contact: class of the contact, or None.
        law: material.
        master: rigid master, or None for the lower block's surface.
        others: options of the contact.
    """

    def __init__(self, comm, contact=di.Lagrange, law=None, master=None, friction=0.3, loads=(), **others):
        made = blocks(comm)
        tags, V = made.tags, fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
        self.u, self.master = fem.Function(V), master
        self.top = fem.Constant(made.mesh, np.zeros(2))
        at = {name: fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags[name])) for name in ("bottom", "top")}
        bcs = [fem.dirichletbc(np.zeros(2), at["bottom"], V), fem.dirichletbc(self.top, at["top"], V)]
        if master is not None:  # the lower block has nothing to do
            everything = np.unique(V.dofmap.list[made.cell_tags.find(tags["master_body"])].ravel()).astype(np.int32)
            bcs[0] = fem.dirichletbc(np.zeros(2), everything, V)
        self.loads = [load(made) for load in loads]
        pair = di.ContactPair(
            made.facet_tags, tags["slave_surface"], master or tags["master_surface"], friction=friction
        )
        law = law or di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
        self.problem = di.StaticProblem(self.u, law, bcs=bcs, loads=self.loads, contact=[contact(pair, **others)])

    def press(self):
        """Targets of the first solve."""
        if self.master is None:
            self.top.value[:] = (0.0, -0.01)
        else:
            self.master.displacement = (0.0, 0.012)
        for load in self.loads:
            load.constant.value[...] = 2.0

    def shear(self):
        """Targets of the second solve."""
        if self.master is None:
            self.top.value[:] = (0.008, -0.012)  # with friction of 0.3 some nodes slip
        else:
            self.master.displacement = (0.006, 0.014)
        for load in self.loads:
            load.constant.value[...] = 5.0


def rectangle(comm):
    """A body of triangles, one mesh for all problems of a communicator as well."""
    if (comm.handle, "rectangle") not in MADE:
        MADE[comm.handle, "rectangle"] = mesh.create_rectangle(comm, [[0.0, 0.0], [1.0, 0.5]], [4, 2])
    return MADE[comm.handle, "rectangle"]


class Mixed:
    """Displacement and pressure of a body that is nearly incompressible, by a residual of its own, with a dead load."""

    def __init__(self, comm):
        domain = rectangle(comm)
        P2, P1 = (basix.ufl.element("P", "triangle", 2, shape=(2,)), basix.ufl.element("P", "triangle", 1))
        W = fem.functionspace(domain, basix.ufl.mixed_element([P2, P1]))
        self.u = fem.Function(W)
        (u, p), (v, q) = ufl.split(self.u), ufl.TestFunctions(W)
        F = ufl.Identity(2) + ufl.grad(u)
        stress = F - (1.0 + p) * ufl.det(F) * ufl.inv(F).T
        self.force = fem.Constant(domain, 0.0)
        residual = ufl.inner(stress, ufl.grad(v)) * ufl.dx + (ufl.det(F) - 1.0 + p / 100.0) * q * ufl.dx
        residual += self.force * v[1] * ufl.dx
        W0, _ = W.sub(0).collapse()
        zero = fem.Function(W0)
        end = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], 0.0))
        dofs = fem.locate_dofs_topological((W.sub(0), W0), 1, end)
        self.problem = di.StaticProblem(self.u, residual=residual, bcs=[fem.dirichletbc(zero, dofs, W.sub(0))])

    def press(self):
        self.force.value = 0.02

    def shear(self):
        self.force.value = 0.05


def plastic():
    return di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=3.0, hardening=50.0, hypothesis="plane_strain")


def sphere():
    return di.RigidCylinder(center=(0.7, -4.5), radius=5.0)


def pushed(made):
    return di.FollowerPressure(made.facet_tags, made.tags["top"], 0.0)


CASES = {
    "multipliers with friction": Two,
    "multipliers, cylinder": lambda comm: Two(comm, law=di.NeoHookean(1e3, 0.3, 1.0, "plane_strain"), master=sphere()),
    "augmented penalty, plastic": lambda comm: Two(comm, di.Penalty, plastic(), augmented=True, tolerance=1e-5),
    "penalty, cylinder": lambda comm: Two(comm, di.Penalty, master=sphere()),
    "mixed": Mixed,
}


def rows(made, comm):
    """Places and displacements of all nodes, sorted by place and displacement."""
    V = made.u.function_space
    if isinstance(made, Mixed):
        u = made.u.sub(0).collapse()
        V, values = u.function_space, u.x.array
    else:
        values = made.u.x.array
    n = V.dofmap.index_map.size_local
    both = np.hstack([V.tabulate_dof_coordinates()[:n, :2], values[: 2 * n].reshape(-1, 2)])
    both = np.vstack(comm.allgather(both))
    return both[np.lexsort([both[:, 2].round(6), *both[:, :2].round(9).T])]


def contact_state(problem):
    """What is told of the contacts."""
    parts = [np.zeros(0)]
    for c in problem.contact:
        parts += [c.force, c.moment, [c.area, c.dissipated]]
        parts += [np.ravel(getattr(c, name)) for name in ("gap", "pressure", "traction", "slip", "status", "points")]
    return np.concatenate(parts)


OPTIONS = {"steps": 2, "progress": False}


def check_two_halves_are_the_whole():
    """One rank goes on bit for bit, several as the linear solver adds up; one rank also reads what several wrote."""
    with shared_folder() as path:
        for k, (name, make) in enumerate(CASES.items()):
            whole, file = make(COMM), path / f"{k}.h5"
            whole.press()
            whole.problem.solve(**OPTIONS)
            whole.problem.save(file)
            told, half = contact_state(whole.problem), whole.u.x.array.copy()
            whole.shear()
            report = whole.problem.solve(**OPTIONS)

            again = make(COMM)
            again.problem.restore(file)
            np.testing.assert_array_equal(again.u.x.array, half, err_msg=name)
            np.testing.assert_allclose(contact_state(again.problem), told, rtol=0, atol=1e-13 * (1 + np.abs(
                np.where(np.isfinite(told), told, 0.0)).max(initial=0.0)), err_msg=name)  # fmt: skip
            again.shear()
            assert again.problem.solve(**OPTIONS).iterations == report.iterations, name
            if COMM.size == 1:
                np.testing.assert_array_equal(again.u.x.array, whole.u.x.array, err_msg=name)
                np.testing.assert_array_equal(contact_state(again.problem), contact_state(whole.problem), err_msg=name)
                # A problem that was not saved in between, and keeps its factors.
                plain = make(COMM)
                for targets in (plain.press, plain.shear):
                    targets()
                    plain.problem.solve(**OPTIONS)
                there = rows(plain, COMM)
            else:
                alone = make(MPI.COMM_SELF)
                alone.problem.restore(file)
                alone.shear()
                alone.problem.solve(**OPTIONS)
                there = rows(alone, MPI.COMM_SELF)
            # Newton's method stops at 1e-10 of the forces; stiffer and softer parts of the bodies differ by 1e2.
            wanted = rows(whole, COMM)
            scale = np.abs(wanted[:, 2:]).max()
            np.testing.assert_allclose(there[:, 2:], wanted[:, 2:], rtol=0, atol=1e-7 * scale, err_msg=name)
            for contact in whole.problem.contact:
                assert contact.dissipated > 1e-12 and contact.area > 0.0, name  # more than round-off
            if whole.problem.has_history:
                assert np.any(COMM.allreduce(np.abs(whole.problem.history["plastic_strain"].values).max(initial=0.0)))


def check_reached_loads():
    """What a load has reached is where the next solve begins, whatever its value is; also before the first solve."""
    with shared_folder() as path:
        start = Two(COMM, loads=(pushed,))
        start.problem.save(path / "start.h5")
        start.press()
        start.problem.solve(**OPTIONS)
        start.problem.save(path / "half.h5")
        start.shear()
        start.problem.solve(**OPTIONS)
        for name, targets in (("start", ("press", "shear")), ("half", ("shear",))):
            again = Two(COMM, loads=(pushed,))
            again.problem.restore(path / f"{name}.h5")
            (constant, reached), = again.loads[0].ramps()  # fmt: skip
            assert reached == (0.0 if name == "start" else 2.0) and constant.value == 0.0
            for target in targets:
                getattr(again, target)()
                again.problem.solve(**OPTIONS)
            atol = 0.0 if COMM.size == 1 and name == "half" else 1e-9
            np.testing.assert_allclose(again.u.x.array, start.u.x.array, rtol=0, atol=atol)


def check_other_problems_are_refused():
    """With a word on what differs, on all ranks, and nothing is changed."""
    other = di.LinearElastic(1.1e3, 0.3, 1.0, "plane_strain")
    plane = di.RigidPlane((0.0, 0.5), (0.0, 1.0))
    cases = (
        (lambda: Two(COMM, law=other), "material"),
        (lambda: Two(COMM, friction=0.2), "friction"),
        (lambda: Two(COMM, di.Penalty), "contact"),
        (lambda: Two(COMM, basis="standard"), "basis"),
        (lambda: Two(COMM, master=plane), "master"),
        (lambda: Two(COMM, loads=(pushed,)), "loads"),
        (lambda: Mixed(COMM), "mesh"),
    )
    with shared_folder() as path:
        good = Two(COMM)
        good.press()
        good.problem.solve(**OPTIONS)
        good.problem.save(path / "good.h5")
        for make, text in cases:
            made = make()
            made.problem.u.x.array[:] = 1e-3
            before = [c.state().copy() for c in made.problem.contact]
            with pytest.raises(ValueError, match=f"another problem.*{text}"):
                made.problem.restore(path / "good.h5")
            assert np.all(made.problem.u.x.array == 1e-3)
            for contact, state in zip(made.problem.contact, before):
                assert not contact.state().difference_of_values(state) and contact.force is None
        free = Two(COMM)
        free.problem.fixed[:] = False
        with pytest.raises(ValueError, match="supports"):
            free.problem.restore(path / "good.h5")
        V = good.u.function_space
        run = di.ExplicitProblem(fem.Function(V), di.LinearElastic(1e3, 0.3, 1.0, "plane_strain"))
        run.save(path / "run.h5")
        with pytest.raises(ValueError, match="another problem"):
            good.problem.restore(path / "run.h5")
        with pytest.raises(ValueError, match="another problem"):
            run.restore(path / "good.h5")


def check_spaces_without_nodes_and_solves_under_way():
    with shared_folder() as path:
        domain = mesh.create_unit_square(COMM, 2, 2)
        W = fem.functionspace(domain, ("RT", 1))
        u = fem.Function(W)
        residual = ufl.inner(u, ufl.TestFunction(W)) * ufl.dx
        with pytest.raises(ValueError, match="values at nodes"):
            di.StaticProblem(u, residual=residual).save(path / "none.h5")
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        u, v = fem.Function(V), ufl.TestFunction(V)
        residual = ufl.inner(u, v) * ufl.dx - ufl.inner(ufl.as_vector((1.0, 0.0)), v) * ufl.dx
        problem = di.StaticProblem(
            u, residual=residual, tangent=ufl.derivative(residual, u), evaluate=lambda u: None,
            accept=lambda u: problem.save(path / "within.h5"),
        )  # fmt: skip
        with pytest.raises(ValueError, match="being solved"):
            problem.solve()
        problem.save(path / "after.h5")
