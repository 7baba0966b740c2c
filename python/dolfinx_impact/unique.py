"""Problems are not copied, and two of them on one displacement function are told of."""

import gc
import warnings
import weakref

_explicit = weakref.WeakKeyDictionary()  # displacement function -> weak reference to the ExplicitProblem on it


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
    other = _explicit.get(u, lambda: None)()
    if other is not None:
        del other
        gc.collect()  # problems and their contacts refer to each other
        other = _explicit.get(u, lambda: None)()
    if other is not None and u.function_space.mesh.comm.rank == 0:
        warnings.warn(
            f"this {type(problem).__name__} and a {type(other).__name__} that is still alive have the same displacement "
            "function u: the explicit one keeps its own state, overwrites u at each advance, and does not see what the "
            "other writes there; give each problem a function of its own, or delete the other one first",
            stacklevel=3,
        )
    if explicit:
        _explicit[u] = weakref.ref(problem)
