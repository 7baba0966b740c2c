# SPDX-License-Identifier: MIT
"""Runs in time as data, and the two adapters that make them with dolfinx_impact and with the hand-written solver."""
