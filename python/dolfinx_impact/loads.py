# SPDX-License-Identifier: MIT
"""Loads with checked input; their virtual work is in forms/loads.py."""

import warnings
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem import Constant, FunctionSpace
from dolfinx.mesh import Mesh, MeshTags, exterior_facet_indices

from . import compat
from .assembly import operators
from .common.collective import comm_of, guard
from .common.fixed import Fixed, read_only
from .common.types import FloatArray, IntArray
from .forms import loads, quadrature
from .common.arguments import number

VARYING = 2  # more degrees of quadrature for a load that is an expression
# Of the earth at 45 degrees, in m/s^2, mm/s^2, cm/s^2, mm/ms^2, ft/s^2 and in/s^2.
GRAVITIES = (9.80665, 9806.65, 980.665, 9.80665e-3, 32.17405, 386.0886)
GRAVITY_WITHIN = 0.005  # 9.8 and 9.83 are meant by the same


def _vector(name: str, value: Any, gdim: int) -> FloatArray:
    try:
        if any(isinstance(x, (str, bytes)) for x in np.ravel(np.asarray(value, dtype=object))):
            raise TypeError
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be {gdim} numbers, found {value!r}") from None
    if array.shape != (gdim,):
        raise ValueError(f"{name} has shape {array.shape}: on this mesh it needs {gdim} components")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} is {array.tolist()}: give finite numbers")
    return array


def check_tag(tags: MeshTags, tag: int, mesh: Mesh, what: str) -> None:
    """Raise ValueError, on all ranks alike, unless some facet of the boundary carries the tag."""
    tdim = mesh.topology.dim
    if tags.dim != tdim - 1:
        raise ValueError(
            f"{what}: loads need tags of facets (dimension {tdim - 1}), found tags of dimension {tags.dim}"
        )
    mesh.topology.create_connectivity(tdim - 1, tdim)
    on_boundary = np.isin(tags.indices, exterior_facet_indices(mesh.topology))
    here = np.unique(tags.values), np.unique(tags.values[on_boundary])
    parts = mesh.comm.allgather(here)
    everywhere, outside = ({int(t) for part in parts for t in part[i]} for i in (0, 1))
    if tag not in everywhere:
        raise ValueError(f"{what}: no facet carries the tag {tag}; the tags of the mesh are {sorted(everywhere)}")
    if tag not in outside:
        raise ValueError(
            f"{what}: the facets with the tag {tag} lie inside the body; tags on the boundary: {sorted(outside)}"
        )


def _tag(tag: Any) -> int:
    if isinstance(tag, bool) or not isinstance(tag, (int, float, np.integer, np.floating)) or tag != tag // 1:
        raise TypeError(f"a tag must be an integer, found {tag!r:.60}")
    return int(tag)


def facet_tags_of(what: str, facet_tags: MeshTags) -> MeshTags:
    """Tags that a load or a pair was given, of the right kind."""
    if not hasattr(facet_tags, "find"):
        raise TypeError(f"{what}: facet_tags must be MeshTags of facets, found {type(facet_tags).__name__}")
    return facet_tags


def _is_gravity(value: float) -> bool:
    """Whether an acceleration is the gravity of the earth in a usual unit."""
    return any(abs(value - g) <= GRAVITY_WITHIN * g for g in GRAVITIES)


class _Load(Fixed):
    """Common part: value as a constant that can be changed between solves (`.constant.value`); of a UFL expression a
    factor of it, one at first."""

    amplitude: Any = None
    vector: Any
    _constant: Constant | None = None
    _mesh: Mesh
    _reached: Any

    @property
    def constant(self) -> Constant:
        """Value of the load in force, which can be changed between solves; there is none before a problem is made.

        Raises:
            AttributeError: no problem has been made with the load.
        """
        if self._constant is None:
            raise AttributeError(f"a {type(self).__name__} has no constant before a problem is made with it")
        return self._constant

    def _prepare(self, mesh: Mesh, value: Any) -> Constant:
        if self._constant is None or self._mesh is not mesh:
            self._mesh = mesh
            self._constant = fem.Constant(mesh, np.asarray(value, dtype=default_scalar_type))
            self._reached = np.zeros_like(self._constant.value)
        return self._constant

    def _vector(self, name: str, mesh: Mesh) -> Any:
        """The load's `vector` in UFL: constants, or a factor times an expression."""
        if not isinstance(self.vector, ufl.core.expr.Expr):
            return self._prepare(mesh, _vector(name, self.vector, mesh.geometry.dim))
        if self.vector.ufl_shape != (mesh.geometry.dim,):
            raise ValueError(
                f"{name} has shape {self.vector.ufl_shape}: on this mesh it needs {mesh.geometry.dim} components"
            )
        domains = ufl.domain.extract_domains(self.vector)
        if any(d.ufl_cargo() is not mesh._cpp_object for d in domains):
            raise ValueError(f"{name} is an expression on another mesh than the displacement")
        return self._prepare(mesh, 1.0) * self.vector

    def form(self, u: Any, v: Any, material: Any) -> ufl.Form:
        """External virtual work.

        Args:
            u: displacement [L].
            v: test function.
            material: material of the bodies.
        """
        raise NotImplementedError

    def __repr__(self) -> str:
        where = f"tag={self.tag}, " if isinstance(self, _FacetLoad) else ""
        return f"{type(self).__name__}({where}{self._what()})"

    def _what(self) -> str:
        """What acts, as `repr` shows it."""
        if self.varies():
            return "vector=expression"
        return f"vector={np.asarray(self.vector).tolist()}"

    def varies(self) -> bool:
        return isinstance(self.vector, ufl.core.expr.Expr)

    def ramps(self) -> list[tuple[Constant, FloatArray]]:
        """Pairs (constant, value reached by earlier solves): what load steps run through."""
        return [(self.constant, self._reached)]


class BodyForce(_Load):
    """Force on the inside of a body. As it stands, `BodyForce((0, -9.81))`, it is one per mass: an acceleration, which
    the density of each material is multiplied with. `per_mass=False` makes it one per volume, such as rho g.

    Args:
        vector: components of the acceleration [L/T^2], or with `per_mass=False` of the force per undeformed volume
            [F/L^3]; or a UFL expression of the place and of functions, for a varying one.
        per_mass: whether `vector` is a force per mass; False: per volume.
        amplitude: factor in problems in time: a function of time, an AmplitudeTable or a pair (times, values);
            None: one [1].

    Raises:
        TypeError: `per_mass` is neither True nor False.

    Warns:
        UserWarning: when a problem takes it: a force per mass that is a density times the gravity of the earth, or a
            force per volume that is this gravity; a force per mass on bodies whose densities are all zero.
    """

    def __init__(self, vector: Any, per_mass: bool = True, amplitude: Any = None) -> None:
        if not isinstance(per_mass, (bool, np.bool_)):
            raise TypeError(f"per_mass is {per_mass!r:.60}: give True (acceleration) or False (force per volume)")
        self.vector, self.per_mass, self.amplitude = read_only(vector), bool(per_mass), amplitude
        self._warned = False

    def _what(self) -> str:
        return f"{super()._what()}, per_mass={self.per_mass}"

    def _warn_of_meaning(self, material: Any, mesh: Mesh) -> None:
        """Warn, once and on rank 0, of a value that looks like the other meaning."""
        if self._warned or self.varies():
            return
        self._warned = True
        size = float(np.linalg.norm(_vector("body force", self.vector, mesh.geometry.dim)))
        densities = [m.density for _, m in material.parts() if m.density is not None]
        text = ""
        if self.per_mass and densities and not any(densities):
            text = "acts on nothing: it is a force per mass and the density is zero; per_mass=False: one per volume"
        elif size and self.per_mass and not _is_gravity(size):
            for density in densities:
                if density and _is_gravity(size / density):
                    text = (
                        f"is the density {density:g} times gravity, but counts as an acceleration, which is multiplied "
                        "with the density: give g, or per_mass=False"
                    )
        elif not self.per_mass and _is_gravity(size) and any(d and abs(d - 1.0) > GRAVITY_WITHIN for d in densities):
            text = "is gravity, but counts as a force per volume: leave out per_mass=False, or give rho g"
        if text and mesh.comm.rank == 0:
            warnings.warn(f"{self!r} {text}", stacklevel=5)

    def form(self, u: Any, v: Any, material: Any) -> ufl.Form:
        V = u.function_space
        mesh = V.mesh
        if self.per_mass:  # before the constant of the load: in this order the kernels of the package have them
            for _, m in material.parts():
                m.density_constant(mesh)
        f = self._vector("body force", mesh)
        self._warn_of_meaning(material, mesh)
        hypothesis = material.hypothesis_on(mesh)
        degree = quadrature.mass_degree(
            mesh.topology.cell_name(),
            V.element.basix_element.degree,
            compat.coordinate_element(mesh).degree,
            hypothesis,
        ) + (VARYING if self.varies() else 0)
        dx = ufl.Measure("dx", domain=mesh, metadata=quadrature.metadata(degree), subdomain_data=material.cell_tags)
        return sum(
            loads.body_force(
                m.density_constant(mesh) * f if self.per_mass else f, v, hypothesis, dx if t is None else dx(t)
            )
            for t, m in material.parts()
        )

    def _dofs(self, V: FunctionSpace) -> IntArray:
        return np.arange(V.dofmap.index_map.size_local * V.dofmap.index_map_bs)


class _FacetLoad(_Load):
    facet_tags: MeshTags
    tag: int

    def _dofs(self, V: FunctionSpace) -> IntArray:
        nodes = fem.locate_dofs_topological(V, self.facet_tags.dim, self.facet_tags.find(self.tag))
        return (V.dofmap.bs * nodes[:, None] + np.arange(V.dofmap.bs)).ravel()

    def _measure(self, u: Any, material: Any, extra: int = 0) -> Any:
        V = u.function_space
        mesh = V.mesh
        check_tag(self.facet_tags, self.tag, mesh, type(self).__name__)
        p, g = V.element.basix_element.degree, compat.coordinate_element(mesh).degree
        degree = quadrature.facet_degree(mesh.topology.cell_name(), p, g, material.hypothesis_on(mesh)) + extra
        metadata = quadrature.metadata(degree)
        return ufl.Measure("ds", domain=mesh, subdomain_data=self.facet_tags, metadata=metadata)(self.tag)


class Traction(_FacetLoad):
    """Dead traction on facets.

    Args:
        facet_tags: MeshTags over facets.
        tag: tag of the loaded facets.
        vector: components per reference area [F/L^2]; or a UFL expression of the place and of functions, for one that
            varies.
        amplitude: factor in problems in time: a function of time, an AmplitudeTable or a pair (times, values);
            None: one [1].

    Raises:
        ValueError: the tag does not exist, wrong number of components; on all ranks.
    """

    def __init__(self, facet_tags: MeshTags, tag: int, vector: Any, amplitude: Any = None) -> None:
        with guard(comm_of(facet_tags), "Traction", tag=tag, vector=vector, amplitude=amplitude):
            self.facet_tags, self.tag = facet_tags_of("Traction", facet_tags), _tag(tag)
        self.vector, self.amplitude = read_only(vector), amplitude

    def form(self, u: Any, v: Any, material: Any) -> ufl.Form:
        mesh = u.function_space.mesh
        t, ds = self._vector("traction", mesh), self._measure(u, material, extra=VARYING if self.varies() else 0)
        return loads.traction(t, v, material.hypothesis_on(mesh), ds)


class FollowerPressure(_FacetLoad):
    """Pressure that stays normal to the deformed surface.

    Args:
        facet_tags: MeshTags over facets.
        tag: tag of the loaded facets.
        pressure: positive pushes on the body [F/L^2].
    """

    def __init__(self, facet_tags: MeshTags, tag: int, pressure: float) -> None:
        with guard(comm_of(facet_tags), "FollowerPressure", tag=tag, pressure=pressure):
            self.facet_tags, self.tag = facet_tags_of("FollowerPressure", facet_tags), _tag(tag)
            self.pressure = number("pressure", pressure, unit=" [F/L^2]")

    def _what(self) -> str:
        return f"pressure={self.pressure}"

    def varies(self) -> bool:
        return False

    def form(self, u: Any, v: Any, material: Any) -> ufl.Form:
        """It depends on u."""
        mesh = u.function_space.mesh
        p = self._prepare(mesh, self.pressure)
        ds = self._measure(u, material, extra=(mesh.geometry.dim - 1) * (u.function_space.element.basix_element.degree))
        return loads.follower_pressure(p, u, v, material.hypothesis_on(mesh), ds)


Load: TypeAlias = _Load  # those of this module, and Foundation


class DeadLoad:
    """Nodal forces of a load that does not follow the body, for the explicit integrator.

    Args:
        load: load of this module.
        form: its virtual work, UFL form of rank 1.
        V: displacement space.

    Attributes:
        dofs: owned degrees of freedom on which any value of the load acts.
    """

    def __init__(self, load: Any, form: Any, V: FunctionSpace) -> None:
        self._force = operators.InternalForce(form)
        self._inputs = operators.Inputs(self._force.compiled.constants, self._force.coefficients.values())
        num_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        if load.varies():  # it may be zero now where it is not later
            self.dofs = load._dofs(V)
        else:
            value = np.copy(load.constant.value)
            load.constant.value = np.ones_like(value)
            self.dofs = np.flatnonzero(self._force.apply().array[:num_owned])
            load.constant.value = value
        self.dofs = self.dofs[self.dofs < num_owned].astype(np.int32)

    def changed(self) -> bool:
        """Has a value of the load changed on this rank since `values`?"""
        return self._inputs.changed()

    def forces(self) -> FloatArray:
        """Forces on `dofs` at the present values [F]. Collective."""
        return self._force.apply().array[self.dofs]

    def values(self) -> FloatArray:
        """Forces on `dofs` as `forces` returns them; `changed` compares with the present values from now on [F].
        Collective."""
        self._inputs.store()
        return self.forces()
