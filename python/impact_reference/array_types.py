# SPDX-License-Identifier: MIT
"""Types of arrays, rules and values over time in annotations, and arrays of these types from what a caller gave."""

from collections.abc import Callable
from typing import Any, TypeAlias, Union

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
AnyArray: TypeAlias = npt.NDArray[Any]  # real or complex
ArrayLike: TypeAlias = npt.ArrayLike

# Name of an integration rule, or its points and weights; None is the default rule of the purpose.
Rule: TypeAlias = Union[str, tuple[ArrayLike, ArrayLike], None]
# A constant, a function of time, or a table (times, values) with linear interpolation.
TimeValues: TypeAlias = Union[ArrayLike, Callable[[float], ArrayLike], tuple[ArrayLike, ArrayLike]]


def floats(values: ArrayLike) -> FloatArray:
    """The values as a contiguous array of numbers, in their shape."""
    return np.ascontiguousarray(values, dtype=float)


def vector(values: ArrayLike) -> FloatArray:
    """The values in one row; one number alone is a row of one."""
    return np.atleast_1d(floats(values)).reshape(-1)


def integers(values: ArrayLike, what: str, ndim: int) -> IntArray:
    """The values as a contiguous array of integers with so many axes; `what` names them in errors.

    Raises:
        TypeError: values that are not integers.
        ValueError: another number of axes.
    """
    array = np.asarray(values)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"{what} must hold integers, found {array.dtype}")
    if array.ndim != ndim:
        raise ValueError(f"{what} must have {ndim} axes, found shape {array.shape}")
    return np.ascontiguousarray(array, dtype=np.int64)
