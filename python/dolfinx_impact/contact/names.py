# SPDX-License-Identifier: MIT
"""Names that tell the contacts of a problem apart, in messages and files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any


def named_apart(contacts: Sequence[Any]) -> list[Any]:
    """Contacts of a problem, of which no two have the same name: those that share one get a number behind it.

    Args:
        contacts: contacts as they were given, with pairs.

    Returns:
        The same contacts; copies where the name has changed.
    """
    counts = Counter(contact.pair.name for contact in contacts)
    taken, out = {name for name, count in counts.items() if count == 1}, []
    for contact in contacts:
        name, k = contact.pair.name, 1
        if counts[name] > 1:
            while f"{name} ({k})" in taken:
                k += 1
            name = f"{name} ({k})"
            taken.add(name)
            contact = contact._copy(pair=contact.pair._copy(name=name))
        out.append(contact)
    return out
