# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
import dolfinx.cpp

class Packed:
    """Coefficients of a DOLFINx form, packed into storage that is reused"""

    def __init__(self, form: dolfinx.cpp.fem.Form_float64) -> None: ...
    def pack(self) -> None: ...

def peak_flops(lanes: int = 0) -> float:
    """
    Double-precision operations of one core [1/s], in vectors of 2, 4 or 8 numbers (0: the best of this processor; 0.0 where it does not have such vectors)
    """

def triad_bandwidth() -> float:
    """Memory bandwidth of one core [B/s]"""
