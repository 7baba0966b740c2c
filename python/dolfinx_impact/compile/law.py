# SPDX-License-Identifier: MIT
"""A law of a user's own on one kind of cells, as forms that kernels are written of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_constants

from ..assembly.cauchy_stress import STRESS, components
from ..forms import inertia, quadrature
from ..forms.materials import weight
from ..forms.point_law import PointLaw

# Kinds of kernels. "elastic_tangent" is the stiffness of the elastic part of a law with internal variables.
KINDS = ("force", "tangent", "elastic_tangent", "energy", "mass", "stress")
DISPLACEMENT = "u"  # name of the unknown in every kernel
DENSITY = "density"  # name of the constant of the mass

Named: TypeAlias = "ufl.Coefficient | ufl.Constant"


class Case(NamedTuple):
    """What kernels are made for, in the order of kernels::Key.

    Attributes:
        cell: one of forms.registry.CELLS.
        degree: degree of the unknown [1].
        geometry_degree: degree of the geometry [1].
        hypothesis: one of forms.materials.HYPOTHESES.
    """

    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str

    def __str__(self) -> str:
        return f"{self.cell}, degree {self.degree}, geometry degree {self.geometry_degree}, {self.hypothesis}"

    @property
    def stiffness_degree(self) -> int:
        """Quadrature degree of the package's own laws [1]."""
        return int(quadrature.stiffness_degree(*self))

    @property
    def mass_degree(self) -> int:
        """Quadrature degree of masses [1]."""
        return int(quadrature.mass_degree(*self))


class KernelForm(NamedTuple):
    """A form that a kernel is written of, with the point law of its internal variables and outputs, if any."""

    form: ufl.Form
    law: PointLaw | None = None


@dataclass
class OwnLaw:
    """A law of a user's own on one kind of cells.

    Attributes:
        name: name of the law in the user's file; its kernels are called "NAME.force" and so on.
        case: the cells.
        forms: form of each kind of kernel, of KINDS.
        names: names of coefficients and constants.
        values: values that constants have in the file, by name; not of symbolic ones.
        missing: why there are no kernels of a kind, by kind.
    """

    name: str
    case: Case
    forms: dict[str, KernelForm]
    names: dict[Named, str]
    values: dict[str, list[float]]
    missing: dict[str, str] = field(default_factory=dict)


def values_of(constants: dict[Named, str]) -> dict[str, list[float]]:
    """Values of constants of DOLFINx by name.

    Args:
        constants: names of constants; symbolic ones and coefficients have no value.

    Raises:
        ValueError: a value is not finite.
    """
    values: dict[str, list[float]] = {}
    for c, name in constants.items():
        if isinstance(c, fem.Constant):
            value = np.ravel(c.value).astype(float)
            if not np.isfinite(value).all():
                raise ValueError(f"the constant {name!r} is {value.tolist()}: give it a finite value in the file")
            values[name] = [float(v) for v in value]
    return values


def constants_of(*terms: Any) -> list[ufl.Constant]:
    """Constants of forms and expressions, in the order in which they were made.

    Args:
        terms: forms, expressions, or None.
    """
    found = {c for term in terms if term is not None for c in extract_constants(term)}
    return sorted(found, key=lambda c: c.count())


def mass_form(u: Any, case: Case) -> tuple[ufl.Form, ufl.Constant]:
    """Mass matrix of the unknown's space, and its constant of density: a vector of one for each field of mixed spaces.

    Args:
        u: the unknown.
        case: the cells.
    """
    V = u.ufl_function_space()
    mesh, element = V.ufl_domain(), V.ufl_element()
    dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(case.mass_degree))
    fields = element.num_sub_elements if element.num_sub_elements > 1 and element.block_size == 1 else 1
    if fields == 1:
        density = ufl.Constant(mesh)
        return inertia.mass(ufl.TrialFunction(V), ufl.TestFunction(V), density, case.hypothesis, dx), density
    density = ufl.Constant(mesh, shape=(fields,))
    pairs = zip(ufl.TrialFunctions(V), ufl.TestFunctions(V))
    return sum(inertia.mass(a, b, density[i], case.hypothesis, dx) for i, (a, b) in enumerate(pairs)), density


def stress_form(u: Any, stress: Any, case: Case) -> KernelForm:
    """Virtual work of a Cauchy stress on the gradient, and the point law whose output "stress" is that stress.

    Args:
        u: the unknown.
        stress: UFL tensor of 3 x 3 [F/L^2].
        case: the cells.

    Raises:
        ValueError: the unknown is no displacement.
    """
    V = u.ufl_function_space()
    mesh = V.ufl_domain()
    dim = mesh.geometric_dimension()
    if u.ufl_shape != (dim,):
        raise ValueError(f"a stress needs a displacement of {dim} components, the unknown has the shape {u.ufl_shape}")
    plane = ufl.as_tensor([[stress[i, j] for j in range(dim)] for i in range(dim)])
    dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(case.stiffness_degree))
    work = ufl.inner(plane, ufl.grad(ufl.TestFunction(V))) * weight(mesh, case.hypothesis) * dx
    outputs = {STRESS: ufl.as_vector([stress[i, j] for i, j in components(dim)])}
    return KernelForm(work, PointLaw(outputs=outputs))
