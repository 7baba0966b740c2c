# SPDX-License-Identifier: MIT
"""Lumped mass, by cells and assembled."""

import functools
from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
import ufl
from dolfinx import cpp, la
from dolfinx.fem import FunctionSpace, functionspace
from dolfinx.mesh import MeshTags
from mpi4py import MPI

from .. import _cpp, compat
from ..common import arguments
from . import operators, problem_arguments
from ..common.collective import comm_of, guard
from ..common.types import FloatArray, IntArray
from ..forms import inertia, quadrature
from ..materials import Material
from .fields import Density, Field, fields_of
from .jit import compile_form

CellMasses: TypeAlias = Sequence[tuple[IntArray, FloatArray]]  # cells of each material, and their masses [M]


def mass_measure(
    V: FunctionSpace,
    hypothesis: str,
    cell_tags: MeshTags | None = None,
    rule: str | None = None,
    degree: int | None = None,
    field: Field | None = None,
) -> ufl.Measure:
    """Measure of cells with a quadrature rule; without a degree, that of the consistent mass, of one field if V is
    mixed."""
    mesh = V.mesh
    cell, p = mesh.topology.cell_name(), V.element.basix_element.degree if field is None else field.degree
    used = degree or quadrature.mass_degree(cell, p, compat.coordinate_element(mesh).degree, hypothesis)
    return ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(used, rule), subdomain_data=cell_tags)


def lumped_mass(V: FunctionSpace, material: Material, scheme: str = "auto") -> la.Vector:
    """Diagonal mass as a vector over the degrees of freedom. Collective.

    The entries of every direction sum up to the mass of the body, and every entry is positive.

    Args:
        V: blocked Lagrange space of degree 1 or 2.
        material: material or MaterialMap with densities.
        scheme: "row_sum"; "hrz" (Hinton, Rock & Zienkiewicz 1976); "nodal" (Gauss-Lobatto-Legendre rule at the nodes,
            quadrilaterals and hexahedra only); "auto": row sums at degree 1, HRZ at degree 2 on simplices and on
            axisymmetric bodies, nodal otherwise.

    Returns:
        Mass vector, ghosts up to date [M].

    Raises:
        TypeError: `V` is not a function space, or `material` not a material; on all ranks.
        ValueError: an unknown scheme, a scheme with entries that are not positive, or a material without density; on
            all ranks.
    """
    with guard(comm_of(V, material), "lumped_mass", material=material, scheme=scheme):
        arguments.function_space("V", V)
        problem_arguments.material(material)
        if material.cell_tags is not None:
            arguments.tags("MaterialMap", material.cell_tags, V.mesh, V.mesh.topology.dim)
    mesh = V.mesh
    scheme = _lumping_scheme(V, material.hypothesis_on(mesh), scheme)
    if scheme == "row_sum":
        v, hypothesis = ufl.TestFunction(V), material.hypothesis_on(mesh)
        dx = mass_measure(V, hypothesis, material.cell_tags)
        parts = [(tag, m.mass_density(mesh)) for tag, m in material.parts()]
        total = sum(inertia.row_sum(v, density, hypothesis, dx if t is None else dx(t)) for t, density in parts)
        return _positive(operators.InternalForce(total).apply(), scheme, mesh.comm)
    parts = [(tag, m.mass_density(mesh)) for tag, m in material.parts()]
    return assemble_masses(V, cell_masses(V, parts, material.hypothesis_on(mesh), material.cell_tags, scheme), scheme)


def _lumping_scheme(V: FunctionSpace, hypothesis: str, scheme: str) -> str:
    """The scheme that "auto" stands for; ValueError for a scheme with entries that are not positive."""
    degree, cell = V.element.basix_element.degree, V.mesh.topology.cell_name()
    simplex, axisymmetric = cell in quadrature.SIMPLICES, hypothesis == "axisymmetric"
    if scheme == "auto":
        scheme = "row_sum" if degree == 1 else "hrz" if simplex or axisymmetric else "nodal"
    if scheme not in ("row_sum", "hrz", "nodal"):
        raise ValueError(f"lumping scheme {scheme!r} is unknown: use auto, row_sum, hrz or nodal")
    if (scheme == "nodal" and simplex) or (scheme == "row_sum" and degree > 1 and (simplex or axisymmetric)):
        where = f"{cell}s of degree {degree}"
        raise ValueError(f"scheme {scheme!r} gives entries that are not positive on {where}: use hrz")
    return scheme


def cell_masses(
    V: FunctionSpace,
    parts: Iterable[tuple[int | None, Density]],
    hypothesis: str,
    cell_tags: MeshTags | None = None,
    scheme: str = "auto",
) -> list[tuple[IntArray, FloatArray]]:
    """Lumped mass cell by cell. Collective.

    Args:
        V: blocked Lagrange space of degree 1 or 2, or a mixed space, whose fields with inertia are of such spaces.
        parts: cell tag and density of each material; the tag None stands for all cells. Or the densities of all
            fields or components, whose degrees of freedom have no mass where it is None [M/L^3].
        hypothesis: hypothesis of the material.
        cell_tags: cell tags of the materials; None: one material.
        scheme: scheme of lumping, as for lumped_mass.

    Returns:
        For each material its cells, (num_cells), and their masses, (num_cells, degrees of freedom of a cell) [M].

    Raises:
        ValueError: an unknown scheme, or a scheme with entries that are not positive; on all ranks.
    """
    parts = list(parts)
    if any(isinstance(density, tuple) for _, density in parts):
        return _masses_of_fields(V, parts, hypothesis, cell_tags, scheme)
    scheme = _lumping_scheme(V, hypothesis, scheme)
    v, trial = ufl.TestFunction(V), ufl.TrialFunction(V)
    dx, degree = mass_measure(V, hypothesis, cell_tags), V.element.basix_element.degree
    errors: list[str] = []
    out: list[tuple[IntArray, FloatArray]] = []
    num_dofs = V.dofmap.dof_layout.num_dofs * V.dofmap.bs  # of a cell; a rank may have no cell of a material
    for tag, density in parts:
        integral = functools.partial(_cell_integral, tag=tag, cell_tags=cell_tags)
        if scheme == "hrz":
            mass = integral(inertia.mass(trial, v, density, hypothesis, dx))
            lump = functools.partial(_cpp.operators.cell_masses_hrz, mass[1], coefficients=mass[2])
        else:
            rule = ("GLL", 2 * degree - 1) if scheme == "nodal" else (None, None)
            nodal = integral(inertia.row_sum(v, density, hypothesis, mass_measure(V, hypothesis, cell_tags, *rule)))
            mass = integral(inertia.row_sum(v, density, hypothesis, dx))
            lump = functools.partial(_cpp.operators.cell_masses_nodal, nodal[1], mass[1], coefficients=mass[2])
        try:
            out.append((mass[0], lump(V=V._cpp_object).reshape(len(mass[0]), num_dofs)))
        except RuntimeError as e:  # perhaps on one rank only; raised on all ranks below
            errors.append(f"rank {V.mesh.comm.rank}: {e}")
    found: list[str] = sum(V.mesh.comm.allgather(errors), [])
    if found:
        raise ValueError(found[0])
    return out


def _masses_of_fields(
    V: FunctionSpace,
    parts: Iterable[tuple[int | None, Density]],
    hypothesis: str,
    cell_tags: MeshTags | None,
    scheme: str,
) -> list[tuple[IntArray, FloatArray]]:
    """`cell_masses` of fields or components with densities of their own, zero without inertia. Collective."""
    out, num_dofs = [], V.dofmap.dof_layout.num_dofs * V.dofmap.bs
    fields = fields_of(V)
    # In the order of the fields, on all ranks: a set would have an order of its own on each.
    elements = dict.fromkeys(f.element for f in fields if f.is_lagrange)
    spaces = {element: functionspace(V.mesh, element) for element in elements}
    for tag, densities in parts:
        assert isinstance(densities, tuple)  # checked with the arguments
        for field, density in zip(fields, densities):
            if density is None or not field.is_lagrange:
                continue
            ((cells, masses),) = cell_masses(spaces[field.element], [(tag, density)], hypothesis, cell_tags, scheme)
            values = np.zeros((len(cells), num_dofs))
            values[:, field.dofs] = masses
            out.append((cells, values))
    return out


def assemble_masses(V: FunctionSpace, masses: CellMasses, scheme: str = "auto") -> la.Vector:
    """Assemble the lumped mass from the masses of cells. Collective.

    Args:
        V: blocked Lagrange space of degree 1 or 2, or a mixed space of such fields.
        masses: cells and their masses, as cell_masses returns them [M].
        scheme: name of the scheme, for messages.

    Returns:
        Mass vector, ghosts up to date [M].

    Raises:
        ValueError: an entry is not positive; on all ranks.
    """
    return _positive(sum_masses(V, masses), scheme, V.mesh.comm)


def sum_masses(V: FunctionSpace, masses: CellMasses) -> la.Vector:
    """Sum the masses of cells at the nodes. Collective.

    Args:
        V: blocked Lagrange space.
        masses: cells and their masses, as cell_masses returns them [M].

    Returns:
        Mass vector, ghosts up to date [M].
    """
    b, bs = la.vector(V.dofmap.index_map, V.dofmap.index_map_bs), V.dofmap.index_map_bs
    for cells, values in masses:
        np.add.at(b.array.reshape(-1, bs), V.dofmap.list[cells].ravel(), values.reshape(-1, bs))
    b.scatter_reverse(la.InsertMode.add)
    b.scatter_forward()
    return b


def _positive(b: la.Vector, scheme: str, comm: MPI.Comm) -> la.Vector:
    """The vector b; ValueError on all ranks if an entry is not positive."""
    owned = b.array[: b.index_map.size_local * b.block_size]
    smallest = comm.allreduce(float(np.min(owned, initial=np.inf)), MPI.MIN)
    if not smallest > 0:
        raise ValueError(
            f"scheme {scheme!r} gives a nodal mass of {smallest}: use hrz, and check that every cell has a volume and "
            "that an axisymmetric mesh has no x < 0"
        )
    return b


def _cell_integral(
    form: ufl.Form, tag: int | None, cell_tags: MeshTags | None
) -> tuple[IntArray, _cpp.operators.Integral, dict[str, cpp.fem.Function_float64]]:
    """Cells of one material, the integral of a form over them for the C++ side, and its coefficients. Collective."""
    compiled = compile_form(form)
    cells = np.ascontiguousarray(
        operators.entities_of(operators.domain_of(form), "cell", -1 if tag is None else tag, cell_tags)
    )
    (kernel,) = compiled.kernels
    functions = {c["name"]: compiled.coefficients[c["position"]] for c in kernel.coefficients}
    for f in functions.values():
        f.x.scatter_forward()
    functions = {name: f._cpp_object for name, f in functions.items()}
    return cells, _cpp.operators.Integral(kernel.address, cells, operators._constants(compiled, kernel)), functions
