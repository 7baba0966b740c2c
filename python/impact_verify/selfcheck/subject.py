# SPDX-License-Identifier: MIT
"""A form on one small mesh, its random states and sizes: what all checks work on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from dolfinx.mesh import Mesh
from scipy.sparse import csr_matrix, diags

from dolfinx_impact import compat
from dolfinx_impact.common.types import FloatArray
from .assembled import assembled
from .fields import Field, displacement_of, fields_of, rotation_of
from .findings import Finding, Picture, SelfCheckReport
from dolfinx_impact.own_forms.own_form import OwnForm

# Round-off of some thousand operations, relative to the largest of the numbers.
ROUND_OFF, ROUND_OFF_REASON = 1e-10, "round-off, of forces and of what is found from them"


@dataclass
class Subject:
    """A form on one small mesh.

    Args:
        name: name of the form.
        own: the form.
        make: writes the form on another mesh.
        report: report to add to.
        mesh_of: makes the block of a number of cells per side.
        cells_per_side: of the mesh [1].
    """

    name: str
    own: OwnForm
    make: Callable[[Mesh], OwnForm]
    report: SelfCheckReport
    mesh_of: Callable[[int], Mesh]
    cells_per_side: int
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(2026))

    def __post_init__(self) -> None:
        self.u, self.space = self.own.u, self.own.u.function_space
        self.mesh = self.space.mesh
        self.gdim: int = self.mesh.geometry.dim
        self.cell: str = self.mesh.topology.cell_name()
        self.rest: FloatArray = np.array(self.u.x.array)
        self.fields = fields_of(self.space)
        self.displacement: Field | None = displacement_of(self.own, self.fields)
        self.rotation: Field | None = rotation_of(self.own, self.fields)
        self.degree = (self.displacement or self.fields[0]).degree
        self.assembled = assembled(self.own)
        self.axisymmetric = self.own.hypothesis == "axisymmetric"
        self.state = self.rest + self.motion()
        self.other = self.motion()  # another one
        self.forces = self.assembled.vector(self.state)
        self.tangent = self.assembled.matrix(self.state)

    # --- what is found ---------------------------------------------------------------------------------------------

    def add(self, check: str, found: float, tolerance: float, reason: str, good: str, bad: str) -> bool:
        """Add a check that was made.

        Args:
            check: name.
            found: what must not exceed the tolerance [1].
            tolerance: bound [1].
            reason: what the tolerance follows from.
            good: what it says if it passes.
            bad: what it says, by how much and what that means, if not.

        Returns:
            Whether it passes.
        """
        g = compat.coordinate_element(self.mesh).degree
        row = Finding(
            "self", self.name, self.cell, self.degree, g, self._hypothesis(), found,
            tolerance, reason, check,
        )  # fmt: skip
        row.note = good if row.passed else bad
        self.report.rows.append(row)
        return row.passed

    def leave_out(self, check: str, why: str) -> None:
        """Add a check that does not apply.

        Args:
            check: name.
            why: the reason.
        """
        g = compat.coordinate_element(self.mesh).degree
        row = Finding(
            "self", self.name, self.cell, self.degree, g, self._hypothesis(), 0.0, 0.0,
            "", check, why, applies=False,
        )  # fmt: skip
        self.report.rows.append(row)

    def picture(self, picture: Picture) -> None:
        """Add a picture."""
        self.report.pictures.setdefault(f"{self.name} on {self.cell}s of degree {self.degree}", []).append(picture)

    def _hypothesis(self) -> str:
        return self.own.hypothesis or ("3d" if self.gdim == 3 else "")

    @property
    def conservative(self) -> bool:
        """Whether the residual should be the derivative of an energy."""
        said = self.own.conservative
        return len(self.fields) == 1 and self.displacement is not None if said is None else said

    # --- states ----------------------------------------------------------------------------------------------------

    def motion(self) -> FloatArray:
        """A random motion with strains of the size that the form is meant for: a smooth field, and noise at nodes.

        Returns:
            Degrees of freedom of the whole space; all fields move.
        """
        out = np.zeros_like(self.rest)
        h = 1.0 / self.cells_per_side
        for f in self.fields:
            size = self.own.strain * (1.0 if f is self.displacement else 2.0)
            phases = self.rng.uniform(0, 2 * np.pi, (f.num_components, self.gdim))
            factors = self.rng.uniform(1.0, 2.0, (f.num_components, self.gdim))

            def smooth(x: FloatArray) -> FloatArray:
                waves = np.sin(factors[:, :, None] * x[None, : self.gdim] + phases[:, :, None]).sum(axis=1)
                return np.asarray((0.3 * size * waves)[0 if not f.shape else slice(None)])

            values = f.interpolate(smooth)
            noise = 0.15 * h / max(f.degree, 1) ** 2 * size * self.rng.uniform(-1, 1, len(values))
            out[f.dofs] = values + noise
        return out

    def of(self, f: Field, values: FloatArray) -> FloatArray:
        """A motion of one field alone.

        Args:
            f: the field.
            values: its values at nodes, shape (num_nodes, num_components).

        Returns:
            Degrees of freedom of the whole space.
        """
        out = np.zeros_like(self.rest)
        out[f.dofs] = np.ravel(values)
        return out

    # --- sizes -----------------------------------------------------------------------------------------------------

    def scales(self) -> FloatArray:
        """Factor of each degree of freedom that makes the blocks of the fields in the tangent equally large.

        Returns:
            Factors, shape (num_dofs): rows and columns of the tangent are multiplied by them.
        """
        K, c = abs(self.tangent), np.ones(len(self.rest))
        first = self.displacement or self.fields[0]
        own = K[first.dofs][:, first.dofs].max()
        c[first.dofs] = 1.0 / np.sqrt(own) if own > 0.0 else 1.0
        for f in self.fields:
            if f is first:
                continue
            mixed = (diags(c[first.dofs]) @ K[first.dofs][:, f.dofs]).max()
            alone = K[f.dofs][:, f.dofs].max()
            c[f.dofs] = 1.0 / mixed if mixed > 0.0 else 1.0 / np.sqrt(alone) if alone > 0.0 else 1.0
        return c

    def scaled(self, K: csr_matrix) -> FloatArray:
        """A tangent with equally large blocks, as an array of shape (num_dofs, num_dofs)."""
        c = self.scales()
        return np.asarray((diags(c) @ K @ diags(c)).toarray())

    def size(self, forces: FloatArray) -> float:
        """Largest of forces, each field by the largest that it has in the random state."""
        worst = 0.0
        largest = np.abs(self.forces * self.scales()).max()
        for f in self.fields:
            scale = np.abs(self.forces[f.dofs]).max()
            floor = largest / max(self.scales()[f.dofs].max(), 1e-300) * 1e-8
            worst = max(worst, float(np.abs(forces[f.dofs]).max() / max(scale, floor, 1e-300)))
        return worst

    def place(self, dof: int) -> str:
        """Text about a degree of freedom: its field, component and node."""
        for f in self.fields:
            at = np.flatnonzero(f.dofs == dof)
            if len(at):
                node, component = divmod(int(at[0]), max(f.space.dofmap.bs, 1))
                where = np.round(f.nodes[node], 3).tolist() if f.nodal else f"degree of freedom {at[0]}"
                name = "" if len(self.fields) == 1 else f"field {f.number}, "
                return f"{name}component {component} at {where}"
        return f"degree of freedom {dof}"
