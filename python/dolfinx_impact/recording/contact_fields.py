# SPDX-License-Identifier: MIT
"""Pressure, gap, tractions, slip and status of contacts at the nodes of their slaves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem
from dolfinx.fem import FunctionSpace

from ..contact.output import ContactOutput
from .names import AXES, dimension

VECTORS = ("traction", "shear_traction", "slip", "slip_velocity")
GAP = "gap"


class ContactFields:
    """Results of contacts; see FieldSource. Each component is a scalar of the degree of the displacement.

    Nodes that are no slave nodes have zeros, and no gap: a number that is none, which ParaView leaves out. So have
    slave nodes without a master. With several contacts the names end in the contact's number, as `force_0` in the
    histories.

    Args:
        V: displacement space.
        contacts: contacts of the problem.
        names: names of CONTACT.
    """

    series = "contact"

    def __init__(self, V: FunctionSpace, contacts: Sequence[ContactOutput], names: Sequence[str]) -> None:
        mesh = V.mesh
        space = fem.functionspace(mesh, ("Lagrange", V.element.basix_element.degree))
        axes = AXES[: mesh.geometry.dim]
        self._contacts, self._names = list(contacts), list(names)
        self.functions, self.dimensions = [], []
        for k in range(len(contacts)):
            for name in names:
                numbered = name if len(contacts) == 1 else f"{name}_{k}"
                parts = [f"{numbered}_{axis}" for axis in axes] if name in VECTORS else [numbered]
                self.functions += [fem.Function(space, name=part) for part in parts]
                self.dimensions += [dimension(name)] * len(parts)

    def update(self) -> None:
        """Set the functions to the results of the present state. Collective."""
        functions = iter(self.functions)
        for contact in self._contacts:
            contact.refresh()
            for name in self._names:
                nodes, values = contact.at_nodes(getattr(contact, name))
                for column in np.atleast_2d(values.T):
                    f = next(functions)
                    elsewhere = np.nan if name == GAP else 0.0
                    f.x.array[:] = elsewhere
                    f.x.array[nodes] = np.where(np.isfinite(column), column, elsewhere)
                    f.x.scatter_forward()
