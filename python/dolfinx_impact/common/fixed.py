# SPDX-License-Identifier: MIT
"""Objects whose attributes are set once: problems read them when they are made, and would not see a later change."""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from dolfinx.fem import Constant


class Fixed:
    """Base class of what problems are described with: materials, loads, pairs of surfaces, contact methods.

    Public attributes can be set while the object is made, by `__init__` of its class or of a class derived from it.
    Afterwards only properties with a setter can, and names with an underscore, which belong to the class itself.
    """

    _made = False
    _made_with: frozenset[str] = frozenset()  # public names that it had then
    _takes_new = False  # whether names that it has not may be added, for a user's own purposes
    _because = "problems read it when they are made and would go on with the old one"

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__init__" in cls.__dict__:
            cls.__init__ = _once_made(cls.__init__)  # type: ignore[method-assign]

    if not TYPE_CHECKING:  # a checker of types would take any name for an attribute

        def __setattr__(self, name: str, value: Any) -> None:
            if self._made and not name.startswith("_") and not _has_setter(type(self), name):
                self._check_added(name)
            object.__setattr__(self, name, value)

        def __delattr__(self, name: str) -> None:
            if self._made and not name.startswith("_"):
                self._check_added(name)
            object.__delattr__(self, name)

        def _check_added(self, name: str) -> None:
            """Raise unless the name is one that a user adds, or has added."""
            if not self._takes_new or name in self._made_with:
                self._refuse_change(name)

    def _copy(self, **changes: Any) -> Any:
        """A copy with other values of some attributes, which are not checked.

        Args:
            changes: values by the names of attributes.
        """
        made = copy.copy(self)
        vars(made).update(changes)
        return made

    def _refuse_change(self, name: str) -> NoReturn:
        kind = type(self).__name__
        if name not in _public(self):
            raise AttributeError(f"{_a(kind)} has no attribute {name!r}: it has {', '.join(sorted(_public(self)))}")
        value = f", or set `{name}.value`" if isinstance(vars(self).get(f"_{name}"), Constant) else ""
        raise AttributeError(f"{name} of {_a(kind)} cannot be changed: {self._because}. Make another {kind}{value}")


def read_only(value: Any) -> Any:
    """A value that nobody else can change in place.

    Args:
        value: an array or a sequence, which are copied; anything else is returned as it is.
    """
    if isinstance(value, np.ndarray):
        value = value.copy()
        value.flags.writeable = False
    return tuple(value) if isinstance(value, list) else value


def _once_made(init: Callable[..., None]) -> Callable[..., None]:
    """The `__init__` of a class, after which the object is made, unless that of a derived class called it."""

    @functools.wraps(init)
    def make(self: Any, *args: Any, **options: Any) -> None:
        init(self, *args, **options)
        if type(self).__init__ is make:
            object.__setattr__(self, "_made_with", _public(self))
            object.__setattr__(self, "_made", True)

    return make


def _a(kind: str) -> str:
    """The name of a class with its article."""
    return f"{'an' if kind[0] in 'AEIO' else 'a'} {kind}"


def _has_setter(kind: type, name: str) -> bool:
    return getattr(getattr(kind, name, None), "fset", None) is not None


def _public(thing: object) -> frozenset[str]:
    """Names of attributes and properties, without methods."""
    properties = {n for kind in type(thing).__mro__ for n, v in vars(kind).items() if isinstance(v, property)}
    return frozenset(name for name in properties | set(vars(thing)) if not name.startswith("_"))
