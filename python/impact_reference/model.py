# SPDX-License-Identifier: MIT
"""Models: discretised bodies that move in time."""

from . import explicit, newmark
from .discretisation import Discretisation


class Model(Discretisation):
    """Body of hand-written elements, seed (3.17)-(3.30), with its motion in time; arguments are those of its parent."""

    run_explicit = explicit.run_explicit
    run_newmark = newmark.run_newmark
    stable_step = explicit.stable_step
