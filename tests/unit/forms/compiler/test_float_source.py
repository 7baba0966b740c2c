# SPDX-License-Identifier: MIT
"""Kernels in float: what depends on constants alone is computed in double, and rounded once."""

import re

from dolfinx_impact.forms import registry
from dolfinx_impact.forms.compiler import float_source, frontend
from dolfinx_impact.forms.compiler.float_source import FloatFormatter


def test_numbers_are_of_single_precision_and_constants_of_double():
    built = registry.build("linear_elastic.force", "hexahedron", 1, 1, "3d")
    (integral,) = frontend.form_integrals(built.form, "linear_elastic.force", built.names, "3d")
    lines = float_source.source(integral, "impact_row").splitlines()
    exact = [line for line in lines if "const double exact_" in line]
    rounded = [line for line in lines if "= float(exact_" in line]
    assert len(exact) == len(rounded) > 0
    assert all("c[" in line or "exact_" in line.split("=")[1] for line in exact)
    assert not any(re.search(r"\d\.\d+(e-?\d+)?f\b", line) for line in exact)
    products = [line for line in lines if " * w[" in line]
    assert products and all(re.search(r"\d\.\d+f \* w\[", line) for line in products)
    assert FloatFormatter()._number(0.5) == "0.5f" and FloatFormatter()._number(2) == "2"
