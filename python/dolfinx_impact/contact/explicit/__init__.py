# SPDX-License-Identifier: MIT
"""Contact of slave nodes with master facets, for explicit dynamics: penalty and kinematic."""
