# SPDX-License-Identifier: MIT
"""Problems cannot be copied, and two of them on one displacement function cause a warning."""

import gc
import warnings
import weakref
from typing import Any, NoReturn, SupportsIndex

from dolfinx.fem import Function

from .fixed import Fixed

# From a displacement function to the ExplicitProblems on it that are alive.
_explicit: weakref.WeakKeyDictionary[Function, weakref.WeakSet[Any]] = weakref.WeakKeyDictionary()


class Unique(Fixed):
    """Base of classes whose objects share state with C++, PETSc and the user's functions: a copy would share it too,
    and a part that was replaced would stay in use."""

    _takes_new = True
    _because = "it was made with it"
    _instead = "make another one on a displacement function of its own"

    def _refuse(self, what: str) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} cannot be {what}: it shares its state with its functions; "
                        f"{self._instead}")  # fmt: skip

    def __copy__(self) -> NoReturn:
        self._refuse("copied")

    def __deepcopy__(self, memo: dict[int, Any]) -> NoReturn:
        self._refuse("copied")

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        self._refuse("pickled")


def claim(u: Function, problem: object, explicit: bool = False) -> None:
    """Register a problem on a displacement function; warn on rank 0 if an explicit problem on it is still alive.

    An explicit problem has a state of its own and writes it into u after each advance; values that others write there
    are lost. Static problems read u: several of them, or one before an explicit one, do not conflict.

    Args:
        u: displacement function.
        problem: the new problem.
        explicit: whether it is an explicit problem.
    """
    others = _explicit.setdefault(u, weakref.WeakSet())
    if others:
        gc.collect()  # problems and their contacts refer to each other
    if others and u.function_space.mesh.comm.rank == 0:
        warnings.warn(
            f"this {type(problem).__name__} and an ExplicitProblem that is still alive have the same displacement "
            "function u: the explicit one keeps its own state, overwrites u at each advance, and does not see what "
            "others write there; give each problem a function of its own, or delete the other one first",
            stacklevel=3,
        )
    if explicit:
        others.add(problem)
