# SPDX-License-Identifier: MIT
"""Means at nodes whose cells are on several ranks: forces, tangents, runs and checkpoints. See on_ranks.py."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem, la, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact.assembly import operators
from dolfinx_impact.assembly.body_forms import body_forms
from dolfinx_impact.assembly.locking import Locking

COMM = MPI.COMM_WORLD
LAWS = (di.LinearElastic, di.NeoHookean)
PRESSURE, STRAIN = "averaged_pressure", "averaged_strain"
AVERAGED_LAWS = [(law, how) for law in LAWS for how in (PRESSURE, STRAIN)]


def cube(comm=COMM, n=3):
    """Space on a cube of tetrahedra."""
    domain = mesh.create_unit_cube(comm, n, n, n, mesh.CellType.tetrahedron)
    return fem.functionspace(domain, ("Lagrange", 1, (3,)))


def bent(V, size=0.05):
    """A smooth displacement that changes the volume."""
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: size * np.array([np.sin(3 * x[1]) * x[0], x[2] ** 2 - x[0], np.cos(2 * x[0]) * x[2]]))
    return u


def layers(V, materials):
    """A MaterialMap of layers of cells, in the order of x."""
    num = V.mesh.topology.index_map(3).size_local + V.mesh.topology.index_map(3).num_ghosts
    cells = np.arange(num, dtype=np.int32)
    numbers = (len(materials) * mesh.compute_midpoints(V.mesh, 3, cells)[:, 0]).astype(np.int32)
    return di.MaterialMap(mesh.meshtags(V.mesh, 3, cells, numbers), dict(enumerate(materials)))


def two_materials(V, law, integration=PRESSURE):
    """Soft and stiff halves, whose pressures and strains must not be mixed at the nodes between them."""
    return layers(V, [law(E, 0.45, 1.0, integration=integration) for E in (1.0, 50.0)])


def owned_product(a, b, V):
    n = V.dofmap.index_map.size_local * 3
    return V.mesh.comm.allreduce(float(a[:n] @ b[:n]))


def check_force_is_the_derivative_of_the_energy():
    """Two materials; the error of central differences with a step of 1e-5 is 1e-10 of the second derivatives."""
    V = cube()
    u, d = bent(V), bent(V, 0.7)
    start = u.x.array.copy()
    for law, how in AVERAGED_LAWS:
        material = two_materials(V, law, how)
        energy = operators.Energy(operators.strain_energy_form(u, material))
        u.x.array[:] = start
        force = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), material)).apply().array
        found = []
        for sign in (1, -1):
            u.x.array[:] = start + sign * 1e-5 * d.x.array
            found.append(energy.value())
        exact = owned_product(force, d.x.array, V)
        assert (found[0] - found[1]) / 2e-5 == pytest.approx(exact, rel=1e-7)


def check_tangent_is_the_derivative_of_the_force():
    """Entries between nodes that share no cell, too; the error of central differences as above."""
    V = cube()
    u, d = bent(V), bent(V, 0.7)
    start = u.x.array.copy()
    plastic = di.J2Plasticity(
        1.0, 0.4, yield_stress=1e-3, hardening=0.1, finite_strain=True, integration="averaged_pressure"
    )
    for material in (two_materials(V, di.NeoHookean), two_materials(V, di.NeoHookean, STRAIN), plastic):
        u.x.array[:] = start
        body = di.StaticProblem(u, material).body
        changes = []
        for sign in (1, -1):
            u.x.array[:] = start + sign * 1e-6 * d.x.array
            changes.append(body.in_cpp().residual().array.copy())
        u.x.array[:] = start
        body.in_cpp().residual()
        K = body.tangent.assemble()
        x, y = K.createVecs()
        x.array[:] = d.x.array[: len(x.array)]
        K.mult(x, y)
        change = (changes[0] - changes[1]) / 2e-6
        size = COMM.allreduce(float(y.array @ y.array)) ** 0.5
        assert COMM.allreduce(float(np.sum((change - y.array) ** 2))) ** 0.5 < 1e-6 * size


def check_explicit_force_is_that_of_the_operator():
    """Explicit problems read means and padded displacements by the kernels' sweeps, multiply by a matrix of the nodes,
    or have two sweeps written by hand (AveragedNeoHookean); the operator gathers batch by batch. Sums over ranks may
    differ in their order: a limit of round-off."""
    for law, how in AVERAGED_LAWS:
        u = bent(cube())
        material = two_materials(u.function_space, law, how)
        problem = di.ExplicitProblem(u, material)
        form = operators.internal_force_form(u, ufl.TestFunction(u.function_space), material)
        force = operators.InternalForce(form).apply().array
        n = 3 * u.function_space.dofmap.index_map.size_local
        found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
        largest = COMM.allreduce(np.abs(force[:n]).max(), MPI.MAX)
        assert np.abs(found + force[:n]).max() < 1e-13 * largest and largest > 1e-3


def check_several_materials_are_swept():
    """Kernels list the means of their own material only: each integral gathers, computes and scatters in one function,
    with the forces of the operator, which does it batch by batch. A limit of round-off, as above."""
    V = cube(n=6)
    linear, rubber = ([law(E, 0.4, 1.0, integration=PRESSURE) for E in (1.0, 5.0, 2.0)] for law in LAWS)
    plastic = {"yield_stress": 1e-3, "hardening": 0.1, "finite_strain": True, "integration": PRESSURE}
    metals = [di.J2Plasticity(E, 0.4, 1.0, **plastic) for E in (1.0, 5.0)]
    n, num_owned = 3 * V.dofmap.index_map.size_local, V.mesh.topology.index_map(3).size_local
    for materials in (linear[:2], linear, rubber[:2], rubber, [*linear[:1], *rubber], metals):
        u, whole = bent(V), layers(V, materials)
        problem = di.ExplicitProblem(u, whole)
        operator = problem._bodies.internal._parts[1]
        assert operator._tags == list(range(len(materials)))
        for number, tag in enumerate(operator._tags):
            several = np.sum(whole.cell_tags.find(tag) < num_owned) >= operator.width
            assert operator._cpp_object.swept(number) == (several and operator.width > 1)
        forms = body_forms(u, whole)
        alone = operators.InternalForce(forms.internal, law=forms.laws)
        force = alone.apply().array
        assert not any(alone._cpp_object.swept(number) for number in range(len(materials)))
        found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
        largest = COMM.allreduce(np.abs(force[:n]).max(), MPI.MAX)
        assert np.abs(found + force[:n]).max() < 1e-13 * largest and largest > 1e-3


def check_residuals_of_ones_own():
    """Multiples of forces of averages are what was written; without a tangent the stable step would be too long."""
    V = cube()
    n = 3 * V.dofmap.index_map.size_local
    for law, how in AVERAGED_LAWS:
        u, v = bent(V), ufl.TestFunction(V)
        residual = fem.Constant(V.mesh, 3.0) * operators.internal_force_form(u, v, law(1.0, 0.3, 1.0, integration=how))
        with pytest.raises(ValueError, match="averages at the nodes.*stable step would be too long"):
            di.ExplicitProblem(u, residual=residual, density=1.0)
        plain = 3.0 * operators.tangent_form(u, ufl.TrialFunction(V), v, law(1.0, 0.3, 1.0))
        problem = di.ExplicitProblem(u, residual=residual, tangent=plain, density=1.0)
        force = operators.InternalForce(residual).apply().array[:n]
        found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
        assert np.abs(found + force).max() < 1e-13 * COMM.allreduce(np.abs(force).max(), MPI.MAX)


def check_ranks_without_cells():
    """They take part in the exchange of sums: explicit forces are those of the operator, as in the check before."""

    def on_last_rank(comm, num_ranks, cell_types, cells):
        return compat.adjacencylist(np.full((len(cells[0]) // 4, 1), num_ranks - 1, dtype=np.int32))

    domain = mesh.create_unit_cube(COMM, 2, 2, 2, mesh.CellType.tetrahedron, partitioner=on_last_rank)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    n = 3 * V.dofmap.index_map.size_local
    for law, how in AVERAGED_LAWS:
        u, material = bent(V), law(1.0, 0.3, 1.0, integration=how)
        problem = di.ExplicitProblem(u, material)
        problem.advance(5e-3, dt=1e-3, progress=False)
        force = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), material)).apply().array
        found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
        largest = COMM.allreduce(np.abs(force[:n]).max(initial=0.0), MPI.MAX)
        assert np.abs(found + force[:n]).max(initial=0.0) < 1e-13 * largest and largest > 1e-3


def check_linear_means_are_those_of_kernels():
    """Means of tr(eps), of strains and of gradients are a product with a matrix in explicit runs, in the plane also
    those of neo-Hooke's law (operators/LinearSums.h); the operator adds up what kernels compute. A limit of round-off,
    as above."""
    square = mesh.create_unit_square(COMM, 4, 4, mesh.CellType.triangle)
    spaces = cube(), fem.functionspace(square, ("Lagrange", 1, (2,)))
    laws = (di.LinearElastic, PRESSURE), (di.LinearElastic, STRAIN), (di.NeoHookean, STRAIN)
    for V, (law, how) in ((V, kind) for V in spaces for kind in laws):
        u, dim = fem.Function(V, name="u"), V.mesh.geometry.dim
        u.interpolate(lambda x, n=dim: 0.03 * np.array([np.sin(3 * x[1]) * x[0], x[0] * x[1] - x[0], x[0] ** 2])[:n])
        steel = law(1.0, 0.4, 1.0, ("plane_strain", "3d")[dim - 2], integration=how)
        problem = di.ExplicitProblem(u, steel)
        problem.advance(1e-3, dt=1e-3, progress=False)
        force = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), steel)).apply().array
        n = dim * V.dofmap.index_map.size_local
        found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
        largest = COMM.allreduce(np.abs(force[:n]).max(), MPI.MAX)
        assert np.abs(found + force[:n]).max() < 1e-13 * largest and largest > 1e-4


def check_laws_side_by_side():
    """Each material has its own means and its own way of adding forces; two tags share one."""
    V = cube(n=4)
    shared = di.NeoHookean(1.0, 0.3, 1.0, integration=STRAIN)
    linear = di.LinearElastic(2.0, 0.4, 1.0, integration=STRAIN)
    other = di.NeoHookean(3.0, 0.2, 1.0, integration=PRESSURE)
    u, material = bent(V), layers(V, [shared, linear, shared, other])
    problem = di.ExplicitProblem(u, material)
    form = operators.internal_force_form(u, ufl.TestFunction(V), material)
    force = operators.InternalForce(form).apply().array
    n = 3 * V.dofmap.index_map.size_local
    found = problem.acceleration.x.array[:n] * problem.mass.array[:n]
    largest = COMM.allreduce(np.abs(force[:n]).max(), MPI.MAX)
    assert np.abs(found + force[:n]).max() < 1e-13 * largest and largest > 1e-3


def run(comm, until=0.4, integration=PRESSURE):
    """A cube thrown against a plane, plastic but with averaged strains."""
    V = cube(comm, 2)
    u, v = fem.Function(V, name="u"), fem.Function(V)
    v.interpolate(lambda x: np.array([0.01 * x[1], 0 * x[0], 0.01 * x[0] - 0.2]))
    if integration == STRAIN:
        steel = di.LinearElastic(1.0, 0.4, 1.0, integration=integration)
    else:
        steel = di.J2Plasticity(
            1.0, 0.4, 1.0, yield_stress=0.02, hardening=0.1, finite_strain=True, integration=integration
        )
    facets = mesh.locate_entities_boundary(V.mesh, 2, lambda x: np.isclose(x[2], 0.0))
    tags = mesh.meshtags(V.mesh, 2, np.sort(facets), np.full(len(facets), 1, dtype=np.int32))
    wall = di.Penalty(di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0, -0.01), (0.0, 0.0, 1.0))))
    problem = di.ExplicitProblem(u, steel, velocity=v, contact=[wall])
    problem.advance(until, dt=0.02, progress=False)
    return problem


def check_plain_cells_beside_averaged_ones():
    """Equilibria of layers with averages and without, the same moduli in all: a linear displacement is the solution.
    A load that follows the body is assembled by FFCx's kernels."""
    V = cube()
    V.mesh.topology.create_connectivity(2, 3)
    outer = mesh.exterior_facet_indices(V.mesh.topology)
    tags = mesh.meshtags(V.mesh, 2, outer, np.ones(len(outer), dtype=np.int32))
    linear = fem.Function(V)
    linear.interpolate(lambda x: 1e-3 * np.array([x[0] + 2.0 * x[1], x[2] - x[1], 0.5 * x[0]]))
    support = fem.dirichletbc(linear, fem.locate_dofs_topological(V, 2, outer))
    steel = {"yield_stress": 1.0, "hardening": 0.1}
    for law, given in ((di.LinearElastic, {}), (di.NeoHookean, {}), (di.J2Plasticity, steel)):
        for how in (PRESSURE,) if given else (PRESSURE, STRAIN):
            materials = [law(1.0, 0.3, integration=integration, **given) for integration in ("full", how, "full")]
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # plain tetrahedra lock
                problem = di.StaticProblem(
                    fem.Function(V), layers(V, materials), bcs=support, loads=di.FollowerPressure(tags, 1, 0.0)
                )
            problem.solve(progress=False)
            assert np.abs(problem.u.x.array - linear.x.array).max(initial=0.0) < 1e-12, (law, how)


def check_run_is_that_of_one_rank():
    """Displacements by place; the balance of energy. Sums in another order differ by round-off, which grows little."""
    for how in (PRESSURE, STRAIN):
        ours, alone = run(COMM, integration=how), run(MPI.COMM_SELF, integration=how)
        assert how == STRAIN or ours.energy["plastic"] > 0
        assert abs(ours.energy["drift"]) < 0.02
        places = [np.round(p.space.tabulate_dof_coordinates(), 9) for p in (ours, alone)]
        at = {tuple(x): k for k, x in enumerate(places[1])}
        theirs = alone.u.x.array.reshape(-1, 3)[[at[tuple(x)] for x in places[0]]]
        assert np.abs(ours.u.x.array.reshape(-1, 3) - theirs).max() < 1e-10 * np.abs(theirs).max()


def check_checkpoint():
    """A run that is continued is the run, bit for bit."""
    with shared_folder(COMM) as folder:
        for how in (PRESSURE, STRAIN):
            file = Path(folder) / how
            problem = run(COMM, 0.2, how)
            problem.save(file)
            problem.advance(0.4, dt=0.02, progress=False)
            state = problem.u.x.array.copy()
            problem.restore(file)
            problem.advance(0.4, dt=0.02, progress=False)
            assert np.array_equal(problem.u.x.array, state)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Locking)
            plain = run(COMM, 0.02, "full")
        with pytest.raises(ValueError, match="of another problem.*averaged_pressure"):
            plain.restore(Path(folder) / PRESSURE)


def check_vectors_have_ghosts():
    """Averages of ghosts are those of their owners."""
    V = cube()
    u = bent(V)
    material = di.NeoHookean(1.0, 0.3, 1.0, integration="averaged_pressure")
    form = operators.internal_force_form(u, ufl.TestFunction(V), material)
    (mean,) = [f for f in form.coefficients() if f is not u]
    operators.InternalForce(form).apply()
    copy = la.vector(mean.function_space.dofmap.index_map)
    copy.array[:] = mean.x.array
    copy.scatter_forward()
    assert np.array_equal(copy.array, mean.x.array) and np.any(mean.x.array)
