# SPDX-License-Identifier: MIT
"""Files: meshes that are read and checked, run folders, checkpoints, frames, plots."""
