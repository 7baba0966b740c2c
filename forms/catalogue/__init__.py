# SPDX-License-Identifier: MIT
"""The catalogue of the package: one registered function per form, in modules named as those of the physics.

The order of the imports is the order of the names.
"""

from . import laws, inertia, loads, foundation, damping, ale, galerkin, plasticity, one_point  # noqa: F401
