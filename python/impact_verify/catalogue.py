# SPDX-License-Identifier: MIT
"""Counterparts in the hand-written solver of the forms of the catalogue, and the rules that make both comparable."""

from collections.abc import Collection, Mapping
from typing import Any, TypeAlias, cast

import impact_reference as ref
import numpy as np

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import quadrature, registry
from .nodes import TheirRule

# (cell, degree, geometry_degree, hypothesis)
Element: TypeAlias = tuple[str, int, int, str]
# (name of the form, cell, degree, geometry_degree, hypothesis)
Case: TypeAlias = tuple[str, str, int, int, str]

FINITE = ("st_venant_kirchhoff", "neo_hookean")
# Integrands that are polynomials on every cell, curved and axisymmetric ones too: both sides integrate them exactly.
POLYNOMIAL = ("mass", "mass_action", "row_sum", "body_force", "gravity")
FOUNDATION = ("normal_foundation", "normal_foundation_tangent", "foundation", "foundation_tangent")
FACET = ("traction", "follower_pressure", "follower_pressure_tangent", *FOUNDATION)
SPIN = ("gyroscopic", "ale_inertia", "centrifugal_load", "momentum_balance")


def exact(name: str, cell: str, degree: int, geometry_degree: int, hypothesis: str) -> bool:
    """Do the default rules of both sides integrate the form exactly? Then each side keeps its own rule.

    Args:
        name: form of the catalogue.
        cell: cell.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        hypothesis: hypothesis of the material.

    Returns:
        Whether both default rules are exact.
    """
    affine = cell in quadrature.SIMPLICES and geometry_degree == 1
    if name in POLYNOMIAL:
        return True
    if name == "nodal_mass":
        return False  # defined by its rule
    if name == "traction":  # the area element of a curved or warped facet is a square root
        return geometry_degree == 1 and cell != "hexahedron"
    if name in FACET:
        return False
    if hypothesis == "axisymmetric" and not name.startswith("poisson"):
        return False  # hoop strain u/r
    if name.split(".")[0] in FINITE:
        return affine and degree == 1
    return affine


def rules(name: str, cell: str, degree: int, geometry_degree: int, hypothesis: str) -> tuple[str | None, str | None]:
    """Rules that make the two sides comparable.

    Where the default rules are not exact, both sides get the same collapsed or plain Gauss-Jacobi rule.

    Args:
        name: form of the catalogue.
        cell: cell.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        hypothesis: hypothesis of the material.

    Returns:
        Rule of the UFL side and rule of the other side; None is the default. "points" stands for Basix's symmetric
        rule, handed over as points and weights.
    """
    if exact(name, cell, degree, geometry_degree, hypothesis) or name == "nodal_mass":
        return None, None
    used = registry.build(name, cell, degree, geometry_degree, hypothesis).degree
    if cell == "tetrahedron" and name in FACET + ("poisson_residual",):
        return None, "points"  # a collapsed rule depends on the facet's first vertex; a symmetric one does not
    if cell in quadrature.SIMPLICES and name not in FACET:
        return "Gauss-Jacobi", f"gauss_jacobi:{used}"
    return None, f"gauss_jacobi:{used}"


def cases(
    names: Collection[str] | None = None,
    cells: Collection[str] | None = None,
    degrees: Collection[int] | None = None,
    full: bool = True,
) -> list[Case]:
    """Combinations of form, element and hypothesis of the catalogue.

    Args:
        names: forms; None for all.
        cells: cells; None for all.
        degrees: degrees of the field; None for all.
        full: include sub- and superparametric geometry, and every hypothesis of each form.

    Returns:
        List of (name, cell, degree, geometry_degree, hypothesis).
    """
    out = []
    for name in registry.NAMES:
        if names and name not in names:
            continue
        for cell, dim in registry.CELLS.items():
            if cells and cell not in cells:
                continue
            if name == "nodal_mass" and cell in quadrature.SIMPLICES:
                continue
            scalar = name.startswith("poisson")
            hypotheses: tuple[str, ...] = ("3d",) if dim == 3 else ("plane_strain", "plane_stress", "axisymmetric")
            for hypothesis in hypotheses:
                if hypothesis == "axisymmetric" and (name in SPIN):
                    continue
                if hypothesis != hypotheses[0] and (scalar or not depends_on_hypothesis(name, hypothesis)):
                    continue
                for degree in registry.DEGREES:
                    if degrees and degree not in degrees:
                        continue
                    for geometry_degree in registry.DEGREES:
                        if not full and (geometry_degree != 1 or hypothesis != hypotheses[0]):
                            continue
                        out.append((name, cell, degree, geometry_degree, hypothesis))
    return out


def depends_on_hypothesis(name: str, hypothesis: str) -> bool:
    """Does the form differ under this hypothesis from that under plane strain?

    Args:
        name: form of the catalogue.
        hypothesis: hypothesis of the material.

    Returns:
        Whether it differs.
    """
    if hypothesis == "axisymmetric":
        return not name.startswith("poisson") and name not in SPIN
    return name in registry.LAW_FORMS or name in ("rayleigh", "momentum_balance")


def parameters(rng: np.random.Generator, name: str, dim: int) -> dict[str, float | FloatArray]:
    """Random values of the constants of a form.

    Args:
        rng: random numbers.
        name: form of the catalogue.
        dim: dimension of space.

    Returns:
        Values by the names that the registry gives them.
    """
    values: dict[str, float | FloatArray] = {
        "E": rng.uniform(0.5, 2.0),
        "nu": rng.uniform(0.05, 0.45),
        "density": rng.uniform(0.5, 2.0),
        "alpha": rng.uniform(0.1, 1.0),
        "beta": rng.uniform(0.1, 1.0),
        "k": rng.uniform(0.5, 2.0),
        "p": rng.uniform(0.5, 2.0),
        "q": rng.uniform(0.5, 2.0),
        "f": rng.uniform(-1.0, 1.0, 1 if name.startswith("poisson") else dim),
        "t": rng.uniform(-1.0, 1.0, dim),
        "springs": rng.uniform(0.5, 2.0, dim),
        "spin": rng.uniform(0.5, 2.0) if dim == 2 else rng.uniform(-1.0, 1.0, 3),
        "centre": rng.uniform(-1.0, 1.0, dim),
    }
    values["g"] = values["f"]  # no draw of its own: those of all other forms stay as they are
    return values


def material(name: str, hypothesis: str, values: Mapping[str, float]) -> ref.Material:
    """Material of the hand-written solver for a form.

    Args:
        name: form of the catalogue.
        hypothesis: hypothesis of the material.
        values: constants by name: E [F/L^2], nu [1] and density [M/L^3].

    Returns:
        Material with the law of the form.
    """
    law = name.split(".")[0] if name in registry.LAW_FORMS else "linear_elastic"
    return ref.Material(values["E"], values["nu"], values["density"], hypothesis, law)


def evaluate(
    name: str,
    element: Element,
    X: FloatArray,
    values: Mapping[str, Any],
    fields: Mapping[str, FloatArray],
    rule: TheirRule,
    facet: list[int] | None = None,
) -> FloatArray:
    """Element tensor of the hand-written solver, in its own order.

    Args:
        name: form of the catalogue.
        element: cell, degree, geometry_degree and hypothesis.
        X: geometry nodes in its order, shape (num_geometry_nodes, gdim) [L].
        values: constants by name: numbers or vectors.
        fields: "u", "velocity" and "acceleration" in its order, shape (num_dofs).
        rule: its integration rule.
        facet: local vertices of a facet in its numbers; None for forms without facet integrals.

    Returns:
        Element tensor, shape (1), (num_dofs) or (num_dofs, num_dofs).

    Raises:
        ValueError: the hand-written solver has no such form.
    """
    cell, degree, geometry_degree, hypothesis = element
    d: dict[str, Any] = {"degree": degree, "geometry_degree": geometry_degree, "rule": rule}
    m = material(name, hypothesis, values)
    v = values
    # Forms without displacement do not read u; forms without facet integrals do not read facet_nodes.
    u, facet_nodes = cast(FloatArray, fields.get("u")), cast(list[int], facet)
    if name in registry.LAW_FORMS:
        kind = name.split(".")[1]
        if kind == "energy":
            return np.array([ref.element_energy(cell, X, m, u, **d)])
        if kind == "force":
            return ref.element_internal_force(cell, X, m, u, **d)
        linear = m.law == "linear_elastic"
        return ref.element_stiffness(cell, X, m, **d) if linear else ref.element_tangent(cell, X, m, u, **d)
    if name == "mass":
        return ref.element_mass(cell, X, m, **d)
    if name == "mass_action":
        return ref.element_mass(cell, X, m, **d) @ u
    if name == "row_sum":
        return ref.element_lumped_mass(cell, X, m, "row_sum", **d)
    if name == "nodal_mass":
        return ref.element_lumped_mass(cell, X, m, "nodal", **d)
    if name == "body_force":
        return ref.element_body_force(cell, X, v["f"], hypothesis, **d)
    if name == "gravity":
        return ref.element_body_force(cell, X, v["density"] * np.asarray(v["g"]), hypothesis, **d)
    if name == "traction":
        return ref.element_traction(cell, X, facet_nodes, v["t"], hypothesis, **d)
    if name == "follower_pressure":
        return ref.element_follower_pressure(cell, X, u, facet_nodes, v["p"], hypothesis, **d)[0]
    if name == "follower_pressure_tangent":
        return ref.element_follower_pressure(cell, X, u, facet_nodes, v["p"], hypothesis, **d)[1]
    if name in FOUNDATION:
        springs = v["k"] if name.startswith("normal") else v["springs"]
        K = ref.element_foundation(cell, X, facet_nodes, springs, hypothesis, **d)
        return K if name.endswith("tangent") else K @ u
    if name == "rayleigh":
        if rule is None:
            return ref.element_damping(cell, X, m, v["alpha"], v["beta"], **d)
        stiffness = quadrature.stiffness_degree(cell, degree, geometry_degree, hypothesis)
        K = ref.element_stiffness(cell, X, m, degree, geometry_degree, f"gauss_jacobi:{stiffness}")
        return v["alpha"] * ref.element_mass(cell, X, m, **d) + v["beta"] * K
    if name == "gyroscopic":
        return ref.element_gyroscopic(cell, X, m, v["spin"], v["centre"], **d)
    if name == "ale_inertia":
        return ref.element_ale_inertia(cell, X, m, v["spin"], v["centre"], **d)
    if name == "centrifugal_load":
        return ref.element_ale_load(cell, X, m, v["spin"], v["centre"], **d)
    if name == "momentum_balance":
        spin = (v["spin"], v["centre"])
        terms = ref.element_stiffness(cell, X, m, **d) @ u + ref.element_mass(cell, X, m, **d) @ fields["acceleration"]
        terms = terms + ref.element_gyroscopic(cell, X, m, *spin, **d) @ fields["velocity"]
        terms = (
            terms - ref.element_ale_inertia(cell, X, m, *spin, **d) @ u - ref.element_ale_load(cell, X, m, *spin, **d)
        )
        return terms - ref.element_body_force(cell, X, v["density"] * np.asarray(v["f"]), hypothesis, **d)
    if name == "poisson":
        return ref.element_poisson(cell, X, v["k"], **d)
    if name == "poisson_residual":
        if facet is not None:
            return -ref.element_flux_load(cell, X, facet_nodes, v["q"], **d)
        return ref.element_poisson(cell, X, v["k"], **d) @ u - ref.element_scalar_load(cell, X, float(v["f"][0]), **d)
    raise ValueError(f"the hand-written solver has nothing named {name}")
