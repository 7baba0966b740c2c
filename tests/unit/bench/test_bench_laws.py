# SPDX-License-Identifier: MIT
"""Laws of the benchmark: the forces of FFCx's kernels, at a cost near that of the neo-Hookean law."""

import numpy as np
import pytest
import ufl

from dolfinx_impact import materials
from dolfinx_impact.assembly import operators
from impact_studies.bench import laws
from impact_studies.bench.setup import Setup

CASE = ("hexahedron", 1, 3)


@pytest.mark.long_rows(where=lambda energy: energy not in (laws.mooney_rivlin, laws.holzapfel))
@pytest.mark.parametrize("energy", laws.LAWS, ids=lambda energy: energy.__name__)
def test_rows_of_a_law(energy):
    """The row itself refuses forces that are not those of FFCx. Operations do not depend on who else uses the machine:
    of those that are counted, without what is inside functions, no law of invariants needs half as many again as
    neo-Hooke's, and Ogden's less than three times as many."""
    (row,) = laws.law_rows((energy,), (CASE,), rounds=1)
    assert row["name"] == f"{energy.__name__} force / neo_hookean" and row["ratio"] > 0.0
    setup = Setup(*CASE, materials.NeoHookean)
    (degree,) = {i.metadata()["quadrature_degree"] for i in setup.form.integrals()}
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    F = ufl.Identity(3) + ufl.grad(setup.u)
    own = operators.InternalForce(ufl.derivative(energy(F) * dx, setup.u, ufl.TestFunction(setup.V)))
    assert own.flops < (3.0 if energy is laws.ogden else 1.5) * operators.InternalForce(setup.form).flops


def test_equal_principal_stretches():
    """Cells at rest, with three equal stretches, and stretched ones, with two, where the angle of the roots' formula
    has no derivative and Ogden's law keeps a margin: forces are numbers, and those of FFCx's kernel."""
    setup = Setup(*CASE, materials.NeoHookean)
    setup.u.interpolate(lambda x: 0.3 * np.array([np.maximum(x[0] - 0.3, 0.0), 0 * x[1], 0 * x[2]]))
    F = ufl.Identity(3) + ufl.grad(setup.u)
    dx = ufl.dx(metadata={"quadrature_degree": 2})
    form = ufl.derivative(laws.ogden(F) * dx, setup.u, ufl.TestFunction(setup.V))
    laws._check(setup, form, operators.InternalForce(form), "ogden")


def test_a_wrong_force_makes_no_row(monkeypatch):
    monkeypatch.setattr(laws, "TOLERANCE", 0.0)
    with pytest.raises(RuntimeError, match="gent, hexahedron P1: the force differs.*no timing counts"):
        laws.law_rows((laws.gent,), (CASE,), rounds=1)
