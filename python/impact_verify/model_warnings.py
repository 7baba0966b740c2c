# SPDX-License-Identifier: MIT
"""Warnings of bodies and contacts that are no good models, which rows have on purpose."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from dolfinx_impact.assembly.large_rotation import LargeRotation
from dolfinx_impact.assembly.locking import Locking
from dolfinx_impact.common.messages import INITIAL_PENETRATION
from dolfinx_impact.dynamics.hourglass import Hourglassing


@contextmanager
def model_warnings_off() -> Iterator[None]:
    """Say nothing of bodies of small strain that turn far, cells that lock or hourglass, and surfaces that overlap
    before anything is loaded: both sides must do the same there, too."""
    level = INITIAL_PENETRATION.level
    INITIAL_PENETRATION.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            for category in (LargeRotation, Locking, Hourglassing):
                warnings.simplefilter("ignore", category)
            yield
    finally:
        INITIAL_PENETRATION.setLevel(level)
