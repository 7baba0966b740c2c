# SPDX-License-Identifier: MIT
"""Studies that are made with dolfinx_impact: creep curves, the rail joint, benchmarks."""
