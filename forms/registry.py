# SPDX-License-Identifier: MIT
"""The forms by name, and the one table of what is compiled ahead of time.

`build` gives any form of the catalogue for any cell, degree, geometry degree and hypothesis, with the names of its
coefficients and constants; `registered` adds a form. NAMES are the forms of the package's own catalogue that `verify`
compares with the hand-written solver element by element: those with internal variables or a stress at their points, and
those that only resist a motion, are compared in runs, those with one point by rows of their own. TABLE lists the rows
that are compiled with the package: what the demos and C++ users need. Everything else takes the run-time route.
"""

from dataclasses import dataclass

from . import catalogue, quadrature  # noqa: F401  (importing the catalogue registers its forms)
from .catalogue import damping, one_point, plasticity
from .catalogue.laws import STRESSES
from .materials import LAWS
from .registration import (
    AXIAL,
    CELLS,
    DEGREES,
    FORMS,
    SCALAR,
    VECTOR,
    Built,
    RegisteredForm,
    Setting,
    build,
    check,
    default_hypothesis,
    registered,
)

__all__ = [
    "AXIAL",
    "CELLS",
    "DEGREES",
    "FORMS",
    "IN_FLOAT",
    "LAW_FORMS",
    "NAMES",
    "SCALAR",
    "TABLE",
    "VECTOR",
    "Built",
    "RegisteredForm",
    "Row",
    "Setting",
    "build",
    "check",
    "default_hypothesis",
    "registered",
]

_APART = (*plasticity.NAMES, *damping.OF_STEPS, *STRESSES, *one_point.NAMES)
NAMES = tuple(name for name in FORMS if name not in _APART)
LAW_FORMS = tuple(name for name in NAMES if name.split(".")[0] in LAWS)


# Where J2Plasticity with its defaults has kernels that come with the package: cell, degree, hypothesis, laws.
PLASTIC = (
    ("hexahedron", 1, "3d", ("small.linear", "small.voce", "finite.linear", "finite.voce")),
    ("quadrilateral", 1, "plane_strain", ("small.linear", "small.voce")),
    ("quadrilateral", 1, "axisymmetric", ("finite.linear", "finite.voce")),
    ("tetrahedron", 2, "3d", ("small.linear", "finite.linear")),
)
# Those with one point.
PLASTIC_REDUCED = ("j2.small.linear", "j2.finite.linear", "j2.finite.voce")


@dataclass(frozen=True)
class Row:
    """A row of the table: one form compiled ahead of time.

    Attributes:
        name: name of the form.
        cell: one of CELLS.
        degree: degree of the space.
        geometry_degree: degree of the geometry.
        hypothesis: one of materials.HYPOTHESES.
    """

    name: str
    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str

    @property
    def symbol(self) -> str:
        """Name of the row's file and prefix of its C symbols."""
        text = f"{self.name}_{self.cell}_{self.degree}_{self.geometry_degree}_{self.hypothesis}"
        return "impact_" + text.replace(".", "_")

    def build(self) -> Built:
        """The row's form."""
        return build(self.name, self.cell, self.degree, self.geometry_degree, self.hypothesis)


def _table() -> tuple[Row, ...]:
    rows: list[Row] = []
    for cell in CELLS:
        main = default_hypothesis(cell)
        for degree in DEGREES:
            names = ["linear_elastic.force", "linear_elastic.tangent", "linear_elastic.energy", "neo_hookean.force"]
            names += ["st_venant_kirchhoff.force", "mass", "row_sum", "body_force", "gravity", "traction"]
            names += ["linear_elastic.stress"]
            if cell not in quadrature.SIMPLICES and degree == 2:
                names.append("nodal_mass")
            if degree == 1:
                names += ["neo_hookean.tangent", "neo_hookean.energy", "neo_hookean.stress"]
                names += ["ale_inertia", "centrifugal_load"]
                names += [
                    f"{law}.{what}" for law in ("linear_elastic", "neo_hookean") for what in ("damping", "viscosity")
                ]
            rows += [Row(name, cell, degree, 1, main) for name in names]
        if CELLS[cell] == 2:
            for hypothesis in ("plane_stress", "axisymmetric"):
                names = [f"linear_elastic.{what}" for what in ("force", "tangent", "energy", "stress")]
                if hypothesis == "axisymmetric":  # in plane stress they are those of plane strain
                    names += ["body_force", "gravity", "traction", "mass", "row_sum"]
                rows += [Row(name, cell, 1, 1, hypothesis) for name in names]
    rows += [Row(f"linear_elastic.reduced.{kind}", "hexahedron", 1, 1, "3d") for kind in one_point.KINDS]
    rows += [Row(f"{law}.reduced.force", "hexahedron", 1, 1, "3d") for law in ("neo_hookean", *PLASTIC_REDUCED)]
    rows.append(Row(one_point.STIFFNESS, "hexahedron", 1, 1, "3d"))
    for cell, degree, hypothesis, laws in PLASTIC:
        names = [f"j2.{law}.{kind}" for law in laws for kind in ("force", "tangent")]
        if any(law.startswith("finite") for law in laws):
            names.append(plasticity.STIFFNESS)
        rows += [Row(name, cell, degree, 1, hypothesis) for name in names]
    return tuple(rows)


TABLE = _table()
# Rows whose kernels exist in single precision, too.
IN_FLOAT = tuple(
    row
    for row in TABLE
    if row.name
    in [f"{law}.{force}" for law in ("linear_elastic", "neo_hookean") for force in ("force", "reduced.force")]
    and row.hypothesis == "3d"
    and row.geometry_degree == 1
)
