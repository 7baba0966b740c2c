# SPDX-License-Identifier: MIT
"""Second stage: kernels applied over the cells of a mesh. Thin wrappers of cpp/dolfinx_impact/operators."""

import numpy as np
import ufl
from dolfinx import cpp, fem, la
from mpi4py import MPI

from .. import _cpp
from ..common import arguments
from ..common.collective import comm_of, guard, same
from ..forms import elasticity, quadrature
from .jit import compile_expression, compile_form


def _domain(form):
    """C++ mesh of a form."""
    if not isinstance(form, ufl.Form):
        raise TypeError(f"expected a UFL form, found {type(form).__name__}: {form!r:.80}")
    return _cargo(form.ufl_domain())


def _is_expression(thing):
    return isinstance(thing, ufl.core.expr.Expr)


def _cargo(domain):
    mesh = None if domain is None else domain.ufl_cargo()
    if mesh is None:
        raise ValueError("the form is on a symbolic mesh: use functions and constants of a DOLFINx mesh")
    return mesh


def _entities(mesh, integral_type, subdomain, data):
    """Entities of one integral on this rank: owned cells, or (cell, local facet) pairs of exterior facets."""
    tdim = mesh.topology.dim
    if integral_type == "cell":
        num_owned = mesh.topology.index_map(tdim).size_local
        if subdomain == -1:
            return np.arange(num_owned, dtype=np.int32)
        cells = _tagged(data, subdomain, "dx", tdim)
        return cells[cells < num_owned]
    topology = mesh.topology
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    facets = cpp.mesh.exterior_facet_indices(topology)
    if subdomain != -1:
        facets = np.intersect1d(_tagged(data, subdomain, "ds", tdim - 1), facets)
    return cpp.fem.compute_integration_domains(fem.IntegralType.exterior_facet, topology, facets, tdim - 1)


def _choose(V, entities, integral_type, part):
    """Those of the entities whose cells touch no ghost node ("inner"), or the others ("outer")."""
    num_owned, dofs = V.dofmap.index_map.size_local, V.dofmap.list
    cells = entities if integral_type == "cell" else entities.reshape(-1, 2)[:, 0]
    outer = np.any(dofs[cells] >= num_owned, axis=1)
    chosen = outer if part == "outer" else ~outer
    return entities[chosen] if integral_type == "cell" else entities.reshape(-1, 2)[chosen].ravel()


def _tagged(data, subdomain, measure, dim):
    if data is None:
        raise ValueError(f"the form integrates over {measure}({subdomain}), but the measure has no subdomain_data")
    if not hasattr(data, "find"):
        raise TypeError(f"subdomain_data of {measure} must be MeshTags, found {type(data).__name__}")
    if data.dim != dim:
        raise ValueError(f"{measure} needs tags of dimension {dim}, found tags of dimension {data.dim}")
    return data.find(subdomain).astype(np.int32)


def _constants(compiled, kernel):
    values = [np.ravel(np.asarray(c.value, dtype=np.float64)) for c in compiled.constants]
    return np.concatenate(values) if values and kernel.constants else np.empty(0)


class _Operator:
    """Kernels of a form with their entities, coefficients and constants on the C++ side."""

    def __init__(self, form, rank, width, part=None):
        name = type(self).__name__
        with guard(comm_of(form), name, form=form, width=width, part=part):
            self.mesh = _domain(form)
            found = len(form.arguments())
            if found != rank:
                raise ValueError(f"{name} takes a form of rank {rank}, this one has {found} arguments")
            arguments.double_precision("the mesh of the form", self.mesh.geometry.x)
            for f in form.coefficients():
                arguments.function("a coefficient of the form", f)
        self.form = form
        self.compiled = compile_form(form)
        spaces = [a.ufl_function_space() for a in form.arguments()]
        self.test = spaces[0] if spaces else None
        data = next(iter(form.subdomain_data().values()))
        coefficients, integrals, self._kernels = {}, [], []
        for kernel in self.compiled.kernels:
            for c in kernel.coefficients:
                function = self.compiled.coefficients[c["position"]]
                if coefficients.setdefault(c["name"], function) is not function:
                    raise ValueError(f"two coefficients are called {c['name']!r}: give each function a name of its own")
            for subdomain in kernel.subdomains:
                given = [d for d in data.get(kernel.integral_type, []) if d is not None]
                if any(d is not given[0] for d in given):
                    raise ValueError(f"the {kernel.integral_type} integrals of one form must share one subdomain_data")
                entities = _entities(self.mesh, kernel.integral_type, subdomain, given[0] if given else None)
                if part:
                    entities = _choose(self.test, entities, kernel.integral_type, part)
                integrals.append(
                    _cpp.operators.Integral(
                        kernel.address, np.ascontiguousarray(entities), _constants(self.compiled, kernel)
                    )
                )
                self._kernels.append(kernel)
        self.coefficients = coefficients
        self._cpp_object = _cpp.operators.InternalForce_float64(
            self.mesh,
            None if self.test is None else self.test._cpp_object,
            integrals,
            {name: f._cpp_object for name, f in coefficients.items()},
            width,
        )

    @property
    def width(self):
        """Cells computed by one kernel call."""
        return self._cpp_object.width(0)

    @property
    def flops(self):
        """Floating-point operations of one application on this rank."""
        return self._cpp_object.flops

    def _update(self):
        for f in self.coefficients.values():
            f.x.scatter_forward()
        self._update_constants()

    def _update_constants(self):
        for i, kernel in enumerate(self._kernels):
            if kernel.constants:
                self._cpp_object.set_constants(i, _constants(self.compiled, kernel))


class InternalForce(_Operator):
    """Vector of a linear form, matrix-free and several cells at a time; equal to dolfinx.fem.assemble_vector to
    round-off.

    Args:
        form: UFL form of rank 1 over dx and ds of one mesh; its functions and constants are read anew at every call.
        width: cells per kernel call, 1, 4 or 8; 0: the machine's default.
        part: None; "inner", "outer": only cells without, with nodes that are ghosts here.

    Raises:
        ValueError: a form of another rank, two functions of one name, a subdomain without tags.
        RuntimeError: kernels cannot be compiled (see jit.compile_form), or elements of another kind.
    """

    def __init__(self, form, width=0, part=None):
        super().__init__(form, 1, width, part)

    def vector(self):
        """New DOLFINx vector of the test space, zero."""
        return la.vector(self.test.dofmap.index_map, self.test.dofmap.index_map_bs)

    def apply(self, b=None):
        """f, complete on owned and ghost entries. Collective.

        Args:
            b: dolfinx.la.Vector to overwrite; None: a new one.
        """
        with guard(self.mesh.comm, "InternalForce.apply"):
            if b is not None and not isinstance(b, la.Vector):
                raise TypeError(f"b must be a dolfinx.la.Vector, found {type(b).__name__}; arrays go to assemble")
            if b is not None:
                self._check_size(b.array)
        b = self.vector() if b is None else b
        self._update()
        self._cpp_object.apply(b._cpp_object)
        return b

    def assemble(self, array):
        """Add this rank's contributions to `array` (owned and ghost entries, float64), as fem.assemble_vector does.
        Collective.

        Raises:
            TypeError: not an array of float64. ValueError: another size, or entries that do not follow each other; on
            all ranks.
        """
        with guard(self.mesh.comm, "InternalForce.assemble"):
            if not isinstance(array, np.ndarray):
                raise TypeError(f"array must be a NumPy array, found {type(array).__name__}")
            self._check_size(array)
            if array.ndim != 1 or not array.flags.c_contiguous or not array.flags.writeable:
                raise ValueError("array must have one dimension, no gaps, and be writeable: forces are added to it")
        self._update()
        self._cpp_object.assemble(array)

    def _check_size(self, array):
        arguments.double_precision("the vector", array)
        dofmap = self.test.dofmap
        needed = (dofmap.index_map.size_local + dofmap.index_map.num_ghosts) * dofmap.index_map_bs
        if array.size != needed:
            raise ValueError(f"the vector has {array.size} entries on this rank, the test space has {needed}")


class Inputs:
    """Constants and coefficients that a form reads, and whether they have changed since they were last taken over.

    Args:
        constants, coefficients: those of the form.
        without: functions that somebody else keeps up to date.
    """

    def __init__(self, constants, coefficients, without=()):
        self._constants = list(constants)
        self._functions = [f for f in coefficients if not any(f is other for other in without)]
        self.take()

    def take(self):
        """Bring ghosts up to date and remember the present values. Collective."""
        for f in self._functions:
            f.x.scatter_forward()
        self._known = [np.array(values) for values in self._values()]

    def changed(self):
        """Has a value changed on this rank? Owned entries count."""
        return any(not np.array_equal(new, old) for new, old in zip(self._values(), self._known))

    def _values(self):
        yield from (c.value for c in self._constants)
        for f in self._functions:
            yield f.x.array[: f.function_space.dofmap.index_map.size_local * f.function_space.dofmap.index_map_bs]


class SplitForce:
    """Vector of a linear form in two parts, for the explicit integrator: cells and facets whose cells touch no ghost
    node, and the others.

    Args:
        form: as for InternalForce. displacement, velocity: its coefficients that the integrator has, or None.
    """

    def __init__(self, form, displacement=None, velocity=None):
        self._parts = [InternalForce(form, part=part) for part in ("inner", "outer")]
        compiled, coefficients = self._parts[0].compiled, self._parts[0].coefficients
        self._names = {id(f): name for name, f in coefficients.items()}
        self._given = displacement, velocity
        self._inputs = Inputs(compiled.constants, coefficients.values(), self._given)

    def changed(self):
        """Have constants, or coefficients that the integrator has not, changed on this rank since `update`?"""
        return self._inputs.changed()

    def update(self):
        """Read constants and the coefficients that the integrator has not. Collective."""
        self._inputs.take()
        for part in self._parts:
            part._update_constants()

    def forces(self):
        """For the C++ side, which coefficients are the displacement and the velocity among them."""
        given = [self._names.get(id(f), "") for f in self._given]
        return _cpp.integrators.FormForces(*(p._cpp_object for p in self._parts), *given)


class Energy(_Operator):
    """Value of a form of rank 0, for example a strain energy. Arguments as for InternalForce."""

    def __init__(self, form, width=0):
        super().__init__(form, 0, width)

    def value(self):
        """Sum over all ranks. Collective."""
        same(self.mesh.comm, "Energy.value")
        self._update()
        return self.mesh.comm.allreduce(self._cpp_object.value(), MPI.SUM)


class Tangent:
    """Matrix of a bilinear form in a PETSc matrix that is created once; FFCx's own C kernels, DOLFINx's assembly.

    Args:
        form: UFL form of rank 2.
        bcs: DirichletBC objects; their rows and columns are zeroed, one on the diagonal.
    """

    def __init__(self, form, bcs=()):
        import dolfinx.fem.petsc as petsc

        with guard(comm_of(form, bcs), "Tangent") as ranks:
            if not isinstance(form, ufl.Form):
                raise TypeError(f"Tangent takes a UFL form of rank 2, found {type(form).__name__}")
            if len(form.arguments()) != 2:
                raise ValueError(f"Tangent takes a UFL form of rank 2, this one has {len(form.arguments())} arguments")
            for bc in arguments.sequence("bcs", bcs, "DirichletBC"):
                arguments.boundary_values("bcs", bc, form.arguments()[0].ufl_function_space())
            ranks.same(form=form, bcs=[arguments.value_of(bc) for bc in bcs])
        self._petsc = petsc
        self.form = fem.form(form)
        self.bcs = list(bcs)
        self.matrix = petsc.create_matrix(self.form)

    def assemble(self):
        """Assemble at the present coefficients; returns the PETSc matrix. Collective."""
        same(self.form.mesh.comm, "Tangent.assemble")
        self.matrix.zeroEntries()
        self._petsc.assemble_matrix(self.matrix, self.form, bcs=self.bcs)
        self.matrix.assemble()
        return self.matrix


class PointValues:
    """A UFL expression at given reference points of every owned cell, for example stresses.

    Args:
        expression: UFL expression of DOLFINx functions.
        points: in the reference cell, shape (num_points, tdim) [1].

    Raises:
        TypeError: not an expression. ValueError: points of another shape or outside the reference cell. On all ranks.
    """

    def __init__(self, expression, points):
        comm = comm_of(*ufl.algorithms.extract_coefficients(expression)) if _is_expression(expression) else None
        with guard(comm, "PointValues") as ranks:
            if not _is_expression(expression):
                raise TypeError(f"PointValues takes a UFL expression, found {type(expression).__name__}")
            domain = ufl.domain.extract_unique_domain(expression)
            self.mesh = _cargo(domain)
            points = arguments.reference_points(points, self.mesh.topology.dim, domain.ufl_cell().cellname())
            ranks.same(shape=expression.ufl_shape, points=points)
        self.compiled = compile_expression(expression, points)
        self.kernel = self.compiled.kernels[0]
        self.kernel.check_mesh(self.mesh)

    def values(self):
        """Array of shape (owned cells, points, components). Collective."""
        same(self.mesh.comm, "PointValues.values")
        num_cells = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        points, components = self.kernel.shape
        out = np.zeros((num_cells, points, components))
        c = _constants(self.compiled, self.kernel)
        parts = []
        for e in self.kernel.coefficients:
            f = self.compiled.coefficients[e["position"]]
            f.x.scatter_forward()
            dofmap = f.function_space.dofmap
            parts.append((e["offset"], f.x.array.reshape(-1, dofmap.bs)[dofmap.list[:num_cells]]))
        w = [values.reshape(num_cells, -1) for _, values in sorted(parts, key=lambda part: part[0])]
        w = np.hstack(w) if w else np.empty((num_cells, 0))
        x = self.mesh.geometry.x[self.mesh.geometry.dofmap[:num_cells]]
        self.kernel.tabulate_cells(out.reshape(-1), w.reshape(-1), c, x.reshape(-1), num_cells)
        return out


def strain_energy_form(u, material):
    """UFL form of the strain energy of u [F L]."""
    return _sum(u, material, lambda law, dx: elasticity.internal_energy(u, law, dx))


def internal_force_form(u, v, material):
    """UFL form of the internal virtual work of u against v."""
    return _sum(u, material, lambda law, dx: elasticity.internal_force(u, v, law, dx))


def tangent_form(u, du, v, material):
    """UFL form of the derivative of the internal virtual work at u in the direction du."""
    return _sum(u, material, lambda law, dx: elasticity.tangent(u, du, v, law, dx))


def sum_materials(u, material, term):
    """Sum of the UFL forms term(m, dx) over the materials m with their parts of the body, stiffness rule."""
    V = u.function_space
    mesh = V.mesh
    degree = quadrature.stiffness_degree(
        mesh.topology.cell_name(),
        V.element.basix_element.degree,
        mesh.geometry.cmap.degree,
        material.hypothesis_on(mesh),
    )
    dx = ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(degree), subdomain_data=material.cell_tags)
    return sum(term(m, dx if tag is None else dx(tag)) for tag, m in material.parts())


def _sum(u, material, term):
    mesh = u.function_space.mesh
    return sum_materials(u, material, lambda m, dx: term(m.law(mesh), dx))
