# SPDX-License-Identifier: MIT
"""Contact by dual Lagrange multipliers: mortar integrals, condensation, friction."""
