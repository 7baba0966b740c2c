# SPDX-License-Identifier: MIT
"""Register a form under a name, and build registered forms on any cell, degree, geometry degree and hypothesis.

    @registered("mass", quadrature=quadrature.mass_degree, constants={"density": SCALAR})
    def mass(on, density):
        return inertia.mass(on.trial, on.test, density, on.hypothesis, on.dx)

The function receives the setting it is built in (`Setting`: functions of the space, measures, hypothesis), and its
constants and coefficients by name. The catalogue of the package is registered this way (forms/catalogue/); forms of
others are registered and built by the same calls.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import basix.ufl
import ufl

from . import quadrature
from .materials import check_hypothesis
from .point_law import PointLaw

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
DEGREES = (1, 2)

# Shapes of constants, as functions of the geometric dimension.
Shape = Callable[[int], tuple[int, ...]]
DegreeRule = Callable[[str, int, int, str], int]


def SCALAR(dim: int) -> tuple[int, ...]:
    """Shape of a number."""
    return ()


def VECTOR(dim: int) -> tuple[int, ...]:
    """Shape of a vector of the space."""
    return (dim,)


def AXIAL(dim: int) -> tuple[int, ...]:
    """Shape of a rotation: a scalar about z in the plane, a vector in space."""
    return () if dim == 2 else (3,)


@dataclass(frozen=True)
class Setting:
    """What a registered function builds its form from, on one cell type.

    Attributes:
        cell: name of the cell.
        degree: degree of the Lagrange space.
        geometry_degree: degree of the geometry.
        hypothesis: one of materials.HYPOTHESES.
        mesh: UFL mesh.
        space: UFL function space, of vectors or scalars as registered.
        test: test function of the space.
        trial: trial function of the space.
        dx: measure of the cells, with the quadrature degree and rule in use.
        ds: measure of the exterior facets, with the same.
        rule: name of the quadrature rule, None: Basix's default.
        quadrature_degree: quadrature degree in use.
        given_degree: quadrature degree that the caller of `build` asked for, or None.
    """

    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str
    mesh: Any
    space: Any
    test: Any
    trial: Any
    dx: Any
    ds: Any
    rule: str | None
    quadrature_degree: int
    given_degree: int | None

    def cells_measure(self, degree: DegreeRule) -> Any:
        """Measure of the cells with another quadrature degree, for forms whose terms need different ones.

        Args:
            degree: rule of forms/quadrature.py; a degree that the caller of `build` gave goes first.
        """
        own = degree(self.cell, self.degree, self.geometry_degree, self.hypothesis)
        used = own if self.given_degree is None else self.given_degree
        return ufl.dx(domain=self.mesh, metadata=quadrature.metadata(used, self.rule))


@dataclass(frozen=True)
class RegisteredForm:
    """A registered form: its function and what `registered` was told about it, see there."""

    name: str
    function: Callable[..., Any]
    quadrature: DegreeRule
    constants: Mapping[str, Shape]
    coefficients: Sequence[str]
    scalar: bool
    rule: str | None
    cells: Sequence[str]
    cells_reason: str
    excluded: Mapping[str, str] = field(default_factory=dict)


@dataclass
class Built:
    """A built form.

    Attributes:
        form: UFL form.
        names: names of its coefficients and constants, by object.
        degree: quadrature degree in use.
        rule: name of the quadrature rule in use, None: Basix's default.
        law: its point law, or None.
    """

    form: ufl.Form
    names: dict[Any, str]
    degree: int
    rule: str | None
    law: PointLaw | None = None


FORMS: dict[str, RegisteredForm] = {}


def registered(
    name: str,
    *,
    quadrature: DegreeRule,
    constants: Mapping[str, Shape] | None = None,
    coefficients: Sequence[str] = (),
    scalar: bool = False,
    rule: str | None = None,
    cells: Sequence[str] = tuple(CELLS),
    cells_reason: str = "",
    excluded: Mapping[str, str] | None = None,
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorator: register a function that returns a UFL form, or a form and its PointLaw, or a form and the names of
    coefficients that it makes itself.

    The function is called with the `Setting`, then with its constants and coefficients as keyword arguments.

    Args:
        name: name of the form; dots are allowed ("linear_elastic.force").
        quadrature: function (cell, degree, geometry_degree, hypothesis) that returns the default quadrature degree.
        constants: shape of each constant by name, a function of the dimension: SCALAR, VECTOR, AXIAL or one's own.
            Their order is the order of the kernel's constants.
        coefficients: names of the coefficients, functions of the space; their order is the kernel's.
        scalar: is the space one of scalars? Otherwise of vectors.
        rule: quadrature rule that the form always has, None: the one that `build` is given.
        cells: cells that the form exists on.
        cells_reason: why it does not exist on the others; part of the error.
        excluded: hypotheses that the form does not exist for, with the reason.

    Raises:
        ValueError: the name is taken, or a cell is unknown.
    """
    unknown = [c for c in cells if c not in CELLS]
    if unknown:
        raise ValueError(f"cell {unknown[0]!r} is unknown: the registry holds {', '.join(CELLS)}")

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        if name in FORMS:
            where = FORMS[name].function
            raise ValueError(f"form {name!r} is registered already, by {where.__module__}.{where.__qualname__}")
        FORMS[name] = RegisteredForm(
            name,
            function,
            quadrature,
            dict(constants or {}),
            tuple(coefficients),
            scalar,
            rule,
            tuple(cells),
            cells_reason,
            dict(excluded or {}),
        )
        return function

    return register


def default_hypothesis(cell: str) -> str:
    """Hypothesis of a cell where none is named: "3d" or "plane_strain"."""
    return "3d" if CELLS[cell] == 3 else "plane_strain"


def check(name: str, cell: str, degree: int, geometry_degree: int, hypothesis: str) -> None:
    """Check that a form can be built.

    Args:
        name: name of the form.
        cell: one of CELLS.
        degree: degree of the space, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        hypothesis: one of materials.HYPOTHESES.

    Raises:
        ValueError: for what is not registered, saying what is.
    """
    if cell not in CELLS:
        raise ValueError(f"cell {cell!r} is unknown: the catalogue holds {', '.join(CELLS)}")
    for what, value in (("degree", degree), ("geometry degree", geometry_degree)):
        if value not in DEGREES:
            raise ValueError(f"{what} {value!r} is not in the catalogue: use 1 or 2, or compile a form of your own")
    if name not in FORMS:
        raise ValueError(f"form {name!r} is unknown: the catalogue holds {', '.join(FORMS)}")
    check_hypothesis(hypothesis, CELLS[cell])
    entry = FORMS[name]
    if hypothesis in entry.excluded:
        raise ValueError(f"{name}: {entry.excluded[hypothesis]}")
    if cell not in entry.cells:
        raise ValueError(f"{name}: {entry.cells_reason or 'only for cells ' + ', '.join(entry.cells)}")


def build(
    name: str,
    cell: str,
    degree: int,
    geometry_degree: int = 1,
    hypothesis: str | None = None,
    rule: str | None = None,
    quadrature_degree: int | None = None,
) -> Built:
    """UFL form of the catalogue, or one that was registered by `registered`.

    Args:
        name: name of the form.
        cell: one of CELLS.
        degree: degree of the space, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        hypothesis: one of materials.HYPOTHESES; None: "3d" or "plane_strain".
        rule: quadrature rule; None: the form's own, or Basix's default.
        quadrature_degree: quadrature degree; None: the form's default.

    Raises:
        ValueError: for what is not registered.
    """
    hypothesis = hypothesis or (default_hypothesis(cell) if cell in CELLS else "")
    check(name, cell, degree, geometry_degree, hypothesis)
    entry, dim = FORMS[name], CELLS[cell]
    mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, geometry_degree, shape=(dim,)))
    shape = () if entry.scalar else (dim,)
    space = ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, degree, shape=shape))
    rule = entry.rule or rule
    default = entry.quadrature(cell, degree, geometry_degree, hypothesis)
    used = default if quadrature_degree is None else quadrature_degree
    metadata = quadrature.metadata(used, rule)
    setting = Setting(
        cell,
        degree,
        geometry_degree,
        hypothesis,
        mesh,
        space,
        ufl.TestFunction(space),
        ufl.TrialFunction(space),
        ufl.dx(domain=mesh, metadata=metadata),
        ufl.ds(domain=mesh, metadata=metadata),
        rule,
        used,
        quadrature_degree,
    )
    constants = {label: ufl.Constant(mesh, shape=shape_of(dim)) for label, shape_of in entry.constants.items()}
    coefficients = {label: ufl.Coefficient(space) for label in entry.coefficients}
    made = entry.function(setting, **constants, **coefficients)
    form, more = made if isinstance(made, tuple) else (made, {})
    names = {o: label for label, o in (constants | coefficients).items()}
    if isinstance(more, PointLaw):
        return Built(form, names, used, rule, more)
    return Built(form, names | more, used, rule)
