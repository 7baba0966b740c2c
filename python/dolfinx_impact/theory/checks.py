# SPDX-License-Identifier: MIT
"""Checks of what users give, shared by all closed forms."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..common.types import ArrayLike


def number(
    name: str,
    value: Any,
    unit: str = "[1]",
    low: float | None = 0.0,
    closed: bool = False,
    high: float = math.inf,
    infinite: bool = False,
) -> float:
    """The value as a float.

    Args:
        name: for the message.
        value: what was given.
        unit: for the message.
        low: lower limit; None: without.
        closed: is `low` itself allowed?
        high: upper limit, itself allowed.
        infinite: np.inf is a value, too.

    Raises:
        TypeError: not a number. ValueError: outside the range, or not finite.
    """
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        found = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number {unit}, found {value!r:.60}") from None
    if math.isnan(found) or (math.isinf(found) and not infinite):
        raise ValueError(f"{name} is {found}: give a finite number {unit}")
    if low is not None and not (found > low or (closed and found == low)):
        raise ValueError(
            f"{name} is {found:g} {unit}: it must {'not be below' if closed else 'be greater than'} {low:g}"
        )
    if found > high:
        raise ValueError(f"{name} is {found:g} {unit}: it must not be above {high:g}")
    return found


def radius(name: str, value: Any) -> float:
    """A radius of curvature [L]: any number but zero; negative for a concave body, np.inf for a flat one."""
    found = number(name, value, "[L]", low=None, infinite=True)
    if found == 0.0:
        raise ValueError(f"{name} is zero: a radius is positive (convex), negative (concave) or np.inf (flat) [L]")
    return found


def poisson(name: str, value: Any, incompressible: bool = True) -> float:
    """Poisson's ratio [1]: above -1, at most 0.5 (below it unless `incompressible`)."""
    found = number(name, value, low=-1.0, high=0.5)
    if found == 0.5 and not incompressible:
        raise ValueError(f"{name} is 0.5: an incompressible solid has no finite answer here; it must be below 0.5")
    return found


def choice(name: str, value: Any, allowed: Sequence[str]) -> str:
    """One of the allowed words."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be one of {', '.join(allowed)}, found {value!r:.60}")
    if value not in allowed:
        raise ValueError(f"{name} {value!r:.60} is unknown: use one of {', '.join(allowed)}")
    return value


def exactly_one(**given: Any) -> str:
    """The name of the one argument that is not None.

    Raises:
        ValueError: none or several are given.
    """
    found = [name for name, value in given.items() if value is not None]
    if len(found) != 1:
        raise ValueError(f"give exactly one of {', '.join(given)}, found {', '.join(found) or 'none'}")
    return found[0]


def points(*coordinates: ArrayLike) -> Any:
    """Coordinates [L] as float arrays of one shape; 0-d arrays for scalars.

    Raises:
        TypeError: not numbers. ValueError: shapes that do not fit together.
    """
    try:
        if any(np.asarray(c).dtype.kind not in "iuf" for c in coordinates):
            raise TypeError
        arrays = [np.asarray(c, dtype=float) for c in coordinates]
    except (TypeError, ValueError):
        raise TypeError(f"coordinates must be real numbers [L], found {coordinates!r:.80}") from None
    alike = np.broadcast_arrays(*arrays)
    return alike if len(alike) > 1 else alike[0]


def root(value: ArrayLike) -> Any:
    """Square root of the positive part: edges of contacts without round-off complaints."""
    return np.sqrt(np.maximum(value, 0.0))
