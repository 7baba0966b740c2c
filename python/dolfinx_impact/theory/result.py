# SPDX-License-Identifier: MIT
"""What all results have in common: they can draw themselves."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Result(ABC):
    """Base of the results. Frozen: an answer does not change after it was given."""

    @abstractmethod
    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        """(label of the abscissa, label of the ordinate, list of (name of a curve, abscissae, ordinates))."""

    def plot(self, ax: Any = None) -> Any:
        """Draw the result.

        Args:
            ax: matplotlib axes; None makes a figure.

        Returns:
            The axes.
        """
        from ..io.plots import styled  # matplotlib is loaded by those who draw only

        if ax is not None:
            return self._draw(ax)
        with styled() as plt:
            return self._draw(plt.subplots(figsize=(5.5, 3.6), layout="constrained")[1])

    def _draw(self, ax: Any) -> Any:
        """Draw on axes, and return them."""
        from ..io.plots import COLOURS

        abscissa, ordinate, curves = self._figure()
        for number, (name, x, y) in enumerate(curves):
            ax.plot(x, y, color=COLOURS[number % len(COLOURS)], label=name, marker="o" if len(x) == 1 else None)
        ax.set_xlabel(abscissa)
        ax.set_ylabel(ordinate)
        if any(name for name, _, _ in curves):
            ax.legend()
        return ax
