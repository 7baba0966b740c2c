# SPDX-License-Identifier: MIT
"""Laws of friction in problems, on one rank and on several: tractions, motions, restart."""

import functools
import itertools
import tempfile
from pathlib import Path

import dolfinx_impact as di
import numpy as np
import pytest
import ufl
from blocks import BOTTOM, TOP, Blocks
from dolfinx import fem, mesh
from dolfinx_impact import interface
from mpi4py import MPI
from over_ranks import largest

CASES = {
    "quadrilateral": ((3, 2), (4, 2), 1), "triangle": ((3, 2), (4, 2), 2), "hexahedron": ((2, 2, 2), (3, 3, 1), 1),
}  # fmt: skip


def steel(dim):
    return di.LinearElastic(E=1e3, nu=0.2, density=1.0, hypothesis="3d" if dim == 3 else "plane_strain")


def temperatures(V):
    """A field that falls along the upper block, from 30 degrees at x = 0 to 10 at x = 1, where the lower one is."""
    T = fem.Function(fem.functionspace(V.mesh, ("Lagrange", V.element.basix_element.degree)))
    T.interpolate(lambda x: 10.0 + 20.0 * (1.0 - x[0]) * (x[V.mesh.geometry.dim - 1] > 1.0 + 5e-4))
    return T


def of_both(pressure, fields, parameters):
    """A coefficient of pressure and of the temperatures of both sides."""
    return parameters.mu * (1 + pressure / 50.0) ** (-0.3) + 0.004 * fields.T_slave + 0.002 * fields.T_master


def dragged(cell, basis="dual", rigid=False):
    """An upper block, pressed down and dragged sideways at its top, on a lower one or on a plane."""
    lower, upper, degree = CASES[cell]
    gap = 0.001  # the halves of the mesh are told apart by it
    blocks = Blocks(cell, lower, upper, gap=gap, degree=degree, narrow=0.1)
    T = temperatures(blocks.V)
    law = di.FrictionLaw(of_both, fields={"T": T}, parameters={"mu": 0.1})
    dim = blocks.dim
    top = fem.locate_dofs_topological(blocks.V, dim - 1, blocks.tags.find(TOP))
    drag = fem.Function(blocks.V)
    bcs = [*blocks.held(BOTTOM, *range(dim)), fem.dirichletbc(drag, top)]
    pair = blocks.pair(friction=law)
    if rigid:
        plane = di.RigidPlane(np.eye(dim)[-1], np.eye(dim)[-1])
        pair = di.ContactPair(blocks.tags, 3, plane, friction=law)
    problem = di.StaticProblem(blocks.u, steel(dim), bcs=bcs, contact=[di.Lagrange(pair, basis=basis)])
    for move in (np.eye(dim)[-1] * -0.02, np.eye(dim)[-1] * -0.02 + np.eye(dim)[0] * 0.1):
        drag.x.array.reshape(-1, dim)[top] = move
        assert problem.solve(steps=2).converged
    return blocks, T, problem


def check_tractions_of_pressure_and_fields():
    """Everywhere it slips: the friction traction is the law's, of the nodal pressure and temperatures."""
    cases = [("quadrilateral", "dual", False), ("quadrilateral", "standard", False), ("triangle", "dual", True),
             ("hexahedron", "dual", False)]  # fmt: skip
    for cell, basis, rigid in cases:
        blocks, T, problem = dragged(cell, basis, rigid)
        contact = problem.contact[0]
        p, t = contact.pressure, contact.traction
        shear = np.linalg.norm(t - p[:, None] * contact.normal, axis=1)
        slips = contact.status == di.ContactStatus.slip
        if basis == "standard":  # means by shape functions: at the ends of the slave they are not the nodes' values
            slips &= np.abs(contact.points[:, 0] - 0.6) < 0.3
        assert MPI.COMM_WORLD.allreduce(int(slips.sum())) >= 3
        warm = T.x.array[contact.nodes]
        cold = 0.0 if rigid else 10.0  # a plane has no temperature
        mu = 0.1 * (1 + p / 50.0) ** (-0.3) + 0.004 * warm + 0.002 * cold
        off = np.abs(shear - mu * p)[slips]
        assert largest(np.array([off.max(initial=0.0)])) < 1e-5 * largest(np.array([(mu * p).max(initial=0.0)])), cell
        assert np.allclose(contact.friction_coefficient[slips], mu[slips], rtol=1e-5)


SPEED, LOAD, HEIGHT, E = 0.2, 1.0, 0.25, 500.0


def exact(of_velocity, end, h=1e-3):
    """A rigid block of mass one on a floor that moves, held by a spring of stiffness one."""
    x, v, sticks, out = 0.0, 0.0, False, []
    for _ in range(round(end / h) + 1):
        out.append(x)
        w = SPEED if sticks else v + h * (LOAD * of_velocity(abs(SPEED - v)) * np.sign(SPEED - v) - x)
        x += 0.5 * h * (v + w)
        sticks, v = (sticks or v < SPEED <= w) and x < of_velocity(0.0) * LOAD, w
    return h * np.arange(len(out)), np.array(out)


@functools.cache
def flat():
    """One mesh for all blocks that are compared: DOLFINx may partition a second one otherwise."""
    return mesh.create_rectangle(MPI.COMM_WORLD, [[0.0, 0.0], [1.0, HEIGHT]], [2, 1], mesh.CellType.quadrilateral)


def block(kind, law=None):
    """A flat block on a moving floor, whose friction falls with the slip velocity."""
    domain = flat()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    sides = [mesh.locate_entities_boundary(domain, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, HEIGHT)]
    facets, values = np.concatenate(sides), np.repeat([1, 2], [len(s) for s in sides]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, 1, facets[order], values[order])
    u = fem.Function(V)
    u.interpolate(lambda x: np.vstack([0 * x[0], -LOAD / E * x[1]]))
    floor = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    floor.motion = lambda t: (SPEED * t, 0.0, 0.0)
    pair = di.ContactPair(tags, 1, floor, friction=law or interface.falling_friction(0.5, 0.2, 0.3))
    method = di.Kinematic if kind is di.ExplicitProblem else di.Lagrange
    return kind(
        u, di.LinearElastic(E, 0.0, density=1.0 / HEIGHT, hypothesis="plane_strain"), contact=[method(pair)],
        loads=[di.Foundation(tags, 1, (1.0, 0.0)), di.Traction(tags, 2, (0.0, -LOAD))], damping=di.Rayleigh(0.0, 2e-3),
    )  # fmt: skip


def mean_place(problem):
    V = problem.u.function_space
    owned = problem.u.x.array[: 2 * V.dofmap.index_map.size_local : 2].sum()
    return MPI.COMM_WORLD.allreduce(owned) / V.dofmap.index_map.size_global


def deviation(kind, end, **steps):
    """Largest distance of the block from the rigid one; it sticks from 2 s on and slips back after 3.6 s."""
    t, place = exact(lambda v: 0.2 + 0.3 * np.exp(-v / 0.3), end)
    problem, rows = block(kind), []
    problem.advance(end, callback=lambda p: rows.append((p.time, mean_place(p))), progress=False, **steps)
    times, found = np.array(rows).T
    return np.abs(found - np.interp(times, t, place)).max()


def check_stick_slip_explicit():
    """The coefficient is that of the last step: of first order in the step, which is 0.02 (seen: 0.0011)."""
    assert deviation(di.ExplicitProblem, 6.0) < 0.003


def check_restart():
    """A run goes on to the bit from a checkpoint in the phase of slip, explicit and implicit."""
    with tempfile.TemporaryDirectory() as folder:
        path = MPI.COMM_WORLD.bcast(Path(folder) / "block.h5", root=0)
        for kind, steps in ((di.ExplicitProblem, {}), (di.NewmarkProblem, {"dt": 0.1})):
            whole, other = block(kind), block(kind)
            whole.advance(1.0, progress=False, **steps)
            whole.save(path)
            other.restore(path)
            for problem in (whole, other):
                problem.advance(1.6, progress=False, **steps)
            assert np.array_equal(whole.u.x.array, other.u.x.array), kind
        MPI.COMM_WORLD.barrier()


def thrown(blocks, rigid):
    """A block that is thrown down and sideways, with kinematic friction of pressure, velocity and temperatures."""

    def coefficient(pressure, slip_rate, fields, parameters):
        return of_both(pressure, fields, parameters) / (1 + ufl.sqrt(ufl.dot(slip_rate, slip_rate) + 1e-6))

    dim = blocks.dim
    law = di.FrictionLaw(coefficient, fields={"T": temperatures(blocks.V)}, parameters={"mu": 0.3})
    pair = blocks.pair(friction=law)
    if rigid:
        up = np.eye(dim)[-1]
        pair = di.ContactPair(blocks.tags, pair.slave, di.RigidPlane(up, up), friction=law)
    velocity = fem.Function(blocks.V)
    cells = np.arange(len(blocks.V.dofmap.list), dtype=np.int32)
    above = mesh.compute_midpoints(blocks.mesh, dim, cells)[:, dim - 1] > 1.0
    nodes = np.unique(blocks.V.dofmap.list[cells[above]])
    velocity.x.array.reshape(-1, dim)[nodes] = (1.5, 0.4, -1.0) if dim == 3 else (1.5, -1.0)
    return di.ExplicitProblem(blocks.u, steel(dim), velocity=velocity, bcs=blocks.held(BOTTOM, *range(dim)),
                              contact=[di.Kinematic(pair)])  # fmt: skip


def check_restart_of_kinematic_friction():
    """A run goes on to the bit from a checkpoint in the middle of contact, on bodies and rigid obstacles: the first
    coefficients of a step are those of the pressure of the step before."""
    with tempfile.TemporaryDirectory() as folder:
        path = MPI.COMM_WORLD.bcast(Path(folder) / "thrown.h5", root=0)
        for cell, rigid in itertools.product(("triangle", "quadrilateral", "tetrahedron", "hexahedron"), (False, True)):
            dim = 2 if cell in ("triangle", "quadrilateral") else 3
            blocks = Blocks(cell, (3,) * dim, (4,) * (dim - 1) + (2,), gap=0.01, narrow=0.15)
            whole = thrown(blocks, rigid)
            whole.advance(0.03, progress=False)
            slips = blocks.total([np.count_nonzero(whole.contact[0].status == di.ContactStatus.slip)])
            assert slips > 0 and whole.energy["friction"] > 0.0, (cell, rigid)
            whole.save(path)
            other = thrown(blocks.again(), rigid)
            other.restore(path)
            for problem in (whole, other):
                problem.advance(0.05, progress=False)
            assert np.array_equal(whole.u.x.array, other.u.x.array), (cell, rigid)
            assert whole.energy == other.energy, (cell, rigid)
        MPI.COMM_WORLD.barrier()


def check_a_law_that_returns_no_number():
    """Under pressure it is the root of a negative number. Nobody takes that for sticking: the run ends on all ranks."""
    law = di.FrictionLaw(lambda pressure: ufl.sqrt(0.1 - pressure))
    implicit = block(di.NewmarkProblem, law)
    before = implicit.u.x.array.copy()
    with pytest.raises(ValueError, match="returns no finite number at"):
        implicit.advance(0.1, dt=0.1, progress=False)
    assert np.array_equal(implicit.u.x.array, before)
    with pytest.raises(RuntimeError, match="went unstable"):
        block(di.ExplicitProblem, law).advance(0.5, progress=False)
