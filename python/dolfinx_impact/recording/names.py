# SPDX-License-Identifier: MIT
"""Names of the fields that can be recorded, and their dimensions."""

from ..assembly.cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from ..forms import plasticity

MOTION = {"displacement": "L", "velocity": "L/T", "acceleration": "L/T^2"}
CONTACT = {"pressure": "F/L^2", "gap": "L", "traction": "F/L^2", "shear_traction": "F/L^2", "slip": "L", "status": "1"}
BODY = {
    STRESS: "F/L^2",
    VON_MISES: "F/L^2",
    plasticity.PLASTIC_STRAIN: "1",
    plasticity.PLASTIC_TENSOR: "1",
    plasticity.THICKNESS_STRAIN: "1",
    plasticity.BACK_STRESS: "F/L^2",
}
SLIDING = {"slip_velocity": "L/T"}  # of contacts with friction in steady rolling
AXES = "xyz"


def dimension(name: str) -> str:
    """Dimension of a field.

    Args:
        name: name of the field.

    Returns:
        Dimension in L, F, T; empty where it is not known, as of internal variables of a law of one's own.
    """
    return {**MOTION, **CONTACT, **SLIDING, **BODY}.get(name, "")
