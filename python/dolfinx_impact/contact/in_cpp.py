# SPDX-License-Identifier: MIT
"""Contacts of static and implicit problems as Newton's method in C++ sees them."""

from typing import Any

from .. import _cpp


def contact_in_cpp(contact: Any) -> _cpp.enforcement.StaticContact:
    """A contact as Newton's method in C++ sees it. What derived classes may have replaced is called through Python: a
    class whose calls are all those of its C++ object says so itself, by `all_in_cpp`, which is not inherited.

    Args:
        contact: contact of a static or implicit problem.
    """
    own = vars(type(contact)).get("all_in_cpp", False)
    return contact._cpp_object if own else _cpp.solve.PythonContact(contact)
