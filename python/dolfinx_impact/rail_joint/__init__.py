# SPDX-License-Identifier: MIT
"""The insulated rail joint in three dimensions: parameters, model, passage of a wheel, report, study."""

from .parameters import EndPost, RailJoint

__all__ = ["EndPost", "RailJoint"]
