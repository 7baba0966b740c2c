# SPDX-License-Identifier: MIT
"""A user's own UFL file against a named operator of the hand-written solver."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import ufl
from dolfinx.mesh import Mesh
from mpi4py import MPI

from dolfinx_impact import compat
from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.assembly.jit import Compiled, compile_form
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.compiler import frontend
from dolfinx_impact.forms.compiler.integrands import integrands
from dolfinx_impact.forms.materials import HYPOTHESES
from dolfinx_impact.own_forms.user_file import run_file
from . import catalogue, element, matched_body, nodes
from .catalogue import Case
from .element import Names
from .nodes import TheirRule
from .reasons.explain import Explanation
from .report import Report

# Names that a user may give for an operator -> names by rank of the form.
ALIASES: dict[str, tuple[str | None, str | None, str | None]] = {
    "elasticity": ("linear_elastic.energy", "linear_elastic.force", "linear_elastic.tangent"),
    "linear_elastic": ("linear_elastic.energy", "linear_elastic.force", "linear_elastic.tangent"),
    "st_venant_kirchhoff": ("st_venant_kirchhoff.energy", "st_venant_kirchhoff.force", "st_venant_kirchhoff.tangent"),
    "neo_hookean": ("neo_hookean.energy", "neo_hookean.force", "neo_hookean.tangent"),
    "mass": (None, "mass_action", "mass"),
    "poisson": (None, "poisson_residual", "poisson"),
    "follower_pressure": (None, "follower_pressure", "follower_pressure_tangent"),
}
# Names of constants or numbers in the user's file -> names of the catalogue.
CONSTANTS = {
    "E": "E", "young": "E", "nu": "nu", "poisson_ratio": "nu", "density": "density", "rho": "density",
    "lmbda": "lambda", "lam": "lambda", "lambda_": "lambda", "mu": "mu", "alpha": "alpha", "beta": "beta", "k": "k",
    "kappa": "k", "p": "p", "pressure": "p", "q": "q", "f": "f", "b": "f", "t": "t", "T": "t", "spin": "spin",
    "Omega": "spin", "centre": "centre", "springs": "springs", "stiffness": "k", "traction": "t", "body_force": "f",
    "g": "g", "gravity": "g",
}  # fmt: skip


class Settings(TypedDict):
    """Keyword arguments of `element.difference` for a form of the user."""

    kernels: Compiled
    names: Names
    values: Mapping[str, Any]
    theirs: dict[str, TheirRule] | None


def operators() -> list[str]:
    """Names that a user may give for an operator of the hand-written solver."""
    return sorted(set(ALIASES) | set(registry.NAMES))


def is_operator(name: str) -> bool:
    """Whether the hand-written solver has an operator of this name.

    Args:
        name: a name that a user may give.
    """
    return name in ALIASES or name in registry.NAMES


def operator_name(name: str, rank: int) -> str:
    """Form of the catalogue for a name and the rank of the user's form.

    Args:
        name: name of the operator, a key of ALIASES or a name of the catalogue.
        rank: rank of the user's form: 0, 1 or 2.

    Returns:
        Name of the catalogue.

    Raises:
        ValueError: unknown name, or no form of that rank; the message lists the names.
    """
    if name in registry.NAMES and name not in ALIASES:
        if rank != _rank(name):
            raise ValueError(f"operator {name!r} has rank {_rank(name)}, the form has rank {rank}")
        return name
    if name not in ALIASES:
        raise ValueError(f"the hand-written solver has no operator {name!r}; it has {', '.join(operators())}")
    found = ALIASES[name][rank]
    if found is None:
        raise ValueError(f"operator {name!r} has no form of rank {rank}")
    return found


def _rank(name: str) -> int:
    """Rank of a form of the catalogue."""
    if name.endswith(".energy"):
        return 0
    return 2 if name.endswith("tangent") or name in ("rayleigh", "gyroscopic", "ale_inertia") else 1


def load(path: Path | str) -> tuple[dict[str, Any], dict[str, ufl.Form]]:
    """Run a user's UFL file.

    Args:
        path: the file.

    Returns:
        Namespace of the file, and its forms by name.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file raises (the message has the line), or defines no form.
    """
    namespace = run_file(path)
    forms = {n: o for n, o in namespace.items() if isinstance(o, ufl.Form)}
    if not forms:
        raise ValueError(f"{path} defines no UFL form: assign one to a variable, for example a = inner(...) * dx")
    return namespace, forms


def _parameters(
    namespace: Mapping[str, Any], form: ufl.Form, rng: np.random.Generator, name: str, dim: int
) -> tuple[dict[ufl.Constant | ufl.Coefficient, str], dict[str, Any]]:
    """Names by object and values by name of the form's constants; numbers of the file replace random values."""
    values: dict[str, Any] = catalogue.parameters(rng, name, dim)
    variables = {id(o): n for n, o in namespace.items() if isinstance(o, ufl.Constant)}
    for variable, catalogue_name in CONSTANTS.items():
        number = namespace.get(variable)
        if isinstance(number, (int, float)) and not isinstance(number, bool):
            values[catalogue_name] = float(number)
    if (
        isinstance(namespace.get("E"), (int, float)) is False
        and isinstance(values.get("mu"), float)
        and "lambda" in values
    ):
        lmbda, mu = values["lambda"], values["mu"]
        values["E"], values["nu"] = mu * (3 * lmbda + 2 * mu) / (lmbda + mu), lmbda / (2 * (lmbda + mu))
    E, nu = values["E"], values["nu"]
    values.setdefault("lambda", E * nu / ((1 + nu) * (1 - 2 * nu)))
    values.setdefault("mu", E / (2 * (1 + nu)))
    names = {}
    for constant in form.constants():
        own_name = variables.get(id(constant))
        if own_name not in CONSTANTS:
            raise ValueError(f"the constant {own_name!r} means nothing here: name it one of {', '.join(CONSTANTS)}")
        names[constant] = CONSTANTS[own_name]
    if name in ("foundation", "foundation_tangent") and "k" in names.values():
        values["springs"] = np.full(dim, values["k"])  # one stiffness along all coordinates
    coefficients = {id(o): n for n, o in namespace.items() if isinstance(o, ufl.Coefficient)}
    fields = [c for c in form.coefficients() if not _constant_in_cells(c)]
    for c in form.coefficients():
        given = getattr(c, "name", "f")
        own = coefficients.get(id(c), given if given != "f" and len(fields) > 1 else "u")
        if _constant_in_cells(c):
            own = coefficients.get(id(c), given if given != "f" else "without a name")
            if own not in CONSTANTS:
                raise ValueError(
                    f"the coefficient {own!r}, constant in each cell, means nothing here: say what it is, from Python "
                    f"by constants={{'E': function}}, in a file by its variable: one of {', '.join(CONSTANTS)}"
                )
            names[c] = CONSTANTS[own]
            continue
        names[c] = own if own in ("u", "velocity", "acceleration") else "u" if len(fields) == 1 else own
        if names[c] not in ("u", "velocity", "acceleration"):
            raise ValueError(f"the coefficient {own!r} means nothing here: displacements are called u")
    _check_numbers(namespace, form, name)
    return names, values


def _constant_in_cells(c: ufl.Coefficient) -> bool:
    """Whether a coefficient has one value in each cell, as a modulus of several materials has."""
    element = c.ufl_function_space().ufl_element()
    return bool(element.family_name == "P" and element.embedded_superdegree == 0 and c.ufl_shape == ())


def _check_numbers(namespace: Mapping[str, Any], form: ufl.Form, name: str) -> None:
    """Refuse a form without constants of an operator that has some: random values would not be those of the form."""
    known = [n for n in namespace if n in CONSTANTS]
    if name.split(".")[0] in registry.LAW_FORMS or "." in name:
        wanted = "constants={'E': 207e9, 'nu': 0.3}"
    elif name == "mass":
        wanted = "constants={'density': 7800.0}"
    else:
        return
    if not form.constants() and not known and not any(_constant_in_cells(c) for c in form.coefficients()):
        raise ValueError(
            f"the form for {name} has numbers in the place of constants: say which, from Python by {wanted}, in a file "
            "by variables of these names"
        )


def parts_of(form: ufl.Form, operator: str) -> list[tuple[ufl.Form, str]]:
    """The integrals of a form that belong to each of its operators, by the kind of entity.

    Args:
        form: form of a user.
        operator: name of an operator, or of two, one over dx and one over ds, with a plus between them.

    Returns:
        Integrals and name for each operator.

    Raises:
        ValueError: an operator has no integrals in the form, or integrals have no operator.
    """
    if "+" not in operator:  # integrals that it does not have are a row of their own, see _of_one_kind
        return [(form, operator)]
    rank, kinds = len(form.arguments()), {"cell": "dx", "exterior_facet": "ds"}
    found: dict[str, list[Any]] = {}
    for integral in form.integrals():
        found.setdefault(integral.integral_type(), []).append(integral)
    out = []
    for name in (part.strip() for part in operator.split("+")):
        counterpart = operator_name(name, rank)
        kind = "exterior_facet" if counterpart in catalogue.FACET else "cell"
        if kind not in found:
            raise ValueError(
                f"operator {name!r} is integrated over {kinds[kind]}, the form has no such integrals: name one "
                f"operator over dx, one over ds, or both with a plus between them, as 'elasticity + normal_foundation'"
            )
        out.append((ufl.Form(found.pop(kind)), name))
    if found:
        left = ", ".join(kinds.get(kind, kind) for kind in found)
        raise ValueError(
            f"the form has integrals over {left}, which operator {operator!r} has not: name an operator for each, "
            f"operator='elasticity + normal_foundation'; over ds there are {', '.join(catalogue.FACET)}"
        )
    return out


def check_body(domain: ufl.Mesh) -> None:
    """Refuse meshes of bars and surfaces.

    Args:
        domain: mesh of a form.

    Raises:
        ValueError: its cells are not those of a body in 2D or 3D.
    """
    tdim, gdim = compat.topological_dimension(domain), compat.geometric_dimension(domain)
    if tdim < 2 or tdim != gdim:
        raise ValueError(
            f"the form is on cells of dimension {tdim} in {gdim} dimension{'s' if gdim > 1 else ''}: the hand-written "
            "solver and the checks of forms know bodies in 2D and 3D only. Compare the kernels of bars, trusses and "
            "shells with DOLFINx's: di.InternalForce(form).apply() with fem.assemble_vector (docs: your own form)"
        )


def _case(form: ufl.Form, name: str, hypothesis: str) -> Case:
    """Name, cell, degree, geometry_degree and hypothesis of a user's form."""
    domain = form.ufl_domain()
    coordinate = domain.ufl_coordinate_element()
    functions = list(form.arguments()) + [c for c in form.coefficients() if not _constant_in_cells(c)]
    if not functions:
        raise ValueError(
            f"the form for {name} holds neither u nor a test function: there is nothing to compare it with"
        )
    space = functions[0].ufl_function_space().ufl_element()
    cell = compat.cell_name(domain)
    check_body(domain)
    degree, geometry_degree = int(space.embedded_superdegree), int(coordinate.embedded_superdegree)
    sub = space.sub_elements[0] if space.block_size > 1 else space
    if sub.family_name != "P" or sub.discontinuous:
        raise ValueError(f"the form uses {space}: the hand-written solver has Lagrange elements of degree 1 and 2")
    degree = int(sub.basix_element.degree)
    geometry_degree = int(coordinate.sub_elements[0].basix_element.degree)
    registry.check(name, cell, degree, geometry_degree, hypothesis)
    return name, cell, degree, geometry_degree, hypothesis


def _rule(integral: Any, cell: str) -> TheirRule:
    """The rule of the user's own form as points and weights of the other side's reference cell."""
    rules = integrands(integral.ir)
    if len(rules) != 1:
        return None
    rule = rules[0][0]
    points, weights = np.asarray(rule.points), np.asarray(rule.weights)
    tensor = cell in nodes.TENSOR
    dim = points.shape[1]
    if tensor or (integral.integral_type != "cell" and cell in ("quadrilateral", "hexahedron", "triangle")):
        return 2 * points - 1, weights * 2**dim
    return points, weights


def check(
    report: Report, path: Path | str, operator: str | None = None, seed: int = 2026, only: str | None = None
) -> None:
    """Add the rows of every form of a user's file, of levels "element" and "operator".

    Args:
        report: report to add to.
        path: the user's file.
        operator: name of the operator; None takes the file's name.
        seed: seed of the random numbers.
        only: name of the one form to check; None: all.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file does not run or defines no form (of this name), or the operator does not exist for a form.
    """
    namespace, forms = load(path)
    if only is not None:
        if only not in forms:
            raise ValueError(f"{path} defines no UFL form called {only!r}; its forms are {', '.join(forms)}")
        forms = {only: forms[only]}
    for variable, form in forms.items():
        where = f"{variable} of {Path(path).name}"
        check_form(report, form, operator or Path(path).stem, namespace, variable, where, seed)


def check_form(
    report: Report,
    form: ufl.Form,
    operator: str,
    namespace: Mapping[str, Any],
    variable: str = "form",
    where: str = "form",
    seed: int = 2026,
) -> None:
    """Add the rows of one UFL form, of levels "element" and "operator".

    Args:
        report: report to add to.
        form: form on a symbolic mesh or on a mesh of DOLFINx.
        operator: name of the operator.
        namespace: constants and coefficients of the form and numbers by name, and "hypothesis".
        variable: name of the form in errors.
        where: name of the form in rows.
        seed: seed of the random numbers.

    Raises:
        ValueError: the operator does not exist for this form, or the form is not one of the catalogue's elements.
    """
    parts = parts_of(form, operator)
    if len(parts) > 1:
        for part, own_name in parts:
            check_form(report, part, own_name, namespace, variable, where, seed)
        return
    ((_, operator),) = parts
    rank = len(form.arguments())
    name = operator_name(operator, rank)
    dim = registry.CELLS.get(compat.cell_name(form.ufl_domain()), 0)
    own = namespace.get("hypothesis")
    hypothesis = own or ("3d" if dim == 3 else "plane_strain")
    case = _case(form, name, hypothesis)
    names, values = _parameters(namespace, form, np.random.default_rng(seed), name, dim)
    form = _of_one_kind(report, form, case, where)
    if form is None:
        return
    compiled = compile_form(form, names, MPI.COMM_SELF)
    integrals = frontend.form_integrals(form, variable, names)
    theirs = {i.integral_type: _rule(i, case[1]) for i in integrals}
    settings: Settings = {"kernels": compiled, "names": names, "values": values, "theirs": theirs}
    worst, note = element.difference(case, **settings)
    cause = ""
    if not worst <= element.TOLERANCE:
        cause = _other_hypothesis(case, settings, own) if dim == 2 else ""
        if not cause:
            other_values = _parameters(namespace, form, np.random.default_rng(seed + 1), name, dim)[1]
            cause = Explanation(case, compiled, names, (values, other_values), integrals, theirs).text()
        note = ". ".join(text for text in (f"{cause[:1].upper()}{cause[1:]}", note) if text)
    report.add("element", name, *case[1:], worst, element.TOLERANCE, element.REASON, where, note, cause)
    if worst <= element.TOLERANCE:
        _check_rule(report, case, settings, variable)
    if rank > 0 and all(k.integral_type == "cell" for k in compiled.kernels) and case[0] in _ASSEMBLED:
        difference, note = _assembled(case, compiled, names, values, theirs["cell"])
        report.add(
            "operator", name, *case[1:], difference, element.TOLERANCE, "round-off", f"{variable} assembled", note
        )


def _of_one_kind(report: Report, form: ufl.Form, case: Case, where: str) -> ufl.Form | None:
    """The integrals over entities that the operator has; a row for those over others.

    Args:
        report: report to add to.
        form: form of the user.
        case: operator with its element.
        where: name of the form in rows.

    Returns:
        The form without integrals that the operator does not have; None if nothing is left.
    """
    expected = {i.integral_type() for i in registry.build(*case).form.integrals()}
    others = [i for i in form.integrals() if i.integral_type() not in expected]
    if not others:
        return form
    words = {"cell": "over cells (dx)", "exterior_facet": "over facets of the boundary (ds)"}
    words["interior_facet"] = "over facets between cells (dS)"
    found, wanted = (
        " and ".join(sorted(words.get(t, t) for t in types))
        for types in ({i.integral_type() for i in others}, expected)
    )
    left = [i for i in form.integrals() if i.integral_type() in expected]
    cause = f"wrong measure: the form has integrals {found}, the operator has integrals {wanted} alone"
    if left:
        cause += "; loads are operators of their own (traction, body_force): compare them apart, or name both"
        cause += ", as 'elasticity + normal_foundation'"
    note = f"{cause[:1].upper()}{cause[1:]}"
    report.add("element", case[0], *case[1:], np.inf, element.TOLERANCE, element.REASON, where, note, cause)
    return ufl.Form(left) if left else None


def _other_hypothesis(case: Case, settings: Settings, declared: str | None) -> str:
    """Which other hypothesis the form agrees with, and what to do; an empty text if there is none."""
    for other in HYPOTHESES[1:]:
        if other != case[4] and element.difference((*case[:4], other), 10, **settings)[0] < element.TOLERANCE:
            what = "write" if declared is None else f"the file says {declared!r}; write"
            return f"It agrees with {other}: {what} hypothesis = {other!r} into the file"
    return ""


def _check_rule(report: Report, case: Case, settings: Settings, variable: str) -> None:
    """Add the row of the form's rule on affine cells, where the other side's default rule is exact."""
    linear = case[0].split(".")[0] not in catalogue.FINITE and case[4] != "axisymmetric"
    if not linear or case[0] in catalogue.FACET:
        return  # no rule is exact: both sides can only be compared with the user's rule
    own: Settings = {**settings, "theirs": None}
    difference, where = element.difference(case, 20, distortion=0.0, **own)
    note = f"with the form's own rule both sides agree, but it is too coarse for this element. {where}"
    cause = "" if difference <= element.TOLERANCE else "the quadrature rule is too coarse"
    name = f"{variable} on affine cells, quadrature rule"
    report.add("element", case[0], *case[1:], difference, element.TOLERANCE, element.REASON, name, note, cause)


_ASSEMBLED = tuple(n for n in registry.LAW_FORMS if not n.endswith("energy")) + ("mass",)


def _assembled(
    case: Case, compiled: Compiled, names: Names, values: Mapping[str, Any], theirs: TheirRule
) -> tuple[float, str]:
    """Largest relative difference of the assembled operator on a block, and a text with the nodes of the entry."""
    name, cell, degree, geometry_degree, hypothesis = case
    domain = distorted_block.block(cell, 3, geometry_degree)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += 0.5
    law = name.split(".")[0] if name in registry.LAW_FORMS else "linear_elastic"

    class _Material:
        """Constants of the user's form."""

        E: float = values["E"]
        nu: float = values["nu"]
        density: float | None = values["density"]

        def hypothesis_on(self, mesh: Mesh) -> str:
            return hypothesis

    body = matched_body.Body(domain, degree, _Material(), law, theirs)
    kernel, bs = compiled.kernels[0], body.gdim
    x, dofmap = domain.geometry.x, compat.geometry_dofmap(domain)
    size = body.model.num_dofs
    u = 0.03 * np.sin(3 * body.V.tabulate_dof_coordinates()[:, :bs]).ravel()
    out = np.zeros((size, size) if kernel.rank == 2 else size)
    for c in range(len(dofmap)):
        dofs = (bs * body.V.dofmap.cell_dofs(c)[:, None] + np.arange(bs)).ravel()
        w, constants = element.pack(kernel, compiled, names, values, {"u": u[dofs]})
        A = np.zeros(kernel.shape[0] * kernel.shape[1])
        kernel.tabulate(A, w, constants, x[dofmap[c]].ravel())
        if kernel.rank == 2:
            out[np.ix_(dofs, dofs)] += A.reshape(kernel.shape)
        else:
            out[dofs] += A
    their_u = body.to_theirs(u)
    if name == "mass":
        expected = body.matrix_to_ours(body.model.mass()).toarray()
    elif kernel.rank == 2:
        tangent = body.model.stiffness() if law == "linear_elastic" else body.model.tangent(their_u)
        expected = body.matrix_to_ours(tangent).toarray()
    else:
        expected = body.to_ours(body.model.internal_force(their_u))
    error = np.abs(out - expected) / np.abs(expected).max()
    k = np.unravel_index(np.argmax(error), error.shape)
    positions = body.V.tabulate_dof_coordinates()[:, :bs]
    where = " against ".join(f"node at {np.round(positions[i // bs], 4).tolist()} component {i % bs}" for i in k)
    return error.max(), f"{where}: UFL {out[k]:.15g}, hand-written {expected[k]:.15g}"
