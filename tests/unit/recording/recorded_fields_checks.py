# SPDX-License-Identifier: MIT
"""Fields of materials and contacts that problems record, read back from XDMF's HDF5 files. See on_ranks.py.

Two blocks, or a block and a rigid plane, are pressed together. Poisson's ratio is zero, so that the equilibrium is
uniform: the stress across the contact is minus its pressure, exactly, under every law and method.
"""

import re

import basix.ufl
import h5py
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
E, NU, N, PRESS, YIELD = 1e3, 0.0, 3, 0.02, 5.0
CONTACTS = ("pressure", "gap", "traction", "shear_traction", "slip", "status")
LAWS = {
    "linear": (di.LinearElastic, {}),
    "neo-Hooke": (di.NeoHookean, {}),
    "St. Venant-Kirchhoff": (di.StVenantKirchhoff, {}),
    "plastic": (di.J2Plasticity, {"yield_stress": YIELD, "hardening": 0.1 * E}),
}


def law(name="linear"):
    kind, more = LAWS[name]
    return kind(E, NU, 1.0, hypothesis="plane_strain", **more)


class Blocks:
    """A unit square, 1 at its lower side and 2 at its upper one; with `two` another one below, 3 on top and 4 below."""

    def __init__(self, two=False, degree=1, friction=0.2):
        number = np.arange((N + 1) ** 2).reshape(N + 1, N + 1)
        quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]], axis=-1).reshape(-1, 4)
        y, x = np.meshgrid(np.linspace(0, 1, N + 1), np.linspace(0, 1, N + 1), indexing="ij")
        points = np.column_stack([x.ravel(), y.ravel()])
        if two:
            points, quads = np.vstack([points, points - [0, 1]]), np.vstack([quads, quads + number.size])
        if COMM.rank > 0:
            points, quads = np.zeros((0, 2)), np.zeros((0, 4), dtype=np.int64)
        element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
        self.mesh = mesh.create_mesh(COMM, quads, x=points, e=element)
        self.two, self.V = two, fem.functionspace(self.mesh, ("Lagrange", degree, (2,)))
        middles = mesh.compute_midpoints(self.mesh, 2, np.arange(self._count(2), dtype=np.int32))[:, 1]
        self.upper = np.flatnonzero(middles > 0.0)
        found = {1: self._side(0.0, True), 2: self._side(1.0, True)}
        if two:
            found |= {3: self._side(0.0, False), 4: self._side(-1.0, False)}
        facets = np.concatenate(list(found.values()))
        values = np.repeat(list(found), [len(f) for f in found.values()]).astype(np.int32)
        self.tags = mesh.meshtags(self.mesh, 1, facets[np.argsort(facets)], values[np.argsort(facets)])
        # The plane approaches the block, which is what pressing the block on it does.
        self.plane = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
        self.pair = di.ContactPair(self.tags, 1, 3 if two else self.plane, friction=friction)

    def _count(self, dim):
        self.mesh.topology.create_connectivity(dim, 2)
        index_map = self.mesh.topology.index_map(dim)
        return index_map.size_local + index_map.num_ghosts

    def _side(self, y, upper):
        """Facets along a side of the upper or the lower block."""
        facets = mesh.locate_entities_boundary(self.mesh, 1, lambda x: np.isclose(x[1], y))
        self.mesh.topology.create_connectivity(1, 2)
        cells = [self.mesh.topology.connectivity(1, 2).links(f)[0] for f in facets]
        return facets[np.isin(cells, self.upper) == upper]

    def held(self):
        """The upper side is pressed down, the lower one of two blocks held; the left ones are planes of symmetry."""
        left = mesh.locate_entities_boundary(self.mesh, 1, lambda x: np.isclose(x[0], 0.0))
        W = self.V.sub(0)
        bcs = [self._bc(2, 1, -PRESS), fem.dirichletbc(0.0, fem.locate_dofs_topological(W, 1, left), W)]
        return [*bcs, self._bc(4, 1, 0.0)] if self.two else bcs

    def _bc(self, tag, axis, value):
        W = self.V.sub(axis)
        return fem.dirichletbc(value, fem.locate_dofs_topological(W, 1, self.tags.find(tag)), W)

    def falling(self):
        f = fem.Function(self.V)
        dofs = fem.locate_dofs_topological(self.V, 2, self.upper.astype(np.int32))
        f.x.array[2 * dofs + 1], f.x.array[2 * dofs] = -1.0, 0.5
        return f


def read(path, series, frame=-1):
    """Points and fields by name of one frame of a series, on every rank."""
    COMM.barrier()
    with h5py.File(path / f"{series}.h5", "r") as file:
        frame = len(file["time"]) + frame if frame < 0 else frame
        fields = {name: group[str(frame)][:].squeeze() for name, group in file["fields"].items()}
        points = file["mesh/points"][:]
    COMM.barrier()
    return points, fields


def at_points(contact, values, points):
    """Values of a contact's nodes, gathered from all ranks, in the order of the points of a file; NaN elsewhere."""
    V = contact.problem.space
    nodes, found = contact.at_nodes(values)
    own = nodes < V.dofmap.index_map.size_local
    x = V.tabulate_dof_coordinates()[nodes[own]]
    x, found = (np.concatenate(COMM.allgather(a)) for a in (x, found[own]))
    out = np.full((len(points), *found.shape[1:]), np.nan)
    for place, value in zip(x, found):  # a point of the file for each node; two blocks have two at a place
        out[np.all(np.isclose(points, place), axis=1)] = value
    return out


def check_static_problems():
    """Laws and contacts: the stress across the contact is minus its pressure."""
    cases = [("linear", di.Lagrange, False), ("linear", di.Penalty, True), ("neo-Hooke", di.Penalty, False)]
    cases += [("St. Venant-Kirchhoff", di.Lagrange, True), ("plastic", di.Lagrange, False)]
    with shared_folder() as path:
        for k, (name, contact, two) in enumerate(cases):
            blocks = Blocks(two, friction=0.0)
            u = fem.Function(blocks.V)
            problem = di.StaticProblem(u, law(name), bcs=blocks.held(), contact=contact(blocks.pair))
            fields = [
                "displacement",
                "stress",
                "von_mises",
                *CONTACTS,
                *(["plastic_strain"] if name == "plastic" else []),
            ]
            recorder = problem.record(path / str(k), fields, ending=".xdmf")
            problem.solve(steps=2)
            recorder.close()
            points, found = read(path / str(k), "contact")
            slave = np.isfinite(found["gap"])
            assert np.count_nonzero(slave) == N + 1
            pressure = found["pressure"][slave]
            assert pressure == pytest.approx(problem.contact[0].force[1], rel=1e-6)  # of a side of length one
            _, of_bodies = read(path / str(k), "materials")
            # Relative to the pressure; Newton's method ends at 1e-10 of it.
            assert of_bodies["stress_yy"] == pytest.approx(-pressure[0], rel=1e-6)
            assert found["traction_y"][slave] == pytest.approx(pressure, rel=1e-6)
            assert np.all(found["status"][slave] > 0) and np.all(found["pressure"][~slave] == 0.0)
            assert found["shear_traction_x"] == pytest.approx(0.0, abs=1e-6 * pressure[0])
            if name != "plastic":
                assert of_bodies["von_mises"] == pytest.approx(pressure[0], rel=1e-6)
            else:
                assert of_bodies["von_mises"] == pytest.approx(YIELD + 0.1 * E * of_bodies["plastic_strain"], rel=1e-6)
                assert of_bodies["plastic_strain"].min() > 1e-3
            with h5py.File(path / str(k) / "history.h5", "r") as file:
                assert file["load_step"][:].tolist() == [0.5, 1.0]
                np.testing.assert_array_equal(file["force_0"][-1], problem.contact[0].force)


def check_problems_in_time():
    """Every method: what is in the file is what the contact tells, and the run is the same without recorder."""
    cases = [(di.ExplicitProblem, di.Penalty, True), (di.ExplicitProblem, di.Kinematic, False)]
    cases += [(di.NewmarkProblem, di.Lagrange, True), (di.NewmarkProblem, di.Penalty, False)]
    with shared_folder() as path:
        for k, (kind, method, two) in enumerate(cases):
            blocks = Blocks(two)
            options = {"penalty": 10 * E} if kind is di.NewmarkProblem and method is di.Penalty else {}
            problem, alone = (
                kind(fem.Function(blocks.V), law(), velocity=blocks.falling(), contact=method(blocks.pair, **options))
                for _ in range(2)
            )
            folder = path / str(k)
            recorder = problem.record(folder, [*CONTACTS, "von_mises"], every=2, ending=".xdmf")
            for one in (problem, alone):
                one.advance(6e-3, dt=1e-3, progress=False)
            recorder.close()
            assert problem.step == 6
            contact = problem.contact[0]
            # Solvers of several ranks do not add up in the same order twice.
            np.testing.assert_allclose(contact.force, alone.contact[0].force, rtol=0, atol=1e-9 * E)
            np.testing.assert_allclose(problem.u.x.array, alone.u.x.array, rtol=0, atol=1e-12)
            points, found = read(folder, "contact")
            slave = np.isfinite(found["gap"])
            assert np.count_nonzero(slave) == N + 1 and np.all(found["pressure"][~slave] == 0.0)
            for name in ("pressure", "gap", "status", "shear_traction"):
                values = at_points(contact, getattr(contact, name), points)[slave]
                recorded = found.get(name, found.get(f"{name}_x"))[slave]
                np.testing.assert_array_equal(recorded, values if values.ndim == 1 else values[:, 0])
            # Coulomb's law, and friction against the motion of the slave along x. The means of a penalty's points obey
            # it as the points do.
            assert found["pressure"].max() > 0.0 and found["shear_traction_x"].min() < 0.0
            assert np.all(np.abs(found["shear_traction_x"]) <= 0.2 * found["pressure"] * (1 + 1e-9))


def check_balanced_contact():
    """Its pressure and traction are those that act: they add up to the force, as in contact of one direction."""
    for balanced in (False, True):
        blocks = Blocks(True, friction=0.0)
        problem = di.ExplicitProblem(
            fem.Function(blocks.V), law(), velocity=blocks.falling(), contact=di.Penalty(blocks.pair, balanced=balanced)
        )
        problem.advance(6e-3, dt=1e-3, progress=False)
        contact = problem.contact[0]
        total = COMM.allreduce(float(contact.pressure @ contact.weight))
        # Both directions have the same pressures but for the motion of the slave along the master, 1 % of a facet, and
        # the deformed surfaces are not quite level.
        assert total == pytest.approx(contact.force[1], rel=1e-3) and total > 0.0
        assert COMM.allreduce(float(contact.weight @ contact.traction[:, 1])) == pytest.approx(total, rel=1e-3)


def check_expressions():
    """A residual of one's own whose stress is given records what the material records; other shapes have components."""
    blocks = Blocks()
    steel, u = law("neo-Hooke"), fem.Function(blocks.V)
    v = ufl.TestFunction(blocks.V)
    residual = ufl.inner(steel.stress(u), steel.law(blocks.mesh).gradient(v)) * ufl.dx(degree=2)
    own = di.StaticProblem(u, residual=residual, bcs=blocks.held(), contact=di.Lagrange(blocks.pair))
    by_name = di.StaticProblem(fem.Function(blocks.V), steel, bcs=blocks.held(), contact=di.Lagrange(blocks.pair))
    x = ufl.SpatialCoordinate(blocks.mesh)
    given = {"stress": steel.cauchy_stress(u), "place": x, "twice": 2 * u[1] + 0 * x[0]}
    with shared_folder() as path:
        recorder = own.record(path / "own", ["stress", "von_mises"], expressions=given, ending=".xdmf", units=di.SI)
        other = by_name.record(path / "named", ["stress", "von_mises"], ending=".xdmf")
        for problem in (own, by_name):
            problem.solve()
        recorder.close()
        other.close()
        points, found = read(path / "own", "materials")
        _, expected = read(path / "named", "materials")
        assert {*found} == {*expected, "place_0", "place_1", "twice"}
        for name, values in expected.items():
            np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-8 * E * PRESS)
        inside = np.all((points[:, :2] > 0.1) & (points[:, :2] < 0.9), axis=1)
        np.testing.assert_allclose(found["place_1"][inside], points[inside, 1], atol=1e-12)
        text = (path / "own" / "materials.xdmf").read_text()
        assert 'Name="von_mises [Pa]"' in text and 'Name="place_0"' in text
        with h5py.File(path / "own" / "materials.h5", "r") as file:
            assert file["fields/stress_xx/0"].attrs["units"] == "Pa"


def check_several_contacts():
    """Their fields are numbered."""
    blocks = Blocks()
    pairs = [blocks.pair, di.ContactPair(blocks.tags, 2, di.RigidPlane((0.0, 1.0), (0.0, -1.0)))]
    problem = di.ExplicitProblem(fem.Function(blocks.V), law(), contact=[di.Penalty(pair) for pair in pairs])
    with shared_folder() as path:
        problem.record(path / "run", ["pressure"], ending=".xdmf").close()
        _, found = read(path / "run", "contact")
        assert {*found} == {"pressure_0", "pressure_1"}


def check_what_is_refused():
    blocks = Blocks()
    steel, u = law(), fem.Function(blocks.V)
    v = ufl.TestFunction(blocks.V)
    residual = ufl.inner(steel.stress(u), steel.law(blocks.mesh).gradient(v)) * ufl.dx
    own = di.ExplicitProblem(u, residual=residual, density=1.0)
    named = di.StaticProblem(fem.Function(blocks.V), steel, bcs=blocks.held())
    for call, kind, words in (
        (lambda: own.record("x", ["von_mises"]), ValueError, "your own.*3 x 3 UFL tensor.*expressions="),
        (lambda: own.stress, ValueError, "your own.*3 x 3 UFL tensor"),
        (lambda: own.record("x", ["von_mises"], expressions={"stress": ufl.grad(u)}), ValueError, r"\(2, 2\).*3 x 3"),
        (lambda: own.record("x", expressions={"von_mises": u[0]}), ValueError, "follows from the stress"),
        (lambda: own.record("x", expressions={"T": 3.0}), TypeError, "T must be a UFL expression, found float"),
        (lambda: own.record("x", expressions=[u[0]]), TypeError, "expressions must be a dict"),
        (lambda: own.record("x", expressions={"pressure": u[0]}), ValueError, r"\['pressure'\].*take others"),
        (lambda: own.record("x", [u]), TypeError, "fields must hold names, found Function"),
        (lambda: named.record("x", ["pressure"]), ValueError, "are those of contacts, and the problem has none"),
        (lambda: named.record("x", ["velocity"]), ValueError, r"\['velocity'\] are unknown: use some of displacement"),
        (lambda: named.record("x", expressions={"stress": u[0]}), ValueError, "stress has the shape"),
        (lambda: named.record("x", ending="vtk"), ValueError, "ending is 'vtk': use one of '.bp', '.xdmf'"),
        (lambda: named.record("x", units="m"), TypeError, "units must be Units, found str"),
        (lambda: named.record("x", every=0), ValueError, "every is 0"),
    ):
        with pytest.raises(kind, match=re.compile(words, re.DOTALL)):
            call()
