# SPDX-License-Identifier: MIT
"""States of static contacts as parts of what a checkpoint holds."""

from collections.abc import Sequence
from typing import Protocol

from .. import _cpp
from ..common.types import FloatArray


class SavedContact(Protocol):
    """What a checkpoint asks of a static contact; see protocol.StaticContact."""

    def saved_state(self) -> _cpp.state.State: ...

    def resume(self, saved: _cpp.state.State, u: FloatArray) -> None: ...


def add_contacts(state: _cpp.state.State, contacts: Sequence[SavedContact]) -> None:
    """Add the states of contacts: parts contact0, contact1, ...

    Args:
        state: state that gets them.
        contacts: contacts of a problem, in their order.
    """
    for k, contact in enumerate(contacts):
        part = contact.saved_state()
        part.rename(f"contact{k}")
        state.add(part)


def resume_contacts(saved: _cpp.state.State, contacts: Sequence[SavedContact], u: FloatArray) -> None:
    """Let contacts continue from the states of `add_contacts`. Collective.

    Args:
        saved: state that has them.
        contacts: contacts of a problem, in their order.
        u: displacements of the checkpoint, owned and ghost dofs [L].
    """
    for k, contact in enumerate(contacts):
        contact.resume(saved.part(f"contact{k}"), u)
