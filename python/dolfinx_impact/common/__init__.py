# SPDX-License-Identifier: MIT
"""What every package uses: checked arguments, agreement of all ranks, interrupts, progress bars."""
