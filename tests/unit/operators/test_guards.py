# SPDX-License-Identifier: MIT
"""A kernel refuses what it was not compiled for; operators refuse forms and data that do not fit, on all ranks
alike."""

import basix.ufl
import numpy as np
import operator_checks
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.common.collective import describe
from dolfinx_impact.forms import registry

COMM = MPI.COMM_SELF


def hexahedra():
    return mesh.create_unit_cube(COMM, 1, 1, 1, mesh.CellType.hexahedron)


def curved(cell="triangle"):
    """Mesh of geometry degree 2: one triangle."""
    element = basix.ufl.element("Lagrange", cell, 2, shape=(2,))
    x = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0.5], [0, 0.5], [0.5, 0]], dtype=float)
    return mesh.create_mesh(COMM, np.arange(6, dtype=np.int64)[None], x=x, e=ufl.Mesh(element))


def surface():
    """Triangles in space."""
    element = basix.ufl.element("Lagrange", "triangle", 1, shape=(3,))
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 1]], dtype=float)
    return mesh.create_mesh(COMM, np.array([[0, 1, 2]], dtype=np.int64), x=x, e=ufl.Mesh(element))


MESHES = {
    "hexahedra": (hexahedra, "triangle.*found hexahedron"),
    "curved": (curved, "geometry degree 1.*found 2"),
    "in space": (surface, "geometric dimension 2.*found 3"),
}


@pytest.mark.parametrize("found", MESHES)
def test_other_meshes_are_refused(found):
    make, words = MESHES[found]
    (kernel,) = _cpp.kernels.find("linear_elastic.force", "triangle", 1, 1, "plane_strain")
    with pytest.raises(RuntimeError, match=f"kernel linear_elastic.force was compiled for.*{words}"):
        kernel.check_mesh(make()._cpp_object)
    kernel.check_mesh(mesh.create_unit_square(COMM, 1, 1)._cpp_object)


def test_other_parts_of_the_cells_are_refused():
    V = fem.functionspace(hexahedra(), ("Lagrange", 1, (3,)))
    form = di.operators.internal_force_form(fem.Function(V), ufl.TestFunction(V), di.LinearElastic(1.0, 0.3))
    with pytest.raises(ValueError, match="part is 'inner': InternalForce takes 'early', 'outer', 'late' or None"):
        di.operators.InternalForce(form, part="inner")


def apply_table_kernel(domain, test_element, u_element, width=1):
    """The table's P1 triangle kernel forced onto a mesh and spaces, as a C++ user might."""
    (kernel,) = _cpp.kernels.find("linear_elastic.force", "triangle", 1, 1, "plane_strain")
    V, U = fem.functionspace(domain, test_element), fem.functionspace(domain, u_element)
    integral = _cpp.operators.Integral(kernel.address, np.zeros(1, dtype=np.int32), np.array([1.0, 0.3]))
    u = fem.Function(U)
    return _cpp.operators.InternalForce_float64(
        domain._cpp_object, V._cpp_object, [integral], {"u": u._cpp_object}, width
    )


P1, P2 = ("Lagrange", 1, (2,)), ("Lagrange", 2, (2,))


@pytest.mark.parametrize(
    "test, coefficient, words",
    [
        (P2, P1, "test space.*degrees of freedom per cell 6.*found 12"),
        (P1, P2, "coefficient u.*6.*found 12"),
        (("Lagrange", 1), P1, "test space.*block size 2.*found 1"),
        (P1, ("Lagrange", 1, (3,)), "coefficient u.*block size 2.*found 3"),
        (P1, ("DG", 1, (2,)), "coefficient u.*P.*found"),
        (("CR", 1, (2,)), P1, "test space.*found degree 1 element of family"),
    ],
)
def test_other_spaces_are_refused(test, coefficient, words):
    apply_table_kernel(mesh.create_unit_square(COMM, 1, 1), P1, P1)
    with pytest.raises(RuntimeError, match=f"kernel linear_elastic.force was compiled for.*{words}"):
        apply_table_kernel(mesh.create_unit_square(COMM, 1, 1), test, coefficient)


def test_operators_refuse_curved_meshes_too():
    with pytest.raises(RuntimeError, match="geometry degree 1.*found 2"):
        apply_table_kernel(curved(), P1, P1)


def test_curved_meshes_get_a_kernel_of_their_own():
    u = operator_checks.displacement(curved(), 1)
    law = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    operator = di.InternalForce(di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), law))
    assert operator.compiled.source != "package"
    operator_checks.equal(operator.apply().array, operator_checks.assembled(operator.form))


def small():
    domain = mesh.create_unit_square(COMM, 2, 2)
    V = fem.functionspace(domain, ("Lagrange", 1))
    return domain, fem.Function(V, name="f"), ufl.TestFunction(V), ufl.TrialFunction(V)


@pytest.mark.parametrize("operator, rank", [(di.InternalForce, 1), (di.Energy, 0), (di.Tangent, 2)])
def test_wrong_arity(operator, rank):
    domain, f, v, du = small()
    for forms_rank, form in enumerate((f * ufl.dx, f * v * ufl.dx, f * v * du * ufl.dx)):
        if forms_rank != rank:
            with pytest.raises(ValueError, match=f"rank {rank}"):
                operator(form)


@pytest.mark.parametrize("operator", [di.InternalForce, di.Energy, di.Tangent])
@pytest.mark.parametrize("wrong", ["u*v*dx", None, 1.0])
def test_not_a_form(operator, wrong):
    with pytest.raises((TypeError, ValueError), match="UFL form"):
        operator(wrong)


def test_symbolic_mesh():
    built = registry.build("row_sum", "triangle", 1)
    with pytest.raises(ValueError, match="symbolic mesh"):
        di.InternalForce(built.form)
    f = ufl.Coefficient(built.form.arguments()[0].ufl_function_space())
    with pytest.raises(ValueError, match="symbolic mesh"):
        di.PointValues(2 * f, [[0.2, 0.2]])


def test_subdomain_data():
    domain, f, v, _ = small()
    cells, facets = operator_checks.tags_of_cells(domain), operator_checks.tags_of_facets(domain)
    with pytest.raises(ValueError, match=r"dx\(1\).*no subdomain_data"):
        di.InternalForce(f * v * ufl.dx(1))
    with pytest.raises(ValueError, match=r"ds\(3\).*no subdomain_data"):
        di.InternalForce(f * v * ufl.ds(3))
    with pytest.raises(ValueError, match="dx needs tags of dimension 2, found.* 1"):
        di.InternalForce(f * v * ufl.Measure("dx", domain, subdomain_data=facets)(3))
    with pytest.raises(ValueError, match="ds needs tags of dimension 1, found.* 2"):
        di.InternalForce(f * v * ufl.Measure("ds", domain, subdomain_data=cells)(1))
    with pytest.raises(TypeError, match="must be MeshTags, found list"):
        di.InternalForce(f * v * ufl.Measure("dx", domain, subdomain_data=[(1, np.arange(2))])(1))
    other = operator_checks.tags_of_cells(domain)
    first, second = (ufl.Measure("dx", domain, subdomain_data=t) for t in (cells, other))
    with pytest.raises(ValueError, match="share one subdomain_data"):
        di.InternalForce(f * v * first(1) + v * second(2))


@pytest.mark.parametrize("width", [2, 16, -1])
def test_width(width):
    domain, f, v, _ = small()
    with pytest.raises(ValueError, match=f"width is {width}.*1, 4 or 8"):
        di.InternalForce(f * v * ufl.dx, width)


def test_vector_of_another_size():
    domain, f, v, _ = small()
    with pytest.raises(ValueError, match="vector has 3 entries.*test space has 9"):
        di.InternalForce(f * v * ufl.dx).assemble(np.zeros(3))


def test_spaces_that_need_transformations():
    domain = mesh.create_unit_square(COMM, 1, 1)
    V = fem.functionspace(domain, ("N1curl", 1))
    v, f = ufl.TestFunction(V), fem.Function(V, name="f")
    with pytest.raises(RuntimeError, match="transformations"):
        di.InternalForce(ufl.inner(f, v) * ufl.dx)


def test_mixed_spaces():
    """A mixed space works or is refused, but is never wrong."""
    domain = mesh.create_unit_square(COMM, 2, 2)
    element = basix.ufl.mixed_element([basix.ufl.element("P", "triangle", d) for d in (2, 1)])
    W = fem.functionspace(domain, element)
    w = fem.Function(W, name="w")
    w.x.array[:] = np.cos(np.arange(w.x.array.size))
    (a, b), (v, q) = ufl.split(w), ufl.TestFunctions(W)
    form = (ufl.inner(ufl.grad(a), ufl.grad(v)) + a * b * q) * ufl.dx
    operator_checks.equal(di.InternalForce(form).apply().array, operator_checks.assembled(form))


def test_ranks_with_other_numbers_of_objects_have_the_same_form():
    """UFL sorts by printed numbers, "10" before "9"; a rank that has made more objects must not seem to differ."""
    square = mesh.create_unit_square(COMM, 1, 1)

    def form():
        """A form with the next two constants."""
        first, second = fem.Constant(square, 1.0), fem.Constant(square, 2.0)
        v = ufl.TestFunction(fem.functionspace(square, ("Lagrange", 1)))
        return (first * second + first**2 * second) * v * ufl.dx

    # The first constant of one form has the last number with so many digits: 9 or 99 or ...
    while set(str(fem.Constant(square, 0.0).count() + 1)) != {"9"}:
        pass
    crossing, inside = form(), form()
    assert crossing.signature() != inside.signature()
    assert describe(crossing) == describe(inside)


@pytest.mark.parametrize("ranks", [2])
def test_same_error_on_two_ranks(script_on_ranks, ranks):
    """Errors met before and after the ranks compile together; the run goes on after each."""
    output = script_on_ranks(
        ranks,
        """
        import ufl
        from dolfinx import fem, mesh
        from mpi4py import MPI
        import dolfinx_impact as di
        comm = MPI.COMM_WORLD
        domain = mesh.create_unit_square(comm, 3, 3)
        V = fem.functionspace(domain, ("Lagrange", 1))
        f, g, v = fem.Function(V, name="f1"), fem.Function(V, name="f1"), ufl.TestFunction(V)
        h = fem.Function(V, name="h")
        N = fem.functionspace(domain, ("N1curl", 1))
        wrong = {
            "arity": lambda: di.Energy(h * v * ufl.dx),
            "names": lambda: di.InternalForce(f * g * v * ufl.dx),
            "tags": lambda: di.InternalForce(h * v * ufl.dx(1)),
            "vertices": lambda: di.InternalForce(h * v * ufl.dP),
            "bessel": lambda: di.InternalForce(ufl.bessel_J(1, h) * v * ufl.dx),
            "space": lambda: di.InternalForce(ufl.inner(fem.Function(N), ufl.TestFunction(N)) * ufl.dx),
            "text": lambda: di.InternalForce("h*v*dx"),
        }
        for name, make in wrong.items():
            try:
                make()
            except (ValueError, TypeError, RuntimeError) as e:
                everywhere = comm.allgather(f"{type(e).__name__}: {e}")
                assert len(set(everywhere)) == 1, everywhere
                print("same", name)
        """,
    )
    assert output.count("same") == 14
