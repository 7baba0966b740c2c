# SPDX-License-Identifier: MIT
"""Explicit problems overwrite internal variables in the sweeps of kernels. Forces and histories of each step are those
of an operator that keeps old values and new ones apart."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.inelastic_part import InelasticPart
from dolfinx_impact.assembly.operators import InternalForce, cells_measure
from dolfinx_impact.forms import inelastic

COMM = MPI.COMM_SELF
# Sums of some hundred terms, and strains that are differences of numbers of the size 1, both sides with one kernel.
ROUND_OFF = 1e-12
CELLS = {  # not all batches of four and eight are whole
    "hexahedron": lambda: mesh.create_unit_cube(COMM, 5, 2, 1, mesh.CellType.hexahedron),
    "tetrahedron": lambda: mesh.create_unit_cube(COMM, 3, 1, 1, mesh.CellType.tetrahedron),
    "quadrilateral": lambda: mesh.create_unit_square(COMM, 5, 3, mesh.CellType.quadrilateral),
}
LAWS = {
    "small, linear": dict(hardening=50.0),
    "small, Voce": dict(hardening=di.Voce(2.0, 30.0, 10.0)),
    "finite, Voce": dict(hardening=di.Voce(2.0, 30.0, 10.0), finite_strain=True),
    "finite, back stress": dict(hardening=50.0, kinematic=20.0, finite_strain=True),
}


class _Exchange:
    """Elastic, with two internal variables that change places: either is read after the other has been computed."""

    history: dict[str, tuple[int, ...]] = {"first": (), "second": ()}
    unknown = None

    def respond(self, strain, history, unknown=None):
        mean = 1e3 * ufl.tr(strain)
        stress = 400.0 * strain + (mean + history["first"]) * ufl.Identity(3)
        new = {"first": history["second"] + ufl.tr(strain), "second": history["first"] - strain[0, 0]}
        return inelastic.Update(stress, new, ufl.inner(stress, strain) / 2)


class Exchange(di.InelasticMaterial):
    """A user's material of that law."""

    def __init__(self, hypothesis):
        super().__init__(1e3, 0.3, 1.0, hypothesis=hypothesis)

    def response(self, mesh):
        return _Exchange()


def check(cell, make):
    """Take some steps and compare; returns the shares of the points whose history changed in each."""
    domain = CELLS[cell]()
    dim = domain.geometry.dim
    u, v = (fem.Function(fem.functionspace(domain, ("Lagrange", 1, (dim,))), name=name) for name in "uv")
    v.interpolate(lambda x: np.array([x[0] ** 6, 0.3 * x[0] ** 6, 0.1 * x[1] * x[0]][:dim]))
    material = make("3d" if dim == 3 else "plane_strain")
    problem = di.ExplicitProblem(u, material, velocity=v)
    w = fem.Function(u.function_space, name="w")
    part = InelasticPart(w, material, *cells_measure(w, material), None)
    form, law = part.force(ufl.TestFunction(w.function_space))
    operator = InternalForce(form, law=law)
    operator.apply()
    operator.history.commit()
    changed = []
    for _ in range(8):
        problem.advance(problem.time + 1e-3, dt=1e-3, progress=False)
        w.x.array[:] = u.x.array
        before = {name: operator.history.values(name) for name in operator.history.state_names}
        force = operator.apply().array.copy()
        operator.history.commit()
        found = problem.acceleration.x.array * problem.mass.array
        assert np.abs(found + force).max() <= ROUND_OFF * np.abs(force).max()
        after = {name: operator.history.values(name) for name in operator.history.state_names}
        for name, values in after.items():
            own = problem.history[name].values.reshape(values.shape)
            assert np.abs(own - values).max() <= ROUND_OFF * max(1.0, np.abs(values).max())
        first = next(iter(after))
        changed.append(np.mean(after[first] != before[first]))
    return changed


# Of kinematic hardening hexahedra show it.
CASES = [(name, cell) for name in LAWS for cell in CELLS if cell != "tetrahedron" or not LAWS[name].get("kinematic")]


@pytest.mark.parametrize(("name", "cell"), CASES)
def test_plastic_steps(name, cell):
    law = LAWS[name]
    changed = check(
        cell, lambda hypothesis: di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=1.0, hypothesis=hypothesis, **law)
    )
    assert changed[0] < max(changed) <= 1.0 and max(changed) > 0.2  # cells that yield beside others that do not


@pytest.mark.parametrize("cell", CELLS)
def test_history_that_is_read_by_another(cell):
    assert max(check(cell, Exchange)) > 0.9


@pytest.mark.parametrize("cell", CELLS)
def test_elastic_cells_beside_plastic_ones(cell):
    """Their kernels sum elastic energy up beside the force. Nothing yields: it is a body of one elastic law."""
    domain = CELLS[cell]()
    dim, num_cells = domain.geometry.dim, domain.topology.index_map(domain.topology.dim).size_local
    hypothesis = "3d" if dim == 3 else "plane_strain"
    elastic = di.LinearElastic(1e3, 0.3, 1.0, hypothesis=hypothesis)
    plastic = di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=1e6, hardening=1.0, average=False, hypothesis=hypothesis)
    tags = mesh.meshtags(domain, dim, np.arange(num_cells), (np.arange(num_cells) % 3 > 0).astype(np.int32))
    problems = []
    for law in (di.MaterialMap(tags, {0: plastic, 1: elastic}), elastic):
        u, v = (fem.Function(fem.functionspace(domain, ("Lagrange", 1, (dim,))), name=name) for name in "uv")
        v.interpolate(lambda x: np.array([x[0] ** 6, 0.3 * x[0] ** 6, 0.1 * x[1] * x[0]][:dim]))
        problems.append(di.ExplicitProblem(u, law, velocity=v))
        problems[-1].advance(8e-3, dt=1e-3, progress=False)
    found, expected = problems
    a = expected.acceleration.x.array
    assert np.abs(found.acceleration.x.array - a).max() <= ROUND_OFF * np.abs(a).max()
    assert found.energy["internal"] == pytest.approx(expected.energy["internal"], rel=ROUND_OFF)
    # What is left of the work of eight steps is what their sums round.
    assert abs(found.energy["plastic"]) <= ROUND_OFF * found.energy["kinetic"]
