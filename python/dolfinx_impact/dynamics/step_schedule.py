# SPDX-License-Identifier: MIT
"""Equal steps from one time to another: begin, until [T], numbers of the first and the last step, length dt [T]."""

from .. import _cpp

StepSchedule = _cpp.problems.StepSchedule
