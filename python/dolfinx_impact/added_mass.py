# SPDX-License-Identifier: MIT
"""Mass on a surface: what is fixed to a body and moves with it, as an axle in the bore of a wheel."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import MeshTags
from mpi4py import MPI

from . import compat
from .assembly.ffcx_form import ffcx_form
from .assembly import operators
from .common.arguments import number
from .common.collective import comm_of, guard
from .common.types import FloatArray
from .forms import foundation, loads, quadrature
from .forms.materials import weight
from .loads import _FacetLoad, _tag, check_tag, facet_tags_of


class AddedMass(_FacetLoad):
    """Mass that is spread evenly over a surface and moves with it: inertia without weight and without stiffness. Its
    weight is a Traction. For problems in time; static ones do not see it.

    Args:
        facet_tags: MeshTags over facets.
        tag: tag of the facets.
        mass: positive; in plane problems per thickness, of axisymmetric bodies that of the whole circumference [M].

    Raises:
        TypeError: an argument of a wrong type; on all ranks.
        ValueError: a mass that is not positive and finite; on all ranks.
    """

    def __init__(self, facet_tags: MeshTags, tag: int, mass: float) -> None:
        with guard(comm_of(facet_tags), "AddedMass", tag=tag, mass=mass):
            self.facet_tags, self.tag = facet_tags_of("AddedMass", facet_tags), _tag(tag)
            self.mass = number("mass", mass, 0.0, " [M]")

    def matrix_form(self, u: Any, v: Any, hypothesis: str) -> ufl.Form:
        """Mass matrix, of rank 2. Collective.

        Args:
            u: trial function.
            v: test function.
            hypothesis: hypothesis of the body.
        """
        mesh = v.ufl_function_space().mesh
        density, ds = self._density(v.ufl_function_space(), hypothesis)
        return foundation.foundation(ufl.as_vector([density] * mesh.geometry.dim), u, v, hypothesis, ds)

    def nodal(self, V: FunctionSpace, hypothesis: str) -> FloatArray:
        """Row sums of the mass matrix, over owned and ghost degrees of freedom [M]. Collective.

        Args:
            V: displacement space.
            hypothesis: hypothesis of the body.
        """
        density, ds = self._density(V, hypothesis)
        each = ufl.as_vector([density] * V.mesh.geometry.dim)
        return operators.InternalForce(loads.traction(each, ufl.TestFunction(V), hypothesis, ds)).apply().array

    def ramps(self) -> list[Any]:
        """Nothing: a mass is no load that steps divide."""
        return []

    def varies(self) -> bool:
        return False

    def _what(self) -> str:
        return f"mass={self.mass}"

    def _density(self, V: FunctionSpace, hypothesis: str) -> tuple[fem.Constant, ufl.Measure]:
        """Mass per area, and the measure of the facets. Collective."""
        mesh = V.mesh
        check_tag(self.facet_tags, self.tag, mesh, "AddedMass")
        p, g = V.element.basix_element.degree, compat.coordinate_element(mesh).degree
        metadata = quadrature.metadata(quadrature.foundation_degree(mesh.topology.cell_name(), p, g, hypothesis))
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.facet_tags, metadata=metadata)(self.tag)
        one = fem.Constant(mesh, np.float64(1.0))
        area = mesh.comm.allreduce(fem.assemble_scalar(ffcx_form(one * weight(mesh, hypothesis) * ds)), MPI.SUM)
        return fem.Constant(mesh, np.float64(self.mass / area)), ds


def added_masses(given: Iterable[Any]) -> list[AddedMass]:
    """The masses among the loads of a problem."""
    return [load for load in given if isinstance(load, AddedMass)]
