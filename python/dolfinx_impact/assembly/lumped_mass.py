# SPDX-License-Identifier: MIT
"""Lumped mass, by cells and assembled."""

import functools

import numpy as np
import ufl
from dolfinx import la
from mpi4py import MPI

from .. import _cpp
from ..common import arguments
from . import operators, problem_arguments
from ..common.collective import comm_of, guard
from ..forms import inertia, quadrature
from .jit import compile_form


def _mass_measure(V, hypothesis, cell_tags=None, rule=None, degree=None):
    mesh = V.mesh
    cell = mesh.topology.cell_name()
    used = degree or quadrature.mass_degree(cell, V.element.basix_element.degree, mesh.geometry.cmap.degree, hypothesis)
    return ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(used, rule), subdomain_data=cell_tags)


def lumped_mass(V, material, scheme="auto"):
    """Diagonal mass as a vector over the degrees of freedom of V [M].

    The total is the body's mass in every direction, and every entry is positive.

    Args:
        V: blocked Lagrange space of degree 1 or 2.
        material: a material or MaterialMap with densities.
        scheme: "row_sum"; "hrz" (Hinton, Rock & Zienkiewicz 1976); "nodal" (Gauss-Lobatto-Legendre rule at the nodes,
            quadrilaterals and hexahedra only); "auto": row sums at degree 1, HRZ on simplices of degree 2 and wherever
            an axisymmetric body of degree 2 would get no mass on the axis, nodal otherwise.

    Returns:
        dolfinx.la.Vector, ghosts up to date.

    Raises:
        ValueError: unknown scheme, a scheme that has no positive entries there, a material without density.
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
        dx = _mass_measure(V, hypothesis, material.cell_tags)
        parts = [(tag, m.mass_density(mesh)) for tag, m in material.parts()]
        total = sum(inertia.row_sum(v, density, hypothesis, dx if t is None else dx(t)) for t, density in parts)
        return _positive(operators.InternalForce(total).apply(), scheme, mesh.comm)
    parts = [(tag, m.mass_density(mesh)) for tag, m in material.parts()]
    return assemble_masses(V, cell_masses(V, parts, material.hypothesis_on(mesh), material.cell_tags, scheme), scheme)


def _lumping_scheme(V, hypothesis, scheme):
    """The scheme that "auto" stands for, or ValueError for one that has no positive entries."""
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


def cell_masses(V, parts, hypothesis, cell_tags=None, scheme="auto"):
    """Lumped mass cell by cell. Collective.

    Args:
        V, scheme: as for lumped_mass.
        parts: pairs (cell tag or None, density in UFL). hypothesis, cell_tags: of the
            material.

    Returns:
        list of pairs (cells, masses of shape (num_cells, local degrees of freedom) [M]).

    Raises:
        ValueError: as lumped_mass; on all ranks.
    """
    scheme = _lumping_scheme(V, hypothesis, scheme)
    v, trial = ufl.TestFunction(V), ufl.TrialFunction(V)
    dx, degree = _mass_measure(V, hypothesis, cell_tags), V.element.basix_element.degree
    errors, out = [], []
    num_dofs = V.dofmap.dof_layout.num_dofs * V.dofmap.bs  # of a cell; a rank may have no cell of a part
    for tag, density in parts:
        integral = functools.partial(_cell_integral, tag=tag, cell_tags=cell_tags)
        if scheme == "hrz":
            mass = integral(inertia.mass(trial, v, density, hypothesis, dx))
            lump = functools.partial(_cpp.operators.cell_masses_hrz, mass[1], coefficients=mass[2])
        else:
            rule = ("GLL", 2 * degree - 1) if scheme == "nodal" else (None, None)
            nodal = integral(inertia.row_sum(v, density, hypothesis, _mass_measure(V, hypothesis, cell_tags, *rule)))
            mass = integral(inertia.row_sum(v, density, hypothesis, dx))
            lump = functools.partial(_cpp.operators.cell_masses_nodal, nodal[1], mass[1], coefficients=mass[2])
        try:
            out.append((mass[0], lump(V=V._cpp_object).reshape(len(mass[0]), num_dofs)))
        except RuntimeError as e:  # of one rank, perhaps: told to all below
            errors.append(f"rank {V.mesh.comm.rank}: {e}")
    errors = sum(V.mesh.comm.allgather(errors), [])
    if errors:
        raise ValueError(errors[0])
    return out


def assemble_masses(V, masses, scheme="auto"):
    """Lumped mass from those of cells (cell_masses): la.Vector, ghosts up to date. Collective."""
    b, bs = la.vector(V.dofmap.index_map, V.dofmap.index_map_bs), V.dofmap.index_map_bs
    for cells, values in masses:
        np.add.at(b.array.reshape(-1, bs), V.dofmap.list[cells].ravel(), values.reshape(-1, bs))
    b.scatter_reverse(la.InsertMode.add)
    b.scatter_forward()
    return _positive(b, scheme, V.mesh.comm)


def _positive(b, scheme, comm):
    """The vector b, or ValueError on all ranks if an entry is not positive."""
    owned = b.array[: b.index_map.size_local * b.block_size]
    smallest = comm.allreduce(float(np.min(owned, initial=np.inf)), MPI.MIN)
    if not smallest > 0:
        raise ValueError(
            f"scheme {scheme!r} gives a nodal mass of {smallest}: use hrz, and check that every cell has a volume and "
            "that an axisymmetric mesh has no x < 0"
        )
    return b


def _cell_integral(form, tag, cell_tags):
    """Cells of one material, the integral of a form over them for the C++ side, and its coefficients. Collective."""
    compiled = compile_form(form)
    cells = np.ascontiguousarray(
        operators._entities(operators._domain(form), "cell", -1 if tag is None else tag, cell_tags)
    )
    (kernel,) = compiled.kernels
    functions = {c["name"]: compiled.coefficients[c["position"]] for c in kernel.coefficients}
    for f in functions.values():
        f.x.scatter_forward()
    functions = {name: f._cpp_object for name, f in functions.items()}
    return cells, _cpp.operators.Integral(kernel.address, cells, operators._constants(compiled, kernel)), functions
