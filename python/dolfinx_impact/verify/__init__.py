# SPDX-License-Identifier: MIT
"""`di.verify`: the package impact_verify, which lies beside this one, under the name that users know.

It is imported on first use, so that importing dolfinx_impact needs neither it nor the hand-written solver.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from impact_verify import OwnForm, cross_check, self_check

__all__ = ["OwnForm", "cross_check", "self_check"]


def __getattr__(name: str) -> Any:
    import impact_verify

    return getattr(impact_verify, name)
