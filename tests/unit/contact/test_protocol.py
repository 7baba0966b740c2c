# SPDX-License-Identifier: MIT
"""Every contact class has what problems ask of it, with the same arguments."""

import inspect
import re

import pytest

from dolfinx_impact.contact import protocol
from dolfinx_impact.contact.explicit.nodal import NodalPair
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.contact.penalty.quadrature_penalty import QuadraturePenalty

CASES = [
    (protocol.StaticContact, QuadraturePenalty),
    (protocol.StaticContact, LagrangeContact),
    (protocol.MultiplierContact, LagrangeContact),
    (protocol.ExplicitContact, NodalPair),
]


def members(asked):
    """Functions and properties that a protocol asks for, and names of its plain attributes."""
    functions, attributes = {}, set()
    for cls in asked.__mro__:
        if getattr(cls, "_is_protocol", False) and cls.__module__ == protocol.__name__:
            attributes |= set(cls.__annotations__)
            functions |= {n: f for n, f in vars(cls).items() if inspect.isfunction(f) and not n.startswith("_")}
            functions |= {n: f for n, f in vars(cls).items() if isinstance(f, property)}
    return functions, attributes


def names(function):
    return [(p.name, p.default) for p in inspect.signature(function).parameters.values()]


def complaints(asked, given):
    """What a class lacks of a protocol, as sentences."""
    functions, attributes = members(asked)
    found = []
    for name, function in functions.items():
        own = inspect.getattr_static(given, name, None)
        if own is None:
            found.append(f"{name} is missing")
        elif inspect.isfunction(function) and (not inspect.isfunction(own) or names(own) != names(function)):
            found.append(f"{name} takes other arguments")
        elif not (function.fget if isinstance(function, property) else function).__doc__:
            found.append(f"{name} is not documented")
    assigned = "".join(inspect.getsource(cls) for cls in given.__mro__ if cls is not object)
    for name in attributes:
        if not hasattr(given, name) and f"self.{name}" not in assigned:
            found.append(f"attribute {name} is missing")
    return found


@pytest.mark.parametrize("asked, given", CASES, ids=lambda c: c.__name__)
def test_contacts_satisfy_their_protocol(asked, given):
    assert complaints(asked, given) == []


def test_a_contact_that_lacks_something_is_noticed():
    class Other(QuadraturePenalty):
        tangent = None

        def update_active_set(self, first):
            return 0

    assert complaints(protocol.StaticContact, Other) == [
        "update_active_set takes other arguments",
        "tangent is missing",
    ]


def test_penalties_have_no_multipliers():
    assert len(complaints(protocol.MultiplierContact, QuadraturePenalty)) > 5
    assert not QuadraturePenalty.has_multipliers and LagrangeContact.has_multipliers


def test_interfaces_in_cpp_ask_for_members_of_the_contacts(checkout):
    """They have the same names, but for what a State and an array of products replace."""
    text = (checkout / "cpp/dolfinx_impact/enforcement/StaticContact.h").read_text()
    asked = {}
    for name, body in re.findall(r"class (\w+)[^;{]*\n\{(.*?)\n\};", text, re.DOTALL):
        asked[name] = set(re.findall(r"virtual [^;(]*?(\w+)\(", body)) - {name}
    assert set(asked) == {"StaticContact", "MultiplierContact"}
    replaced = {"name", "state", "smallest_gap", "has_friction", "set_convex", "mortar"}
    # What laws of the interface ask for, which are C++ alone.
    replaced |= {"check_without_time", "set_time_step", "needs_line_search"}
    # Rotation of rigid masters.
    replaced |= {"set_rotation", "rotation", "centre"}
    assert asked["StaticContact"] - set(dir(QuadraturePenalty)) - members(protocol.StaticContact)[1] <= replaced
    assert len(asked["StaticContact"] & set(dir(LagrangeContact))) > 20
    assert len(asked["MultiplierContact"] & set(dir(LagrangeContact))) > 10
