# SPDX-License-Identifier: MIT
"""The insulated rail joint in three dimensions: parameters, model, passage of a wheel, report, study."""

from .case import Case
from .model import JointModel
from .parameters import EndPost, RailJoint
from .passage import Passage
from .results import Summary

__all__ = ["Case", "EndPost", "JointModel", "Passage", "RailJoint", "Summary"]
