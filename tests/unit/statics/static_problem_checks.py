# SPDX-License-Identifier: MIT
"""Static problems with known or foreign solutions, on the ranks of COMM_WORLD; see on_ranks.py."""

import warnings

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact.statics import linear_solver

COMM = MPI.COMM_WORLD
CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


def body(cell, n=3):
    """Unit square or cube whose inner nodes are moved."""
    dim, kind = CELLS[cell], getattr(mesh.CellType, cell)
    create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
    domain = create(COMM, *[n] * dim, kind)
    x = domain.geometry.x
    x[:, 0] += 0.08 * np.prod(np.sin(np.pi * x[:, :dim]), axis=1)
    return domain


def facets_at(domain, **where):
    """MeshTags 1, 2, ... of the boundary facets where a coordinate has a value: facets_at(domain, x=1.0, y=0.0)."""
    tdim = domain.topology.dim
    parts = [
        mesh.locate_entities_boundary(domain, tdim - 1, lambda p, a=axis, v=value: np.isclose(p["xyz".index(a)], v))
        for axis, value in where.items()
    ]
    facets, first = np.unique(np.concatenate(parts), return_index=True)
    values = np.repeat(np.arange(1, len(parts) + 1), [len(p) for p in parts])[first]
    return mesh.meshtags(domain, tdim - 1, facets.astype(np.int32), values.astype(np.int32))


def space(domain, degree=1):
    return fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))


def clamp(V, axis=0, value=0.0, displacement=None):
    dofs = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[axis], value))
    dim = V.mesh.geometry.dim
    return fem.dirichletbc(np.zeros(dim) if displacement is None else np.asarray(displacement, dtype=float), dofs, V)


def hypothesis(domain):
    return "3d" if domain.geometry.dim == 3 else "plane_strain"


def total(V, array):
    """Sum over all nodes, by component."""
    dim = V.mesh.geometry.dim
    owned = array[: V.dofmap.index_map.size_local * dim].reshape(-1, dim)
    return COMM.allreduce(owned.sum(axis=0))


def largest(x):
    return COMM.allreduce(float(np.max(np.abs(x), initial=0.0)), MPI.MAX)


def check_patch():
    """Linear displacement on the boundary of a distorted mesh: linear inside, after one linear solve."""
    for cell, dim in CELLS.items():
        A = np.array([[0.01, 0.02, -0.01], [0.005, -0.02, 0.01], [0.0, 0.015, 0.01]])[:dim, :dim]
        for degree in (1, 2):
            domain = body(cell)
            V = space(domain, degree)
            exact = fem.Function(V)
            exact.interpolate(lambda x: A @ x[:dim])
            domain.topology.create_connectivity(dim - 1, dim)
            facets = mesh.exterior_facet_indices(domain.topology)
            boundary = fem.dirichletbc(exact, fem.locate_dofs_topological(V, dim - 1, facets))
            u = fem.Function(V, name="u")
            report = di.StaticProblem(
                u, di.LinearElastic(2.0, 0.3, hypothesis=hypothesis(domain)), bcs=[boundary]
            ).solve()
            # Round-off times the condition of some hundred unknowns.
            assert largest(u.x.array - exact.x.array) < 1e-13 and report.iterations == [1]


def check_linear_problem():
    """Traction and gravity on a clamped body equal dolfinx.fem.petsc.LinearProblem, reactions balance the loads."""
    for cell in ("quadrilateral", "tetrahedron"):
        domain = body(cell)
        dim, V = domain.geometry.dim, space(domain, 2)
        u, law = fem.Function(V, name="u"), di.LinearElastic(2.0, 0.3, 1.5, hypothesis(domain))
        tags, t, g = facets_at(domain, x=1.0), 0.01 * np.arange(1, dim + 1), 0.02 * np.arange(dim)
        bcs = [clamp(V)]
        problem = di.StaticProblem(u, law, bcs=bcs, loads=[di.Traction(tags, 1, t), di.BodyForce(g)])
        assert problem.solve().iterations == [1]
        du, v = ufl.TrialFunction(V), ufl.TestFunction(V)
        lmbda, mu = law.lame
        eps = ufl.sym(ufl.grad(du))
        sigma = lmbda * ufl.tr(eps) * ufl.Identity(dim) + 2 * mu * eps
        right = ufl.inner(fem.Constant(domain, t), v) * ufl.Measure("ds", domain, subdomain_data=tags)(1)
        right += 1.5 * ufl.inner(fem.Constant(domain, g), v) * ufl.dx
        options = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"}
        left = ufl.inner(sigma, ufl.sym(ufl.grad(v))) * ufl.dx
        linear = compat.linear_problem(left, right, bcs, options, prefix="compared_with_")
        expected = linear.solve()
        # DOLFINx takes a higher quadrature degree on these cells: equal where both are exact (tetrahedra are straight).
        tolerance = 1e-11 if cell == "tetrahedron" else 2e-4
        assert largest(u.x.array - expected.x.array) < tolerance * largest(expected.x.array)
        volume = COMM.allreduce(fem.assemble_scalar(fem.form(fem.Constant(domain, 1.0) * ufl.dx)))
        applied = t + 1.5 * g * volume
        assert np.allclose(total(V, problem.reactions().x.array), -applied, rtol=0, atol=1e-12)


def check_reactions_vanish_inside():
    """Reactions are zero at free nodes, and their sum with a prescribed displacement balances itself."""
    domain = body("hexahedron")
    V = space(domain)
    u = fem.Function(V, name="u")
    bcs = [clamp(V), clamp(V, 0, 1.0, (0.1, 0.05, 0.0))]
    problem = di.StaticProblem(u, di.NeoHookean(2.0, 0.3), bcs=bcs)
    problem.solve()
    r = problem.reactions().x.array
    free = np.setdiff1d(np.arange(len(r)), np.concatenate([bc.dof_indices()[0] for bc in bcs]))
    assert largest(r) > 1e-2 and largest(r[free]) < 1e-10 * largest(r)
    assert np.allclose(total(V, r), 0, atol=1e-12 * largest(r) + 1e-13)


def check_newton():
    """Neo-Hookean bar pulled by a quarter: the error of each step is about the square of the last."""
    domain = body("hexahedron")
    V = space(domain)
    u = fem.Function(V, name="u")
    bcs = [clamp(V), clamp(V, 0, 1.0, (0.25, 0.0, 0.0))]
    report = di.StaticProblem(u, di.NeoHookean(2.0, 0.3), bcs=bcs).solve(rtol=1e-13)
    assert report.converged and len(report.iterations) == 1 and 3 <= report.iterations[0] <= 8
    norms = np.array(report.residual_norms[0][1:])  # the first one is of the boundary values
    seen = [(a, b) for a, b in zip(norms, norms[1:]) if b > 1e-13 * norms[0]]  # above round-off
    assert len(seen) >= 2
    # C of b = C a^2 / scale would be of order one; linear convergence would need b / a^2 to grow without bound.
    assert all(b / norms[0] < 10 * (a / norms[0]) ** 2 for a, b in seen), norms


def check_tiny_load_on_finite_strain():
    """Round-off of 1 + Grad u makes residuals that do not fall with the load: Newton's method stops there, and the
    displacement is that of linear elasticity."""
    found, domain = [], body("quadrilateral", 8)  # one mesh: DOLFINx may partition a second one otherwise
    for law in (di.LinearElastic, di.NeoHookean, di.StVenantKirchhoff):
        V = space(domain, 2)
        u = fem.Function(V)
        load = di.Traction(facets_at(domain, x=1.0), 1, (0.0, 1e-2))
        steel = law(2e8, 0.3, hypothesis="plane_strain")
        report = di.StaticProblem(u, steel, bcs=[clamp(V)], loads=[load]).solve()
        assert report.converged and sum(report.iterations) <= 3
        found.append(u.x.array.copy())
    for other in found[1:]:
        # The strain is 1e-10, of which eps is 1e-6.
        assert largest(other - found[0]) < 1e-4 * largest(found[0])


def check_own_residual():
    """A residual of the user's equals the same material; loads change between solves."""
    domain = body("triangle")
    V = space(domain)
    law, tags, bcs = di.NeoHookean(2.0, 0.3, hypothesis="plane_strain"), facets_at(domain, x=1.0), [clamp(V)]
    u, w = fem.Function(V, name="u"), fem.Function(V, name="w")
    load = di.Traction(tags, 1, (0.0, 0.02))
    problem = di.StaticProblem(u, law, bcs=bcs, loads=[load])
    t = fem.Constant(domain, (0.0, 0.02))
    v = ufl.TestFunction(V)
    residual = di.operators.internal_force_form(w, v, law) - ufl.inner(t, v) * ufl.Measure(
        "ds", domain, subdomain_data=tags
    )(1)
    own = di.StaticProblem(w, residual=residual, bcs=bcs)
    for factor in (1.0, 2.0):
        load.constant.value[1] = t.value[1] = 0.02 * factor
        problem.solve()
        own.solve()
        assert largest(u.x.array) > 1e-3 and largest(u.x.array - w.x.array) < 1e-10 * largest(u.x.array)


def check_two_materials_and_pressure():
    """Material map, follower pressure: residual after the solve, and convergence, say that tangent and force agree."""
    domain = body("quadrilateral", 4)
    V = space(domain)
    cells = np.arange(domain.topology.index_map(2).size_local + domain.topology.index_map(2).num_ghosts, dtype=np.int32)
    values = np.where(mesh.compute_midpoints(domain, 2, cells)[:, 0] < 0.5, 1, 2).astype(np.int32)
    two = {
        1: di.NeoHookean(2.0, 0.3, hypothesis="plane_strain"),
        2: di.LinearElastic(9.0, 0.2, hypothesis="plane_strain"),
    }
    material = di.MaterialMap(mesh.meshtags(domain, 2, cells, values), two)
    u = fem.Function(V, name="u")
    facets = facets_at(domain, x=1.0, y=1.0)
    loads = [di.FollowerPressure(facets, tag, 0.1) for tag in (1, 2)]
    report = di.StaticProblem(u, material, bcs=[clamp(V)], loads=loads).solve(rtol=1e-12)
    assert report.iterations[0] <= 7 and largest(u.x.array) > 1e-3


def refuses(problem, u, words, **arguments):
    """solve raises RuntimeError with the words, the same on all ranks, and u keeps its start."""
    start = u.x.array.copy()
    try:
        problem.solve(**arguments)
    except RuntimeError as e:
        everywhere = COMM.allgather(str(e))
        assert len(set(everywhere)) == 1 and words in everywhere[0], everywhere
    else:
        raise AssertionError(f"no error; u between {u.x.array.min()} and {u.x.array.max()}")
    assert np.array_equal(u.x.array, start)


def check_unsupported_body():
    """Nothing holds the body, or something lets it slide: an error, not a large displacement."""
    for cell in ("quadrilateral", "tetrahedron"):
        domain = body(cell)
        V = space(domain)
        dim, law = domain.geometry.dim, di.LinearElastic(2.0, 0.3, 1.0, hypothesis(domain))
        u = fem.Function(V, name="u")
        u.x.array[:] = 0.001
        pull = di.Traction(facets_at(domain, x=1.0), 1, [0.01] * dim)
        refuses(di.StaticProblem(u, law, loads=[pull]), u, "rigid motion")
        normal = V.sub(0).collapse()[0]
        on, zero = fem.locate_dofs_geometrical((V.sub(0), normal), lambda x: np.isclose(x[0], 0)), fem.Function(normal)
        refuses(di.StaticProblem(u, law, bcs=[fem.dirichletbc(zero, on, V.sub(0))], loads=[pull]), u, "rigid motion")


def check_balanced_load():
    """A free body under loads that balance: there are solutions, but no one of them."""
    domain = body("hexahedron")
    u = fem.Function(space(domain), name="u")
    facets = mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[0] * (1 - x[0]), 0))
    tags = mesh.meshtags(domain, 2, facets, np.ones(len(facets), dtype=np.int32))
    loads = [di.Traction(tags, 1, 0.01 * ufl.FacetNormal(domain))]
    refuses(di.StaticProblem(u, di.LinearElastic(2.0, 0.3), loads=loads), u, "rigid motion")


def check_divergence():
    """Too large a load in one step, too few iterations, an inverted start: errors that say so."""
    domain = body("quadrilateral")
    V = space(domain)
    law = di.NeoHookean(2.0, 0.3, hypothesis="plane_strain")
    u = fem.Function(V, name="u")
    push = di.StaticProblem(u, law, bcs=[clamp(V), clamp(V, 0, 1.0, (-1.5, 0.0))])
    refuses(push, u, "smaller parts")
    few = di.StaticProblem(u, law, bcs=[clamp(V), clamp(V, 0, 1.0, (0.3, 0.0))])
    refuses(few, u, "did not converge in 1 iterations", max_iterations=1)
    few.solve()  # and with enough of them it does converge, from the start that was kept
    u.interpolate(lambda x: (-2 * x[0], 0 * x[0]))  # F = -1: the logarithm has no value
    refuses(di.StaticProblem(u, law, bcs=[clamp(V)]), u, "residual is nan")


def check_options():
    """Options belong to their problem: the next one with the same prefix has its own."""
    domain = body("triangle")
    V = space(domain)
    law, bcs, load = (
        di.LinearElastic(2.0, 0.3, hypothesis="plane_strain"),
        [clamp(V)],
        di.Traction(facets_at(domain, x=1.0), 1, (0.0, 0.1)),
    )
    first, second = fem.Function(V, name="u"), fem.Function(V, name="u")
    iterative = {"ksp_type": "cg", "pc_type": "jacobi", "ksp_rtol": 1e-12}
    direct = di.StaticProblem(first, law, bcs=bcs, loads=[load])
    other = di.StaticProblem(second, law, bcs=bcs, loads=[load], options=iterative)
    assert direct.linear_solver.ksp.getType() == "fgmres" and other.linear_solver.ksp.getType() == "cg"
    direct.solve()
    other.solve()
    assert largest(first.x.array - second.x.array) < 1e-9 * largest(first.x.array)


def check_multigrid_that_is_indefinite():
    """Jacobi sweeps with too little damping make multigrid indefinite: conjugate gradients give up, GMRES goes on."""
    domain = body("hexahedron", 5)
    V = space(domain)
    law, load = di.LinearElastic(2.0, 0.3), di.Traction(facets_at(domain, x=1.0), 1, (0.0, 0.1, 0.0))
    sweeps = {"mg_levels_ksp_type": "richardson", "mg_levels_pc_type": "jacobi", "mg_levels_ksp_richardson_scale": 0.7}
    first, second = fem.Function(V, name="u"), fem.Function(V, name="u")
    di.StaticProblem(first, law, bcs=[clamp(V)], loads=[load]).solve()
    other = di.StaticProblem(second, law, bcs=[clamp(V)], loads=[load], options={"pc_type": "gamg", **sweeps})
    other.solve()
    assert other.linear_solver.ksp.getType() == "gmres"
    assert largest(first.x.array - second.x.array) < 1e-8 * largest(first.x.array)  # Newton's tolerance


def check_what_changes_a_tangent():
    """Of a linear residual of one's own it does not depend on u, but its coefficients may change from step to step."""
    V = space(body("triangle"))
    u, v, stiffness = fem.Function(V, name="u"), ufl.TestFunction(V), fem.Constant(V.mesh, 1.0)
    linear = stiffness * ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
    for residual, expected in ((linear, True), (linear + ufl.inner(u, u) * ufl.inner(u, v) * ufl.dx, False)):
        made = di.StaticProblem(u, residual=residual, bcs=[clamp(V)]).body.properties
        assert (made.linear, made.keeps_tangent) == (expected, False)
    law = di.LinearElastic(2.0, 0.3, hypothesis="plane_strain")
    made = di.StaticProblem(u, law, bcs=[clamp(V)]).body.properties
    assert (made.linear, made.keeps_tangent) == (True, True)


def check_iterations_that_do_not_converge():
    """A solver that was chosen by size and fails: the system is factorised, and a warning says so."""
    domain = body("hexahedron", 4)
    V = space(domain)
    law, load = di.LinearElastic(2.0, 0.3), di.Traction(facets_at(domain, x=1.0), 1, (0.0, 0.1, 0.0))
    first, second = fem.Function(V, name="u"), fem.Function(V, name="u")
    di.StaticProblem(first, law, bcs=[clamp(V)], loads=[load]).solve()
    kept = linear_solver.LIMITS.largest_direct
    linear_solver.LIMITS.largest_direct = [0] * 4
    try:
        other = di.StaticProblem(second, law, bcs=[clamp(V)], loads=[load], options={"ksp_max_it": 2})
        own = {"ksp_type": "cg", "pc_type": "jacobi", "ksp_max_it": 2}
        refused = di.StaticProblem(fem.Function(V, name="u"), law, bcs=[clamp(V)], loads=[load], options=own)
    finally:
        linear_solver.LIMITS.largest_direct = kept
    assert not other.linear_solver.direct
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        other.solve()
    said = [str(w.message) for w in caught if "factorised" in str(w.message)]
    assert len(said) == (COMM.rank == 0), said
    assert other.linear_solver.direct
    assert largest(first.x.array - second.x.array) < 1e-8 * largest(first.x.array)  # Newton's tolerance
    refuses(refused, refused.u, "PETSc reason")  # who chooses a solver is told that it fails


def check_nothing_to_do():
    """No load, no prescribed displacement: zero, without an iteration."""
    V = space(body("triangle"))
    u = fem.Function(V, name="u")
    report = di.StaticProblem(u, di.LinearElastic(2.0, 0.3, hypothesis="plane_strain"), bcs=[clamp(V)]).solve()
    assert report.iterations == [0] and largest(u.x.array) == 0.0
