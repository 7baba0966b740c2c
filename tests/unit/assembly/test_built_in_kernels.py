# SPDX-License-Identifier: MIT
"""Forms whose integrals have kernels that come with the package: materials by cell tags, loads on tagged facets."""

import dolfinx.fem.petsc as petsc
import numpy as np
import pytest
import scipy.sparse
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import jit, operators
from dolfinx_impact.assembly.cauchy_stress import CauchyStress
from dolfinx_impact.forms import quadrature

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
TOP = 7


class Body:
    """Box of two materials, loaded on its upper side, with a displacement that is not affine."""

    def __init__(self, cell="quadrilateral", degree=1, hypothesis=None):
        dim = CELLS[cell]
        create = mesh.create_rectangle if dim == 2 else mesh.create_box
        low, high = np.array([1.0, 0.0, 0.0])[:dim], np.array([2.0, 1.0, 1.0])[:dim]  # r > 0
        self.mesh = create(MPI.COMM_SELF, [low, high], [3] * dim, getattr(mesh.CellType, cell))
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (dim,)))
        self.u, self.other = (fem.Function(self.V, name=name) for name in ("u", "other"))
        for f, size in ((self.u, 0.01), (self.other, 0.02)):
            f.interpolate(lambda x: size * np.array([np.sin(x[0] + 2 * x[1]), x[0] * x[1], np.cos(x[2] + x[0])])[:dim])
        cells = np.arange(self.mesh.topology.index_map(dim).size_local, dtype=np.int32)
        self.tags = mesh.meshtags(self.mesh, dim, cells, (1 + cells % 2).astype(np.int32))
        top = mesh.locate_entities_boundary(self.mesh, dim - 1, lambda x: np.isclose(x[1], 1.0))
        self.facet_tags = mesh.meshtags(self.mesh, dim - 1, np.sort(top), np.full(len(top), TOP, dtype=np.int32))
        self.hypothesis = hypothesis or ("3d" if dim == 3 else "plane_strain")
        soft, stiff = (di.LinearElastic(E, 0.3, E / 10, self.hypothesis) for E in (10.0, 20.0))
        self.materials = di.MaterialMap(self.tags, {1: soft, 2: stiff})
        self.loads = [
            di.Traction(self.facet_tags, TOP, np.arange(1.0, 1.0 + dim)),
            di.BodyForce(np.arange(2.0, 2.0 + dim)),
            di.BodyForce(np.arange(3.0, 3.0 + dim), per_mass=False),
        ]

    @property
    def v(self):
        return ufl.TestFunction(self.V)

    @property
    def du(self):
        return ufl.TrialFunction(self.V)

    def forms(self):
        """Forms of rank 0, 1 and 2."""
        yield operators.strain_energy_form(self.u, self.materials)
        yield operators.internal_force_form(self.u, self.v, self.materials)
        yield operators.tangent_form(self.u, self.du, self.v, self.materials)
        for load in self.loads[:2]:
            yield load.form(self.u, self.v, self.materials)


def by_ffcx(form):
    compiled = fem.form(form)
    if compiled.rank == 0:
        return fem.assemble_scalar(compiled)
    return petsc.assemble_vector(compiled).array if compiled.rank == 1 else fem.assemble_matrix(compiled).to_dense()


def by_kernels(form):
    rank = len(form.arguments())
    if rank == 2:
        tangent = di.Tangent(form)
        assert tangent.form is None  # no form of DOLFINx
        rows, columns, values = tangent.assemble().getValuesCSR()
        return scipy.sparse.csr_matrix((values, columns, rows)).toarray()
    operator = (di.Energy, di.InternalForce)[rank](form)
    assert operator.compiled.source == "package"
    return operator.value() if rank == 0 else operator.apply().array


CASES = [(cell, degree, None) for cell in CELLS for degree in (1, 2)]
CASES += [
    (cell, 1, hypothesis) for cell in ("triangle", "quadrilateral") for hypothesis in ("plane_stress", "axisymmetric")
]


@pytest.mark.parametrize("cell, degree, hypothesis", CASES)
def test_each_integral_has_its_kernel_and_its_numbers(cell, degree, hypothesis):
    body = Body(cell, degree, hypothesis)
    for form in body.forms():
        theirs = by_ffcx(form)
        # Sums of a few numbers of the largest one's size, in two orders.
        np.testing.assert_allclose(by_kernels(form), theirs, atol=1e-13 * np.abs(theirs).max(), rtol=0)


def test_constants_belong_to_their_integrals():
    """Changed one by one, after the operator was made; 1e-12 is round-off of sums of numbers up to 1e2."""
    body = Body()
    form = sum(load.form(body.u, body.v, body.materials) for load in body.loads[:2])
    operator = di.InternalForce(form)
    assert operator.compiled.source == "package"
    for constant in form.constants():
        constant.value *= 3.0
        np.testing.assert_allclose(operator.apply().array, by_ffcx(form), atol=1e-12)


def test_stress_of_two_materials():
    body = Body()
    stress = CauchyStress(body.u, body.materials)
    assert stress._force.compiled.source == "package"
    found = stress.values()
    for tag, material in body.materials.parts():
        alone = CauchyStress(body.u, material).values()
        np.testing.assert_array_equal(found[body.tags.find(tag)], alone[body.tags.find(tag)])


def test_integrals_over_the_same_cells_are_compiled_together():
    """One pass over the cells is faster than two."""
    body = Body()
    elastic = di.LinearElastic(10.0, 0.3, 1.0, "plane_strain")
    force = operators.internal_force_form(body.u, body.v, elastic)
    assert jit.find_form(force).source == "package"
    for both in (force + force, force + body.loads[2].form(body.u, body.v, elastic)):
        assert jit.find_form(both) is None and jit.compile_form(both).source != "package"


def test_everywhere_and_a_tag_overlap():
    body = Body()
    f = fem.Constant(body.mesh, (2.0, 1.0))
    degree = quadrature.mass_degree("quadrilateral", 1, 1, "plane_strain")
    dx = ufl.dx(domain=body.mesh, subdomain_data=body.tags, metadata=quadrature.metadata(degree))
    work = ufl.inner(f, body.v)
    assert jit.find_form(work * dx) is not None and jit.find_form(work * dx(1)) is not None
    assert jit.find_form(work * dx + work * dx(1)) is None
    assert jit.find_form(work * dx(1) + work * dx(2)) is not None


def test_a_kernel_has_one_name_for_one_function():
    """Both kernels call their displacement "u": with two functions the form is compiled as it stands."""
    body = Body()
    soft, stiff = (m for _, m in body.materials.parts())
    dx = operators.cells_measure(body.u, body.materials)[0]
    form = 0
    for f, m, tag in ((body.u, soft, 1), (body.other, stiff, 2)):
        law = m.law(body.mesh)
        form += ufl.inner(law.stress(f), law.gradient(body.v)) * dx(tag)
    assert jit.find_form(form) is None
    operator = di.InternalForce(form)
    np.testing.assert_allclose(operator.apply().array, by_ffcx(form), atol=1e-14)  # round-off of numbers of size one


def test_a_form_without_kernels_is_not_compiled(monkeypatch):
    body = Body()
    monkeypatch.setattr(jit, "_from_cache", None)  # would be called to compile
    assert jit.find_form(ufl.inner(ufl.sin(body.u[0]) * body.u, body.v) * ufl.dx) is None
    assert jit.find_form(operators.internal_force_form(body.u, body.v, body.materials)).source == "package"


def test_placing_a_kernel_takes_a_number_for_each_object():
    (kernel,) = jit.compile_form(
        operators.strain_energy_form(Body().u, di.LinearElastic(1.0, 0.3, 1.0, "plane_strain"))
    ).kernels
    placed = kernel.placed([4, 5], [3], [2, 1])
    assert placed.subdomains == [4, 5] and kernel.subdomains == [-1]
    assert [c["position"] for c in placed.coefficients] == [3]
    assert [c["position"] for c in placed.constants] == [2, 1] and [c["name"] for c in placed.constants] == ["E", "nu"]
    for wrong in (([1], [], [0, 1]), ([1], [0], [0])):
        with pytest.raises(ValueError, match="give each its number"):
            kernel.placed(*wrong)


def test_own_forms_list_what_an_integral_reads():
    """Of tagged cells, a kernel that is compiled at run time has the coefficients of its own cells."""
    body = Body()
    dx = operators.cells_measure(body.u, body.materials)[0]
    form = sum(ufl.inner(f + ufl.sin(f[0]) * f, body.v) * dx(tag) for f, tag in ((body.u, 1), (body.other, 2)))
    compiled = jit.compile_form(form)
    assert compiled.source != "package"
    names = [[c["name"] for c in kernel.coefficients] for kernel in compiled.kernels]
    assert names == [["u"], ["other"]]
    force = di.InternalForce(form).apply().array
    np.testing.assert_allclose(force, by_ffcx(form), atol=1e-14)  # as above
