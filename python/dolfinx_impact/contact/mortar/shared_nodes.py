# SPDX-License-Identifier: MIT
"""Nodes that several contacts by multipliers have in common: joined, kept apart, or refused; docs/contact.md.

They are found in C++: cpp/dolfinx_impact/enforcement/mortar/shared_nodes.h.
"""

from collections.abc import Sequence
from typing import Any

from ... import _cpp


def connect(contacts: Sequence[Any]) -> bool:
    """Find the nodes that contacts by multipliers have in common, and join them where one constraint is meant.
    Collective.

    Args:
        contacts: all contacts of a problem.

    Returns:
        Whether nodes are left with constraints of several contacts, so that multipliers cannot be condensed.

    Raises:
        ValueError: two pairs have the same facets twice, or each has the other's slave for its master, or share slave
            nodes in a problem that cannot solve for them; on all ranks.
    """
    return bool(_cpp.multipliers.connect([c._cpp_object for c in contacts if c.has_multipliers]))
