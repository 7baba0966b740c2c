# SPDX-License-Identifier: MIT
"""Types of arrays and of names of files in annotations; shapes and units are in docstrings."""

import os
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.floating[Any]]
Float64Array: TypeAlias = npt.NDArray[np.float64]  # memory that C++ writes to, or keeps a view of
IntArray: TypeAlias = npt.NDArray[np.integer[Any]]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
AnyArray: TypeAlias = npt.NDArray[Any]
ArrayLike: TypeAlias = npt.ArrayLike
FilePath: TypeAlias = str | os.PathLike[str]
