# SPDX-License-Identifier: MIT
"""Static problems: load steps, Newton's method with contact, line search, linear solvers."""
