# SPDX-License-Identifier: MIT
"""Energy that an explicit run gains without work: limits and what a user is told; docs/explicit/energies.md."""

import math

LIMITS = (0.1, 0.5)  # of the energies so far: warn, stop. Runs with contact that are in order gain less than 0.01


def checked(limits):
    """The argument `energy_limits` of `advance` as two numbers.

    Raises:
        ValueError: no two numbers, or not in order.
    """
    if limits is None:
        return math.inf, math.inf
    try:
        warn, stop = (float(limit) for limit in limits)
    except (TypeError, ValueError) as e:
        raise ValueError(f"energy_limits is {limits!r}: give two numbers, for the warning and the stop, or None") from e
    if not 0.0 < warn <= stop:
        raise ValueError(f"energy_limits is {limits!r}: the first must be positive, the second no smaller")
    return warn, stop


def told(gain):
    """What to say of a run that has gained this part of its energies."""
    return (
        f"it has gained energy without the work of loads or supports: {100 * gain:.3g} % of the energies so far. "
        "Contact or the steps bring it in: take a smaller step, damping or bulk viscosity, or check that bodies do not "
        "pass through each other; energy_limits=... of advance changes the limits."
    )
