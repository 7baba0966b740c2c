# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from . import (
    bench as bench,
    enforcement as enforcement,
    files as files,
    gap as gap,
    integrators as integrators,
    kernels as kernels,
    multipliers as multipliers,
    nodal as nodal,
    operators as operators,
    penalty as penalty,
    problems as problems,
    rolling as rolling,
    search as search,
    solve as solve,
    state as state,
    surface as surface,
)
