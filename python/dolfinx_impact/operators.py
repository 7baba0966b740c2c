"""Second stage: kernels applied over the cells of a mesh. Thin wrappers of cpp/dolfinx_impact/operators."""

import functools

import numpy as np
import ufl
from dolfinx import cpp, fem, la
from mpi4py import MPI

from . import _cpp
from .forms import elasticity, inertia, quadrature
from .jit import compile_expression, compile_form


def _domain(form):
    """C++ mesh of a form."""
    if not isinstance(form, ufl.Form):
        raise TypeError(f"expected a UFL form, found {type(form).__name__}: {form!r:.80}")
    return _cargo(form.ufl_domain())


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

    def __init__(self, form, rank, width):
        self.form = form
        self.mesh = _domain(form)
        found = len(form.arguments())
        if found != rank:
            raise ValueError(f"{type(self).__name__} takes a form of rank {rank}, this one has {found} arguments")
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
        for i, kernel in enumerate(self._kernels):
            if kernel.constants:
                self._cpp_object.set_constants(i, _constants(self.compiled, kernel))


class InternalForce(_Operator):
    """Vector of a linear form, matrix-free and several cells at a time; equal to dolfinx.fem.assemble_vector to
    round-off.

    Args:
        form: UFL form of rank 1 over dx and ds of one mesh; its functions and constants are read anew at every call.
        width: cells per kernel call, 1, 4 or 8; 0: the machine's default.

    Raises:
        ValueError: a form of another rank, two functions of one name, a subdomain without tags.
        RuntimeError: kernels cannot be compiled (see jit.compile_form), or elements of another kind.
    """

    def __init__(self, form, width=0):
        super().__init__(form, 1, width)

    def vector(self):
        """New DOLFINx vector of the test space, zero."""
        return la.vector(self.test.dofmap.index_map, self.test.dofmap.index_map_bs)

    def apply(self, b=None):
        """f, complete on owned and ghost entries. Collective.

        Args:
            b: dolfinx.la.Vector to overwrite; None: a new one.
        """
        b = self.vector() if b is None else b
        self._update()
        self._cpp_object.apply(b._cpp_object)
        return b

    def assemble(self, array):
        """Add this rank's contributions to `array` (owned and ghost entries), as fem.assemble_vector does."""
        self._update()
        self._cpp_object.assemble(array)


class Energy(_Operator):
    """Value of a form of rank 0, for example a strain energy. Arguments as for InternalForce."""

    def __init__(self, form, width=0):
        super().__init__(form, 0, width)

    def value(self):
        """Sum over all ranks. Collective."""
        self._update()
        return self.mesh.comm.allreduce(self._cpp_object.value(), MPI.SUM)


class Tangent:
    """Matrix of a bilinear form in a PETSc matrix that is created once; FFCx's own C kernels, DOLFINx's assembly.

    Args:
        form: UFL form of rank 2. bcs: DirichletBC objects; their rows and columns are zeroed, one on the diagonal.
    """

    def __init__(self, form, bcs=()):
        import dolfinx.fem.petsc as petsc

        if not isinstance(form, ufl.Form) or len(form.arguments()) != 2:
            raise ValueError("Tangent takes a UFL form of rank 2")
        self._petsc = petsc
        self.form = fem.form(form)
        self.bcs = list(bcs)
        self.matrix = petsc.create_matrix(self.form)

    def assemble(self):
        """Assemble at the present coefficients; returns the PETSc matrix. Collective."""
        self.matrix.zeroEntries()
        self._petsc.assemble_matrix(self.matrix, self.form, bcs=self.bcs)
        self.matrix.assemble()
        return self.matrix


class PointValues:
    """A UFL expression at given reference points of every owned cell, for example stresses.

    Args:
        expression: UFL expression of DOLFINx functions. points: shape (num_points, tdim), reference coordinates.
    """

    def __init__(self, expression, points):
        self.mesh = _cargo(ufl.domain.extract_unique_domain(expression))
        self.compiled = compile_expression(expression, points)
        self.kernel = self.compiled.kernels[0]
        self.kernel.check_mesh(self.mesh)

    def values(self):
        """Array of shape (owned cells, points, components)."""
        num_cells = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        points, components = self.kernel.shape
        out = np.zeros((num_cells, points, components))
        c = _constants(self.compiled, self.kernel)
        w = np.empty(sum(e["num_dofs"] for e in self.kernel.coefficients))
        functions = [(e, self.compiled.coefficients[e["position"]]) for e in self.kernel.coefficients]
        for f in functions:
            f[1].x.scatter_forward()
        x, dofmap = self.mesh.geometry.x, self.mesh.geometry.dofmap
        for cell in range(num_cells):
            for e, f in functions:
                bs = f.function_space.dofmap.bs
                dofs = f.function_space.dofmap.cell_dofs(cell)
                w[e["offset"] : e["offset"] + e["num_dofs"]] = f.x.array.reshape(-1, bs)[dofs].ravel()
            self.kernel.tabulate(out[cell].reshape(-1), w, c, np.ascontiguousarray(x[dofmap[cell]]).reshape(-1))
        return out


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
    mesh, cell = V.mesh, V.mesh.topology.cell_name()
    degree = V.element.basix_element.degree
    simplex = cell in quadrature.SIMPLICES
    axisymmetric = material.hypothesis_on(mesh) == "axisymmetric"
    if scheme == "auto":
        scheme = "row_sum" if degree == 1 else "hrz" if simplex or axisymmetric else "nodal"
    if scheme not in ("row_sum", "hrz", "nodal"):
        raise ValueError(f"lumping scheme {scheme!r} is unknown: use auto, row_sum, hrz or nodal")
    if (scheme == "nodal" and simplex) or (scheme == "row_sum" and degree > 1 and (simplex or axisymmetric)):
        where = f"{cell}s of degree {degree}"
        raise ValueError(f"scheme {scheme!r} gives entries that are not positive on {where}: use hrz")
    v, trial = ufl.TestFunction(V), ufl.TrialFunction(V)
    hypothesis = material.hypothesis_on(mesh)
    dx = _mass_measure(V, hypothesis, material.cell_tags)
    parts = [(tag, m.density_constant(mesh)) for tag, m in material.parts()]
    if scheme == "row_sum":
        total = sum(inertia.row_sum(v, density, hypothesis, dx if t is None else dx(t)) for t, density in parts)
        return _positive(InternalForce(total).apply(), scheme, mesh.comm)
    errors, b = [], la.vector(V.dofmap.index_map, V.dofmap.index_map_bs)
    for tag, density in parts:
        if scheme == "hrz":
            (mass,) = _cell_integrals(inertia.mass(trial, v, density, hypothesis, dx), tag, material)
            lump = functools.partial(_cpp.operators.lump_hrz, mass)
        else:
            at_nodes = _mass_measure(V, hypothesis, material.cell_tags, "GLL", 2 * degree - 1)
            (nodal,) = _cell_integrals(inertia.row_sum(v, density, hypothesis, at_nodes), tag, material)
            (row_sum,) = _cell_integrals(inertia.row_sum(v, density, hypothesis, dx), tag, material)
            lump = functools.partial(_cpp.operators.lump_nodal, nodal, row_sum)
        try:
            lump(V._cpp_object, b.array)
        except RuntimeError as e:  # of one rank, perhaps: told to all below
            errors.append(f"rank {mesh.comm.rank}: {e}")
    errors = sum(mesh.comm.allgather(errors), [])
    if errors:
        raise ValueError(errors[0])
    b.scatter_reverse(la.InsertMode.add)
    b.scatter_forward()
    return _positive(b, scheme, mesh.comm)


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


def _cell_integrals(form, tag, material):
    """Integrals of a form over the cells of one material, for the C++ side."""
    compiled = compile_form(form)
    entities = _entities(_domain(form), "cell", -1 if tag is None else tag, material.cell_tags)
    return [_cpp.operators.Integral(k.address, entities, _constants(compiled, k)) for k in compiled.kernels]


def strain_energy_form(u, material):
    """UFL form of the strain energy of u [F L]."""
    return _sum(u, material, lambda law, dx: elasticity.internal_energy(u, law, dx))


def internal_force_form(u, v, material):
    """UFL form of the internal virtual work of u against v."""
    return _sum(u, material, lambda law, dx: elasticity.internal_force(u, v, law, dx))


def tangent_form(u, du, v, material):
    """UFL form of the derivative of the internal virtual work at u in the direction du."""
    return _sum(u, material, lambda law, dx: elasticity.tangent(u, du, v, law, dx))


def _sum(u, material, term):
    V = u.function_space
    mesh = V.mesh
    degree = quadrature.stiffness_degree(
        mesh.topology.cell_name(),
        V.element.basix_element.degree,
        mesh.geometry.cmap.degree,
        material.hypothesis_on(mesh),
    )
    dx = ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(degree), subdomain_data=material.cell_tags)
    return sum(term(m.law(mesh), dx if tag is None else dx(tag)) for tag, m in material.parts())
