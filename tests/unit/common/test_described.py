# SPDX-License-Identifier: MIT
"""What objects say of themselves when they are printed: what they are, in a line."""

import importlib
import pathlib
import re

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.common.described import Described
from dolfinx_impact.io.run_folder import RunFolder

STEEL = di.LinearElastic(200.0, 0.3, 2.0, "plane_strain")


@pytest.fixture(scope="module")
def square():
    return mesh.create_unit_square(MPI.COMM_SELF, 2, 2)


@pytest.fixture(scope="module")
def facet_tags(square):
    square.topology.create_connectivity(1, 2)
    facets = mesh.exterior_facet_indices(square.topology)
    return mesh.meshtags(square, 1, facets, np.arange(len(facets), dtype=np.int32))


def test_materials(square):
    cells = mesh.meshtags(square, 2, np.arange(8, dtype=np.int32), np.repeat([3, 1], 4).astype(np.int32))
    soft = di.NeoHookean(1.0, 0.2, None, "plane_strain")
    assert repr(STEEL) == "LinearElastic(E=200.0, nu=0.3, density=2.0, hypothesis='plane_strain')"
    assert repr(di.MaterialMap(cells, {3: STEEL, 1: soft})) == f"MaterialMap({{1: {soft!r}, 3: {STEEL!r}}})"
    assert repr(di.Rayleigh(0.5, 0.1)) == "Rayleigh(alpha=0.5, beta=0.1)"


def test_loads(square, facet_tags):
    x = ufl.SpatialCoordinate(square)
    assert repr(di.BodyForce((0, -9.81))) == "BodyForce(vector=[0.0, -9.81], per_mass=True)"
    assert repr(di.BodyForce(x, per_mass=False)) == "BodyForce(vector=expression, per_mass=False)"
    assert repr(di.Traction(facet_tags, 2, (1.0, 0.5))) == "Traction(tag=2, vector=[1.0, 0.5])"
    assert repr(di.FollowerPressure(facet_tags, 3, 7)) == "FollowerPressure(tag=3, pressure=7.0)"


def test_prescribed_motion(square):
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    motion = di.PrescribedMotion(fem.dirichletbc(np.zeros(2), np.array([0, 1, 2], dtype=np.int32), V), 1.0)
    assert repr(motion) == "PrescribedMotion(of 6 degrees of freedom of this rank)"


def test_rigid_obstacles():
    plane = di.RigidPlane((0, 1), (0, -2))
    assert repr(plane) == "RigidPlane(point=[0.0, 1.0, 0.0], normal=[0.0, -1.0, 0.0])"
    plane.displacement = (0.5, 0.0)
    assert repr(plane).endswith(", displacement=[0.5, 0.0, 0.0])")
    assert repr(di.RigidSphere((0, 1, 2), -3)) == "RigidSphere(center=[0.0, 1.0, 2.0], radius=-3.0)"
    cylinder = di.RigidCylinder((0, 1), 2.0)
    assert repr(cylinder) == "RigidCylinder(center=[0.0, 1.0, 0.0], radius=2.0, axis=[0.0, 0.0, 1.0])"
    punch = di.RigidSurface.from_function(lambda x: 0.1 * x**2, (-1, 1), (0, 0), (0, 1))
    assert repr(punch) == "RigidSurface(2D)"
    punch.motion = lambda t: (0.0, t)
    assert repr(punch) == "RigidSurface(2D, motion=...)"


def test_pairs(facet_tags):
    pair = di.ContactPair(facet_tags, slave=1, master=2, friction=0.3)
    assert repr(pair) == "ContactPair('1 on 2': slave 1, master 2, friction 0.3)"
    ball = di.RigidSphere((0, 2), 1)
    named = di.ContactPair(facet_tags, slave=1, master=ball, name="ball")
    assert repr(named) == f"ContactPair('ball': slave 1, master {ball!r}, friction 0.0)"


def test_run_folder(tmp_path):
    assert (
        repr(RunFolder(tmp_path, comm=MPI.COMM_SELF, name="cube"))
        == f"RunFolder({str(tmp_path)!r}, name='cube', ranks=1)"
    )


def test_contacts(facet_tags):
    pair = di.ContactPair(facet_tags, slave=1, master=2)
    assert repr(di.Lagrange(pair)) == f"Lagrange({pair!r}, basis='dual')"
    assert repr(di.Penalty(pair)) == f"Penalty({pair!r}, penalty='auto')"
    augmented = di.Penalty(pair, penalty=10, tangential=5, augmented=True)
    more = "augmented=True, tolerance=1e-08, max_augmentations=200"
    assert repr(augmented) == f"Penalty({pair!r}, penalty=10.0, tangential=5.0, {more})"
    assert repr(di.Penalty(pair, quadrature_degree=3)) == f"Penalty({pair!r}, penalty='auto', quadrature_degree=3)"
    assert repr(di.Lagrange(pair, 4)) == f"Lagrange({pair!r}, basis='dual', quadrature_degree=4)"
    wide = di.ContactPair(facet_tags, 1, 2, search_distance=0.5, remove_penetration=True, smooth=(True, False))
    assert repr(wide).endswith("friction 0.0, search_distance 0.5, remove_penetration, smooth slave, crease 30)")
    assert repr(di.Kinematic(pair)) == f"Kinematic({pair!r}, sweeps=3)"


def test_problems_and_report(square):
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    fixed = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: x[0] < 0.1), V)
    static = di.StaticProblem(fem.Function(V), STEEL, bcs=[fixed], loads=[di.BodyForce((0, -1))])
    assert repr(static) == f"StaticProblem(18 unknowns, {STEEL!r}, 1 boundary conditions, 1 loads, 0 contacts)"
    report = static.solve(steps=2)
    assert str(report) == f"Report: converged, 2 increments, {sum(report.iterations)} iterations"
    explicit = di.ExplicitProblem(fem.Function(V), STEEL, velocity=fem.Function(V))
    assert repr(explicit) == f"ExplicitProblem(18 unknowns, {STEEL!r}, 0 loads, 0 contacts, step 0, time 0)"


def test_operators(square):
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
    form = ufl.inner(u, v) * ufl.dx(degree=2) + v[0] * ufl.ds(degree=1)
    force, cells = di.InternalForce(form, width=1), "8 triangle cells on this rank"
    assert repr(force) == f"InternalForce(integrals: 1 cell, 1 exterior_facet, of u; {cells}, 1 at once)"
    energy = di.Energy(ufl.inner(u, u) * ufl.dx(degree=2), width=1)
    assert repr(energy) == f"Energy(integrals: 1 cell, of u; {cells}, 1 at once)"
    fixed = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: x[0] < 0.1), V)
    tangent = di.Tangent(ufl.derivative(form, u), fixed)
    assert repr(tangent) == f"Tangent(18 x 18, 1 boundary conditions; {cells})"
    points = di.PointValues(ufl.grad(u), [[0.2, 0.2], [0.3, 0.3]])
    assert repr(points) == f"PointValues(values of shape (2, 2) at 2 points; {cells})"


def test_recorders_and_pictures(square, tmp_path):
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    run = di.ExplicitProblem(fem.Function(V), STEEL)
    fixed = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: x[0] < 0.1), V)
    static = di.StaticProblem(fem.Function(V, name="u"), STEEL, bcs=fixed)
    recorders = [run.record(tmp_path / "a", ["velocity"], every=5), static.record(tmp_path / "b", every=2)]
    assert repr(recorders[0]) == f"Recorder({str(tmp_path / 'a')!r}, every 5 steps: velocity)"
    assert repr(recorders[1]) == f"LoadStepRecorder({str(tmp_path / 'b')!r}, every 2 increments: displacement)"
    for recorder in recorders:
        recorder.close()
    assert repr(di.DeformedBody(static.u, scale=3)) == "DeformedBody(displacement, 0 to 0, displacement x 3)"


def test_every_class_of_the_interface_says_what_it_is():
    """By a method of its own: neither its address, nor the first line of what it is for alone."""
    pages = (pathlib.Path(__file__).parents[3] / "docs" / "api").glob("*.md")
    named = {name for page in pages for name in re.findall(r"autoclass:: dolfinx_impact\.([\w.]+)", page.read_text())}
    found = [thing for name in di.__all__ if isinstance(thing := getattr(di, name), type)]
    for name in named:
        module, _, last = name.rpartition(".")
        found.append(getattr(importlib.import_module(f"dolfinx_impact.{module}".rstrip(".")), last))
    mute = {c.__name__ for c in found if c.__repr__ in (object.__repr__, Described.__repr__)}
    assert len(found) > 40 and not mute


def returned(thing):
    """The objects of this package that an object's documented attributes are, or lists of them have: those that its
    docstring names, and its properties."""
    found, documented = [], (type(thing).__doc__ or "").partition("Attributes:")[2]
    for name in (name for name in dir(thing) if not name.startswith("_")):
        if f" {name}: " not in documented and not isinstance(getattr(type(thing), name, None), property):
            continue
        try:
            value = getattr(thing, name)
        except (AttributeError, ValueError, RuntimeError):  # what there is none of
            continue
        for item in value if isinstance(value, (list, tuple)) else [value]:
            module = type(item).__module__
            if module.startswith("dolfinx_impact.") and not module.endswith("_cpp") and not callable(item):
                found.append(item)
    return found


def test_all_that_problems_return(square, facet_tags):
    """No object that a public attribute leads to prints its address."""
    floor = di.RigidPlane((0, 0), (0, 1))
    tags = mesh.meshtags(square, 1, mesh.locate_entities_boundary(square, 1, lambda x: np.isclose(x[1], 0)), 1)
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    fixed = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: x[1] > 0.9), V)
    pair = di.ContactPair(tags, 1, floor, friction=0.1)
    law = di.J2Plasticity(200.0, 0.3, 2.0, yield_stress=1.0, hypothesis="plane_strain")
    load = [di.BodyForce((0, -0.1)), di.Foundation(facet_tags, 3, 1.0)]
    problems = [di.StaticProblem(fem.Function(V), law, bcs=[fixed], loads=load, contact=[di.Lagrange(pair)])]
    problems.append(di.StaticProblem(fem.Function(V), STEEL, bcs=[fixed], contact=[di.Penalty(pair)]))
    reports = [problem.solve() for problem in problems]
    for method in (di.Penalty, di.Kinematic):
        problems.append(di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V), contact=[method(pair)]))
    problems.append(di.NewmarkProblem(fem.Function(V), law, velocity=fem.Function(V), contact=[di.Lagrange(pair)]))
    seen = [thing for one in (*problems, *reports) for thing in (one, *returned(one))]
    names = {type(thing).__name__ for thing in seen}
    assert {"LagrangeContact", "QuadraturePenalty", "NodalPair", "Report"} <= names
    assert [] == sorted(
        {type(thing).__module__ + "." + type(thing).__name__ for thing in seen if " object at 0x" in repr(thing)}
    )
    assert "force on the slave" in repr(problems[0].contact[0]) and repr(pair) in repr(problems[2].contact[0])
