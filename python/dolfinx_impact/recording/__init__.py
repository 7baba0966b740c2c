# SPDX-License-Identifier: MIT
"""Fields that problems record: of the motion, of the bodies' materials, of the contacts."""
