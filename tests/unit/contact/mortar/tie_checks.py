# SPDX-License-Identifier: MIT
"""Surfaces that are tied to each other; docs/tie.md. See on_ranks.py: cells are scattered over the ranks."""

import itertools

import numpy as np
import pytest
import ufl
from box_bodies import Boxes
from dolfinx import fem
from mpi4py import MPI
from shared_folder import shared_folder
from tied_boxes import (
    BOTTOM,
    MASTER,
    SLAVE,
    TOP,
    boxes,
    curve,
    largest_error,
    linear,
    outside,
    pair,
    prescribe,
    tie,
)

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact.contact.explicit.tied import ExplicitTie
from dolfinx_impact.contact.mortar.tie import TieContact

COMM = MPI.COMM_WORLD
CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
# Uniform states are in the spaces of displacements and tractions: what is left is round-off of a direct solution.
PATCH = 1e-12
# Sums of some hundred terms of order one over two hundred steps.
ROUND_OFF = 1e-13
# Newton's method solves for forces to 1e-10 of the largest.
BALANCED = 1e-9


def owned(m):
    return m.V.dofmap.index_map.size_local * m.dim


def largest(m, values):
    return m.mesh.comm.allreduce(float(np.abs(values).max(initial=0.0)), MPI.MAX)


def on_these_ranks(rows):
    """All rows on one rank, two of them on several: they differ in nothing but the cells."""
    rows = list(rows)
    return rows if COMM.size == 1 else [rows[1], rows[-2]]


def explicit_law(m):
    return di.NeoHookean(1000.0, 0.3, density=1.0, hypothesis="plane_strain" if m.dim == 2 else "3d")


def spinning(m, rate=3.0):
    """Velocity of a rigid motion: translation, and spin about the third axis."""
    v = fem.Function(m.V)
    flight = np.array([1.0, 0.5, -0.2])[: m.dim]

    def field(x):
        out = np.zeros((m.dim, x.shape[1]))
        out[0], out[1] = -rate * x[1], rate * x[0]
        return out + flight[:, None]

    v.interpolate(field)
    return v


def momenta(m, problem):
    """Momentum, and moment of momentum about the third axis."""
    mass = problem.mass.array[: owned(m)].reshape(-1, m.dim)
    v = problem.velocity.x.array[: owned(m)].reshape(-1, m.dim)
    x = m.V.tabulate_dof_coordinates()[: len(v), : m.dim] + m.u.x.array[: owned(m)].reshape(-1, m.dim)
    angular = (mass[:, 0] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])).sum()
    return m.sum((mass * v).sum(axis=0)), float(m.sum(angular))


# --- static ----------------------------------------------------------------------------------------------------------


def check_linear_fields_pass():
    """Patch test: the outer boundary moves linearly, with nodes of both surfaces among the supports."""
    for cell, degree, turn in on_these_ranks(itertools.product(CELLS, (1, 2), (0.0, 0.3))):
        m = boxes(cell, degree=degree, turn=turn)
        field = linear(m.dim)
        problem = di.StaticProblem(m.u, m.law, bcs=prescribe(m, field), contact=[tie(m)])
        problem.solve(progress=False)
        assert largest_error(m, field) < PATCH, (cell, degree, turn)


def check_bases_that_stay_in_the_system_pass_too():
    """Pulled between planes of symmetry, so that every facet has a free corner."""
    for cell, basis in (("triangle", "standard"), ("tetrahedron", "linear")):
        m = boxes(cell, degree=2)
        up = m.dim - 1
        bcs = m.hold(0, up, 0.0, up)
        for axis in range(up):
            bcs += m.hold(0, axis, 0.0, axis) + m.hold(1, axis, 0.0, axis)
        problem = di.StaticProblem(
            m.u, m.law, bcs=bcs, contact=[tie(m, basis=basis)],
            loads=[di.Traction(m.tag, TOP, tuple(np.eye(m.dim)[up]))],
        )  # fmt: skip
        problem.solve(progress=False)
        # E = 1000, nu = 0.3; plane strain in the plane.
        strain = np.full(m.dim, -0.3 * (1.3 if m.dim == 2 else 1.0)) / 1000.0
        strain[up] = (1.0 - 0.3**2 if m.dim == 2 else 1.0) / 1000.0
        assert largest_error(m, lambda x: strain[:, None] * x[: m.dim]) < PATCH, (cell, basis)


def pulled(cell, degree=1, options=None, force=1.0, **given):
    """The upper box is held by the tie alone and pulled upwards and sideways."""
    m = boxes(cell, degree=degree, **given)
    load = np.array([0.3, 0.0, 1.0]) if m.dim == 3 else np.array([0.3, 1.0])
    load = force * (load @ m.axes)
    bcs = m.hold(0, m.dim - 1, 0.0, *range(m.dim))
    problem = di.StaticProblem(
        m.u, m.law, bcs=bcs, loads=[di.Traction(m.tag, TOP, tuple(load))], contact=[tie(m)], options=options
    )
    return m, problem, load


def check_a_tie_alone_holds_a_body():
    for cell, degree in on_these_ranks(itertools.product(CELLS, (1, 2))):
        m, problem, load = pulled(cell, degree)
        problem.solve(progress=False)
        c = problem.contact[0]
        assert np.allclose(c.force, -load, atol=BALANCED), (cell, degree)  # the master holds it
        assert np.allclose(m.support(problem), -load, atol=BALANCED)
        assert m.imbalance(problem) < BALANCED
        assert abs(c.area - 1.0) < 1e-12 and np.all(c.status == di.ContactStatus.stick)
        assert isinstance(c, TieContact)
        # Tractions are forces per area; the tie pulls: pressures are negative.
        assert np.allclose(m.sum((c.traction * c.weight[:, None]).sum(axis=0)), -load, atol=BALANCED)
        assert np.allclose(c.pressure, np.einsum("ij,ij->i", c.traction, c.normal), atol=1e-14)
        assert float(m.sum((c.pressure * c.weight).sum())) < -0.99
        assert largest(m, c.gap) < 1e-12 and largest(m, c.slip) == 0.0
        assert largest(m, c._cpp_object.conditions.jump(m.u.x.array[: owned(m)])) < 1e-14


def check_iterative_solvers_serve():
    m, problem, load = pulled("hexahedron", options={"ksp_type": "cg", "pc_type": "gamg", "ksp_rtol": 1e-12})
    problem.solve(progress=False)
    assert np.allclose(problem.contact[0].force, -load, atol=BALANCED)
    with pytest.raises(ValueError, match="saddle point"):  # another basis stays in the system
        di.StaticProblem(m.u, m.law, contact=[tie(m, basis="standard")], options={"ksp_type": "cg", "pc_type": "gamg"})


def check_ties_along_the_normal_let_slide():
    for cell, turn in on_these_ranks(itertools.product(("quadrilateral", "triangle", "hexahedron"), (0.0, 0.4))):
        m = boxes(cell, turn=turn, poisson=0.0)
        t = tie(m, directions="normal")
        up, along = np.eye(m.dim)[-1] @ m.axes, np.eye(m.dim)[0] @ m.axes
        problem = di.StaticProblem(
            m.u, m.law, bcs=m.hold(0, m.dim - 1, 0.0, *range(m.dim)), contact=[t],
            loads=[di.Traction(m.tag, TOP, tuple(up))],
        )  # fmt: skip
        with pytest.raises(RuntimeError, match="not held against rigid motion"):
            problem.solve(progress=False)
        # Slide the top by 0.1: nothing resists, and the normal force is that of the stretch alone.
        dofs = fem.locate_dofs_topological(m.V, m.dim - 1, m.tag.find(TOP))
        m.u = fem.Function(m.V)
        lifted = fem.Function(m.V)
        lifted.interpolate(lambda x: np.tile((0.1 * along + 0.002 * up)[:, None], x.shape[1]))
        problem = di.StaticProblem(
            m.u, m.law, bcs=[*m.hold(0, m.dim - 1, 0.0, *range(m.dim)), fem.dirichletbc(lifted, dofs)], contact=[t]
        )
        problem.solve(progress=False)
        c = problem.contact[0]
        # Two unit cubes in a row, stretched by 0.002 in all, without lateral strain: E = 1000.
        assert abs(c.force @ up + 1.0) < 1e-6 and abs(c.force @ along) < 1e-9, (cell, turn, c.force)


def check_rigid_motions_give_no_force_on_curved_joints():
    """The joint is a polygon on one side and another one on the other: they do not lie on each other."""
    for cell in ("quadrilateral", "tetrahedron") if COMM.size == 1 else ("tetrahedron",):
        m = boxes(cell, slave=5, master=3)
        curve(m)
        shift = np.array([0.3, -0.2, 0.1])[: m.dim]
        bcs = prescribe(m, lambda x: np.tile(shift[:, None], x.shape[1]))
        problem = di.StaticProblem(m.u, m.law, bcs=bcs, contact=[tie(m)])
        problem.solve(progress=False)
        assert largest_error(m, lambda x: np.tile(shift[:, None], x.shape[1])) < PATCH
        # What the surfaces are apart is told, and removed where it is asked for: rotations give no force then either.
        spec = tie(m)
        assert largest(m, problem.contact[0].offset) > 1e-4
        told = spec.adjust(m.V)
        assert told.number > 0 and 1e-4 < told.largest < 0.1  # [L]
        turn = linear(m.dim)(np.eye(m.dim))
        turn = turn - turn.T
        m.u.x.array[:] = 0.0
        turned = fem.Function(m.V)
        turned.interpolate(lambda x: turn @ x[: m.dim])
        ends = fem.locate_dofs_topological(m.V, m.dim - 1, np.concatenate([m.tag.find(TOP), m.tag.find(BOTTOM)]))
        problem = di.StaticProblem(m.u, m.law, bcs=[fem.dirichletbc(turned, ends)], contact=[spec])
        problem.solve(progress=False)
        assert largest(m, problem.contact[0].offset) < 1e-13
        assert largest_error(m, lambda x: turn @ x[: m.dim]) < PATCH


def check_ties_meet_contacts_and_each_other():
    """A block is tied to one of two blocks that it stands on, and presses on the other, then is tied to both; the two
    stand side by side, tied to each other, so that three bodies meet at a corner."""
    for cell in ("quadrilateral",) if COMM.size > 1 else ("quadrilateral", "hexahedron"):
        dim = 2 if cell == "quadrilateral" else 3
        at = (lambda *x: x) if dim == 2 else (lambda *x: (x[0], 0.0, x[1]))
        to = (lambda *x: x) if dim == 2 else (lambda *x: (x[0], 1.0, x[1]))
        n = (lambda *x: x) if dim == 2 else (lambda *x: (x[0], 2, x[1]))
        up = dim - 1
        for case in ("contact", "ties", "corner"):
            m = Boxes(
                [(at(0, 0), to(1, 1), n(2, 2)), (at(1, 0), to(2, 1), n(3, 3)), (at(0, 1), to(2, 2), n(5, 2))], cell
            )
            tags = m.tags({
                1: (0, up, 1.0), 2: (1, up, 1.0), 3: (2, up, 1.0), 5: (2, up, 2.0), 6: (0, 0, 1.0), 7: (1, 0, 1.0),
            })  # fmt: skip
            second = di.ContactPair(tags, slave=3, master=2, name="second")
            contact = [di.Tie(di.ContactPair(tags, slave=3, master=1, name="first"), partial=True)]
            contact += [di.Lagrange(second) if case == "contact" else di.Tie(second, partial=True)]
            bcs = m.hold(0, up, 0.0, up) + m.hold(0, 0, 0.0, 0)
            bcs += m.hold(1, up, 0.0, *((up,) if case == "corner" else range(dim)))
            if dim == 3:
                bcs += m.hold(0, 1, 0.0, 1) + m.hold(1, 1, 0.0, 1) + m.hold(2, 1, 0.0, 1)
            if case == "corner":
                contact.append(di.Tie(di.ContactPair(tags, slave=7, master=6, name="third")))
            load = np.eye(dim)[up] * (-1.0 if case == "contact" else 1.0)
            problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[di.Traction(tags, 5, tuple(load))], contact=contact)
            problem.solve(progress=False)
            forces = sum(c.force for c in problem.contact[:2])
            assert np.allclose(forces + 2.0 * load, 0.0, atol=1e-8), (cell, case, forces)
            assert m.imbalance(problem) < BALANCED
            strain = load[up] / 1000.0  # uniform, without lateral strain: Poisson's ratio is zero
            assert abs(m.lowest(up) - min(2.0 * strain, 0.0)) < 1e-11 or case == "contact"


def check_chains_of_ties():
    """Four blocks in a row: surfaces of the middle ones are masters and slaves."""
    m = Boxes([((k, 0.0), (k + 1.0, 1.0), (2, n)) for k, n in enumerate((3, 2, 4, 3))], "triangle")
    tags = m.tags({2 * k + s: (k, 0, float(k + s)) for k in range(4) for s in (0, 1)})
    ties = [di.Tie(di.ContactPair(tags, slave=2 * k + 2, master=2 * k + 1)) for k in range(3)]
    problem = di.StaticProblem(
        m.u, m.law, bcs=m.hold(0, 0, 0.0, 0, 1), loads=[di.Traction(tags, 7, (1.0, 0.0))], contact=ties,
        options={"ksp_type": "cg", "pc_type": "lu", "ksp_rtol": 1e-12},  # no node belongs to two ties: no saddle point
    )  # fmt: skip
    problem.solve(progress=False)
    assert all(np.allclose(c.force, (-1.0, 0.0), atol=BALANCED) for c in problem.contact)


def check_finite_strain():
    """Ties hold from the reference configuration on: a body that turns by a right angle takes its tie along."""
    m = boxes("quadrilateral")
    law = explicit_law(m)
    c, s = np.cos(0.5 * np.pi), np.sin(0.5 * np.pi)
    turn = np.array([[c, -s], [s, c]]) @ np.diag([1.1, 0.95]) - np.eye(2)
    problem = di.StaticProblem(m.u, law, bcs=prescribe(m, lambda x: turn @ x[:2]), contact=[tie(m)])
    m.u.interpolate(lambda x: turn @ x[:2])
    m.u.x.array[:] += 1e-3 * np.sin(np.arange(len(m.u.x.array)))
    m.u.x.scatter_forward()
    problem.solve(progress=False)
    assert largest_error(m, lambda x: turn @ x[:2]) < 1e-11  # quadratic convergence ends at 1e-10 of the forces
    assert np.allclose(problem.contact[0].normal, (-1.0, 0.0), atol=1e-9)  # out of the master, turned with it


def check_the_order_of_convergence():
    """A smooth solution in tied boxes: errors of the strain fall with the degree, as in one mesh."""
    for cell, degree, curved in (("quadrilateral", 1, True), ("triangle", 2, False)):
        errors = []
        for n in (2, 4):
            m = boxes(cell, slave=3 * n, master=2 * n, degree=degree, layers=2 * n)
            if curved:
                curve(m, 0.1)
            x = ufl.SpatialCoordinate(m.mesh)
            exact = 0.01 * ufl.as_vector([ufl.sin(2 * x[0]) * ufl.cos(1.5 * x[1]), ufl.cos(x[0]) * ufl.sin(2 * x[1])])
            v, dx = ufl.TestFunction(m.V), ufl.dx(metadata={"quadrature_degree": 2 * degree + 4})

            def strain(u):
                return ufl.sym(ufl.grad(u))

            residual = ufl.inner(strain(m.u), strain(v)) * dx + ufl.inner(ufl.div(strain(exact)), v) * dx
            boundary = fem.Function(m.V)
            boundary.interpolate(fem.Expression(exact, compat.interpolation_points(m.V)))
            dofs = fem.locate_dofs_topological(m.V, 1, outside(m))
            problem = di.StaticProblem(
                m.u, residual=residual, hypothesis="plane_strain", bcs=[fem.dirichletbc(boundary, dofs)],
                contact=[tie(m)],
            )  # fmt: skip
            problem.solve(progress=False)
            off = strain(m.u - exact)
            errors.append(float(np.sqrt(m.sum(fem.assemble_scalar(fem.form(ufl.inner(off, off) * dx))))))
        # Measured: 1.00 and 1.95; the orders of one mesh are 1.00 and 1.96.
        assert abs(np.log2(errors[0] / errors[1]) - degree) < 0.1, (cell, degree, errors)


# --- in time ---------------------------------------------------------------------------------------------------------


def check_explicit_ties_keep_momentum():
    """A free body of two halves spins, flies and vibrates; springs store nothing, and no energy is lost."""
    for cell, degree in on_these_ranks(itertools.product(CELLS, (1, 2))):
        m = boxes(cell, degree=degree, slave=3, master=2)
        problem = di.ExplicitProblem(m.u, explicit_law(m), velocity=spinning(m), contact=[tie(m)])
        assert problem._cpp_object.lost_at_start < 1e-15
        (before, spin), energy = momenta(m, problem), problem.energy["total"]
        problem.advance(until=60 * problem.stable_step(), progress=False)
        after, spun = momenta(m, problem)
        assert np.abs(after - before).max() < ROUND_OFF * np.abs(before).max(), (cell, degree)
        assert abs(spun - spin) < ROUND_OFF * abs(spin), (cell, degree)
        assert abs(problem.energy["total"] - energy) < ROUND_OFF * energy
        assert largest(m, problem.contact[0].tie.conditions.jump(m.u.x.array[: owned(m)])) < 1e-14
        assert isinstance(problem.contact[0], ExplicitTie)
        assert np.linalg.norm(problem.contact[0].force) > 1e-3  # centripetal


def check_the_stable_step_is_not_smaller():
    """Constraints interlace frequencies: a run at 0.99 of the bodies' own limit stays bounded."""
    m = boxes("quadrilateral")
    alone = di.ExplicitProblem(fem.Function(m.V), m.law).stable_step("eigenvalue")
    noise = fem.Function(m.V)
    x = m.V.tabulate_dof_coordinates()
    noise.x.array[:] = np.sin(37.0 * x[:, 0] + 11.0 * x[:, 1]).repeat(2)
    problem = di.ExplicitProblem(m.u, m.law, velocity=noise, contact=[tie(m)])
    assert problem.stable_step("eigenvalue") == pytest.approx(alone, rel=1e-9)
    assert problem._cpp_object.lost_at_start > 0.0  # this velocity contradicts the tie: it is projected
    energy = problem.energy["total"]
    problem.advance(until=0.99 * alone * 400, dt=0.99 * alone, unsafe=True, progress=False)  # beyond the cells' bound
    assert abs(problem.energy["total"] - energy) < 1e-10 * energy


def check_waves_pass():
    """A pulse along two bars that are tied end to end, with cells that do not match across the joint."""
    m = Boxes([((0.0, 0.0), (1.0, 0.1), (80, 2)), ((1.0, 0.0), (2.0, 0.1), (80, 3))], "quadrilateral", poisson=0.0)
    tags = m.tags({3: (1, 0, 1.0), 4: (0, 0, 1.0)})
    v = fem.Function(m.V)
    c = np.sqrt(1000.0)

    def pulse(s):
        return np.where(np.abs(s - 0.5) < 0.2, np.cos(2.5 * np.pi * (s - 0.5)) ** 2, 0.0)

    m.u.interpolate(lambda x: np.array([-pulse_integral(x[0]) / c, 0.0 * x[0]]))
    v.interpolate(lambda x: np.array([pulse(x[0]), 0.0 * x[0]]))
    problem = di.ExplicitProblem(m.u, m.law, velocity=v, contact=[di.Tie(di.ContactPair(tags, slave=3, master=4))])
    problem.advance(until=1.0 / c, progress=False)
    arrived = fem.Function(m.V)
    arrived.interpolate(lambda x: np.array([pulse(x[0] - 1.0), 0.0 * x[0]]))
    off = problem.velocity.x.array[: owned(m)] - arrived.x.array[: owned(m)]
    assert largest(m, off) < 0.02  # dispersion of 32 cells to the pulse; nothing is reflected


def pulse_integral(x):
    """Integral of the pulse: a wave to the right has the velocity -c du/dx."""
    s = np.clip(x - 0.5, -0.2, 0.2)
    return 0.5 * s + np.sin(5.0 * np.pi * s) / (10.0 * np.pi)


def check_supports_at_tied_nodes_do_work():
    """The master's surface is prescribed to move: what its supports give the other body is external work."""
    m = boxes("quadrilateral")
    up = fem.Function(m.V)
    up.interpolate(lambda x: np.array([0.0 * x[0], 1.0 + 0.0 * x[0]]))
    dofs = fem.locate_dofs_topological(m.V, 1, np.concatenate([m.tag.find(MASTER), m.tag.find(BOTTOM)]))
    bc = di.PrescribedMotion(fem.dirichletbc(up, dofs), lambda t: 0.01 * (1.0 - np.cos(20.0 * t)))
    problem = di.ExplicitProblem(m.u, m.law, bcs=[bc], contact=[tie(m)])
    problem.advance(until=0.1, progress=False)
    e = problem.energy
    given = e["kinetic"] + e["internal"]
    assert given > 1e-4 and e["impact"] == 0.0
    # Central differences keep the sum of energies up to terms of the square of the step.
    assert abs(given - e["external"]) < 1e-2 * given, e


def check_implicit_ties_conserve():
    """The trapezoidal rule with consistent accelerations at the start: conditions hold in all three rates."""
    for cell in ("quadrilateral", "tetrahedron") if COMM.size == 1 else ("quadrilateral",):
        m = boxes(cell)
        v = fem.Function(m.V)
        v.interpolate(lambda x: np.vstack([0.0 * x[: m.dim - 1], -0.01 * np.cos(np.pi * (x[m.dim - 1] - 1.0))]))
        problem = di.NewmarkProblem(m.u, m.law, velocity=v, contact=[tie(m)])
        energy = problem.energy["total"]
        problem.advance(until=0.2, dt=0.01, progress=False)
        assert abs(problem.energy["total"] - energy) < 1e-11 * energy
        jump = problem.contact[0]._cpp_object.conditions.jump
        for f in (m.u, problem.velocity, problem.acceleration):
            assert largest(m, jump(f.x.array[: owned(m)])) < 1e-10 * largest(m, f.x.array)
        assert np.linalg.norm(problem.contact[0].force) > 1e-3


def check_static_states_go_on_in_time():
    """A load that a tie bears at rest: the explicit run from the equilibrium stays there."""
    m, static, load = pulled("quadrilateral")
    static.solve(progress=False)
    problem = di.ExplicitProblem.from_static(static, bcs=static.bcs, loads=static.loads, contact=[tie(m)])
    problem.advance(until=50 * problem.stable_step(), progress=False)
    assert largest(m, problem.velocity.x.array) < 1e-9
    assert np.allclose(problem.contact[0].force, -load, atol=1e-8)


# --- restart ---------------------------------------------------------------------------------------------------------


def check_runs_go_on():
    """Static, explicit and implicit problems go on from checkpoints as if never stopped."""
    with shared_folder(COMM) as folder:
        m, static, _ = pulled("quadrilateral")
        static.solve(progress=False)
        static.save(folder / "static.h5")
        force, traction = np.array(static.contact[0].force), static.contact[0].traction.copy()
        again, other, _ = pulled("quadrilateral")
        other.restore(folder / "static.h5")
        assert np.array_equal(other.contact[0].force, force) and np.array_equal(other.contact[0].traction, traction)

        def explicit():
            m = boxes("quadrilateral")
            return m, di.ExplicitProblem(m.u, explicit_law(m), velocity=spinning(m), contact=[tie(m)])

        def implicit():
            m = boxes("quadrilateral")
            v = fem.Function(m.V)
            v.interpolate(lambda x: np.array([0.0 * x[0], 0.01 * x[1]]))
            return m, di.NewmarkProblem(m.u, m.law, velocity=v, contact=[tie(m)])

        for make, dt in ((explicit, "auto"), (implicit, 0.01)):
            m, problem = make()
            problem.advance(until=0.05, dt=dt, progress=False)
            problem.save(folder / f"{make.__name__}.h5")
            kept = problem.contact[0].traction.copy()
            problem.advance(until=0.1, dt=dt, progress=False)
            again, other = make()
            other.restore(folder / f"{make.__name__}.h5")
            assert np.array_equal(other.contact[0].traction, kept)
            other.advance(until=0.1, dt=dt, progress=False)
            same = np.array_equal if COMM.size == 1 else lambda a, b: np.allclose(a, b, rtol=1e-9, atol=1e-12)
            assert same(again.u.x.array[: owned(m)], m.u.x.array[: owned(m)]), make.__name__
            assert same(other.contact[0].force, problem.contact[0].force)


# --- refusals --------------------------------------------------------------------------------------------------------


def check_nodes_without_a_master_are_named():
    """The slave is wider than the master."""
    m = Boxes([((0.0, 0.0), (1.0, 1.0), (2, 2)), ((0.0, 1.0), (2.0, 2.0), (6, 2))], "quadrilateral")
    tags = m.tags({3: (1, 1, 1.0), 4: (0, 1, 1.0)})
    p = di.ContactPair(tags, slave=3, master=4, name="joint")
    with pytest.raises(
        ValueError, match=r"joint: 3 of 7 slave nodes have no master .* \[\[1\.333333333, 1\.0\], .*partial"
    ):
        di.StaticProblem(m.u, m.law, contact=[di.Tie(p)])
    free = di.StaticProblem(m.u, m.law, bcs=m.hold(0, 1, 0.0, 0, 1), contact=[di.Tie(p, partial=True)])
    assert free.contact[0].num_free == 3 and int(m.sum(len(free.contact[0].nodes))) == 4
    with pytest.raises(ValueError, match="none of the 7 slave nodes has a master"):
        far = Boxes([((0.0, 0.0), (1.0, 1.0), (2, 2)), ((0.0, 9.0), (2.0, 10.0), (6, 2))], "quadrilateral")
        tags = far.tags({3: (1, 1, 9.0), 4: (0, 1, 1.0)})
        di.StaticProblem(far.u, far.law, contact=[di.Tie(di.ContactPair(tags, slave=3, master=4), partial=True)])


def check_what_ties_do_not_take():
    m = boxes("quadrilateral")
    plane = di.RigidPlane(point=(0.0, 0.0), normal=(0.0, 1.0))
    for given, sentence in (
        (di.ContactPair(m.tag, SLAVE, plane), "needs a surface of the mesh"),
        (pair(m, friction=0.1), "do not rub"),
        (pair(m, remove_penetration=True), "remove_penetration is of contacts"),
        (pair(m, smooth=True), "leave smooth out"),
    ):
        with pytest.raises(ValueError, match=sentence):
            di.Tie(given)
    for options, sentence in ((dict(directions="x"), "directions is 'x'"), (dict(basis="x"), "basis is 'x'")):
        with pytest.raises(ValueError, match=sentence):
            tie(m, **options)
    with pytest.raises(TypeError, match="ContactPair"):
        di.Tie(3)
    back = di.Tie(di.ContactPair(m.tag, slave=MASTER, master=SLAVE))
    for make in (di.StaticProblem, di.ExplicitProblem):
        m.u = fem.Function(m.V)
        with pytest.raises(ValueError, match="the slave of each is the master of the other"):
            make(m.u, m.law, contact=[tie(m), back])
        m.u = fem.Function(m.V)
        with pytest.raises(ValueError, match="tie the same surfaces twice"):
            make(m.u, m.law, contact=[tie(m), tie(m)])
    m.u = fem.Function(m.V)
    m.u.interpolate(lambda x: np.array([0.1 * (x[1] > 1.0), 0.0 * x[0]]) + 0.01 * x[:2] ** 2)
    with pytest.raises(ValueError, match="moves tied surfaces apart"):
        di.ExplicitProblem(m.u, m.law, contact=[tie(m)])
    assert "directions='normal'" in repr(tie(m, directions="normal"))
