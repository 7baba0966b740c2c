# SPDX-License-Identifier: MIT
"""Contact by penalty at quadrature points, with augmentation (Uzawa), for static problems."""
