# SPDX-License-Identifier: MIT
"""Winkler's foundation: springs and dashpots from a surface to the ground; seed (3.9), (3.10), docs/foundation.md."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem import Function
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI

from . import compat
from .assembly.ffcx_form import ffcx_form
from .assembly import operators
from .common.collective import comm_of, guard
from .common.fixed import read_only
from .common.types import FloatArray
from .forms import foundation, quadrature
from .forms.materials import check_hypothesis
from .loads import VARYING, _FacetLoad, _tag, check_tag, facet_tags_of


class Foundation(_FacetLoad):
    """Springs, and dashpots beside them, between a surface of a body and the ground: each point of the surface by
    itself is pulled back with the traction t = -k (u . n) n - c (v . n) n, n the normal of the undeformed surface.

    `constant.value` is the stiffness (of an expression a factor of it, one at first), `damping_constant.value` the
    damping; both may be changed between solves and between steps. Load steps do not divide them.

    Args:
        facet_tags: MeshTags over facets.
        tag: tag of the supported facets.
        stiffness: force per area and displacement: a number acts along the normal only, gdim numbers along the
            coordinates, t_i = -k_i u_i; or a UFL expression of the place and of functions with one of these shapes
            [F/L^3].
        damping: force per area and velocity of problems in time, as `stiffness`; static problems do not see it
            [F T/L^3].

    Raises:
        TypeError: an argument of a wrong type; on all ranks.
        ValueError: a stiffness or damping that is negative or not finite; on all ranks.
    """

    def __init__(self, facet_tags: MeshTags, tag: int, stiffness: Any, damping: Any = 0.0) -> None:
        with guard(comm_of(facet_tags), "Foundation", tag=tag) as ranks:
            self.facet_tags, self.tag = facet_tags_of("Foundation", facet_tags), _tag(tag)
            self.stiffness = _coefficient("stiffness", stiffness, "[F/L^3]")
            self.damping = _coefficient("damping", damping, "[F T/L^3]")
            if not _is_expression(self.stiffness) and not np.any(self.stiffness):
                raise ValueError("the stiffness of a Foundation is zero: give a positive one [F/L^3]")
            ranks.same(stiffness=_shown(self.stiffness), damping=_shown(self.damping))
        self._damping_constant: fem.Constant | None = None
        self._unit: tuple[tuple[Any, ...], list[operators.InternalForce]] | None = None  # of unit_forces

    @property
    def damping_constant(self) -> fem.Constant | None:
        """Damping in force, which can be changed between steps; None before a problem is made, and without dashpots."""
        return self._damping_constant

    @property
    def damps(self) -> bool:
        """Whether there are dashpots."""
        return _is_expression(self.damping) or bool(np.any(self.damping))

    def springs(self, u: Any, v: Any, hypothesis: str | None = None) -> ufl.Form:
        """Internal virtual work of the springs, for a residual of your own.

        Args:
            u: displacement, or trial function [L].
            v: test function.
            hypothesis: hypothesis of the body; only "axisymmetric" makes a difference.

        Raises:
            ValueError: the tag does not exist, or the stiffness does not fit the mesh or is negative; on all ranks.
        """
        mesh = v.ufl_function_space().mesh
        k, self._constant = self._on("stiffness", mesh, self.stiffness, self._constant)
        return foundation.foundation(k, u, v, _hypothesis(hypothesis, mesh), self._supported(v, hypothesis))

    def dashpots(self, velocity: Any, v: Any, hypothesis: str | None = None) -> ufl.Form:
        """Internal virtual work of the dashpots, for a residual of your own.

        Args:
            velocity: velocity, or trial function [L/T].
            v: test function.
            hypothesis: as in `springs`.

        Raises:
            ValueError: as in `springs`.
        """
        mesh = v.ufl_function_space().mesh
        c, self._damping_constant = self._on("damping", mesh, self.damping, self._damping_constant)
        return foundation.foundation(c, velocity, v, _hypothesis(hypothesis, mesh), self._supported(v, hypothesis))

    def form(self, u: Any, v: Any, material: Any) -> ufl.Form:
        """That of the springs; it depends on u."""
        return -self.springs(u, v, material.hypothesis_on(u.function_space.mesh))

    def force(self, u: Function, velocity: Function | None = None, hypothesis: str | None = None) -> FloatArray:
        """Total force of the foundation on the body. Collective.

        Args:
            u: displacement [L].
            velocity: velocity; None: without the dashpots [L/T].
            hypothesis: as in `springs`.

        Returns:
            Force, of axisymmetric bodies that of the whole circumference, (gdim) [F].
        """
        V = u.function_space
        v = ufl.TestFunction(V)
        form = -self.springs(u, v, hypothesis)
        if velocity is not None and self.damps:
            form = form - self.dashpots(velocity, v, hypothesis)
        nodal = operators.InternalForce(form).apply().array[: V.dofmap.index_map.size_local * V.dofmap.index_map_bs]
        return np.asarray(V.mesh.comm.allreduce(nodal.reshape(-1, V.dofmap.index_map_bs).sum(axis=0), MPI.SUM))

    def unit_forces(self, V: fem.FunctionSpace, hypothesis: str | None = None) -> list[FloatArray]:
        """Internal nodal forces of springs and of dashpots under the displacement and velocity one: what a checkpoint
        compares. Their kernels are looked for once. Collective.

        Args:
            V: displacement space.
            hypothesis: as in `springs`.

        Returns:
            Two arrays of owned nodes, (num_owned, gdim) [F/L], [F T/L].
        """
        given = (V, hypothesis, self.stiffness, self.damping, self._constant, self._damping_constant)
        if self._unit is None or any(a is not b for a, b in zip(given, self._unit[0])):
            one, v = fem.Function(V, name="u"), ufl.TestFunction(V)
            one.x.array[:] = 1.0
            forces = [operators.InternalForce(work(one, v, hypothesis)) for work in (self.springs, self.dashpots)]
            self._unit = (*given[:4], self._constant, self._damping_constant), forces
        n, bs = V.dofmap.index_map.size_local, V.dofmap.index_map_bs
        return [force.apply().array[: n * bs].reshape(n, bs) for force in self._unit[1]]

    def energy_form(self, u: Any, material: Any) -> ufl.Form:
        """Energy stored in the springs, a form of rank 0 [F L]."""
        return 0.5 * self.springs(u, u, material.hypothesis_on(u.function_space.mesh))

    def ramps(self) -> list[tuple[fem.Constant, FloatArray]]:
        """Nothing: springs are there from the first load step."""
        return []

    def varies(self) -> bool:
        return _is_expression(self.stiffness)

    def _what(self) -> str:
        return f"stiffness={_shown(self.stiffness)!r}, damping={_shown(self.damping)!r}"

    def _supported(self, v: Any, hypothesis: str | None) -> ufl.Measure:
        """Measure of the supported facets."""
        V = v.ufl_function_space()
        check_tag(self.facet_tags, self.tag, V.mesh, "Foundation")
        p, g = V.element.basix_element.degree, compat.coordinate_element(V.mesh).degree
        degree = quadrature.foundation_degree(V.mesh.topology.cell_name(), p, g, _hypothesis(hypothesis, V.mesh))
        degree += VARYING if _is_expression(self.stiffness) or _is_expression(self.damping) else 0
        metadata = quadrature.metadata(degree)
        return ufl.Measure("ds", domain=V.mesh, subdomain_data=self.facet_tags, metadata=metadata)(self.tag)

    def _on(self, name: str, mesh: Mesh, value: Any, known: fem.Constant | None) -> tuple[Any, fem.Constant]:
        """A coefficient in UFL on a mesh, and its constant, the known one on the same mesh."""
        shape = value.ufl_shape if _is_expression(value) else np.shape(value)
        if shape not in ((), (mesh.geometry.dim,)):
            raise ValueError(
                f"the {name} of a Foundation has shape {shape}: on this mesh give one number, along the normal, or "
                f"{mesh.geometry.dim}, along the coordinates"
            )
        if known is None or known.ufl_domain().ufl_cargo() is not mesh._cpp_object:
            self._mesh = mesh
            start = 1.0 if _is_expression(value) else value
            known = fem.Constant(mesh, np.asarray(start, dtype=default_scalar_type))
        if not _is_expression(value):
            return known, known
        if any(d.ufl_cargo() is not mesh._cpp_object for d in ufl.domain.extract_domains(value)):
            raise ValueError(f"the {name} of a Foundation is an expression on another mesh than the displacement")
        self._check_sign(name, mesh, value)
        return known * value, known

    def _check_sign(self, name: str, mesh: Mesh, value: Any) -> None:
        """Refuse an expression that is negative at a point of the rule. Collective."""
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.facet_tags, metadata=quadrature.metadata(3))(self.tag)
        parts = [value] if value.ufl_shape == () else [value[i] for i in range(mesh.geometry.dim)]
        negative = sum(ufl.conditional(ufl.ge(part, 0.0), 0.0, 1.0) for part in parts)
        area = mesh.comm.allreduce(fem.assemble_scalar(ffcx_form(negative * ds)), MPI.SUM)
        if area > 0.0:
            raise ValueError(f"the {name} of a Foundation is negative, or not a number, on a part of tag {self.tag}")


def foundations(loads: Iterable[Any]) -> list[Foundation]:
    """The foundations among the loads of a problem."""
    return [load for load in loads if isinstance(load, Foundation)]


def dashpot_form(loads: Iterable[Any], velocity: Any, v: Any, material: Any) -> ufl.Form | None:
    """Internal virtual work of the dashpots of all foundations; None without any.

    Args:
        loads: loads of a problem.
        velocity: velocity, or trial function [L/T].
        v: test function.
        material: material of the bodies.
    """
    hypothesis = material.hypothesis_on(v.ufl_function_space().mesh)
    forms = [f.dashpots(velocity, v, hypothesis) for f in foundations(loads) if f.damps]
    return sum(forms[1:], forms[0]) if forms else None


def spring_form(loads: Iterable[Any], u: Any, v: Any, material: Any) -> ufl.Form | None:
    """Internal virtual work of the springs of all foundations; None without any. Arguments as `dashpot_form`."""
    hypothesis = material.hypothesis_on(v.ufl_function_space().mesh)
    forms = [f.springs(u, v, hypothesis) for f in foundations(loads)]
    return sum(forms[1:], forms[0]) if forms else None


def _is_expression(value: Any) -> bool:
    return isinstance(value, ufl.core.expr.Expr)


def _shown(value: Any) -> Any:
    """A coefficient as `repr` and comparisons between ranks have it."""
    return "expression" if _is_expression(value) else np.asarray(value).tolist()


def _hypothesis(hypothesis: str | None, mesh: Mesh) -> str:
    """A hypothesis, checked; None: that of a body that is not axisymmetric."""
    if hypothesis is None:
        return "3d" if mesh.geometry.dim == 3 else "plane_strain"
    check_hypothesis(hypothesis, mesh.geometry.dim)
    return hypothesis


def _coefficient(name: str, value: Any, unit: str) -> Any:
    """A UFL expression, or numbers as an array, () or (gdim)."""
    if _is_expression(value):
        return value
    try:
        if value is None or any(isinstance(x, (str, bytes, bool)) for x in np.ravel(np.asarray(value, dtype=object))):
            raise TypeError
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number, or one per coordinate, found {value!r:.80}") from None
    if array.ndim > 1:
        raise ValueError(f"{name} has shape {array.shape}: give a number, or one per coordinate")
    if not np.all(np.isfinite(array)) or np.any(array < 0.0):
        raise ValueError(f"{name} is {array.tolist()}: it must be finite and not negative {unit}")
    return read_only(array)
