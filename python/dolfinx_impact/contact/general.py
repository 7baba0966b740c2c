# SPDX-License-Identifier: MIT
"""Contact that finds itself: all outer facets against each other, no pairs named; docs/general_contact.md and
docs/explicit/general_contact.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx.mesh import MeshTags

from ..common.arguments import number
from ..common.collective import comm_of, guard
from ..common.fixed import Fixed
from ..loads import _tag, facet_tags_of
from .explicit.general import GeneralOutput
from .general_surface import GeneralSurface
from .pair import ContactPair
from .penalty.static_general import StaticGeneral
from .protocol import ExplicitContactProblem, StaticContactProblem


class GeneralContact(Fixed):
    """Contact of all outer facets with each other, by penalty; docs/general_contact.md, and
    docs/explicit/general_contact.md for explicit problems.

    Neither side is slave or master, a body may touch itself, and edges touch edges in 3D. What pairs of the same
    problem enforce between their surfaces is left to them. Explicit problems take displacements of degree 1 on straight
    facets.

    Args:
        facet_tags: tags of facets.
        tags: tags of the facets that may touch; None: all facets of the boundary, tagged or not.
        friction: coefficient of friction, zero or more [1].
        name: name for messages and files.

    Raises:
        TypeError: `facet_tags` are no tags of facets, or a tag is no integer; on all ranks.
        ValueError: no tags in `tags`, a tag twice, or a friction that is negative or not finite; on all ranks. The tags
            are compared with the mesh when a problem is made.
    """

    def __init__(
        self,
        facet_tags: MeshTags,
        tags: Sequence[int] | int | None = None,
        friction: float = 0.0,
        name: str = "general contact",
    ) -> None:
        with guard(comm_of(facet_tags), "GeneralContact", tags=tags, friction=friction, name=name):
            facet_tags_of("GeneralContact", facet_tags)
            chosen = None
            if tags is not None:
                given = list(tags) if isinstance(tags, (list, tuple, set, np.ndarray)) else [tags]
                chosen = tuple(_tag(tag) for tag in given)
                if not chosen:
                    raise ValueError("tags is empty: name the tags of facets that may touch, or give None for all")
                if len(set(chosen)) < len(chosen):
                    raise ValueError(f"tags has a tag twice: {list(chosen)}")
            coefficient = number("friction", friction)
            if coefficient < 0.0:
                raise ValueError(f"friction is {coefficient}: a coefficient of friction is zero or positive")
            self.pair = GeneralSurface(facet_tags, chosen, coefficient, name)

    def __repr__(self) -> str:
        which = "all outer facets" if self.pair.tags is None else f"tags {list(self.pair.tags)}"
        return f"GeneralContact({self.pair.name!r}: {which}, friction {self.pair.friction})"

    def _bind(self, problem: StaticContactProblem) -> StaticGeneral:
        return StaticGeneral(self.pair, problem)

    def _bind_explicit(self, problem: ExplicitContactProblem) -> GeneralOutput:
        return GeneralOutput(self.pair, problem)


def named_pairs(contacts: Sequence[Any]) -> list[ContactPair]:
    """Pairs of surfaces that a general contact of the same problem leaves alone.

    Args:
        contacts: contacts that a problem was given.

    Raises:
        ValueError: several contacts are general.
    """
    if sum(isinstance(c, GeneralContact) for c in contacts) > 1:
        raise ValueError("contact has several GeneralContact: give the tags of all surfaces that may touch to one")
    pairs = [getattr(c, "pair", None) for c in contacts]
    return [pair for pair in pairs if isinstance(pair, ContactPair) and not pair.rigid]
