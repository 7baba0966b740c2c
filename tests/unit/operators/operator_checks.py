# SPDX-License-Identifier: MIT
"""Operators against DOLFINx's own assembly, on the ranks of COMM_WORLD; see on_ranks.py."""

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem, la, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.assembly.averaged_form import compile_columns
from dolfinx_impact.assembly.cell_matrices import CellMatrices
from dolfinx_impact.assembly.operators import BilinearKernels
from dolfinx_impact.assembly.packed_cells import packed_cells

COMM = MPI.COMM_WORLD
CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}

# Both sides add the same few hundred element entries per node, in different orders and with different rounding inside
# the kernels; stresses cancel at interior nodes. Relative to the largest entry.
TOLERANCE = 1e-12


def body(cell, shape=(3, 2, 2), comm=COMM, left=0.0):
    """Box with unevenly moved nodes, so that no two cells are alike; not a multiple of any width."""
    dim, kind = CELLS[cell], getattr(mesh.CellType, cell)
    low, high = [(left, 0, 0)[:dim], (left + 2, 1, 1)[:dim]]
    create = mesh.create_rectangle if dim == 2 else mesh.create_box
    domain = create(comm, [low, high], shape[:dim], kind)
    x = domain.geometry.x
    x[:, 1] += 0.1 * x[:, 0] * x[:, 1] * (1 - x[:, 1])
    x[:, 0] += 0.05 * (x[:, 0] - left) * (left + 2 - x[:, 0]) * np.cos(3 * x[:, 1])
    return domain


def displacement(domain, degree, name="u"):
    """Smooth and finite, a few percent of strain."""
    dim = domain.geometry.dim
    u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (dim,))), name=name)
    u.interpolate(lambda x: 0.05 * np.array([np.sin(2 * x[0] + x[1]), x[0] * x[1] + x[2], np.cos(x[0] - x[2])])[:dim])
    return u


def hypothesis(domain):
    return "3d" if domain.geometry.dim == 3 else "plane_strain"


def tags_of_cells(domain):
    """1 left of x = 1, 2 right of it; ghosts included."""
    tdim = domain.topology.dim
    imap = domain.topology.index_map(tdim)
    cells = np.arange(imap.size_local + imap.num_ghosts, dtype=np.int32)
    values = np.where(mesh.compute_midpoints(domain, tdim, cells)[:, 0] < 1.0, 1, 2).astype(np.int32)
    return mesh.meshtags(domain, tdim, cells, values)


def tags_of_facets(domain):
    """3 at the left end, 4 at the right end, 5 at y = 0."""
    tdim = domain.topology.dim
    parts = [
        mesh.locate_entities_boundary(domain, tdim - 1, where)
        for where in (lambda x: np.isclose(x[0], 0), lambda x: np.isclose(x[0], 2), lambda x: np.isclose(x[1], 0))
    ]
    facets, first = np.unique(np.concatenate(parts), return_index=True)
    values = np.repeat([3, 4, 5], [len(p) for p in parts])[first]
    return mesh.meshtags(domain, tdim - 1, facets.astype(np.int32), values.astype(np.int32))


def largest(x):
    return COMM.allreduce(float(np.max(np.abs(x), initial=0.0)), MPI.MAX)


def equal(found, expected, tolerance=TOLERANCE):
    """Arrays equal on all ranks, relative to the largest entry."""
    scale = largest(expected)
    assert scale > 0 and np.all(np.isfinite(found))
    difference = largest(found - expected) / scale
    assert difference < tolerance, difference


def assembled(form):
    """dolfinx.fem.assemble_vector, complete on owned and ghost entries."""
    b = fem.assemble_vector(fem.form(form))
    b.scatter_reverse(la.InsertMode.add)
    b.scatter_forward()
    return b.array


def check_force():
    """Every cell and degree, every width."""
    for cell in CELLS:
        for degree in (1, 2):
            u = displacement(body(cell), degree)
            law = di.StVenantKirchhoff(2.1, 0.3, hypothesis=hypothesis(u.function_space.mesh))
            form = di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), law)
            expected = assembled(form)
            for width in (0, 1, 4, 8):
                operator = di.InternalForce(form, width)
                assert operator.compiled.source == "package" and operator.flops >= 0
                assert operator.width in (1, 4, 8) and (width == 0 or operator.width <= width)
                equal(operator.apply().array, expected)


def check_assemble_adds():
    """`assemble` adds this rank's part, without communication; `apply` overwrites."""
    u = displacement(body("hexahedron"), 1)
    form = di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), di.LinearElastic(2.1, 0.3))
    operator = di.InternalForce(form)
    local = fem.assemble_vector(fem.form(form)).array
    array = np.ones_like(local)
    operator.assemble(array)
    equal(array, local + 1)
    b = operator.apply()
    first = b.array.copy()
    operator.apply(b)
    assert np.array_equal(b.array, first)


def check_materials_and_loads():
    """Two materials by cell tag, tractions and a follower pressure by facet tag, gravity: one form."""
    for cell in ("quadrilateral", "tetrahedron"):
        domain = body(cell)
        u, dim, kind = displacement(domain, 1), domain.geometry.dim, hypothesis(domain)
        two = {1: di.NeoHookean(2.1, 0.3, 1.0, kind), 2: di.LinearElastic(9.0, 0.2, 5.0, kind)}
        material, facets, v = (
            di.MaterialMap(tags_of_cells(domain), two),
            tags_of_facets(domain),
            ufl.TestFunction(u.function_space),
        )
        loads = [di.Traction(facets, 4, np.arange(1, dim + 1)), di.FollowerPressure(facets, 5, 0.3)]
        loads.append(di.BodyForce(np.arange(dim)))
        form = di.operators.internal_force_form(u, v, material) - sum(load.form(u, v, material) for load in loads)
        for width in (1, 0):
            equal(di.InternalForce(form, width).apply().array, assembled(form))
        energy = di.operators.strain_energy_form(u, material)
        expected = COMM.allreduce(fem.assemble_scalar(fem.form(energy)))
        assert abs(di.Energy(energy).value() / expected - 1) < TOLERANCE


def check_everywhere_and_tagged():
    """dx, dx(1), dx((1, 2)), ds and ds(4) in one form."""
    domain = body("triangle")
    f = fem.Function(fem.functionspace(domain, ("Lagrange", 2)), name="f")
    f.interpolate(lambda x: 1 + x[0] * x[1])
    v = ufl.TestFunction(f.function_space)
    dx = ufl.Measure("dx", domain, subdomain_data=tags_of_cells(domain), metadata={"quadrature_degree": 4})
    ds = ufl.Measure("ds", domain, subdomain_data=tags_of_facets(domain), metadata={"quadrature_degree": 4})
    form = f * v * dx + 2 * f**2 * v * dx(1) + 3 * v * dx((1, 2)) + 5 * f * v * ds(4) + 7 * v * ds + 11 * v * ds((3, 5))
    equal(di.InternalForce(form).apply().array, assembled(form))


def check_parts():
    """Early, outer and late cells are all cells; only outer ones touch ghosts, and the others are two halves."""
    u = displacement(body("hexahedron", (6, 5, 4)), 1)
    V = u.function_space
    num_cells, num_owned = V.mesh.topology.index_map(3).size_local, V.dofmap.index_map.size_local
    form = di.operators.internal_force_form(u, ufl.TestFunction(V), di.LinearElastic(2.1, 0.3))
    force, work = {}, {}
    for part in (None, "early", "outer", "late"):
        operator = di.InternalForce(form, part=part)
        force[part] = np.zeros(len(u.x.array))
        operator.assemble(force[part])
        work[part] = operator.flops
    equal(force["early"] + force["outer"] + force["late"], force[None])
    assert not np.any(force["early"][3 * num_owned :]) and not np.any(force["late"][3 * num_owned :])
    touching = np.sum(np.any(V.dofmap.list[:num_cells] >= num_owned, axis=1))
    one = work[None] / num_cells
    assert one > 0.0 and work["outer"] == touching * one
    late = (num_cells - touching) // 2 if touching else 0
    assert work["late"] == late * one and work["early"] == (num_cells - touching - late) * one


def check_few_cells():
    """Fewer cells than a batch holds, on some ranks none at all."""
    for cell in ("quadrilateral", "hexahedron"):
        u = displacement(body(cell, (1, 1, 1)), 1)
        domain = u.function_space.mesh
        counts = COMM.allgather(domain.topology.index_map(domain.topology.dim).size_local)
        assert sum(counts) == 1
        law = di.NeoHookean(2.1, 0.3, 1.0, hypothesis(domain))
        form = di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), law)
        for width in (1, 4, 8):
            equal(di.InternalForce(form, width).apply().array, assembled(form))
        energy = di.Energy(di.operators.strain_energy_form(u, law))
        assert energy.value() > 0 and len(set(COMM.allgather(energy.value()))) == 1
        assert np.all(di.lumped_mass(u.function_space, law).array > 0)


def check_energy():
    """Strain energy; and its derivative is the internal force (central difference)."""
    for cell in CELLS:
        u = displacement(body(cell), 1)
        domain = u.function_space.mesh
        law = di.NeoHookean(2.1, 0.3, hypothesis=hypothesis(domain))
        form = di.operators.strain_energy_form(u, law)
        expected = COMM.allreduce(fem.assemble_scalar(fem.form(form)))
        for width in (1, 4, 8):  # terms of order one leave an energy of order 1e-3
            assert abs(di.Energy(form, width).value() / expected - 1) < 1e-11
        force = di.InternalForce(di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), law)).apply()
        direction, start, h = displacement(domain, 1), u.x.array.copy(), 1e-4
        direction.x.array[:] = np.cos(7 * start)
        direction.x.scatter_forward()
        ends, energy = [], di.Energy(form)
        for s in (h, -h):
            u.x.array[:] = start + s * direction.x.array
            ends.append(energy.value())
        owned = u.function_space.dofmap.index_map.size_local * u.function_space.dofmap.index_map_bs
        slope = COMM.allreduce(float(force.array[:owned] @ direction.x.array[:owned]))
        # Error of the difference: h^2 times third derivatives of order ten.
        assert abs((ends[0] - ends[1]) / (2 * h) - slope) < 1e-5 * max(1.0, abs(slope))


def check_tangent():
    """Tangent with boundary conditions equals DOLFINx's matrix, and follows u; its product is the linear force."""
    for cell in ("triangle", "hexahedron"):
        u = displacement(body(cell), 2)
        V = u.function_space
        law = di.NeoHookean(2.1, 0.3, hypothesis=hypothesis(V.mesh))
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        dofs = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0))
        bcs = [fem.dirichletbc(np.zeros(V.mesh.geometry.dim), dofs, V)]
        tangent = di.Tangent(di.operators.tangent_form(u, du, v, law), bcs)
        derivative = fem.form(ufl.derivative(di.operators.internal_force_form(u, v, law), u, du))
        for factor in (1.0, -0.5):
            u.x.array[:] *= factor
            A = petsc.assemble_matrix(derivative, bcs=bcs)
            A.assemble()
            A.axpy(-1.0, tangent.assemble())
            assert A.norm() < TOLERANCE * tangent.matrix.norm()


def matrices_one_by_one(matrices):
    """Element matrices of all owned cells of a form with one kernel, which computes one cell at a time."""
    ((kernel, functions, cells, constants),) = matrices._integrals()
    assert kernel.rank == 2 and list(cells) == list(range(len(cells)))
    w, x = packed_cells(matrices.space.mesh, kernel, functions, cells)
    A = np.zeros((len(cells), *kernel.shape))
    kernel.tabulate_cells(A.ravel(), w.ravel(), constants, x.ravel(), len(cells))
    return kernel, A


def check_matrices_of_some_cells():
    """Tangents and spectra, whose kernels compute four cells at a time, against one cell after the other; the number of
    cells is no multiple of four."""
    linear, hyperelastic = di.LinearElastic, di.NeoHookean
    cases = [(cell, 1, law) for cell in CELLS for law in (linear, hyperelastic)] + [("tetrahedron", 2, linear)]
    for cell, degree, law in cases:
        u = displacement(body(cell, (3, 3, 1)), degree)
        V = u.function_space
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        form = di.operators.tangent_form(u, du, v, law(2.1, 0.3, 1.7, hypothesis=hypothesis(V.mesh)))
        matrices = CellMatrices(u, form, (u,))
        kernel, A = matrices_one_by_one(matrices)
        assert (4 in kernel.widths) == (_cpp.kernels.processor_width() >= 4)
        assert COMM.allreduce(len(A)) % 4
        masses = 1.0 + 0.1 * (np.arange(A.shape[0] * A.shape[1]).reshape(A.shape[:2]) % 7)
        scale = 1 / np.sqrt(masses)
        expected = np.linalg.eigvalsh(0.5 * (A + A.swapaxes(1, 2)) * scale[:, :, None] * scale[:, None, :])
        equal(matrices.spectra(masses)[:, :2].ravel(), expected[:, [0, -1]].ravel())
        d, force = displacement(V.mesh, degree, "d"), fem.Function(V)
        bs = V.dofmap.bs
        dofs = (bs * V.dofmap.list[: len(A), :, None] + np.arange(bs)).reshape(len(A), -1)
        np.add.at(force.x.array, dofs, np.einsum("eij,ej->ei", A, d.x.array[dofs]))
        force.x.scatter_reverse(la.InsertMode.add)
        product = force.x.petsc_vec.duplicate()
        di.Tangent(form).assemble().mult(d.x.petsc_vec, product)
        equal(product.array, force.x.array[: product.local_size])


def check_matrices_of_facets():
    """Kernels of our own on cells and outer facets, in one matrix, against FFCx's."""
    for cell in CELLS:
        domain = body(cell)
        f = displacement(domain, 1)
        V = f.function_space
        u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
        form = (1 + ufl.inner(f, f)) * ufl.inner(u, v) * ufl.ds + ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
        kernels = BilinearKernels(form, compile_columns(form, V))
        spaces = V._cpp_object, V._cpp_object
        ours = _cpp.operators.KernelTangent(*spaces, kernels.integrals, kernels.sources, None)
        ours.assemble([])
        theirs = petsc.assemble_matrix(fem.form(form))
        theirs.assemble()
        size = theirs.norm()
        theirs.axpy(-1.0, ours.matrix)
        assert size > 1.0 and theirs.norm() <= TOLERANCE * size, (cell, theirs.norm() / size)


def check_updates():
    """Functions and constants are read anew at every call; ghosts are refreshed."""
    domain = body("hexahedron")
    u = displacement(domain, 1)
    law = di.LinearElastic(2.1, 0.3, 1.0)
    operator = di.InternalForce(di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), law))
    first = operator.apply().array.copy()
    u.x.array[:] *= 2
    owned = u.function_space.dofmap.index_map.size_local * 3
    u.x.array[owned:] = 1e9  # spoilt ghosts
    equal(operator.apply().array, 2 * first)
    law._constants[(u.function_space.mesh.ufl_id() if hasattr(domain, "ufl_id") else id(domain), "E")].value *= 3
    equal(operator.apply().array, 6 * first)


def check_coefficients():
    """Coefficients per cell and at quadrature points, of two degrees, in a form of the user's."""
    import basix.ufl

    domain = body("hexahedron")
    u = displacement(domain, 1)
    d = fem.Function(fem.functionspace(domain, ("DG", 0)), name="d")
    d.x.array[:] = 1 + 0.1 * np.arange(d.x.array.size)
    d.x.scatter_forward()
    element = basix.ufl.quadrature_element("hexahedron", (2,), degree=2)
    q = fem.Function(fem.functionspace(domain, element), name="q")
    q.x.array[:] = np.cos(np.arange(q.x.array.size))
    p = fem.Function(fem.functionspace(domain, ("Lagrange", 2)), name="p")
    p.interpolate(lambda x: x[0] ** 2 - x[1])
    c = fem.Constant(domain, np.array([[1.0, 2.0], [3.0, 4.0]]))
    v = ufl.TestFunction(u.function_space)
    form = (d * q[1] * c[1, 0] * ufl.inner(ufl.grad(u), ufl.grad(v)) + p * q[0] * c[0, 1] * v[2]) * ufl.dx(
        metadata={"quadrature_degree": 2}
    )
    for width in (1, 4):
        equal(di.InternalForce(form, width).apply().array, assembled(form))


def check_point_values():
    """Stresses at points of all cells, against dolfinx.fem.Expression."""
    points = {"triangle": [[0.2, 0.3], [0.5, 0.1]], "hexahedron": [[0.2, 0.3, 0.9], [0.5, 0.5, 0.5]]}
    for cell, x in points.items():
        u = displacement(body(cell), 2)
        domain = u.function_space.mesh
        law = di.NeoHookean(2.1, 0.3, hypothesis=hypothesis(domain))
        stress = law.stress(u)
        found = di.PointValues(stress, np.array(x)).values()
        cells = np.arange(domain.topology.index_map(domain.topology.dim).size_local, dtype=np.int32)
        expected = fem.Expression(stress, np.array(x)).eval(domain, cells)
        equal(found.reshape(-1), expected.reshape(-1))
