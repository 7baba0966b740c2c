# SPDX-License-Identifier: MIT
"""Steady rolling in the ALE frame: the mesh stands, the material flows through it."""
