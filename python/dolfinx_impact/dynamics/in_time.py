# SPDX-License-Identifier: MIT
"""Supports and contacts of a problem in time, as the C++ side takes them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from dolfinx.fem import DirichletBC

from .. import _cpp
from ..amplitude import Amplitude, PrescribedMotion
from ..contact import in_cpp
from .functions_of_time import FunctionsOfTime

if TYPE_CHECKING:
    from ..contact.explicit.general import GeneralOutput
    from ..contact.explicit.nodal import NodalPair
    from ..contact.explicit.tied import ExplicitTie
    from ..contact.mortar.lagrange import LagrangeContact
    from ..contact.mortar.tie import TieContact
    from ..contact.penalty.quadrature_penalty import QuadraturePenalty

    BoundContact: TypeAlias = NodalPair | ExplicitTie | GeneralOutput


def prescribed_motion(bc: DirichletBC | PrescribedMotion, functions: FunctionsOfTime) -> _cpp.problems.PrescribedMotion:
    """A support.

    Args:
        bc: condition whose values are constant, or function of time.
        functions: receives the function of time.

    Returns:
        The C++ object, which has the amplitude at the start.
    """
    if not isinstance(bc, PrescribedMotion):
        return _cpp.problems.PrescribedMotion(bc._cpp_object, None)
    functions.add(bc.amplitude)
    return _cpp.problems.PrescribedMotion(bc.bc._cpp_object, bc.amplitude.sample(np.zeros(1))[0])


def contact_in_time(contact: BoundContact, functions: FunctionsOfTime) -> _cpp.problems.ContactInTime:
    """A contact.

    Args:
        contact: contact of an explicit problem.
        functions: receives the motion of a rigid master.

    Returns:
        The C++ object.
    """
    start = None
    if contact.motion is not None:
        functions.add(contact.motion)
        start = contact.motion.sample(np.zeros(1))[0]
    turned = None if contact.motion is None else contact.pair.rigid_master.angle_in_time(contact.pair.name)
    if turned is not None:
        functions.add(turned)
    angle = None if turned is None else turned.sample(np.zeros(1))[0]
    return _cpp.problems.ContactInTime(contact._cpp_object, contact.pair.name, start, contact.body, angle)


def contacts_in_time(contacts: Sequence[BoundContact], functions: FunctionsOfTime) -> list[_cpp.problems.ContactInTime]:
    """All contacts of an explicit problem.

    Args:
        contacts: the contacts.
        functions: receives the motions of rigid masters, then the loads on rigid bodies.

    Returns:
        The C++ objects.
    """
    out = [contact_in_time(contact, functions) for contact in contacts]
    bodies = list(dict.fromkeys(c.pair.rigid_body for c in contacts if c.pair.rigid_body is not None))
    for body in bodies:  # the list grows by those that they meet
        bodies += [other for other in body.met_bodies() if other not in bodies]
        for load in body.loads():
            functions.add(load)
    lost = list(dict.fromkeys(other for body in bodies for other in body.met_by() if other not in bodies))
    if lost:
        warnings.warn(
            "rigid bodies that meet those of this problem are not in it: "
            f"{', '.join(f'{body!r:.80}' for body in lost)}; let the master of a pair meet them, in its `meets`",
            stacklevel=2,
        )
    return out


def implicit_contact(
    contact: LagrangeContact | QuadraturePenalty | TieContact, functions: FunctionsOfTime
) -> _cpp.problems.ImplicitContact:
    """A contact of implicit steps.

    Args:
        contact: contact of an implicit problem.
        functions: receives the motion of a rigid master.

    Returns:
        The C++ object, which has the master's displacement at the start.
    """
    right = in_cpp.contact_in_cpp(contact)
    if not contact.pair.rigid or contact.pair.rigid_body is not None:
        return _cpp.problems.ImplicitContact(right, None, None, None)
    master = contact.pair.rigid_master
    functions.add(Amplitude(master.motion, f"motion of the rigid master of {contact.pair.name}", size=3))
    turned = master.angle_in_time(contact.pair.name)
    if turned is not None:
        functions.add(turned)
    return _cpp.problems.ImplicitContact(
        right, [float(d) for d in master.displacement], np.zeros(3), None if turned is None else turned.sample([0.0])[0]
    )


def implicit_bodies(
    problem: Any, contacts: Sequence[LagrangeContact | QuadraturePenalty | TieContact], functions: FunctionsOfTime
) -> list[_cpp.problems.ImplicitBodyInTime]:
    """Rigid bodies of an implicit problem.

    Args:
        problem: the problem.
        contacts: its contacts.
        functions: receives the loads on rigid bodies.

    Returns:
        The C++ objects.
    """
    out = []
    for body in dict.fromkeys(c.pair.rigid_body for c in contacts if c.pair.rigid_body is not None):
        for load in body.loads():
            functions.add(load)
        out.append(body.bind_implicit(problem))
    return out
