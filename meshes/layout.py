# SPDX-License-Identifier: MIT
"""Block layouts: what a recipe returns. Points with cell sizes, arcs, four- or eight-cornered blocks; no gmsh in here.

A block is a quadrilateral (2D) or a hexahedron (3D) given by its corners; opposite edges have the same number of cells,
and that number follows from the sizes asked for at the points. Bodies do not share nodes unless they are glued.
"""

import math

import numpy as np

HEX_FACES = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def require(condition, message):
    """Raise ValueError(message) unless the condition holds."""
    if not condition:
        raise ValueError(message)


def positive(**values):
    """Raise ValueError for the first value that is not a finite number above zero."""
    for name, value in values.items():
        try:
            good = math.isfinite(value) and value > 0
        except TypeError:
            good = False
        require(good, f"{name} = {value!r}: a finite number above zero is needed")


def count(**values):
    """Raise ValueError for the first value that is not a whole number of at least one."""
    for name, value in values.items():
        good = isinstance(value, (int, np.integer)) and not isinstance(value, bool) and value >= 1
        require(good, f"{name} = {value!r}: a whole number of at least 1 is needed")


def axis_cells(length, first, last):
    """Number of cells on an edge whose cell size goes linearly from `first` to `last`."""
    if abs(first - last) < 1e-9 * max(first, last):
        cells = length / first
    else:
        cells = length * math.log(last / first) / (last - first)
    return max(1, math.ceil(cells - 1e-6))


def between(a, b):
    """Size of free simplices where the plan asks for a and the extrusion for b: nearer to the larger of the two."""
    return max(a, b) ** 0.75 * min(a, b) ** 0.25


def at(axis, value, tolerance=1e-9):
    """A predicate: every corner of the facet has coordinate `axis` equal to `value`."""
    return lambda corners: bool(np.all(np.abs(corners[:, axis] - value) <= tolerance * max(1.0, abs(value))))


class Body:
    """One body of a layout: its blocks and, in order of precedence, the names of its outer facets."""

    def __init__(self, layout, name, nodes):
        self.layout, self.name, self.nodes = layout, name, nodes
        self.blocks, self.rules, self.maps = [], [], []

    def point(self, x, size):
        """Point at x with cell size `size`; the same coordinates give the same point, with the smaller size."""
        layout = self.layout
        x = tuple(float(v) for v in x)
        assert len(x) == layout.dim
        key = (self.nodes, tuple(round(v / layout.tolerance) for v in x))
        index = layout.index.setdefault(key, len(layout.points))
        if index == len(layout.points):
            layout.points.append(np.array(x))
            layout.sizes.append(float(size))
        layout.sizes[index] = min(layout.sizes[index], float(size))
        return index

    def arc(self, p, q, centre):
        """Make the edge from p to q an arc (less than half a turn) about `centre`."""
        self.layout.arcs[frozenset((p, q))] = np.array(centre, dtype=float)

    def block(self, *corners):
        """Add a block: four corners around a quadrilateral, or the lower four then the upper four of a hexahedron."""
        assert len(corners) == 2 ** self.layout.dim and len(set(corners)) == len(corners)
        self.blocks.append(tuple(corners))

    def tag(self, name, predicate=lambda corners: True):
        """Name the outer facets whose corners satisfy the predicate; the first rule that fits wins."""
        self.rules.append((name, predicate))

    def facet(self, name, *corners):
        """Name one facet by its corners."""
        self.layout.named[frozenset(corners)] = name

    def map(self, function, straight=False):
        """Move all nodes of the body by x -> function(x), arrays of shape (n, 3); `straight`: vertices only."""
        self.maps.append((function, straight))


class Layout:
    """Bodies made of blocks.

    `structured`: simplices, too, follow the blocks; `snap`: facet name -> map of its nodes onto the true surface;
    `made_of`: names of the cells it may be made of, None for all.
    """

    def __init__(self, dim, scale, structured=False):
        self.dim, self.structured = dim, structured
        self.tolerance = 1e-9 * scale
        self.points, self.sizes, self.index = [], [], {}
        self.arcs, self.spheres, self.cells, self.named, self.edge_sizes, self.snap = {}, {}, {}, {}, {}, {}
        self.bodies, self.made_of = [], None

    def body(self, name, glued_to=None):
        """New body; `glued_to` another one it shares the nodes at equal places with."""
        self.bodies.append(Body(self, name, len(self.bodies) if glued_to is None else glued_to.nodes))
        return self.bodies[-1]

    def facets_of(self, block):
        """Corner tuples of a block's facets, each in order around the facet."""
        if self.dim == 2:
            return [(block[i], block[(i + 1) % 4]) for i in range(4)]
        return [tuple(block[i] for i in face) for face in HEX_FACES]

    def faces_of(self, block):
        """Corner tuples of the quadrilateral faces of a block (itself, in 2D)."""
        return [block] if self.dim == 2 else self.facets_of(block)

    def edge_length(self, p, q):
        """Length of an edge, along its arc if it has one."""
        a, b = self.points[p], self.points[q]
        centre = self.arcs.get(frozenset((p, q)))
        chord = float(np.linalg.norm(b - a))
        if centre is None:
            return chord
        radius = float(np.linalg.norm(a - centre))
        assert abs(np.linalg.norm(b - centre) - radius) < 1e-6 * radius, f"points {a}, {b}: no circle about {centre}"
        return 2 * radius * math.asin(min(1.0, chord / (2 * radius)))

    def divisions(self):
        """(number of cells, size at the lower point, size at the higher point) of each edge (lower, higher)."""
        parent = {}

        def find(edge):
            parent.setdefault(edge, edge)
            while parent[edge] != edge:
                parent[edge] = parent[parent[edge]]
                edge = parent[edge]
            return edge

        for body in self.bodies:
            for block in body.blocks:
                for a, b, c, d in self.faces_of(block):
                    for (p, q), (r, s) in (((a, b), (d, c)), ((b, c), (a, d))):
                        parent[find((min(p, q), max(p, q)))] = find((min(r, s), max(r, s)))
        sizes = {e: self.edge_sizes.get(e, (self.sizes[e[0]], self.sizes[e[1]])) for e in parent}
        number = {}
        for edge in sorted(parent):
            root, wanted = find(edge), axis_cells(self.edge_length(*edge), *sizes[edge])
            number[root] = max(number.get(root, 1), wanted)
        for edge, wanted in self.cells.items():
            number[find(edge)] = wanted
        return {edge: (number[find(edge)], *sizes[edge]) for edge in sorted(parent)}

    def set_cells(self, p, q, number):
        """Fix the number of cells on the edge (and so on all edges opposite to it), of equal size."""
        edge = (min(p, q), max(p, q))
        self.cells[edge] = int(number)

    def outer_facets(self):
        """Name -> list of corner tuples, over the facets that belong to one block only."""
        owners = {}
        for body in self.bodies:
            for block in body.blocks:
                for corners in self.facets_of(block):
                    owners.setdefault(frozenset(corners), []).append((body, corners))
        names = {}
        for key, where in owners.items():
            if len(where) > 1:
                continue
            body, corners = where[0]
            name = self.named.get(key)
            if name is None:
                x = np.array([self.points[p] for p in corners])
                name = next((rule for rule, predicate in body.rules if predicate(x)), "free")
            names.setdefault(name, []).append(corners)
        return names

    def extruded(self, place, levels, sizes, ends=("front", "back")):
        """3D layout: this plan at every level, place(plan point, level) -> 3D point, cells of size `sizes` there.

        `ends` are the names of the first and last face, or a function of the body giving them.
        """
        assert self.dim == 2 and len(levels) == len(sizes) >= 2
        out = Layout(3, self.tolerance * 1e9, self.structured)
        names = {frozenset(c): name for name, facets in self.outer_facets().items() for c in facets}
        plan_sizes = {e: (a, b) for e, (_, a, b) in self.divisions().items()}
        copies = []
        for body in self.bodies:
            copies.append(Body(out, body.name, body.nodes))
            new = {}
            for p in {p for block in body.blocks for p in block}:
                new[p] = [
                    copies[-1].point(place(self.points[p], t), between(self.sizes[p], s)) for t, s in zip(levels, sizes)
                ]
                for k in range(len(levels) - 1):
                    out.edge_sizes[(new[p][k], new[p][k + 1])] = (sizes[k], sizes[k + 1])
            for block in body.blocks:
                first, last = ends(body.name) if callable(ends) else ends
                copies[-1].facet(first, *(new[p][0] for p in block))
                copies[-1].facet(last, *(new[p][-1] for p in block))
                for k in range(len(levels) - 1):
                    copies[-1].block(*(new[p][k] for p in block), *(new[p][k + 1] for p in block))
                for p, q in self.facets_of(block):
                    edge, (a, b) = frozenset((p, q)), plan_sizes[(min(p, q), max(p, q))]
                    for k, t in enumerate(levels):
                        pair = (new[min(p, q)][k], new[max(p, q)][k])
                        out.edge_sizes[(min(pair), max(pair))] = (a, b) if pair[0] < pair[1] else (b, a)
                        if edge in self.arcs:
                            copies[-1].arc(*pair, place(self.arcs[edge], t))
                        if (min(p, q), max(p, q)) in self.cells:
                            out.cells[(min(pair), max(pair))] = self.cells[(min(p, q), max(p, q))]
                        if k and edge in names:
                            copies[-1].facet(names[edge], new[p][k], new[q][k], new[p][k - 1], new[q][k - 1])
        out.bodies = copies
        return out

    def merge(self, other, glued=False):
        """Add the bodies of another layout of the same dimension, with their own nodes or `glued` to those here."""
        assert self.dim == other.dim
        new, first = {}, len(self.bodies)
        for body in other.bodies:
            # Bodies that share nodes in the other layout share them here.
            nodes = self.bodies[0].nodes if glued else first + body.nodes
            copy = Body(self, body.name, nodes)
            copy.rules, copy.maps = list(body.rules), list(body.maps)
            self.bodies.append(copy)
            for block in body.blocks:
                for p in block:
                    new[p] = copy.point(other.points[p], other.sizes[p])
                copy.block(*(new[p] for p in block))
        for mine, theirs in ((self.arcs, other.arcs), (self.spheres, other.spheres), (self.named, other.named)):
            for key, value in theirs.items():
                mine[frozenset(new[p] for p in key)] = value
        for (p, q), number in other.cells.items():
            self.set_cells(new[p], new[q], number)
        for (p, q), sizes in other.edge_sizes.items():
            p, q, sizes = (new[p], new[q], sizes) if new[p] < new[q] else (new[q], new[p], sizes[::-1])
            self.edge_sizes[(p, q)] = sizes
