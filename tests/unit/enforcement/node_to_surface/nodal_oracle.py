# SPDX-License-Identifier: MIT
"""Penalty contact in plain NumPy from docs/explicit/penalty.md, node by node; closest points by a full search."""

import numpy as np

from dolfinx_impact import _cpp

SHARES = {  # of a facet's area, degree 2: integrals of squared shape functions
    "interval": [1 / 6, 1 / 6, 2 / 3],
    "triangle": [1 / 19] * 3 + [16 / 57] * 3,
    "quadrilateral": [1 / 36] * 4 + [1 / 9] * 4 + [4 / 9],
}


def gauss(shape):
    x, w = np.polynomial.legendre.leggauss(5)
    x, w = (x + 1) / 2, w / 2
    if shape == "interval":
        return [(p, 0.0) for p in x], w
    points, weights = [(p, q) for p in x for q in x], [a * b for a in w for b in w]
    if shape == "triangle":  # collapsed
        weights = [v * (1 - p) for v, (p, q) in zip(weights, points)]
        points = [(p, q * (1 - p)) for p, q in points]
    return points, weights


def areas(facets, num):
    """Nodal areas on the reference configuration: facets.x = X."""
    out, e = np.zeros(num), facets.displacement
    points, weights = gauss(e.shape)
    for f in range(facets.size):
        for p, w in zip(points, weights):
            area = w * facets.evaluate(f, *p)[6]
            share = e.tabulate(*p)[0] if e.degree == 1 else np.array(SHARES[e.shape])
            np.add.at(out, facets.nodes[f], area * share)
    return out


def node_normals(facets, num, dim):
    out = np.zeros((num, dim))
    for f in range(facets.size):
        for i, node in enumerate(facets.nodes[f]):
            out[node] += facets.evaluate(f, *facets.displacement.node(i))[3 : 3 + dim]
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)


SIDES = {  # of a facet: corners, and whether a point of the facet is on it
    "interval": [((0,), lambda a, b: a), ((1,), lambda a, b: 1 - a)],
    "triangle": [((0, 1), lambda a, b: b), ((0, 2), lambda a, b: a), ((1, 2), lambda a, b: 1 - a - b)],
    "quadrilateral": [
        ((0, 1), lambda a, b: b), ((0, 2), lambda a, b: a), ((1, 3), lambda a, b: 1 - a), ((2, 3), lambda a, b: 1 - b)
    ],
}  # fmt: skip


def rim(facets):
    """Sides, as sets of nodes, that one facet only has."""
    sides = [frozenset(nodes[list(c)]) for nodes in facets.nodes for c, _ in SIDES[facets.displacement.shape]]
    return {side for side in sides if sides.count(side) == 1}


def width(facets, f, X):
    """Longest way between corners of a facet."""
    corners = X[facets.nodes[f][: {"interval": 2, "triangle": 3, "quadrilateral": 4}[facets.displacement.shape]]]
    return max(np.linalg.norm(a - b) for a in corners for b in corners)


def closest(facets, X, x, normals, reach):
    """A full search, and the rule at the rim (docs/explicit/penalty.md, "At the rim"); beside: farther than that."""
    p = _cpp.search.SurfaceSearch(facets).project(np.ascontiguousarray(x), np.ascontiguousarray(normals), reach)
    ends, dim = rim(facets), x.shape[1]
    corners = set().union(*ends)
    p["beside"], p["below"] = np.zeros((2, len(x)), dtype=bool)
    for q in range(len(x)):
        f, xi = int(p["facet"][q]), p["xi"][q]
        if f < 0:
            continue
        a, b = xi[0], xi[1] if len(xi) > 1 else 0.0
        on = [facets.nodes[f][list(c)] for c, far in SIDES[facets.displacement.shape] if abs(far(a, b)) < 1e-12]
        shared = set(on[0]).intersection(*on[1:]) if on else set()
        if not on or (frozenset(on[0]) not in ends if len(on) == 1 else not shared & corners):
            continue
        at = facets.evaluate(f, a, b)
        d, n = x[q] - at[:dim], at[3 : 3 + dim]
        depth = d @ n
        if d @ d - depth**2 < (0.05 * width(facets, f, X)) ** 2:
            p["gap"][q], p["normal"][q] = depth, n
        else:
            p["beside"][q], p["below"][q] = True, depth < 0
    return p


def mean_overlap(g, r, beside):
    """Integral of max(-g, 0) over gaps from g - |r|/2 to g + |r|/2, by |r|; none where g >= 0 beside the rim."""
    if g >= 0 and beside:
        return 0.0
    ends = np.minimum([g - abs(r) / 2, g + abs(r) / 2], 0.0)
    return (ends[0] ** 2 - ends[1] ** 2) / (2 * abs(r)) if abs(r) > 1e-9 * abs(g) else max(-g, 0.0)


class Oracle:
    """Of a Nodal model on one rank; facets are those it was made of."""

    def __init__(self, model, slave, master, friction=0.0, kappa=0.5, penalty=0.0, reach=None):
        self.model, self.slave, self.master, self.dim = model, slave, master, model.dim
        self.friction, self.kappa, self.penalty = friction, kappa, penalty
        zero = np.zeros(model.num * self.dim)
        slave.move(zero), master.move(zero)
        self.A, self.A_master = areas(slave, model.num), areas(master, model.num)
        self.nodes = np.unique(slave.nodes)
        self.t = np.zeros((model.num, self.dim))
        self.slip = np.zeros((model.num, self.dim))
        self.closed = np.zeros(model.num, dtype=bool)
        self.barred = np.zeros(model.num, dtype=bool)  # below the surface, from beside the rim
        self.reach = reach or model.contact.search_distance
        self.dissipated = self.lost = 0.0
        self.springs = {i: Spring(self.dim) for i in self.nodes}

    def project(self, u):
        self.slave.move(u.reshape(-1)), self.master.move(u.reshape(-1))
        normals = node_normals(self.slave, self.model.num, self.dim)[self.nodes]
        x = (self.model.x + u)[self.nodes]
        return x, closest(self.master, self.model.x, x, normals, self.reach)

    def forces(self, u, du):
        x, p = self.project(u)
        self.gap = p["gap"]
        m, dt, A = self.model.mass_owned, self.model.dt, self.A
        f, self.stored, self.k = np.zeros_like(u), 0.0, np.zeros(len(self.nodes))
        for q, i in enumerate(self.nodes):
            g, n = p["gap"][q], p["normal"][q]
            overlap, spring = 0.0, self.springs[i]
            if p["facet"][q] >= 0:
                masters = self.master.nodes[p["facet"][q]]
                phi = self.master.displacement.tabulate(*p["xi"][q])[0]
                step = du[i] - phi @ du[masters]
                r = n @ step
                turning = carried((self.model.x + u)[masters], x[q], phi, du[masters]) if self.friction > 0 else 0.0
                overlap = mean_overlap(g, r, p["beside"][q])
            self.barred[i] = p["below"][q] or (self.barred[i] and g < 0)
            begins = not self.closed[i]
            if not overlap > 0 or self.barred[i]:
                if not begins:  # a node that has not come out through the surface loses what is stored
                    through = p["facet"][q] >= 0 and not self.barred[i]
                    n = n if through else np.zeros(self.dim)
                    change, step = (
                        (moved(g, spring.gap, step), across(step - turning, n))
                        if through
                        else (0.0, np.zeros(self.dim))
                    )
                    self.lost += spring.leave(change)
                    self.dissipated += spring.leave_friction(turn(self.t[i], n), step)
                self.t[i], self.slip[i], self.closed[i] = 0.0, 0.0, False
                continue
            compliance = 1 / m[i] + sum(abs(phi) * (1 + self.A_master[masters] / A[i]) / m[masters])
            k = self.kappa / dt**2 / compliance if self.penalty == 0 else self.penalty * A[i]
            self.k[q] = k
            if begins:
                spring.begin(k, g, r)
            self.lost += spring.push(k * overlap, k, g, r if begins else moved(g, spring.gap, step))
            force = spring.force * n
            if self.friction > 0:
                slides = across(step - turning, n)
                way = np.sort([g - r, g])
                psi = float(g < 0) if r == 0 else np.diff(np.minimum(way, 0.0))[0] / abs(r)
                turned, limit = turn(self.t[i], n), self.friction * spring.force
                t = trial = turned - k * psi * slides
                t = cut(t, limit)
                t, taken = spring.rub(t, turned, slides, limit)
                self.dissipated += taken
                if not np.allclose(t, trial, rtol=1e-11, atol=0.0):
                    self.slip[i] += psi * slides + (t - turned) / k
                self.t[i] = t
                force = force + t
            self.closed[i] = True
            self.stored += spring.stored + spring.tangential_stored
            f[i] += force
            np.add.at(f, masters, -np.outer(phi, force))
            f[masters] += couple((self.model.x + u)[masters], x[q], phi, force)
        return f


def across(v, n):
    return v - n * (n @ v)


def carried(masters, x, phi, du):
    """How much more x moves than the point on the facet if it turns with the facet's nodes, by least squares."""
    dim = masters.shape[1]
    r = masters - masters.mean(axis=0)
    spins = [np.array([[-a[1]], [a[0]]]) if dim == 2 else np.cross(np.eye(3), a).T for a in r]  # x a
    spin = np.linalg.lstsq(np.vstack(spins), (du - du.mean(axis=0)).reshape(-1), rcond=None)[0]
    lever = x - phi @ masters
    return spin[0] * np.array([-lever[1], lever[0]]) if dim == 2 else np.cross(spin, lever)


def turn(t, n):
    """Into the plane across n, of the same size."""
    flat = t - n * (n @ t)
    return flat * np.linalg.norm(t) / np.linalg.norm(flat) if np.any(flat) else flat


def cut(t, limit):
    size = np.linalg.norm(t)
    return t * (limit / size) if size > limit else t


def moved(gap, before, step):
    """Change of the gap; where it is more than the motion could bring, another facet is the nearest now."""
    way = 2 * np.linalg.norm(step)
    return np.clip(gap - before, -way, way)


class Spring:
    """Energies of a node's spring, found by bisection where the code has the solution of a quadratic equation."""

    def __init__(self, dim):
        self.force = self.stored = self.tangential_stored = self.surplus = self.owed = 0.0
        self.k, self.gap, self.last = 1.0, 0.0, np.zeros(dim)

    def begin(self, k, g, r):
        self.force, self.stored, self.tangential_stored = 0.0, k * max(0.0, r - g) ** 2 / 2, 0.0

    def left(self, force, k, change):
        """Surplus with this force."""
        return self.surplus + self.stored - force**2 / (2 * k) - (self.force + force) / 2 * change

    def push(self, wanted, k, g, change):
        """Takes the force of the step; returns what it dissipates."""
        low, force = 0.0, wanted
        best = np.clip(-k * change / 2, 0.0, wanted)  # leaves most
        if self.left(wanted, k, change) < -1e-12 * (self.stored + wanted**2 / k):
            low, high = best, wanted
            if self.left(best, k, change) < 0:
                high = best
            for _ in range(200):
                middle = (low + high) / 2
                low, high = (middle, high) if self.left(middle, k, change) >= 0 else (low, middle)
            force = high
        if change > 0 and g + change > 0:  # both halves of its work, if it opens in the next step
            force = min(force, max(0.0, self.surplus + self.stored - self.force * change / 2) / change)
        before, self.surplus = self.surplus, self.left(force, k, change)
        self.force, self.stored, self.k, self.gap = force, force**2 / (2 * k), k, g
        return self.surplus - before

    def leave(self, change):
        left = self.left(0.0, 1.0, change)
        before, self.surplus, self.force, self.stored = self.surplus, min(left, 0.0), 0.0, 0.0
        return left - before

    def rub(self, t, turned, motion, limit):
        """The tangential force and what it dissipates."""
        k = self.k

        def taken(t):
            return self.tangential_stored - t @ t / (2 * k) - (turned + t) @ motion / 2

        if self.owed + taken(t) < -1e-12 * (self.tangential_stored + t @ t / k):
            center = -k * motion / 2
            room = center @ center + 2 * k * (self.owed + self.tangential_stored - turned @ motion / 2)
            t = cut(center + cut(t - center, np.sqrt(max(room, 0.0))), limit)
        dissipated, self.tangential_stored = taken(t), t @ t / (2 * k)
        self.owed = min(0.0, self.owed + dissipated)
        return t, dissipated

    def leave_friction(self, turned, motion):
        dissipated, self.tangential_stored = self.tangential_stored - turned @ motion / 2, 0.0
        self.owed = min(0.0, self.owed + dissipated)
        return dissipated


def couple(masters, x, phi, force):
    """The smallest forces on masters without resultant that give back the moment of `force` at x and its reaction."""
    dim, num = masters.shape[1], len(masters)
    r = masters - masters.mean(axis=0)
    turn = [np.array([[-a[1], a[0]]]) if dim == 2 else np.cross(a, np.eye(3)).T for a in r]  # a x
    lever = phi @ masters - x
    moment = np.array([[-lever[1], lever[0]]]) @ force if dim == 2 else np.cross(lever, force)
    rows = [np.kron(np.ones(num), np.eye(dim)), np.hstack(turn)]
    return np.linalg.lstsq(np.vstack(rows), np.concatenate([np.zeros(dim), moment]))[0].reshape(num, dim)
