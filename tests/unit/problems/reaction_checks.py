# SPDX-License-Identifier: MIT
"""Reactions of supports and forces across sections, of problems of every kind, on any number of ranks: checked against
equilibrium. See on_ranks.py."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx.la import InsertMode
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.section_force import _SomeCells

COMM = MPI.COMM_WORLD
LENGTH, LOAD = 2.0, 3.0


class Bar:
    """A cantilever along x, held at x = 0 (tag 1), loaded at its end (tag 2); cells beyond x = 1 have the tag 7, others
    6.
    Facets between them have the tag 3."""

    def __init__(self, cell="quadrilateral", degree=1, law=di.LinearElastic, two=False, **more):
        plane = cell in ("triangle", "quadrilateral")
        self.dim = 2 if plane else 3
        kind = getattr(mesh.CellType, cell)
        if plane:
            self.mesh = mesh.create_rectangle(COMM, [[0, 0], [LENGTH, 0.5]], [8, 3], kind)
        else:
            self.mesh = mesh.create_box(COMM, [[0, 0, 0], [LENGTH, 0.5, 0.4]], [4, 2, 2], kind)
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (self.dim,)))
        tdim = self.dim
        self.mesh.topology.create_connectivity(tdim - 1, tdim)
        places = {1: 0.0, 2: LENGTH, 3: 1.0}
        found = {tag: mesh.locate_entities(self.mesh, tdim - 1, lambda x, a=a: np.isclose(x[0], a))
                 for tag, a in places.items()}  # fmt: skip
        facets = np.concatenate(list(found.values()))
        order = np.argsort(facets)
        values = np.repeat(list(found), [len(f) for f in found.values()]).astype(np.int32)
        self.facets = mesh.meshtags(self.mesh, tdim - 1, facets[order], values[order])
        index_map = self.mesh.topology.index_map(tdim)
        cells = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        middles = mesh.compute_midpoints(self.mesh, tdim, cells)[:, 0]
        self.cells = mesh.meshtags(self.mesh, tdim, cells, np.where(middles > 1.0, 7, 6).astype(np.int32))
        hypothesis = {"hypothesis": "plane_strain"} if plane else {}
        self.material = law(E=1e3, nu=0.3, density=1.0, **hypothesis, **more)
        if two:
            stiff = law(E=4e3, nu=0.2, density=2.0, **hypothesis, **more)
            self.material = di.MaterialMap(self.cells, {6: self.material, 7: stiff})
        self.finite = law in (di.NeoHookean, di.StVenantKirchhoff)
        self.u = fem.Function(self.V, name="displacement")
        held = fem.locate_dofs_topological(self.V, tdim - 1, self.facets.find(1))
        self.support = fem.dirichletbc(np.zeros(self.dim), held, self.V)
        self.section = 0.5 if plane else 0.2
        self.load = np.zeros(self.dim)
        self.load[:2] = 0.4 * LOAD, -LOAD
        self.pull = di.Traction(self.facets, 2, self.load / self.section)

    def applied(self):
        """Force and moment about the origin of the load, from its nodal forces."""
        v = ufl.TestFunction(self.V)
        t = fem.Constant(self.mesh, self.load / self.section)
        ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=self.facets)(2)
        b = fem.assemble_vector(fem.form(ufl.inner(t, v) * ds))
        b.scatter_reverse(InsertMode.add)
        n = self.V.dofmap.index_map.size_local
        forces = b.array[: n * self.dim].reshape(n, self.dim)
        return forces.sum(axis=0), self.moments(forces)

    def moments(self, forces):
        """About the origin; in theory of small strain at undeformed positions."""
        n = len(forces)
        x = self.V.tabulate_dof_coordinates()[:n, : self.dim].copy()
        if self.finite:
            x += self.u.x.array.reshape(-1, self.dim)[:n]
        if self.dim == 2:
            return np.array([np.sum(x[:, 0] * forces[:, 1] - x[:, 1] * forces[:, 0])])
        return np.cross(x, forces).sum(axis=0)


def total(values):
    return COMM.allreduce(np.asarray(values, dtype=float), MPI.SUM)


STATIC = (
    ("quadrilateral", 1, di.LinearElastic, {}),
    ("triangle", 2, di.NeoHookean, {}),
    ("hexahedron", 1, di.StVenantKirchhoff, {}),
    ("tetrahedron", 2, di.LinearElastic, {"two": True}),
    ("quadrilateral", 1, di.J2Plasticity, {"yield_stress": 60.0, "hardening": 100.0}),
    ("quadrilateral", 1, di.J2Plasticity, {"yield_stress": 60.0, "hardening": 100.0, "two": True}),
)


def check_static_reactions_and_sections_are_in_equilibrium():
    """The support, and the section in the middle: force and moment of the load, to what Newton's method leaves."""
    for cell, degree, law, more in STATIC:
        bar = Bar(cell, degree, law, **more)
        problem = di.StaticProblem(bar.u, bar.material, bcs=[bar.support], loads=[bar.pull])
        problem.solve(rtol=1e-13, progress=False)
        force, moment = (total(part) for part in bar.applied())
        size = np.abs(moment).max()
        for reaction in (
            problem.reaction(bar.support), problem.reaction((bar.facets, 1)), problem.reaction()
        ):  # fmt: skip
            np.testing.assert_allclose(reaction.force, -force, rtol=0.0, atol=1e-10 * size)
            np.testing.assert_allclose(reaction.moment, -moment, rtol=0.0, atol=1e-10 * size)
        if law is di.J2Plasticity:
            most = COMM.allreduce(problem.history["plastic_strain"].values.max(initial=0.0), MPI.MAX)
            assert most > 1e-3, "it yields"
        for facets in (None, (bar.facets, 3)):
            # The end hangs on the section, and the root holds it by the opposite.
            end = di.section_force(problem, (bar.cells, 7), facets)
            root = di.section_force(problem, (bar.cells, 6), facets)
            np.testing.assert_allclose(end.force, -force, rtol=0.0, atol=1e-9 * size, err_msg=str((cell, law)))
            np.testing.assert_allclose(end.moment, -moment, rtol=0.0, atol=1e-9 * size, err_msg=str((cell, law)))
            np.testing.assert_allclose(root.force, force, rtol=0.0, atol=1e-9 * size)


def check_materials_of_some_cells_are_those_that_occur():
    bar = Bar(two=True)
    cells = bar.cells.find(7)
    part = mesh.meshtags(bar.mesh, bar.dim, cells, np.full(len(cells), 7, dtype=np.int32))
    some = _SomeCells(part, dict(bar.material.parts()))
    assert [tag for tag, _ in some.parts()] == [7] and some.cell_tags is part
    assert some.hypothesis_on(bar.mesh) == "plane_strain"


def check_moments_are_about_the_point():
    bar = Bar()
    problem = di.StaticProblem(bar.u, bar.material, bcs=[bar.support], loads=[bar.pull])
    problem.solve(progress=False)
    there, origin = problem.reaction(point=(0.5, -0.2)), problem.reaction()
    arm = np.array([0.5, -0.2])
    shift = arm[0] * origin.force[1] - arm[1] * origin.force[0]
    assert there.moment[0] == pytest.approx(origin.moment[0] - shift, rel=1e-12)
    assert there.point.tolist() == [0.5, -0.2] and np.array_equal(there.force, origin.force)


def check_contact_is_a_support_of_the_other_kind():
    """A block that is pressed on a floor by its head: reaction of the head and contact force are opposite."""
    from box_bodies import Boxes

    m = Boxes([((0, 0), (1, 1), (3, 2)), ((0, 1), (1, 2), (4, 2))], "quadrilateral", poisson=0.3)
    tags = m.tags({3: (1, 1, 1.0), 4: (0, 1, 1.0)})
    low, head = m.hold(0, 1, 0.0, 0, 1), m.hold(1, 1, 2.0, 1, value=-0.02)
    bcs = [*low, *head, *m.hold(1, 0, 0.0, 0)]
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, contact=[di.Lagrange(di.ContactPair(tags, 3, 4))])
    problem.solve(progress=False)
    force = problem.contact[0].force
    assert force[1] > 1.0
    np.testing.assert_allclose(problem.reaction(head[0]).force[1], -force[1], rtol=1e-9)
    np.testing.assert_allclose(problem.reaction((m.tags({9: (0, 1, 0.0)}), 9)).force[1], force[1], rtol=1e-9)


def momentum(bar, run):
    """Momentum of the bar with the lumped mass."""
    n = bar.V.dofmap.index_map.size_local * bar.dim
    return total((run.mass.array[:n] * run.velocity.x.array[:n]).reshape(-1, bar.dim).sum(axis=0))


def inertia(bar, run):
    """Rate of this momentum."""
    n = bar.V.dofmap.index_map.size_local * bar.dim
    return total((run.mass.array[:n] * run.acceleration.x.array[:n]).reshape(-1, bar.dim).sum(axis=0))


def check_explicit_reactions_balance_inertia():
    """Of a bar that is drawn at its root and loaded at its end: reaction and load are the rate of momentum, with
    mass-proportional damping its drag, at any time."""
    for damping in (None, di.Rayleigh(2.0, 0.0)):
        bar = Bar()
        drawn = di.PrescribedMotion(
            fem.dirichletbc(np.array([0.01, 0.02]), bar.support.dof_indices()[0][::2] // 2, bar.V),
            lambda t: np.sin(40.0 * t) ** 2,
        )
        run = di.ExplicitProblem(bar.u, bar.material, bcs=[drawn], loads=[bar.pull], damping=damping)
        for until in (0.01, 0.03, 0.05):
            run.advance(until=until, dt=1e-3, progress=False)
            dt, n = 1e-3, bar.V.dofmap.index_map.size_local * bar.dim
            v_before = run.velocity.x.array[:n] - 0.5 * dt * run.acceleration.x.array[:n]
            drag = 2.0 if damping else 0.0
            drag *= total((run.mass.array[:n] * v_before).reshape(-1, 2).sum(axis=0))
            reaction = run.reaction(drawn)
            expected = inertia(bar, run) + drag - bar.load
            size = np.abs(reaction.force).max()
            np.testing.assert_allclose(reaction.force, expected, rtol=0.0, atol=1e-11 * max(size, LOAD))
            assert size > 1.0


def check_explicit_sections_balance_inertia():
    """The end beyond the section: what its other nodes have of inertia and load is what the section bears."""
    bar = Bar()
    run = di.ExplicitProblem(bar.u, bar.material, bcs=[bar.support], loads=[bar.pull])
    run.advance(until=0.03, dt=1e-3, progress=False)
    x = bar.V.tabulate_dof_coordinates()[: bar.V.dofmap.index_map.size_local, 0]
    rates = run.mass.array[: 2 * len(x)].reshape(-1, 2) * run.acceleration.x.array[: 2 * len(x)].reshape(-1, 2)
    beyond = total(rates[x > 1.0 + 1e-9].sum(axis=0))
    section = di.section_force(run, (bar.cells, 7))
    np.testing.assert_allclose(section.force, beyond - bar.load, rtol=0.0, atol=1e-10 * LOAD)
    assert np.abs(section.force).max() > 0.1


def check_explicit_contact_and_support():
    """A block between its support and a floor under it, at rest in the end by damping: both bear its weight."""
    for method in (di.Penalty, di.Kinematic):
        bar = Bar()
        floor = di.RigidPlane((LENGTH, 0.0), (-1.0, 0.0))
        push = di.BodyForce((5.0, 0.0))
        contact = [method(di.ContactPair(bar.facets, 2, floor))]
        run = di.ExplicitProblem(bar.u, bar.material, bcs=[bar.support], loads=[push], contact=contact)
        run.advance(until=0.05, dt=5e-4, progress=False)
        mass = total(run.mass.array[: 2 * bar.V.dofmap.index_map.size_local : 2].sum())
        out = run.reaction().force[0] + run.contact[0].force[0] + 5.0 * mass - inertia(bar, run)[0]
        # Forces of kinematic contact are those of the step before.
        assert abs(out) < (1e-11 if method is di.Penalty else 0.2) * 5.0 * mass


def check_implicit_reactions_balance_inertia():
    for options in ({"lumping": "row_sum"}, {"rho_inf": 0.8}):
        bar = Bar()
        run = di.NewmarkProblem(bar.u, bar.material, bcs=[bar.support], loads=[bar.pull], **options)
        run.advance(until=0.08, dt=2e-3, progress=False)
        a = run.acceleration
        rate = total([fem.assemble_scalar(fem.form(a[c] * ufl.dx)) for c in range(2)])  # of density one
        reaction = run.reaction(bar.support)
        # Newton's method ends at 1e-10 of the forces.
        np.testing.assert_allclose(reaction.force, rate - bar.load, rtol=0.0, atol=1e-8 * LOAD, err_msg=str(options))
        assert np.abs(reaction.force).max() > 0.1


def check_what_is_refused():
    bar = Bar()
    problem = di.StaticProblem(bar.u, bar.material, bcs=[bar.support], loads=[bar.pull])
    other = Bar()
    for call, error, text in (
        (lambda: problem.reaction(3), TypeError, "a DirichletBC, a PrescribedMotion, a pair"),
        (lambda: problem.reaction(other.support), ValueError, "another mesh"),
        (lambda: problem.reaction((bar.cells, 7)), ValueError, "facets"),
        (lambda: problem.reaction(point=(0.0,)), ValueError, "2 finite numbers"),
        (lambda: di.section_force(problem, (bar.cells, 9)), ValueError, "no cell has the tag 9"),
        (lambda: di.section_force(problem, (bar.facets, 3)), ValueError, "cells"),
        (lambda: di.section_force(problem, bar.cells), TypeError, "a pair of MeshTags"),
        (lambda: di.section_force(problem, (bar.cells, 7), (bar.facets, 1)), ValueError, "no node on the section"),
    ):
        with pytest.raises(error, match=text):
            call()
