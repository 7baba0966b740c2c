# SPDX-License-Identifier: MIT
"""Strains of bodies with internal variables: parts of an averaged strain, and the mean stress that laws may name."""

import dataclasses

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.inelastic_part import InelasticPart
from dolfinx_impact.assembly.operators import InternalForce, cells_measure
from dolfinx_impact.forms import inelastic
from impact_verify.material_tangent import TangentOfBody

ROUND_OFF = 1e-13  # relative to the largest force; sums of some hundred terms


@pytest.fixture
def u():
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 2, 2, 2, mesh.CellType.hexahedron)
    rng = np.random.default_rng(3)
    cube.geometry.x[:] += 0.05 * rng.uniform(-1.0, 1.0, cube.geometry.x.shape)  # averages differ from values at points
    u = fem.Function(fem.functionspace(cube, ("Lagrange", 1, (3,))), name="u")
    u.x.array[:] = 0.02 * rng.uniform(-1.0, 1.0, u.x.array.shape)
    return u


def force(u, change=None, **law):
    """Internal force of a material that yields, with a change of what its law returns."""
    material = di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=1.0, hardening=50.0, **law)
    dx, degree = cells_measure(u, material)
    part = InelasticPart(u, material, dx, degree, None)
    if change is not None:
        respond = part.response.respond
        part.response.respond = lambda *given: change(respond(*given))
    form, law = part.force(ufl.TestFunction(u.function_space))
    operator = InternalForce(form, law=law)
    return operator.apply().array.copy()


def difference(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


def test_a_mean_stress_saves_work_and_changes_nothing(u):
    expected = force(u, lambda update: dataclasses.replace(update, mean=None))
    assert difference(force(u), expected) < ROUND_OFF


FINITE = [{"finite_strain": True}, {"finite_strain": True, "kinematic": 20.0}]


@pytest.mark.parametrize("law", FINITE, ids=("isotropic", "kinematic"))
def test_a_mean_stress_of_finite_strain_saves_work_and_changes_nothing(u, law):
    expected = force(u, lambda update: dataclasses.replace(update, mean=None), **law)
    assert difference(force(u, **law), expected) < ROUND_OFF

    # What would come out if the dilatation of each point did the work of the mean stress, without the factor J/theta:
    def wrong(update):
        return dataclasses.replace(update, piola=update.stress)

    assert difference(force(u, wrong, **law), expected) > 1e-5


def test_derivatives_of_positions_make_the_same_force(u):
    plain = inelastic.Kinematics("3d", True, True)
    laws = [di.J2Plasticity(1.0, 0.3, yield_stress=1.0, **law).response(u.function_space.mesh) for law in FINITE]
    assert [inelastic.DeformedCell.serves(law, plain) for law in laws] == [True, False]
    # Without what DeformedCell.takes, F and its inverse are computed.
    expected = force(u, lambda update: dataclasses.replace(update, kirchhoff=None), finite_strain=True)
    assert difference(force(u, finite_strain=True), expected) < ROUND_OFF


def test_a_mean_stress_of_finite_strain_that_varies_in_the_cell_is_averaged(u):
    def varying(named):
        def change(update):
            pressure = 10.0 * ufl.tr(ufl.grad(u))
            F = ufl.Identity(3) + ufl.grad(u)
            root = (ufl.cell_avg(ufl.det(F)) / ufl.det(F)) ** (1 / 3)
            more = pressure * ufl.inv(F).T
            mean = update.mean + pressure if named else None
            return dataclasses.replace(update, stress=update.stress + more / root, piola=update.piola + more, mean=mean)

        return change

    assert difference(force(u, varying(True), **FINITE[0]), force(u, varying(False), **FINITE[0])) < ROUND_OFF


def test_gradient_and_dilatation_of_an_averaged_strain(u):
    F = ufl.Identity(3) + ufl.grad(u)
    averaged = inelastic.Kinematics("3d", True, True)
    assert inelastic.gradient_and_dilatation(averaged.strain(u)) == (F, averaged.projection(u))
    linear, theta = inelastic.Kinematics("3d", True, "linear"), fem.Constant(u.function_space.mesh, 1.1)
    assert inelastic.gradient_and_dilatation(linear.strain(u, theta)) == (F, theta)
    assert inelastic.gradient_and_dilatation(linear.strain(u))[0] == F
    for plain in (F, 2 * F, inelastic.Kinematics("3d", True).strain(u)):
        assert inelastic.gradient_and_dilatation(plain) == (plain, ufl.det(plain))


def test_a_mean_stress_that_varies_in_the_cell_is_averaged(u):
    """The average must not be left out then."""
    g = ufl.grad(u)

    def varying(named):
        def change(update):
            pressure = 10.0 * ufl.tr(g)
            mean = update.mean + pressure if named else None
            return dataclasses.replace(update, stress=update.stress + pressure * ufl.Identity(3), mean=mean)

        return change

    with_average = force(u, varying(False))
    assert difference(force(u, varying(True)), with_average) < ROUND_OFF
    # What would come out without the check, from a law whose mean claims not to vary:
    wrong = force(u, lambda update: dataclasses.replace(varying(False)(update), mean=update.mean))
    assert difference(wrong, with_average) > 1e-5


def test_same_in_cell(u):
    g = ufl.grad(u)
    constant = fem.Constant(u.function_space.mesh, 2.0)
    assert inelastic.same_in_cell(3 * constant * ufl.cell_avg(ufl.tr(g)))
    x = ufl.SpatialCoordinate(u.function_space.mesh)
    for varies in (ufl.tr(g), ufl.cell_avg(ufl.tr(g)) + ufl.tr(g), constant * x[0]):
        assert not inelastic.same_in_cell(varies)


def test_parts_of_an_averaged_strain():
    """At a point, with numbers: trace and deviator are those that UFL gives."""
    rng = np.random.default_rng(1)
    g, theta = ufl.as_tensor(rng.normal(size=(3, 3)).tolist()), 0.7
    averaged = ufl.dev(ufl.sym(g)) + theta / 3 * ufl.Identity(3)
    for strain in (averaged, ufl.sym(g)):
        assert inelastic.trace(strain)(()) == pytest.approx(ufl.tr(strain)(()), abs=1e-14)
        for i, j in np.ndindex(3, 3):
            expected = ufl.dev(strain)[i, j](())
            assert inelastic.deviator(strain)[i, j](()) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("stretches", [(1.0, 1.0), (1.5, 0.9), (0.7, 0.8), (1.4, 1.4)], ids=str)
def test_the_elastic_stiffness_of_a_sheet_bounds_its_tangent(stretches):
    """A sheet that has yielded and is unloaded a little: eigenvalues of its tangent, to the elastic strains (2 %), lie
    below those of the stiffness that explicit steps are bounded by, and as far as the area has grown."""
    body = TangentOfBody("quadrilateral", 1, "plane_stress", True, {"hardening": 0.01})
    x = body.V.tabulate_dof_coordinates()[:, :2]
    u = (x * (np.array(stretches) - 1)).ravel()
    d = body.homogeneous(1.0)
    for part in (0.25, 0.5, 0.75, 1.0):
        body.force(part * u)
        body.body.in_cpp().accept_step()
    assert stretches == (1.0, 1.0) or body.body.force.history.values("plastic_strain").min() > 0.1
    plastic = np.array([body.action(u - 1e-4 * u, e) for e in np.eye(len(d))])
    (part,) = body.body.parts
    du, v = ufl.TrialFunction(body.V), ufl.TestFunction(body.V)
    elastic = fem.assemble_matrix(fem.form(part.elastic_tangent(du, v))).to_dense()
    largest = [np.linalg.eigvalsh((K + K.T) / 2)[-1] for K in (plastic, elastic)]
    assert largest[0] <= 1.02 * largest[1]
    assert largest[1] <= 1.02 * max(1.0, np.prod(stretches)) * largest[0]
