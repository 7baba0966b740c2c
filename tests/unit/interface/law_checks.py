# SPDX-License-Identifier: MIT
"""Laws of the interface in problems, on one rank and on several: equilibrium, energies, restart, what is refused."""

import itertools
import tempfile
from pathlib import Path

import dolfinx_impact as di
import numpy as np
import ufl
from blocks import BOTTOM, MASTER, SLAVE, TOP, Blocks
from dolfinx import fem, mesh
from dolfinx_impact import interface
from mpi4py import MPI

CASES = {
    "quadrilateral": ((3, 2), (4, 2)),
    "triangle": ((3, 2), (4, 2)),
    "hexahedron": ((2, 2, 2), (3, 3, 1)),
    "tetrahedron": ((2, 2, 1), (3, 2, 1)),
}


def stiff(dim, nu=0.0):
    return di.LinearElastic(E=1e7, nu=nu, density=1.0, hypothesis="3d" if dim == 3 else "plane_strain")


def sides(blocks):
    """The lower block's foot is held; the upper block may only move up and down."""
    bcs = blocks.held(BOTTOM, *range(blocks.dim))
    for c in range(blocks.dim - 1):
        dofs = fem.locate_dofs_geometrical(
            (blocks.V.sub(c), blocks.V.sub(c).collapse()[0]), lambda x: x[blocks.dim - 1] > 1.0 + 5e-4
        )
        zero = fem.Function(blocks.V.sub(c).collapse()[0])
        bcs.append(fem.dirichletbc(zero, dofs, blocks.V.sub(c)))
    return bcs


def check_pressure_of_a_gap():
    """Uniform pressure on a block: everywhere the gap is that of the law."""
    p0, c, load = 40.0, 0.02, 5.0
    for cell, (lower, upper) in CASES.items():
        for degree in (1, 2) if cell in ("quadrilateral", "tetrahedron") else (1,):
            blocks = Blocks(cell, lower, upper, gap=0.01, degree=degree)
            law = di.InterfaceLaw(pressure=lambda gap: p0 * np.e ** (-gap / c))
            down = np.zeros(blocks.dim)
            down[-1] = -load
            problem = di.StaticProblem(
                blocks.u, stiff(blocks.dim), bcs=sides(blocks), loads=[di.Traction(blocks.tags, TOP, down)],
                contact=[di.Penalty(blocks.pair(), law=law)],
            )  # fmt: skip
            report = problem.solve()
            contact = problem.contact[0]
            exact = c * np.log(p0 / load)
            # The lower block is squeezed sideways at its held foot: the pressure is uniform to what that leaves.
            assert report.converged and np.allclose(contact.force[-1], load, rtol=1e-9), (cell, contact.force)
            assert np.all(np.abs(contact.gap - exact) < 1e-6 * exact), (cell, contact.gap, exact)
            # The work of the pressure counts as stored: of one increment, by the trapezoidal rule.
            stored = -0.5 * (p0 * np.exp(-0.01 / c) + load) * (exact - 0.01)
            found = contact.stored_energy()
            assert abs(contact.dissipated) < 1e-12 * load
            assert abs(found - stored) < 1e-6 * abs(stored), (found, stored)


def check_work_in_small_increments():
    """The work of a law without an energy converges to the area under its curve, of second order."""
    p0, c, load = 40.0, 0.02, 5.0
    errors = []
    for steps in (4, 8):
        blocks = Blocks("quadrilateral", (3, 2), (4, 2), gap=0.01)
        law = di.InterfaceLaw(pressure=lambda gap: p0 * np.e ** (-gap / c))
        top = fem.Function(blocks.V)
        problem = di.StaticProblem(
            blocks.u, stiff(2), bcs=[*sides(blocks), *_moved(blocks, top)], contact=[di.Penalty(blocks.pair(), law=law)]
        )
        for k in range(1, steps + 1):
            top.x.array[1::2] = 0.03 * k / steps
            problem.solve()
        gap = problem.contact[0].gap
        g = blocks.mesh.comm.allreduce(gap.max(initial=-np.inf), MPI.MAX)
        exact = -c * p0 * (np.exp(-0.01 / c) - np.exp(-g / c))
        errors.append(abs(problem.contact[0].stored_energy() - exact))
        assert load > 0
    assert errors[1] < 0.35 * errors[0] and errors[1] < 0.01 * abs(exact), (errors, exact)


def _moved(blocks, values):
    """The top is moved by a function that a test changes."""
    dofs = fem.locate_dofs_topological(blocks.V, blocks.dim - 1, blocks.tags.find(TOP))
    return [fem.dirichletbc(values, dofs)]


def bond():
    return interface.cohesive_zone(1e6, 300.0, 0.2, 400.0, 0.3)


def pulled(blocks, law, way=1e-3):
    """Problem and the function that pulls the top."""
    top = fem.Function(blocks.V)
    bcs = [*blocks.held(BOTTOM, *range(blocks.dim)), *_moved(blocks, top)]
    problem = di.StaticProblem(blocks.u, stiff(blocks.dim), bcs=bcs, contact=[di.Penalty(blocks.pair(), law=law)])
    return problem, top


def check_a_bond_breaks_with_its_energy():
    """Pulled apart in opening and in shear, the work done and not stored is the energy of fracture times the area."""
    for component, energy in ((1, 0.2), (0, 0.3)):
        blocks = Blocks("quadrilateral", (3, 2), (4, 2))
        problem, top = pulled(blocks, bond())
        steps = 24
        work, last = 0.0, np.zeros(2)
        for k in range(1, steps + 1):
            top.x.array[:] = 0.0
            top.x.array[component::2] = 2.4e-3 * k / steps
            problem.solve()
            force = problem.contact[0].force
            work -= 0.5 * (force + last)[component] * 2.4e-3 / steps
            last = force.copy()
        contact = problem.contact[0]
        assert np.allclose(contact.force, 0.0, atol=1e-9)
        assert np.all(contact.status != di.ContactStatus.stick) and (component == 0 or np.all(contact.status == 0))
        # The trapezoidal rule of 24 increments over a triangle.
        assert abs(contact.dissipated - energy) < 0.02 * energy, (contact.dissipated, energy)
        assert abs(contact.stored_energy()) < 1e-12
        assert abs(work - energy) < 0.05 * energy, (work, energy)


def check_restart_of_static_problems():
    """A bond that was damaged goes on from a checkpoint as if it had never stopped."""
    found, blocks = [], Blocks("quadrilateral", (3, 2), (4, 2))
    with tempfile.TemporaryDirectory() as folder:
        path = MPI.COMM_WORLD.bcast(Path(folder) / "bond.h5", root=0)
        for stops in (False, True):
            problem, top = pulled(blocks.again(), bond())
            for k in range(1, 7):
                top.x.array[:] = 0.0
                top.x.array[1::2], top.x.array[0::2] = 1e-4 * k, 4e-5 * k
                problem.solve()
                if stops and k == 3:
                    problem.save(path)
                    force, stored = problem.contact[0].force.copy(), problem.contact[0].stored_energy()
                    traction = problem.contact[0].traction.copy()
                    problem, top = pulled(blocks.again(), bond())
                    problem.restore(path)
                    contact = problem.contact[0]
                    assert np.array_equal(contact.force, force) and np.allclose(contact.traction, traction, rtol=1e-13)
                    assert np.isclose(contact.stored_energy(), stored, rtol=1e-13)
            contact = problem.contact[0]
            found.append([*contact.force, contact.dissipated, contact.stored_energy()])
        MPI.COMM_WORLD.barrier()
    assert found[0][2] > 0.0 and np.allclose(found[0], found[1], rtol=1e-9), found


def check_fields_of_both_sides():
    """A pressure that depends on the temperatures of both sides, static and explicit."""
    blocks = Blocks("quadrilateral", (3, 2), (4, 2))
    theta = fem.Function(fem.functionspace(blocks.mesh, ("Lagrange", 1)), name="temperature")
    theta.interpolate(lambda x: np.where(x[1] > 1.0 + 1e-9, 5.0, 3.0 + 0.0 * x[0]))
    # Nodes on the common line belong to either block: they are told apart by the cells.
    upper = np.unique(blocks.V.dofmap.list[_cells_above(blocks)])
    theta.x.array[:] = 3.0
    theta.x.array[upper] = 5.0
    law = di.InterfaceLaw(
        pressure=lambda fields: fields.temperature_slave + 10.0 * fields.temperature_master,
        fields={"temperature": theta},
        reach=0.1,
    )
    problem = di.StaticProblem(
        blocks.u, stiff(2), bcs=[*blocks.held(BOTTOM, 0, 1), *blocks.held(TOP, 0, 1)],
        contact=[di.Penalty(blocks.pair(), law=law)],
    )  # fmt: skip
    problem.solve()
    assert np.allclose(problem.contact[0].pressure, 35.0, rtol=1e-12)
    run = di.ExplicitProblem(fem.Function(blocks.V), stiff(2), contact=[di.Penalty(blocks.pair(), law=law)])
    run.advance(until=1e-6, dt=1e-6, progress=False)
    assert np.allclose(run.contact[0].pressure[run.contact[0].status > 0], 35.0, rtol=1e-12)


def _cells_above(blocks):
    from dolfinx import mesh

    cells = np.arange(len(blocks.V.dofmap.list), dtype=np.int32)
    middle = mesh.compute_midpoints(blocks.mesh, blocks.dim, cells)
    return cells[middle[:, blocks.dim - 1] > 1.0]


def bouncing(law, velocity, v0=1.0):
    """A block of one cell, stiff against the law, that falls on a floor: what it is made of, and the run."""
    blocks = Blocks("quadrilateral", (1, 1), (2, 2), gap=0.0)
    floor = di.RigidPlane(point=(0.0, 1.0), normal=(0.0, 1.0))
    pair = di.ContactPair(blocks.tags, slave=SLAVE, master=floor)
    v = fem.Function(blocks.V)
    v.x.array.reshape(-1, 2)[np.unique(blocks.V.dofmap.list[_cells_above(blocks)]), 1] = -v0
    law_ = di.LinearElastic(E=velocity, nu=0.0, density=1.0, hypothesis="plane_strain")
    bcs = blocks.held(BOTTOM, 0, 1)
    run = di.ExplicitProblem(fem.Function(blocks.V), law_, velocity=v, bcs=bcs, contact=[di.Penalty(pair, law=law)])
    return blocks, run


def check_damped_bounce():
    """A block that bounces off a damped floor leaves with the velocity of the point mass's equation."""
    from scipy.integrate import solve_ivp

    mass, k, d = 0.5, 50.0, 0.3
    law = interface.damped_contact(k, d)
    blocks, run = bouncing(law, 4e4)
    run.advance(until=0.45, progress=False, energy_limits=None)
    above = np.unique(blocks.V.dofmap.list[_cells_above(blocks)])
    owned = above[above < blocks.V.dofmap.index_map.size_local]
    vertical = run.velocity.x.array.reshape(-1, 2)[owned, 1]
    # The block's nodes have masses 1 : 2 : 4 from its corners to its middle.
    momentum = blocks.total([_nodal_mass(blocks, owned) @ vertical])

    def point_mass(t, y):
        spring = max(-k * y[0], 0.0)
        return [y[1], spring * max(1.0 - d * y[1], 0.0) / mass]

    exact = solve_ivp(point_mass, (0.0, 0.45), [0.0, -1.0], rtol=1e-10, atol=1e-12).y[1, -1]
    assert run.contact[0].force[1] == 0.0 and exact > 0.5
    # The block is 800 times as stiff as the floor: waves in it carry away about the square of the ratio of the times.
    assert abs(momentum / mass - exact) < 0.01, (momentum / mass, exact)
    energy = run.energy
    assert abs(energy["drift"]) < 2e-4 and energy["impact"] > 0.1 * 0.25, energy


def _nodal_mass(blocks, nodes):
    """Lumped masses of nodes of the upper block, of density 1."""
    from dolfinx import fem as dfem
    import ufl

    V = dfem.functionspace(blocks.mesh, ("Lagrange", 1))
    form = dfem.form(ufl.TestFunction(V) * ufl.dx(metadata={"quadrature_rule": "vertex", "quadrature_degree": 1}))
    b = dfem.assemble_vector(form)
    from dolfinx import la

    b.scatter_reverse(la.InsertMode.add)
    b.scatter_forward()
    return b.array[nodes]


def check_restart_of_explicit_runs():
    """An explicit run with a bond that is pulled apart goes on from a checkpoint to the last bit."""
    found, blocks = [], Blocks("quadrilateral", (3, 2), (4, 2), narrow=0.1)
    with tempfile.TemporaryDirectory() as folder:
        path = MPI.COMM_WORLD.bcast(Path(folder) / "run.h5", root=0)
        for stops in (False, True):
            run = _thrown_apart(blocks.again())
            run.advance(until=60 * 2e-5, dt=2e-5, progress=False, energy_limits=None)
            if stops:
                run.save(path)
                run = _thrown_apart(blocks.again())
                run.restore(path)
            run.advance(until=180 * 2e-5, dt=2e-5, progress=False, energy_limits=None)
            found.append((run.u.x.array.copy(), run.energy, run.contact[0].traction.copy()))
        MPI.COMM_WORLD.barrier()
    (u, energy, traction), (other, again, back) = found
    assert np.array_equal(u, other) and np.array_equal(traction, back)
    assert energy == again and energy["friction"] > 0.0 and abs(energy["drift"]) < 1e-3, energy


def check_energy_where_nodes_leave_with_friction():
    """A block that is thrown at another one or at a plane, obliquely, and leaves: the works of a law's tractions, with
    the moments that its friction needs, are those that the bodies get, to round-off."""
    for dim, cell, rigid in ((2, "triangle", False), (2, "quadrilateral", True), (3, "hexahedron", False)):
        cells = ((3, 2), (4, 2)) if dim == 2 else ((2, 2, 2), (3, 3, 2))
        blocks = Blocks(cell, *cells, narrow=0.1)
        v = fem.Function(blocks.V)
        along = (0.8,) + (0.3,) * (dim - 2)
        v.x.array.reshape(-1, dim)[np.unique(blocks.V.dofmap.list[_cells_above(blocks)])] = (*along, -0.5)
        hypothesis = "plane_strain" if dim == 2 else "3d"
        bodies = di.LinearElastic(E=1e3, nu=0.2, density=1.0, hypothesis=hypothesis)
        law = interface.linear_pressure(2e4, friction=0.3)
        pair = blocks.pair()
        if rigid:
            pair = di.ContactPair(blocks.tags, SLAVE, di.RigidPlane((0.0, 1.0), (0.0, 1.0)))
        run = di.ExplicitProblem(
            fem.Function(blocks.V), bodies, velocity=v, bcs=blocks.held(BOTTOM, *range(dim)),
            contact=[di.Penalty(pair, law=law)],
        )  # fmt: skip
        closed, left = 0, 0
        for _ in range(30):
            run.advance(until=run.time + 10 * 1e-3, dt=1e-3, progress=False, energy_limits=None)
            now = int(blocks.total([np.count_nonzero(run.contact[0].status > 0)]))
            closed, left = max(closed, now), left + (now < closed)
        energy = run.energy
        assert closed > 0 and left > 0 and energy["friction"] > 1e-3 * energy["kinetic"]
        # Of sums of some thousand works; half a step's work where nodes leave, without its moments, is 1e-4.
        assert abs(energy["drift"]) < 1e-11, (dim, cell, rigid, energy)


def damaged(reach):
    """A bond whose damage is the largest opening so far over one hundredth."""

    def respond(point):
        opening = ufl.max_value(point.gap, 0)
        damage = ufl.max_value(point.history.damage, ufl.min_value(100 * opening, 1))
        return di.InterfaceUpdate(2e4 * ((damage - 1) * opening - ufl.min_value(point.gap, 0)),
                                  history={"damage": damage})  # fmt: skip

    return di.InterfaceLaw(response=respond, history={"damage": ()}, reach=reach)


def tumbling(blocks, spin, down=0.0, turned=0.0):
    """Displacement that turns the upper block about its middle, and its velocity; in space about the second axis."""
    dim = blocks.dim
    middle, c, s = np.full(dim, 0.5), np.cos(turned), np.sin(turned)
    middle[-1] = 1.25
    plane = np.array([[0.0, -1.0], [1.0, 0.0]])
    u, v = fem.Function(blocks.V), fem.Function(blocks.V)
    nodes = np.unique(blocks.V.dofmap.list[_cells_above(blocks)])
    r = (blocks.V.tabulate_dof_coordinates()[nodes, :dim] - middle)[:, [0, -1]]
    now = r @ np.array([[c, -s], [s, c]]).T
    u.x.array.reshape(-1, dim)[np.ix_(nodes, [0, dim - 1])] = now - r
    v.x.array.reshape(-1, dim)[np.ix_(nodes, [0, dim - 1])] = spin * now @ plane.T - [0.0, down]
    return u, v


def check_tractions_of_nodes_that_come_and_go():
    """A block that tumbles onto another one or onto a plane: its nodes come within reach one after the other, and
    leave. At every step the pressure of each node is the law's at its gap, with its own history."""
    p0, c = 40.0, 0.04
    laws = {"exponential": lambda: interface.exponential_pressure(p0, c), "damaged": lambda: damaged(c)}
    for cell, (lower, upper) in CASES.items():
        for rigid, name in itertools.product((False, True), laws):
            dim = len(lower)
            blocks = Blocks(cell, lower, upper, gap=0.06, narrow=0.1)
            u, v = tumbling(blocks, 1.5, 0.6)
            pair = blocks.pair()
            if rigid:
                up = np.eye(dim)[-1]
                pair = di.ContactPair(blocks.tags, SLAVE, di.RigidPlane(up, up))
            law = di.NeoHookean(E=1e3, nu=0.2, density=1.0, hypothesis="3d" if dim == 3 else "plane_strain")
            run = di.ExplicitProblem(
                u, law, velocity=v, bcs=blocks.held(BOTTOM, *range(dim)), contact=[di.Penalty(pair, law=laws[name]())]
            )
            damage, counts = np.zeros(len(run.contact[0].gap)), []

            def look(run):
                contact = run.contact[0]
                gap = np.where(contact.gap < c, contact.gap, c)
                if name == "exponential":
                    y = 1.0 - gap / c
                    exact = p0 / (np.e - 1.0) * y * np.expm1(y)
                else:
                    within = contact.gap < c
                    damage[within] = np.maximum(damage, np.clip(100 * gap, 0.0, 1.0))[within]
                    exact = 2e4 * np.where(within, (damage - 1) * np.maximum(gap, 0) - np.minimum(gap, 0), 0.0)
                # A few operations, whose round-off is that of the gaps' positions, of size 1.
                assert np.allclose(contact.pressure, exact, rtol=1e-9, atol=1e-9), (cell, rigid, name, run.step)
                counts.append(np.count_nonzero(contact.gap < c))

            run.advance(until=0.4, callback=look, progress=False, energy_limits=None)
            changes = np.diff([int(n) for n in blocks.total([counts])])
            assert np.count_nonzero(changes > 0) > 1 and np.any(changes < 0), (cell, rigid, name)


def check_no_law_beyond_the_search_distance():
    """A law without a reach is asked up to the search distance: a tension ends there."""
    for cell in ("quadrilateral", "hexahedron"):
        lower, upper = CASES[cell]
        dim = len(lower)
        blocks = Blocks(cell, lower, upper, gap=0.01)
        v = fem.Function(blocks.V)
        v.x.array.reshape(-1, dim)[np.unique(blocks.V.dofmap.list[_cells_above(blocks)]), -1] = 3.0
        pull = di.InterfaceLaw(pressure=lambda gap: -0.01 + 0.0 * gap)
        law = di.LinearElastic(E=1e3, nu=0.2, density=1.0, hypothesis="3d" if dim == 3 else "plane_strain")
        run = di.ExplicitProblem(
            fem.Function(blocks.V), law, velocity=v, bcs=blocks.held(BOTTOM, *range(dim)),
            contact=[di.Penalty(blocks.pair(search_distance=0.2), law=pull)],
        )  # fmt: skip
        forces = []
        run.advance(until=0.1, callback=lambda run: forces.append((run.time, run.contact[0].force[-1])), progress=False)
        for time, force in forces:
            gap = 0.01 + 3.0 * time
            if abs(gap - 0.2) > 0.02:  # the pull slows the block and deforms it by much less
                assert np.isclose(force, -0.01 if gap < 0.2 else 0.0, rtol=1e-9, atol=0.0), (cell, gap, force)
        assert forces[-1][0] == 0.1


def check_sides_that_turn_away():
    """A block turns above another one, whose far side its own sides come to face. It never touches: no law acts,
    whatever its reach, and the motion is that of a free block."""
    for cell in CASES:
        dim = 3 if cell in ("hexahedron", "tetrahedron") else 2
        blocks = Blocks(cell, (3,) * dim, (4,) * (dim - 1) + (2,), gap=0.05, narrow=0.3)
        outer = mesh.locate_entities_boundary(blocks.mesh, dim - 1, lambda x: x[dim - 1] > 1.01)
        below = mesh.locate_entities_boundary(blocks.mesh, dim - 1, lambda x: x[dim - 1] < 1.01)
        values = np.repeat([SLAVE, MASTER], [len(outer), len(below)]).astype(np.int32)
        order = np.argsort(np.concatenate([outer, below]))
        tags = mesh.meshtags(blocks.mesh, dim - 1, np.concatenate([outer, below])[order], values[order])
        law = di.NeoHookean(E=1e3, nu=0.2, density=1.0, hypothesis="3d" if dim == 3 else "plane_strain")
        motions = []
        for contact in ([], [di.Penalty(di.ContactPair(tags, SLAVE, MASTER), law=interface.linear_pressure(1e3))]):
            u, v = tumbling(blocks, 1.0, turned=-0.04)
            run = di.ExplicitProblem(u, law, velocity=v, contact=contact)
            run.advance(until=0.1, dt=5e-4, progress=False, energy_limits=None)
            motions.append(run.u.x.array.copy())
            assert run.energy["contact"] == 0.0, (cell, run.energy)
        assert np.array_equal(*motions), cell


def _thrown_apart(blocks):
    """Two bonded blocks, the upper one thrown up and sideways."""
    v = fem.Function(blocks.V)
    v.x.array.reshape(-1, 2)[np.unique(blocks.V.dofmap.list[_cells_above(blocks)])] = (0.6, 1.5)
    law = di.LinearElastic(E=1e6, nu=0.2, density=1.0, hypothesis="plane_strain")
    bonded = interface.cohesive_zone(1e6, 300.0, 0.2, 400.0, 0.3)
    return di.ExplicitProblem(
        blocks.u, law, velocity=v, bcs=blocks.held(BOTTOM, 0, 1), contact=[di.Penalty(blocks.pair(), law=bonded)]
    )


def check_implicit_rates():
    """A damped floor in implicit steps: the same bounce as the explicit run's."""
    k, d = 50.0, 0.3
    velocities = []
    for implicit in (False, True):
        blocks, run = bouncing(interface.damped_contact(k, d), 4e4)
        if implicit:
            v = fem.Function(blocks.V)
            v.x.array.reshape(-1, 2)[np.unique(blocks.V.dofmap.list[_cells_above(blocks)]), 1] = -1.0
            floor = di.RigidPlane(point=(0.0, 1.0), normal=(0.0, 1.0))
            pair = di.ContactPair(blocks.tags, slave=SLAVE, master=floor)
            law = di.LinearElastic(E=4e4, nu=0.0, density=1.0, hypothesis="plane_strain")
            run = di.NewmarkProblem(
                fem.Function(blocks.V), law, velocity=v, bcs=blocks.held(BOTTOM, 0, 1), rho_inf=0.8,
                contact=[di.Penalty(pair, law=interface.damped_contact(k, d))],
            )  # fmt: skip
            run.advance(until=0.45, dt=0.005, progress=False)
        else:
            run.advance(until=0.45, progress=False, energy_limits=None)
        above = np.unique(blocks.V.dofmap.list[_cells_above(blocks)])
        owned = above[above < blocks.V.dofmap.index_map.size_local]
        vertical = run.velocity.x.array.reshape(-1, 2)[owned, 1]
        velocities.append(blocks.total([_nodal_mass(blocks, owned) @ vertical]) / 0.5)
        if implicit:
            assert run.contact[0].dissipated > 0.02, run.contact[0].dissipated
    # Ninety implicit steps over a contact of about half a unit of time.
    assert abs(velocities[0] - velocities[1]) < 0.02, velocities


def check_local_equations_that_have_no_solution():
    """Static and explicit problems say which contact it was."""

    def respond(point):
        x = point.unknown
        return di.InterfaceUpdate(x, residual=x**2 + 1, start=0 * point.gap + 1, scale=1.0)

    for explicit in (False, True):
        blocks = Blocks("quadrilateral", (2, 1), (2, 1))
        contact = [di.Penalty(blocks.pair(name="joint"), law=di.InterfaceLaw(response=respond, unknown=(), reach=0.1))]
        bcs = [*blocks.held(BOTTOM, 0, 1), *blocks.held(TOP, 0, 1)]
        try:
            if explicit:
                run = di.ExplicitProblem(blocks.u, stiff(2), bcs=bcs, contact=contact)
                run.advance(until=1e-4, dt=1e-6, progress=False)
            else:
                di.StaticProblem(blocks.u, stiff(2), bcs=bcs, contact=contact).solve()
        except RuntimeError as e:
            assert "joint: the local equations of the law of the interface were not solved at" in str(e), e
        else:
            raise AssertionError("it was not told")


def check_what_is_refused():
    """Rates in statics, two sources of friction, two laws in one contact."""
    blocks = Blocks("quadrilateral", (2, 1), (2, 1))
    problem = di.StaticProblem(
        blocks.u, stiff(2), bcs=[*blocks.held(BOTTOM, 0, 1), *blocks.held(TOP, 0, 1)],
        contact=[di.Penalty(blocks.pair(), law=interface.damped_contact(1.0, 1.0))],
    )  # fmt: skip
    for call, kind, message in (
        (problem.solve, ValueError, "a static problem has no time"),
        (lambda: di.Penalty(blocks.pair(friction=0.3), law=interface.linear_pressure(1.0)), ValueError, "has its own"),
        (lambda: di.Penalty(blocks.pair(), 1e3, law=interface.linear_pressure(1.0)), ValueError, "in the place of"),
        (lambda: di.Penalty(blocks.pair(), law=3), TypeError, "must be an InterfaceLaw"),
    ):
        try:
            call()
        except kind as e:
            assert message in str(e), e
        else:
            raise AssertionError(message)
    assert MASTER != SLAVE
