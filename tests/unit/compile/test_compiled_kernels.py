# SPDX-License-Identifier: MIT
"""Kernels that `dolfinx-impact compile` writes give the numbers of those that Python compiles of the same file."""

import os
import runpy
import shlex
import subprocess

import basix
import numpy as np
import pytest
import ufl
from mpi4py import MPI

from dolfinx_impact.own_forms import distorted_block
import dolfinx_impact as di
from dolfinx_impact import _cpp, compat
from dolfinx_impact.assembly import jit
from dolfinx_impact.compile import compile_command
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.quadrature import with_rules

# Some hundred roundings, which compilers order differently; relative to the largest entry.
ROUND_OFF = 1e-12


def compiler(*arguments):
    done = subprocess.run([*shlex.split(os.environ.get("CXX", "c++")), "-std=c++20", *map(str, arguments)],
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]


def written(file, folder, *options):
    """Kernels of a file by the kind of each, from header and source in a folder."""
    assert (
        compile_command.run(compile_command.parser().parse_args([str(file), "-o", str(folder), *map(str, options)]))
        == 0
    )
    source = folder / f"{file.stem}.cpp"
    symbols = [
        line.split()[-1][:-1] for line in source.read_text().splitlines() if line.startswith('extern "C" __attr')
    ]
    compiler("-O1", "-march=native", "-shared", "-fPIC", "-w", f"-I{jit.INCLUDE}", f"-I{folder}", source,
             "-o", folder / "kernels.so")  # fmt: skip
    kernels = _cpp.kernels.load(os.fsencode(folder / "kernels.so"), symbols)
    return {kernel.name.rpartition(".")[2]: kernel for kernel in kernels}


def numbers(kernel, w, c, x):
    """Element tensor and outputs."""
    A = np.zeros(kernel.size_A)
    kernel.tabulate(A, w, c, x)
    return A


def same(ours, theirs, w, c, x):
    found, expected = numbers(ours, w, c, x), numbers(theirs, w, c, x)
    assert np.abs(expected).max() > 0.0
    assert np.abs(found - expected).max() <= ROUND_OFF * np.abs(expected).max()


def same_in_lanes(kernel, w, c, x):
    """All cells of a vector get what one cell gets; the processor may have no vectors."""
    one = numbers(kernel, w, c, x)
    for lanes in kernel.widths:
        A, many = _aligned(kernel.size_A * lanes), []
        for values in (w, x):
            many.append(_aligned(len(values) * lanes))
            many[-1].reshape(-1, lanes)[:] = values[:, None]
        kernel.tabulate(A, many[0], c, many[1], 0, lanes)
        assert np.abs(A.reshape(-1, lanes) - one[:, None]).max() <= ROUND_OFF * np.abs(one).max()


def _aligned(size):
    """Zeros at an address that is a multiple of 64."""
    raw = np.zeros(size + 8)
    return raw[(-raw.ctypes.data // 8) % 8 :][:size]


FOAM = [
    ("triangle", 1, 1), ("triangle", 2, 1), ("quadrilateral", 1, 1), ("quadrilateral", 1, 2), ("quadrilateral", 2, 1),
    ("tetrahedron", 1, 1), ("tetrahedron", 2, 1), ("hexahedron", 1, 1), ("hexahedron", 2, 1),
]  # fmt: skip


@pytest.mark.long_rows(where=lambda case: case not in (("triangle", 2, 1), ("quadrilateral", 1, 2)))
@pytest.mark.parametrize("case", FOAM, ids=str)
def test_a_function_of_a_mesh(case, checkout, tmp_path, rng):
    """The law of the demo: force, tangent, energy, mass and stress."""
    cell, degree, geometry_degree = case
    file = checkout / "demos" / "cpp" / "foam.py"
    options = ("--cells", cell, "--degree", degree, "--geometry-degree", geometry_degree)
    ours = written(file, tmp_path, *options)
    assert set(ours) == {"force", "tangent", "energy", "mass", "stress"}

    mesh = distorted_block.block(cell, 2, geometry_degree)
    own = runpy.run_path(str(file))["foam"](mesh, degree)
    u, names = own.u, {own.u: "u"} | {c: n for n, c in own.parameters.items()}
    V = u.function_space
    x = mesh.geometry.x[compat.geometry_dofmap(mesh)[0]].ravel()
    w, c = 0.05 * rng.standard_normal(V.element.space_dimension), np.array([own.parameters["mu"].value])

    tangent = ufl.derivative(with_rules(own.residual), u, ufl.TrialFunction(V))
    for kind, form in (("force", own.residual), ("tangent", tangent), ("energy", own.energy)):
        (theirs,) = jit.compile_form(form, names, MPI.COMM_SELF).kernels
        assert ours[kind].signature == theirs.signature
        same(ours[kind], theirs, w, c, x)
    same_in_lanes(ours["force"], w, c, x)
    same_in_lanes(ours["energy"], w, c, x)

    built = registry.build("mass", cell, degree, geometry_degree)
    (mass,) = jit.compile_form(built.form, built.names, MPI.COMM_SELF).kernels
    same(ours["mass"], mass, np.empty(0), np.array([1100.0]), x)

    # The stress at the points of the rule, as an expression.
    rule, _ = basix.make_quadrature(getattr(basix.CellType, cell), di.quadrature_degree(u))
    axes = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))[: 6 if mesh.geometry.dim == 3 else 4]
    components = ufl.as_vector([own.stress[i, j] for i, j in axes])
    (at_points,) = jit.compile_expression(components, rule, names, MPI.COMM_SELF).kernels
    (output,) = ours["stress"].outputs
    assert output["name"] == "stress" and ours["stress"].num_points == len(rule)
    found, expected = numbers(ours["stress"], w, c, x)[output["offset"] :], numbers(at_points, w, c, x)
    assert np.abs(found - expected).max() <= ROUND_OFF * np.abs(expected).max()


MATERIALS = """
import dolfinx_impact as di
rubber = di.NeoHookean(E=1e6, nu=0.4)
steel = di.J2Plasticity(E=207e9, nu=0.3, density=7800.0, yield_stress=5e8, hardening=2e9, hypothesis="plane_strain")
"""


@pytest.mark.parametrize("name, cell, counterparts", (
    ("rubber", "hexahedron", {"force": "neo_hookean.force", "tangent": "neo_hookean.tangent",
                              "energy": "neo_hookean.energy", "mass": "mass"}),
    ("steel", "quadrilateral", {"force": "j2.small.linear.force", "tangent": "j2.small.linear.tangent",
                                "elastic_tangent": "linear_elastic.tangent", "mass": "mass"}),
), ids=("elastic", "inelastic"))  # fmt: skip
def test_materials(name, cell, counterparts, tmp_path, rng):
    """Kernels of a material of a file are those of the package, where it has them."""
    file = tmp_path / "own_materials.py"
    file.write_text(MATERIALS)
    ours = written(file, tmp_path / "kernels", name, "--cells", cell)
    assert set(ours) == {*counterparts, "stress"}
    mesh = distorted_block.block(cell, 2)
    x = mesh.geometry.x[compat.geometry_dofmap(mesh)[0]].ravel()
    values = {"E": 2.0, "nu": 0.3, "density": 3.0, "yield_stress": 0.02, "hardening": 0.1, "modulus": 0.1}
    for kind, counterpart in counterparts.items():
        (theirs,) = _cpp.kernels.find(counterpart, cell, 1, 1, "3d" if cell == "hexahedron" else "plane_strain")
        w = np.zeros(sum(e["num_dofs"] for e in theirs.coefficients))
        for e in theirs.coefficients:
            if e["name"] in ("u", "direction of the tangent"):
                w[e["offset"] : e["offset"] + e["num_dofs"]] = 0.05 * rng.standard_normal(e["num_dofs"])
        c = np.array([values[constant["name"]] for constant in ours[kind].constants])
        same(ours[kind], theirs, w, c, x)
        if kind == "force":
            same_in_lanes(ours[kind], w, c, x)
            # The element vector of the kernel with the stress is the same force.
            n = ours["force"].shape[0]
            force, stress = numbers(ours["force"], w, c, x), numbers(ours["stress"], w, c, x)
            assert np.abs(force[:n] - stress[:n]).max() <= ROUND_OFF * np.abs(force[:n]).max()
            assert "stress" in {o["name"] for o in ours["stress"].outputs}


SYMBOLIC = """
import basix.ufl
import ufl

mesh = ufl.Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
V = ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", "triangle", 2, shape=(2,)))
u, v = ufl.Coefficient(V), ufl.TestFunction(V)
heat = ufl.Coefficient(ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", "triangle", 1)))
mu, k = ufl.Constant(mesh), ufl.Constant(mesh, shape=(2,))
stress = 2 * mu * ufl.sym(ufl.grad(u)) - heat * ufl.Identity(2)
F = ufl.inner(stress, ufl.grad(v)) * ufl.dx(degree=2) + ufl.inner(ufl.elem_mult(k, u), v) * ufl.ds(3, degree=4)
"""


def test_a_form_on_a_symbolic_mesh(tmp_path, rng):
    """One kernel for each integral; coefficients and constants have the names of the file's variables."""
    file = tmp_path / "springs.py"
    file.write_text(SYMBOLIC)
    assert (
        compile_command.run(
            compile_command.parser().parse_args([str(file), "-o", str(tmp_path / "springs.h"), "--kernels", "force"])
        )
        == 0
    )
    namespace = runpy.run_path(str(file))
    names = {namespace[name]: name for name in ("u", "heat", "mu", "k")}
    theirs = jit.compile_form(namespace["F"], names, MPI.COMM_SELF).kernels
    text = (tmp_path / "springs.h").read_text()
    assert [k.integral_type for k in theirs] == ["cell", "exterior_facet"]
    for k, kernel in enumerate(theirs):
        assert f"impact_springs_F_force_triangle_2_1_plane_strain_{k}" in text and kernel.signature in text
    assert text.count('"exterior_facet"') == 1 and '{"mu", 1, 0}, {"k", 2, 1}' in text and "_subdomains[] = {3}" in text
    assert "F.force: u, heat, mu, k" in text
