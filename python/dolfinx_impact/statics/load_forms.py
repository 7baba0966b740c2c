# SPDX-License-Identifier: MIT
"""Virtual work of the loads of a static or implicit problem, by what assembles it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import ufl
from dolfinx import fem

from ..added_mass import AddedMass
from ..assembly.residual_bodies import ResidualBodies
from ..foundation import Foundation
from ..loads import Load
from ..materials import Material


@dataclass
class LoadForms:
    """Virtual work of loads: the package has kernels of constant ones, FFCx compiles the others.

    Attributes:
        dead: external virtual work of each load with constants that does not follow the bodies.
        springs: internal virtual work of each foundation with constant stiffness.
        spring_tangents: its derivative, likewise.
        other: external virtual work of the other loads; None: there are none.
        has_springs: whether springs to the ground may hold the bodies.
    """

    dead: list[ufl.Form] = field(default_factory=list)
    springs: list[ufl.Form] = field(default_factory=list)
    spring_tangents: list[ufl.Form] = field(default_factory=list)
    other: ufl.Form | None = None
    has_springs: bool = False

    def work(self) -> ufl.Form | None:
        """External virtual work of all loads; None: there are none."""
        forms = [*self.dead, *(-form for form in self.springs)]
        forms += [] if self.other is None else [self.other]
        return sum(forms[1:], forms[0]) if forms else None


def load_forms(u: fem.Function, bodies: Material | ResidualBodies | None, loads: Sequence[Load]) -> LoadForms:
    """Virtual work of loads.

    Args:
        u: displacement function [L].
        bodies: material of the bodies, or those of a residual; None without loads.
        loads: loads; masses are none, they count with the inertia. Others than those of the package have a `form`.
    """
    V = u.function_space
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    out = LoadForms()
    for load in loads:
        if isinstance(load, AddedMass):
            continue
        out.has_springs = out.has_springs or isinstance(load, Foundation)
        if isinstance(load, Foundation) and not load.varies():
            assert bodies is not None  # there are loads
            hypothesis = bodies.hypothesis_on(V.mesh)
            out.springs.append(load.springs(u, v, hypothesis))
            out.spring_tangents.append(load.springs(du, v, hypothesis))
            continue
        form = load.form(u, v, bodies)
        if isinstance(load, Load) and not load.varies() and u not in form.coefficients():
            out.dead.append(form)
        else:
            out.other = form if out.other is None else out.other + form
    return out
