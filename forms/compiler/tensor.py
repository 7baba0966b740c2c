# SPDX-License-Identifier: MIT
"""Sum factorisation on quadrilaterals and hexahedra.

A table of a Lagrange element at the points of a product rule is a product of 1D tables. FFCx's own option needs special
elements; here the factors are found for the ordinary ones, from the positions of nodes and points, and are verified
against the table before they are used.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

TOLERANCE = 1e-13  # of a table against the product of its factors: round-off of basis values of order one


def _axis(values):
    """Sorted distinct coordinates."""
    values = np.sort(values)
    return values[np.concatenate([[True], np.diff(values) > 1e-10])]


def grid_of_points(points):
    """1D coordinates of a product rule whose points run lexicographically, first coordinate slowest; or None."""
    points = np.asarray(points)
    if points.ndim != 2 or points.shape[1] < 2:
        return None
    axes = [_axis(points[:, a]) for a in range(points.shape[1])]
    if any(len(a) != len(axes[0]) for a in axes) or np.prod([len(a) for a in axes]) != len(points):
        return None
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(len(points), -1)
    return axes[0] if np.allclose(grid, points, atol=1e-12, rtol=0) else None


@dataclass(frozen=True)
class Factors:
    """1D tables and node numbering of a scalar Lagrange element on a product rule."""

    num_points: int  # per direction
    num_nodes: int  # per direction
    node: tuple  # element dof of lattice node (i0, i1, ...), flattened lexicographically
    tables: tuple  # (values, derivatives), each num_points x num_nodes as nested tuples

    def table(self, derivative):
        return np.array(self.tables[derivative])

    def unit(self, derivatives):
        """Factor that sum factorisation leaves out, for these derivative counts.

        With one point, at the centre of a linear element, tables have one magnitude: transforms by their signs alone
        add and subtract, and their results are multiplied once.
        """
        return float(np.prod([self._magnitude(d) for d in derivatives]))

    def unit_table(self, derivative):
        """1D table without that factor."""
        return self.table(derivative) / self._magnitude(derivative)

    def _magnitude(self, derivative):
        sizes = np.abs(self.table(derivative))
        return sizes[0, 0] if self.num_points == 1 and np.all(sizes == sizes[0, 0]) and sizes[0, 0] > 0 else 1.0

    def constant(self, derivative):
        """Is the 1D table the same at every point (the derivative of a linear function)?"""
        t = self.table(derivative)
        return self.num_points > 1 and bool(np.all(np.abs(t - t[0]) < TOLERANCE))


def _lagrange(nodes, x, derivative):
    n = len(nodes)
    out = np.zeros((len(x), n))
    for i in range(n):
        p = np.poly1d([1.0])
        for j in range(n):
            if j != i:
                p *= np.poly1d([1.0, -nodes[j]]) / (nodes[i] - nodes[j])
        out[:, i] = (p.deriv() if derivative else p)(x)
    out[np.abs(out) < 1e-15] = 0.0
    return out


def factors(element, rule_points):
    """Factors of a (blocked or scalar) Lagrange element on a product rule, or None."""
    x = grid_of_points(rule_points)
    if x is None:
        return None
    scalar = element.sub_elements[0] if element.block_size > 1 else element
    if getattr(scalar, "family_name", "") != "P" or scalar.embedded_superdegree < 1:
        return None
    try:
        basix_element = scalar.basix_element
    except (AttributeError, NotImplementedError):  # mixed elements have none
        return None
    return _factors(basix_element.points.tobytes(), basix_element.points.shape, x.tobytes())


@lru_cache(maxsize=None)
def _factors(nodes, shape, x):
    nodes, x = np.frombuffer(nodes).reshape(shape), np.frombuffer(x)
    axes = [_axis(nodes[:, a]) for a in range(shape[1])]
    n = len(axes[0])
    if any(len(a) != n or not np.allclose(a, axes[0]) for a in axes) or n ** shape[1] != len(nodes):
        return None
    if len(x) == 1 and n > 2:  # at the centre, tables of degree 2 are mostly zeros
        return None
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(len(nodes), -1)
    order = tuple(int(np.argmin(np.abs(nodes - p).sum(axis=1))) for p in grid)
    if len(set(order)) != len(order):
        return None
    tables = tuple(tuple(map(tuple, _lagrange(axes[0], x, d))) for d in (0, 1))
    return Factors(len(x), n, order, tables)


def matches(factor, derivatives, table):
    """Does the product of the 1D tables give `table` (num_points x num_dofs) for these derivative counts?"""
    if max(derivatives) > 1:
        return False
    product = np.ones((1, 1))
    for d in derivatives:
        product = np.kron(product, factor.table(d))
    if product.shape != table.shape:
        return False
    return bool(np.max(np.abs(product - table[:, list(factor.node)])) < TOLERANCE)


def reduce_columns(table):
    """Write a table as basis times reduction: table = basis @ reduction, reduction with entries 0, 1, -1 only.

    Columns that are zero drop out and columns that are sums or differences of two others are expressed by them, so that
    fewer products are made per point. Args: table (num_points, num_dofs). Returns (basis, reduction).
    """
    return _reduced(np.asarray(table, dtype=float).tobytes(), table.shape)


@lru_cache(maxsize=512)
def _reduced(content, shape):
    table = np.frombuffer(content).reshape(shape)
    num_points, num_dofs = shape
    basis, combinations = np.empty((num_points, 0)), []
    for j, column in enumerate(table.T):
        if np.max(np.abs(column)) < TOLERANCE:
            continue
        found = _as_one_column(basis, column) or _as_two_columns(basis, column)
        if not found:
            found = {basis.shape[1]: 1.0}
            basis = np.column_stack((basis, column))
        combinations.append((j, found))
    reduction = np.zeros((basis.shape[1], num_dofs))
    for j, combination in combinations:
        for a, sign in combination.items():
            reduction[a, j] = sign
    return basis, reduction


SIGNS = np.array([1.0, -1.0])


def _as_one_column(basis, column):
    """{number: sign} of the last column of a basis that is the given one but for its sign, or {}."""
    differences = SIGNS * basis[:, :, None] - column[:, None, None]
    equal = np.argwhere(np.max(np.abs(differences), axis=0, initial=0.0) < TOLERANCE)
    return {int(a): float(SIGNS[s]) for a, s in equal[-1:]}


def _as_two_columns(basis, column):
    """{number: sign} of the first two columns of a basis whose sum or difference is the given one, or {}.

    Most pairs are ruled out by one point, the one where the column is largest.
    """
    largest = np.argmax(np.abs(column))
    signed = np.multiply.outer(basis[largest], SIGNS)  # column, sign
    sums = signed[:, None, :, None] + signed[None, :, None, :]  # of columns a and b, by their signs
    pairs = np.argwhere(np.abs(sums - column[largest]) < TOLERANCE)
    a, b, s, t = pairs[pairs[:, 1] < pairs[:, 0]].T
    differences = SIGNS[s] * basis[:, a] + SIGNS[t] * basis[:, b] - column[:, None]
    equal = np.flatnonzero(np.max(np.abs(differences), axis=0) < TOLERANCE)
    return {int(n[k]): float(SIGNS[sign[k]]) for k in equal[:1] for n, sign in ((a, s), (b, t))}


def split_rows(basis):
    """Write a table as a row that all points share plus one entry of its own per point, where it has that form.

    On simplices with symmetric rules (three points on triangles, four on tetrahedra) the derivatives of degree 2 do: a
    product per point is left instead of one per point and column.

    Args:
        basis: shape (num_points, num_columns).

    Returns:
        (shared row, column of each point's own entry, what it adds there), or None.
    """
    num_points, num_columns = basis.shape
    if num_points < 3 or num_columns < 2:
        return None
    shared = np.empty(num_columns)
    for j in range(num_columns):
        counts = [np.sum(np.abs(basis[:, j] - x) < TOLERANCE) for x in basis[:, j]]
        shared[j] = basis[int(np.argmax(counts)), j]
    own = np.abs(basis - shared) > TOLERANCE
    if not np.all(own.sum(axis=1) == 1):
        return None
    columns = np.argmax(own, axis=1)
    return shared, columns, basis[np.arange(num_points), columns] - shared[columns]
