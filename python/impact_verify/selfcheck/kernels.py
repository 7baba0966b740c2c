# SPDX-License-Identifier: MIT
"""Check of the kernels of this package against those of FFCx."""

from __future__ import annotations

import numpy as np

from dolfinx_impact.assembly.operators import InternalForce
from .assembled import AssembledForm
from .subject import Subject

# Sums of the same products in another order.
TOLERANCE, REASON = 1e-12, "round-off: sums in another order"


def kernels(subject: Subject) -> None:
    """Does the kernel of this package give the forces of FFCx's?

    Args:
        subject: the form.
    """
    form = subject.assembled
    if not isinstance(form, AssembledForm):
        subject.leave_out("kernels", "FFCx does not solve the local equations of a material")
        return
    subject.u.x.array[:] = subject.state
    try:
        ours = np.array(InternalForce(form.internal).apply().array)
    except ValueError as e:
        subject.leave_out("kernels", f"this package has no kernel for the form: {e}")
        return
    found = subject.size(ours - subject.forces)
    subject.add(
        "kernels", found, TOLERANCE, REASON, "the kernel of this package gives the forces of FFCx's",
        f"the kernel of this package differs from FFCx's by {found:.1e} of the largest force: this is an error of the "
        "package, please report it with the form",
    )  # fmt: skip
