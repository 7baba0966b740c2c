# SPDX-License-Identifier: MIT
"""Bodies of static problems: residual and tangent by our kernels against FFCx's C, both assembled into PETSc's objects.

Both sides are one body each, as problems have them: MaterialBody with our kernels, FormBody with the same forms as a
user's own, which DOLFINx assembles with FFCx's C, compiled with DOLFINx's default flags.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import ufl

from dolfinx_impact import materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.statics.form_body import FormBody
from dolfinx_impact.statics.material_body import MaterialBody
from .rows import Job, Row, row
from .setup import Case, MaterialClass, Setup, best_time

# Matrices that no cache holds: 45 MB and more.
CASES: tuple[Case, ...] = (
    ("hexahedron", 1, 26),
    ("hexahedron", 2, 9),
    ("tetrahedron", 1, 20),
    ("tetrahedron", 2, 14),
    ("quadrilateral", 1, 200),
    ("quadrilateral", 2, 120),
)
LAWS = (materials.LinearElastic, materials.NeoHookean)
# Two sums of some hundred terms in different orders.
TOLERANCE = 1e-12


def body_rows(cases: Sequence[Case] = CASES, law: MaterialClass = materials.LinearElastic) -> list[Row]:
    """Measure residual and tangent of bodies of one material.

    Args:
        cases: cell, degree and cells per side.
        law: class of the material.

    Returns:
        Rows.

    Raises:
        RuntimeError: the residuals or matrices of the two sides differ.
    """
    rows: list[Row] = []
    for case in cases:
        cell, degree, _ = case
        setup = Setup(*case, law)
        u, v, du = setup.u, ufl.TestFunction(setup.V), ufl.TrialFunction(setup.V)
        material = law(1e3, 0.3, 1.0, "3d" if setup.mesh.topology.dim == 3 else "plane_strain")
        ours = MaterialBody(u, material)
        theirs = FormBody(u, setup.form, operators.tangent_form(u, du, v, material))
        name, label = law.law_class.name, f"{cell} P{degree}"
        forces = [body.in_cpp().residual().array.copy() for body in (ours, theirs)]
        matrices = [body.tangent.assemble() for body in (ours, theirs)]
        size = matrices[1].norm()
        matrices[1].axpy(-1.0, matrices[0])
        difference = max(np.abs(forces[0] - forces[1]).max() / np.abs(forces[1]).max(), matrices[1].norm() / size)
        if not difference < TOLERANCE:
            raise RuntimeError(f"{name}, {label}: the two sides differ by {difference:.1e}: no timing counts")
        for what, times in (
            ("residual", [best_time(body.in_cpp().residual)[1] for body in (ours, theirs)]),
            ("tangent", [best_time(body.tangent.assemble)[1] for body in (ours, theirs)]),
        ):
            rates = [setup.num_cells / seconds * 1e-3 for seconds in times]
            rows.append(row(f"{name} {what} of a body / FFCx", label, 1, rates[0], "thousand cells/s", rates[1]))
    return rows


def jobs() -> list[Job]:
    """Measurements of static bodies.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [
        (f"{law.law_class.name} body, {case[0]} P{case[1]}", partial(body_rows, (case,), law))
        for law in LAWS
        for case in CASES
    ]
