# SPDX-License-Identifier: MIT
"""What the kernels of one form of a law are written of."""

from __future__ import annotations

from dataclasses import dataclass

from ..forms.compiler import frontend
from .own_law import OwnLaw


@dataclass
class KernelSource:
    """Kernels of one form of a law.

    Attributes:
        law: the law on its cells.
        kind: kind of the kernel, of own_law.KINDS.
        integrals: what the kernels are written of.
    """

    law: OwnLaw
    kind: str
    integrals: list[frontend.Integral]

    @property
    def name(self) -> str:
        """Name by which kernels::find finds it."""
        return f"{self.law.name}.{self.kind}"

    def prefix(self, stem: str) -> str:
        """Beginning of the names of its descriptors.

        Args:
            stem: name of the header.
        """
        return "_".join(["impact", stem, self.law.name, self.kind, *map(str, self.law.case)])


def source_of_kernels(law: OwnLaw, kind: str) -> KernelSource:
    """What the kernels of a form are written of.

    Args:
        law: the law.
        kind: kind of the kernel.

    Raises:
        ValueError: kernels do not support the form.
    """
    form = law.forms[kind]
    try:
        found = frontend.form_integrals(form.form, f"{law.name}.{kind}", law.names, law.case.hypothesis, form.law)
    except Exception as e:  # UFL and FFCx raise errors of many kinds
        lines = str(e).strip().splitlines() or [type(e).__name__]
        what = lines[0] if isinstance(e, ValueError) else f"{type(e).__name__}: {lines[0]}"
        raise ValueError(
            f"no kernel can be written of {law.name}.{kind} on {law.case}: {what}; --kernels leaves a kind out"
        ) from e
    return KernelSource(law, kind, found)
