# SPDX-License-Identifier: MIT
"""Checks of forms that have no hand-written counterpart: what must hold of any residual, and where it does not."""
