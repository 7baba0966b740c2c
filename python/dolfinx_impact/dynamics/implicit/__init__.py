# SPDX-License-Identifier: MIT
"""Implicit dynamics: Newmark's method and generalised-alpha, with contact."""
