# SPDX-License-Identifier: MIT
"""Loads: their resultants in closed form, their derivatives, and what is refused."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.loads import _FacetLoad, _Load


def body(cell="hexahedron", n=2, degree=1):
    """Box of sides 2 x 1 (x 1), with all boundary facets at x = 2 tagged 5, at x = 0 tagged 4, one interior facet 9."""
    comm = MPI.COMM_SELF
    kind = getattr(mesh.CellType, cell)
    if cell in ("triangle", "quadrilateral"):
        domain = mesh.create_rectangle(comm, [(0, 0), (2, 1)], (n, n), kind)
    else:
        domain = mesh.create_box(comm, [(0, 0, 0), (2, 1, 1)], (n, n, n), kind)
    tdim = domain.topology.dim
    domain.topology.create_connectivity(tdim - 1, tdim)
    right = mesh.locate_entities_boundary(domain, tdim - 1, lambda x: np.isclose(x[0], 2))
    left = mesh.locate_entities_boundary(domain, tdim - 1, lambda x: np.isclose(x[0], 0))
    inside = np.setdiff1d(
        np.arange(domain.topology.index_map(tdim - 1).size_local), mesh.exterior_facet_indices(domain.topology)
    )[:1]
    facets = np.concatenate([right, left, inside]).astype(np.int32)
    values = np.repeat([5, 4, 9], [len(right), len(left), len(inside)]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, tdim - 1, facets[order], values[order])
    V = fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))
    return tags, fem.Function(V, name="u")


def material(u, hypothesis=None, density=3.0):
    hypothesis = hypothesis or ("3d" if u.function_space.mesh.geometry.dim == 3 else "plane_strain")
    return di.LinearElastic(1.0, 0.3, density, hypothesis)


def force(load, u, m):
    """Nodal forces (nodes, components)."""
    f = di.InternalForce(load.form(u, ufl.TestFunction(u.function_space), m)).apply()
    return f.array.reshape(-1, u.function_space.mesh.geometry.dim)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
@pytest.mark.parametrize("degree", [1, 2])
def test_traction_adds_up(cell, degree):
    tags, u = body(cell, degree=degree)
    t = np.arange(1.0, 4.0)[: u.function_space.mesh.geometry.dim]
    # Area 1: the sum over all nodes is the traction, to the round-off of a few dozen additions.
    assert force(di.Traction(tags, 5, t), u, material(u)).sum(axis=0) == pytest.approx(t, rel=1e-13)


def test_traction_that_varies():
    tags, u = body(degree=2)
    x = ufl.SpatialCoordinate(u.function_space.mesh)
    load = di.Traction(tags, 5, ufl.as_vector([x[1] ** 2, x[1] * x[2], 0]))
    assert force(load, u, material(u)).sum(axis=0) == pytest.approx([1 / 3, 1 / 4, 0], abs=1e-14)


def test_axisymmetric_traction_is_a_total():
    tags, u = body("quadrilateral")
    total = force(di.Traction(tags, 5, (0, 1.5)), u, material(u, "axisymmetric")).sum(axis=0)
    assert total == pytest.approx([0, 1.5 * 2 * np.pi * 2], rel=1e-13)  # circumference of radius 2, height 1


def test_gravity_adds_up():
    _, u = body()
    for per_mass, factor in ((True, 3.0), (False, 1.0)):
        total = force(di.BodyForce((0, 0, -9.81), per_mass), u, material(u)).sum(axis=0)
        assert total == pytest.approx([0, 0, -9.81 * 2 * factor], rel=1e-13)  # volume 2, density 3


def test_body_force_that_varies():
    """A polynomial of the place, and a function by cell; per volume and per mass. Moments by hand over the box."""
    _, u = body(degree=2)
    domain = u.function_space.mesh
    x = ufl.SpatialCoordinate(domain)
    step = fem.Function(fem.functionspace(domain, ("DG", 0)), name="step")
    step.interpolate(lambda x: np.where(x[0] < 1.0, 1.0, 3.0))
    for per_mass, factor in ((True, 3.0), (False, 1.0)):
        total = force(di.BodyForce(ufl.as_vector([x[0] ** 2, x[1] * x[2], step]), per_mass), u, material(u)).sum(axis=0)
        assert total == pytest.approx(np.array([8 / 3, 1 / 2, 4.0]) * factor, rel=1e-12)
    _, plane = body("quadrilateral")
    r = ufl.SpatialCoordinate(plane.function_space.mesh)[0]
    total = force(di.BodyForce(ufl.as_vector([0, r]), False), plane, material(plane, "axisymmetric")).sum(axis=0)
    assert total == pytest.approx([0.0, 2 * np.pi * 8 / 3], rel=1e-12)  # 2 pi r r over r to 2


def test_expressions_that_do_not_fit():
    tags, u = body()
    _, other = body("quadrilateral")
    m, v = material(u), ufl.TestFunction(u.function_space)
    x = ufl.SpatialCoordinate(u.function_space.mesh)
    foreign = fem.Function(fem.functionspace(other.function_space.mesh, ("DG", 0, (3,))), name="foreign")
    for make in (di.BodyForce, lambda vector: di.Traction(tags, 5, vector)):
        with pytest.raises(ValueError, match=r"has shape \(2,\)"):
            make(ufl.as_vector([x[0], x[1]])).form(u, v, m)
        with pytest.raises(ValueError, match=r"has shape \(\)"):
            make(x[0]).form(u, v, m)
        with pytest.raises(ValueError, match="another mesh"):
            make(foreign).form(u, v, m)


def test_loads_in_motion_follow_their_functions():
    """A free body under a body force, or a pull on its sides, that a callback changes in a function: all of it moves as
    one, by the accelerations 0 and 2."""
    for kind in ("body", "traction"):
        tags, u = body("quadrilateral")
        V = u.function_space
        size = fem.Function(fem.functionspace(V.mesh, ("Lagrange", 1)), name="size")
        f = ufl.as_vector([size, 0])
        loads = [di.BodyForce(f, per_mass=False)] if kind == "body" else [di.Traction(tags, t, f) for t in (4, 5)]
        problem = di.ExplicitProblem(u, material(u), velocity=fem.Function(V), loads=loads)
        dt = 0.5 * problem.stable_step()

        def callback(p, size=size):
            size.x.array[:] = 6.0 if p.step >= 4 else 0.0  # over a mass of six

        problem.advance(12 * dt, dt=dt, callback=callback, progress=False)
        # From the fourth step on 8 steps: 8 * 9/2.
        mean = problem.mass.array[::2] @ u.x.array[::2] / problem.mass.array[::2].sum()
        assert mean == pytest.approx(2.0 * dt**2 * 36, rel=1e-12), kind
        loads[0].constant.value = 0.0
        before = problem.velocity.x.array[::2].copy()
        problem.advance(problem.time + dt, dt=dt, progress=False)
        if kind == "body":
            assert problem.velocity.x.array[::2] == pytest.approx(before, rel=0.1)


def test_a_body_without_weight():
    """Density 0 in a static problem: gravity does nothing; in an explicit one it is refused."""
    tags, u = body()
    V = u.function_space
    left = fem.locate_dofs_topological(V, 2, tags.find(4))
    bcs = [fem.dirichletbc(np.zeros(3), left, V)]
    law = material(u, density=0.0)
    loads = [di.BodyForce((0, 0, -9.81)), di.Traction(tags, 5, (1e-3, 0, 0))]
    problem = di.StaticProblem(u, law, bcs=bcs, loads=loads)
    problem.solve()
    assert problem.reactions().x.array.reshape(-1, 3).sum(axis=0) == pytest.approx([-1e-3, 0, 0], abs=1e-12)
    with pytest.raises(ValueError, match="density 0.*StaticProblem"):
        di.ExplicitProblem(u, law, velocity=fem.Function(V))


def test_gravity_needs_a_density():
    _, u = body()
    with pytest.raises(ValueError, match="no density"):
        di.BodyForce((0, 0, -9.81)).form(u, ufl.TestFunction(u.function_space), material(u, density=None))


@pytest.mark.parametrize("cell", ["quadrilateral", "tetrahedron"])
def test_pressure_follows_the_surface(cell):
    """Turning the body turns the force of the pressure with it; stretching the facet makes it grow."""
    tags, u = body(cell)
    dim = u.function_space.mesh.geometry.dim
    turn = np.eye(dim)
    turn[:2, :2] = [[0, -1], [1, 0]]
    stretch = np.diag([1.0, 2.0, 3.0][:dim])
    A = turn @ stretch
    u.interpolate(lambda x: (A - np.eye(dim)) @ x[:dim])
    total = force(di.FollowerPressure(tags, 5, 0.7), u, material(u)).sum(axis=0)
    area = np.prod(np.diag(stretch)[1:])
    assert total == pytest.approx(-0.7 * area * turn[:, 0], abs=1e-13)


def test_pressure_on_a_closed_surface_has_no_resultant(rng):
    tags, u = body("hexahedron", degree=2)
    m = u.function_space.mesh
    facets = mesh.exterior_facet_indices(m.topology)
    tags = mesh.meshtags(m, 2, facets, np.full(len(facets), 1, dtype=np.int32))
    u.x.array[:] = 0.1 * rng.uniform(-1, 1, size=u.x.array.size)
    f = force(di.FollowerPressure(tags, 1, 1.0), u, material(u))
    # Exact integration of the cofactor: the divergence of the cofactor vanishes; round-off of forces of order 0.1.
    assert np.abs(f.sum(axis=0)).max() < 1e-13 and np.abs(f).max() > 0.01


def test_derivative_of_the_follower_pressure(rng):
    tags, u = body("quadrilateral", degree=2)
    V = u.function_space
    load, m = di.FollowerPressure(tags, 5, 1.0), material(u)
    form = load.form(u, ufl.TestFunction(V), m)
    K = fem.assemble_matrix(fem.form(ufl.derivative(form, u, ufl.TrialFunction(V)))).to_dense()
    start, direction, h = 0.1 * rng.normal(size=u.x.array.size), rng.normal(size=u.x.array.size), 1e-4
    ends = []
    for s in (h, -h):
        u.x.array[:] = start + s * direction
        ends.append(force(load, u, m).ravel())
    u.x.array[:] = start
    K = fem.assemble_matrix(fem.form(ufl.derivative(form, u, ufl.TrialFunction(V)))).to_dense()
    # In the plane the force is linear in u, so that the central difference has no error but round-off / h.
    assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(K @ direction, abs=1e-10)


def test_value_can_be_changed():
    tags, u = body()
    load, m = di.Traction(tags, 5, (0, 1.0, 0)), material(u)
    f = di.InternalForce(load.form(u, ufl.TestFunction(u.function_space), m))
    first = f.apply().array.copy()
    load.constant.value[:] = (0, 2.5, 0)
    assert f.apply().array == pytest.approx(2.5 * first, rel=1e-14)


NAN = float("nan")


@pytest.mark.parametrize(
    "make, error, words",
    [
        (lambda t: di.Traction(t, 77, (0, 0, 1)), ValueError, r"no facet carries the tag 77.*\[4, 5, 9\]"),
        (lambda t: di.Traction(t, 9, (0, 0, 1)), ValueError, r"tag 9 lie inside.*\[4, 5\]"),
        (lambda t: di.FollowerPressure(t, 77, 1.0), ValueError, "no facet carries the tag 77"),
        (lambda t: di.Traction(t, 5, (0, 1)), ValueError, r"shape \(2,\).*3 components"),
        (lambda t: di.Traction(t, 5, 1.0), ValueError, r"shape \(\).*3 components"),
        (lambda t: di.Traction(t, 5, (0, NAN, 1)), ValueError, "finite"),
        (lambda t: di.Traction(t, 5, ("0", "1", "2")), TypeError, "3 numbers.*'0'"),
        (lambda t: di.Traction(t, 5, "down"), TypeError, "3 numbers.*'down'"),
        (lambda t: di.Traction(t, "right", (0, 0, 1)), TypeError, "integer.*'right'"),
        (lambda t: di.FollowerPressure(t, 5, NAN), ValueError, "pressure is nan"),
        (lambda t: di.FollowerPressure(t, 5, "high"), TypeError, "pressure must be a number.*'high'"),
        (lambda t: di.BodyForce((0, 0, NAN)), ValueError, "finite"),
        (lambda t: di.BodyForce((0, 0)), ValueError, "3 components"),
    ],
)
def test_bad_loads(make, error, words):
    tags, u = body()
    with pytest.raises(error, match=words):
        make(tags).form(u, ufl.TestFunction(u.function_space), material(u))


def test_tags_of_cells_are_refused():
    _, u = body()
    domain = u.function_space.mesh
    tags = mesh.meshtags(domain, 3, np.arange(8, dtype=np.int32), np.full(8, 5, dtype=np.int32))
    with pytest.raises(ValueError, match="tags of facets.*dimension 3"):
        di.Traction(tags, 5, (0, 0, 1)).form(u, ufl.TestFunction(u.function_space), material(u))


@pytest.mark.parametrize("ranks", [2, 3])
def test_tags_on_one_rank_only(script_on_ranks, ranks):
    """A tag that one rank alone has is no error anywhere; one that nobody has is the same error everywhere."""
    output = script_on_ranks(
        ranks,
        """
        import numpy as np
        import ufl
        from dolfinx import fem, mesh
        from mpi4py import MPI
        import dolfinx_impact as di
        comm = MPI.COMM_WORLD
        domain = mesh.create_unit_square(comm, 6, 1)
        right = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], 1))
        tags = mesh.meshtags(domain, 1, right, np.full(len(right), 5, dtype=np.int32))
        u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))), name="u")
        steel, v = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain"), ufl.TestFunction(u.function_space)
        f = di.InternalForce(di.Traction(tags, 5, (3.0, 0)).form(u, v, steel)).apply()
        total = comm.allreduce(f.array[: 2 * f.index_map.size_local].sum())
        assert abs(total - 3.0) < 1e-13, total
        try:
            di.Traction(tags, 6, (3.0, 0)).form(u, v, steel)
        except ValueError as e:
            everywhere = comm.allgather(str(e))
            assert "[5]" in everywhere[0] and len(set(everywhere)) == 1, everywhere
            print("same")
        """,
    )
    assert output.count("same") == ranks


@pytest.mark.parametrize("cell, dofs", [("quadrilateral", 6), ("hexahedron", 27)])
def test_loads_know_their_degrees_of_freedom_and_what_they_ramp(cell, dofs):
    """Two cells along each side: 3 nodes of 2, or 9 of 3 components, on one side."""
    tags, u = body(cell)
    V, dim = u.function_space, u.function_space.mesh.geometry.dim
    load, gravity = di.Traction(tags, 5, [1.0] * dim), di.BodyForce([2.0] * dim)
    assert isinstance(load, _FacetLoad) and isinstance(gravity, _Load) and not isinstance(gravity, _FacetLoad)
    found = load._dofs(V)
    assert len(set(found)) == len(found) == dofs
    assert V.tabulate_dof_coordinates()[found // dim, 0] == pytest.approx(2.0, abs=1e-14)
    assert np.array_equal(gravity._dofs(V), np.arange(len(u.x.array)))
    for one in (load, gravity):
        with pytest.raises(AttributeError, match=f"a {type(one).__name__} has no constant before"):
            one.constant
        one.form(u, ufl.TestFunction(V), material(u))
        ((constant, reached),) = one.ramps()
        assert constant is one.constant and not np.any(reached) and not one.varies()
        one.form(u, ufl.TestFunction(V), material(u))
        assert one.constant is constant  # of one mesh
    assert repr(load) == f"Traction(tag=5, vector={[1.0] * dim})"
    with pytest.raises(NotImplementedError):
        _Load().form(u, None, None)
