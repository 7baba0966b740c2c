# SPDX-License-Identifier: MIT
"""Problems are not copied, and two of them on one displacement function are told of."""

import gc
import warnings
import weakref

_explicit = weakref.WeakKeyDictionary()  # displacement function -> ExplicitProblems on it that are alive


class Unique:
    """Base of classes whose objects share state with C++, PETSc and the user's functions: a copy would share it too."""

    _instead = "make another one on a displacement function of its own"

    def _refuse(self, what):
        raise TypeError(f"a {type(self).__name__} cannot be {what}: it shares its state with its functions; "
                        f"{self._instead}")  # fmt: skip

    def __copy__(self):
        self._refuse("copied")

    def __deepcopy__(self, memo):
        self._refuse("copied")

    def __reduce_ex__(self, protocol):
        self._refuse("pickled")


def claim(u, problem, explicit=False):
    """A problem has been made on u. Warn, on rank 0, if an explicit problem that is still alive is on it.

    An explicit problem has its own state and writes it into u after each advance: what others write there is lost.
    Static problems read u, so that several of them, or one before an explicit one, are fine.
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
