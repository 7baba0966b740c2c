# SPDX-License-Identifier: MIT
"""Kernels of J2 plasticity that come with the package: found without a compiler, and the same as compiled ones."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.assembly import jit
from dolfinx_impact.forms import registry

HARDENING = {"linear": 0.1, "voce": di.Voce(0.02, 40.0, 0.05)}
ROWS = [
    (cell, degree, hypothesis, law) for cell, degree, hypothesis, laws in registry.PLASTIC for law in laws
]  # fmt: skip


def thrown(cell, degree, hypothesis, law, **options):
    """Explicit problem of a small block that flies apart, fast enough to yield."""
    strain, hardening = law.split(".")
    kind = getattr(mesh.CellType, cell)
    if hypothesis == "3d":
        domain = mesh.create_unit_cube(MPI.COMM_SELF, 2, 2, 2, kind)
    else:
        domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, kind)
        domain.geometry.x[:, 0] += 0.5
    dim = domain.geometry.dim
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u, v = fem.Function(V, name="u"), fem.Function(V, name="v")
    v.interpolate(lambda x: 0.2 * (x[:dim] - 0.5) * (1.0 + x[-1 if dim == 3 else 1]))
    steel = di.J2Plasticity(
        2.0, 0.3, 1.0, yield_stress=0.01, hardening=HARDENING[hardening], finite_strain=strain == "finite",
        hypothesis=hypothesis, **options,
    )  # fmt: skip
    return di.ExplicitProblem(u, steel, velocity=v)


def state(problem, num_steps=20):
    dt = 0.5 * problem.stable_step()
    problem.advance(num_steps * dt, dt=dt, progress=False)
    energies = [problem.energy[name] for name in ("kinetic", "internal", "plastic")]
    history = [problem.history[name].values.ravel() for name in problem.history]
    return [problem.u.x.array.copy(), problem.velocity.x.array.copy(), np.array(energies), *history]


@pytest.fixture
def no_compiler(monkeypatch):
    """Every kernel that is not the package's is an error."""

    def refuse(key, integrals, comm):
        raise AssertionError(f"compiled at run time: {[i.name for i in integrals()]}")

    monkeypatch.setattr(jit, "_from_cache", refuse)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(map(str, row)))
def test_first_use_calls_no_compiler(row, no_compiler):
    problem = thrown(*row)
    state(problem, 2)
    assert {part.compiled.source for part in problem._bodies.internal._parts} == {"package"}
    assert problem.history["plastic_strain"].values.max() > 0.0


@pytest.mark.parametrize("options", ({"average": False}, {"kinematic": 0.1}), ids=str)
def test_other_laws_are_compiled(options, no_compiler):
    """The check above must see a compiler at work."""
    with pytest.raises(AssertionError, match="compiled at run time"):
        thrown("hexahedron", 1, "3d", "small.linear", **options)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(map(str, row)))
def test_packaged_kernels_are_those_compiled_at_run_time(row, monkeypatch):
    """The same generated code with other flags: products and sums may be fused elsewhere, 1e-16 per operation, over 20
    steps of points that yield."""
    packaged = thrown(*row)
    expected = state(packaged)
    with monkeypatch.context() as patch:
        patch.setattr(_cpp.kernels, "find_signature", lambda key: [])
        compiled = thrown(*row)
        found = state(compiled)
    assert {part.compiled.source for part in packaged._bodies.internal._parts} == {"package"}
    assert "package" not in {part.compiled.source for part in compiled._bodies.internal._parts}
    for a, b in zip(found, expected):
        assert np.abs(b).max() > 0.0 and np.abs(a - b).max() <= 1e-11 * np.abs(b).max()


def test_order_of_use_does_not_matter(no_compiler):
    """Kernels are found by a signature in which constants are numbered by age: also where the elastic part, whose
    constants are the same, was asked for first."""
    problem = thrown("hexahedron", 1, "3d", "small.voce")
    steel = problem.material
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.hexahedron)
    steel.elastic_law(domain)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V))
