# SPDX-License-Identifier: MIT
"""Contacts of static and implicit problems as Newton's method in C++ sees them."""

from typing import Any

from .. import _cpp
from .mortar.lagrange import LagrangeContact
from .penalty.quadrature_penalty import QuadraturePenalty


def contact_in_cpp(contact: Any) -> _cpp.enforcement.StaticContact:
    """A contact as Newton's method in C++ sees it. What derived classes may have replaced is called through Python.

    Args:
        contact: contact of a static or implicit problem.
    """
    own = type(contact) in (LagrangeContact, QuadraturePenalty)
    return contact._cpp_object if own else _cpp.solve.PythonContact(contact)
