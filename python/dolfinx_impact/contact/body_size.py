# SPDX-License-Identifier: MIT
"""The length scale of tolerances of gaps."""

from dolfinx.mesh import Mesh

from .. import _cpp


def body_size(mesh: Mesh) -> float:
    """Diagonal of the bounding box of the whole mesh. Collective.

    Args:
        mesh: mesh of the bodies.

    Returns:
        The diagonal [L].
    """
    return float(_cpp.gap.body_size(mesh._cpp_object))
