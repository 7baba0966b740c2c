# SPDX-License-Identifier: MIT
"""Equal steps from one time to another: begin, until [T], numbers of the first and the last step, length dt [T]."""

from typing import TypeAlias

from .. import _cpp

StepSchedule: TypeAlias = _cpp.problems.StepSchedule
