# SPDX-License-Identifier: MIT
"""Nodes that several contacts by multipliers have in common: joined, kept apart, or refused; docs/contact.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.types import BoolArray, FloatArray, IntArray
from ..nodal_sum import NodalSum

if TYPE_CHECKING:
    from .lagrange import LagrangeContact

# Normals of two pairs at a node agree within 30 degrees, as facets of one smooth surface do.
CREASE = np.cos(np.deg2rad(30.0))
SHOWN = 3  # places in a message


def connect(contacts: Sequence[Any]) -> bool:
    """Find the nodes that contacts by multipliers have in common, and join them where one constraint is meant.
    Collective.

    Args:
        contacts: all contacts of a problem.

    Returns:
        Whether nodes are left with constraints of several contacts, so that multipliers cannot be condensed.

    Raises:
        ValueError: two pairs have the same facets twice, or each has the other's slave for its master, or share slave
            nodes in a problem that cannot solve for them; on all ranks.
    """
    several: list[LagrangeContact] = [c for c in contacts if c.has_multipliers]
    if len(several) < 2:
        return False
    for k, a in enumerate(several):
        for b in several[k + 1 :]:
            _check_surfaces(a, b)
    chained = any([_chained(a, b) for a in several for b in several if a is not b])
    numbers, count, joined, apart = _number(several)
    sums = several[0].comm.allreduce(np.array([len(joined), len(apart)]))
    if chained or sums[0] or sums[1]:
        for contact in several:
            if not contact.may_share_nodes:
                raise ValueError(
                    f"{contact.pair.name} shares nodes with another contact by multipliers, the first at "
                    f"{_places(contact, np.concatenate([joined, apart]).astype(np.int64))}: rolling with friction "
                    "solves for contacts one by one; leave the common nodes out of one of the tags, or use Penalty "
                    "without friction"
                )
    if sums[0]:
        _join(several, numbers, count)
    if sums[1]:
        _tell_edges(several, numbers)
    return bool(chained or sums[1])


def over_constrained(contacts: Sequence[Any]) -> str:
    """A sentence about nodes that cannot fulfil the conditions of all their contacts, or an empty text. Collective.

    Args:
        contacts: contacts by multipliers.
    """
    sentences = []
    for contact in contacts:
        nodes = contact.over_constrained()
        number = contact.comm.allreduce(len(nodes))
        if not number:
            continue
        others = [
            c.pair.name
            for c in contacts
            if c is not contact and contact.comm.allreduce(int(np.any(np.isin(c.nodes, nodes))))
        ]
        sentences.append(
            f"{number} nodes, the first at {_places(contact, nodes)}, cannot fulfil the conditions of "
            f"{' and '.join([contact.pair.name, *others])} at once: leave them out of one of the tags, or free their "
            "supports"
        )
    return "; ".join(sentences)


def _join(contacts: Sequence[LagrangeContact], numbers: Sequence[IntArray], count: int) -> None:
    _cpp.multipliers.join([c.geometry for c in contacts], [n.astype(np.int32) for n in numbers], count)
    for k, contact in enumerate(contacts):
        contact.partners = [(other, contact.geometry.rows_in(i)) for i, other in enumerate(contacts) if i != k]


def _tell_edges(contacts: Sequence[LagrangeContact], numbers: Sequence[IntArray]) -> None:
    """Tell contacts which of their nodes others constrain along another normal."""
    for a, own in zip(contacts, numbers):
        for b, others in zip(contacts, numbers):
            _, mine, theirs = np.intersect1d(a.nodes, b.nodes, return_indices=True)
            apart = own[mine] != others[theirs]
            if a is not b and np.any(apart):
                a.edges.append((b, mine[apart], theirs[apart]))


def _number(contacts: Sequence[LagrangeContact]) -> tuple[list[IntArray], int, IntArray, IntArray]:
    """Number the slave nodes of this rank, those that are to be joined alike.

    Returns:
        Numbers of each contact's nodes; count of numbers; nodes that are joined; nodes with several constraints.
    """
    seen: dict[int, list[tuple[int, int, int]]] = {}  # node -> (contact, row, number)
    numbers: list[IntArray] = []
    count = 0
    joined: set[int] = set()
    apart: set[int] = set()
    size = int(max((int(c.nodes.max(initial=-1)) for c in contacts), default=-1)) + 1
    times = np.zeros(size, dtype=int)
    for c in contacts:
        times[c.nodes] += 1
    for k, c in enumerate(contacts):
        own = np.empty(len(c.nodes), dtype=np.int64)
        shared = times[c.nodes] > 1
        alone = int(np.count_nonzero(~shared))
        own[~shared] = count + np.arange(alone)
        count += alone
        for row in np.flatnonzero(shared):
            node = int(c.nodes[row])
            before = seen.setdefault(node, [])
            alike = [number for i, r, number in before if _agree(contacts[i], r, c, int(row))]
            own[row] = alike[0] if alike else count
            count += 0 if alike else 1
            (joined if alike else apart if before else set()).add(node)
            before.append((k, int(row), int(own[row])))
        numbers.append(own)
    return numbers, count, np.array(sorted(joined), dtype=np.int64), np.array(sorted(apart), dtype=np.int64)


def _agree(a: LagrangeContact, i: int, b: LagrangeContact, j: int) -> bool:
    """Is one constraint meant by those of two contacts at a node?"""
    if a.pair.rigid or b.pair.rigid:
        return a.pair.master is b.pair.master
    return bool(a.geometry.normal[i] @ b.geometry.normal[j] > CREASE)


def _chained(a: LagrangeContact, b: LagrangeContact) -> bool:
    """Do slave nodes of one contact lie on the master of another? Collective."""
    if b.geometry.master is None:
        return False
    total = NodalSum(b.geometry.index_map, 1)
    marks = np.zeros(total.num_nodes)
    marks[b.geometry.master.nodes.ravel()] = 1.0
    on_master = total(marks).ravel() > 0.0
    return bool(a.comm.allreduce(bool(np.any(on_master[a.nodes])), MPI.LOR))


def _check_surfaces(a: LagrangeContact, b: LagrangeContact) -> None:
    """Refuse pairs that constrain the same facets twice. Collective."""
    first, second = a.geometry, b.geometry
    same_slave = _common(a, first.slave, second.slave)
    if a.pair.rigid or b.pair.rigid:
        same_master = int(a.pair.master is b.pair.master)
    else:
        same_master = int(np.any(_common(a, first.master, second.master)[0]))
    if same_slave[0] and a.comm.allreduce(same_master, MPI.MAX):
        raise ValueError(
            f"{a.pair.name} and {b.pair.name} pair the same {same_slave[0]} slave facets with the same master twice, "
            f"the first at {same_slave[1]}: leave them out of one of the pairs"
        )
    crossed = _common(a, first.slave, second.master), _common(a, first.master, second.slave)
    if crossed[0][0] and crossed[1][0]:
        raise ValueError(
            f"{a.pair.name} and {b.pair.name}: the slave of each is the master of the other, on {crossed[0][0]} and "
            f"{crossed[1][0]} facets, the first at {crossed[0][1]}: multipliers would hold every point twice, which "
            "leaves the bodies no freedom; leave one of the two pairs out"
        )


def _common(contact: LagrangeContact, one: Any, other: Any) -> tuple[int, list[list[float]]]:
    """Number of facets that two surfaces have in common, and where the first of them are. Collective."""
    shared: BoolArray = np.zeros(0, dtype=bool)
    here: list[list[float]] = []
    if one is not None and other is not None:
        shared = np.isin(one.id, other.id)
        here = [X.mean(axis=0).round(9).tolist() for X in one.X[np.flatnonzero(shared)[:SHOWN]]]
    places = [place for found in contact.comm.allgather(here) for place in found][:SHOWN]
    return int(contact.comm.allreduce(int(np.count_nonzero(shared)))), places


def _places(contact: LagrangeContact, nodes: IntArray) -> list[list[float]]:
    """Reference positions of the first of some nodes, of all ranks. Collective."""
    here: FloatArray = contact.problem.space.tabulate_dof_coordinates()[nodes[:SHOWN], : contact.gdim]
    return [place for found in contact.comm.allgather(here.round(9).tolist()) for place in found][:SHOWN]
