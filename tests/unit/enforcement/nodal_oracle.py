"""Penalty contact of nodes in plain NumPy from docs/explicit.md, node by node; closest points by a full search."""

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
    """A full search, and the rule for nodes just beside the rim (docs/explicit.md); beside: farther than that."""
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
        self.dissipated = 0.0

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
            overlap = 0.0
            if p["facet"][q] >= 0:
                masters = self.master.nodes[p["facet"][q]]
                phi = self.master.displacement.tabulate(*p["xi"][q])[0]
                step = du[i] - phi @ du[masters]
                r = n @ step
                overlap = mean_overlap(g, r, p["beside"][q])
            self.barred[i] = p["below"][q] or (self.barred[i] and g < 0)
            if not overlap > 0 or self.barred[i]:
                self.t[i], self.slip[i], self.closed[i] = 0.0, 0.0, False
                continue
            compliance = 1 / m[i] + sum(abs(phi) * (1 + self.A_master[masters] / A[i]) / m[masters])
            k = self.kappa / dt**2 / compliance if self.penalty == 0 else self.penalty * A[i]
            self.k[q] = k
            force = k * overlap * n
            if self.friction > 0:
                P = np.eye(self.dim) - np.outer(n, n)
                way = np.sort([g - r, g])
                psi = float(g < 0) if r == 0 else np.diff(np.minimum(way, 0.0))[0] / abs(r)
                step = psi * P @ step
                turned = P @ self.t[i]
                if np.any(turned):
                    turned *= np.linalg.norm(self.t[i]) / np.linalg.norm(turned)
                t = turned - k * step
                limit = self.friction * k * overlap
                if np.linalg.norm(t) > limit:
                    t *= limit / np.linalg.norm(t)
                    slip = step + (t - turned) / k
                    self.slip[i] += slip
                    self.dissipated += np.linalg.norm(t) * np.linalg.norm(slip)
                self.t[i] = t
                force = force + t
                self.stored += t @ t / k / 2
            self.closed[i] = True
            self.stored += k * overlap**2 / 2
            f[i] += force
            np.add.at(f, masters, -np.outer(phi, force))
            f[masters] += couple((self.model.x + u)[masters], x[q], phi, force)
        return f


def couple(masters, x, phi, force):
    """The smallest forces on masters without resultant that give back the moment of `force` at x and its reaction."""
    dim, num = masters.shape[1], len(masters)
    r = masters - masters.mean(axis=0)
    turn = [np.array([[-a[1], a[0]]]) if dim == 2 else np.cross(a, np.eye(3)).T for a in r]  # a x
    lever = phi @ masters - x
    moment = np.array([[-lever[1], lever[0]]]) @ force if dim == 2 else np.cross(lever, force)
    rows = [np.kron(np.ones(num), np.eye(dim)), np.hstack(turn)]
    return np.linalg.lstsq(np.vstack(rows), np.concatenate([np.zeros(dim), moment]))[0].reshape(num, dim)
