# SPDX-License-Identifier: MIT
"""Types of arrays, rules and values over time in annotations; shapes and units stand in docstrings."""

from collections.abc import Callable
from typing import TypeAlias, Union

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
ArrayLike: TypeAlias = npt.ArrayLike

# Name of an integration rule, or its points and weights; None is the default rule of the purpose.
Rule: TypeAlias = Union[str, tuple[ArrayLike, ArrayLike], None]
# A constant, a function of time, or a table (times, values) with linear interpolation.
TimeValues: TypeAlias = Union[ArrayLike, Callable[[float], ArrayLike], tuple[ArrayLike, ArrayLike]]
