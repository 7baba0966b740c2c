# SPDX-License-Identifier: MIT
"""Explicit dynamics: time stepping, stable step, energies, restart and output of a run."""
