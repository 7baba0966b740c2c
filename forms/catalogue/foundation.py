# SPDX-License-Identifier: MIT
"""Winkler's foundation, along the normal only ("normal_foundation") and along the coordinates ("foundation")."""

from typing import Any

from .. import foundation as winkler
from .. import quadrature
from ..registration import SCALAR, VECTOR, Setting, registered


@registered("normal_foundation", quadrature=quadrature.foundation_degree, constants={"k": SCALAR}, coefficients=("u",))
def normal_foundation(on: Setting, k: Any, u: Any) -> Any:
    return winkler.foundation(k, u, on.test, on.hypothesis, on.ds)


@registered("normal_foundation_tangent", quadrature=quadrature.foundation_degree, constants={"k": SCALAR})
def normal_foundation_tangent(on: Setting, k: Any) -> Any:
    return winkler.foundation(k, on.trial, on.test, on.hypothesis, on.ds)


@registered("foundation", quadrature=quadrature.foundation_degree, constants={"springs": VECTOR}, coefficients=("u",))
def foundation(on: Setting, springs: Any, u: Any) -> Any:
    return winkler.foundation(springs, u, on.test, on.hypothesis, on.ds)


@registered("foundation_tangent", quadrature=quadrature.foundation_degree, constants={"springs": VECTOR})
def foundation_tangent(on: Setting, springs: Any) -> Any:
    return winkler.foundation(springs, on.trial, on.test, on.hypothesis, on.ds)
