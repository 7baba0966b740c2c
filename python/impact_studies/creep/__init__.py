# SPDX-License-Identifier: MIT
"""Creep curves of a wheel on a rail in 3D: the command `dolfinx-impact creep`."""
