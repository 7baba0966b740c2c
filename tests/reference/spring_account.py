# SPDX-License-Identifier: MIT
"""The accounts of one node's spring, docs/explicit/penalty.md, "Energy of the springs", written once more: roots of
polynomials in place of formulas."""

import numpy as np

ROUND_OFF = 1e-12


class SpringAccount:
    """A node of the stiffness k. taken, dissipated: what its normal and its tangential force have taken since the
    start."""

    def __init__(self, k):
        self.k, self.closed, self.N = k, False, 0.0
        self.e = self.q = self.taken = self.dissipated = 0.0

    def press(self, g, gamma, delta):
        """The normal force at the gap g, after the gap has changed by gamma; delta: the overlap."""
        k, was_closed, self.closed = self.k, self.closed, delta > 0
        stored = self.N**2 / 2 / k
        if self.closed and not was_closed:
            stored = k / 2 * max(0, gamma - g) ** 2  # as it is when seen first
        a = self.e + stored - self.N * gamma / 2

        def left(N):
            return a - N * (gamma + N / k) / 2

        N = k * delta
        if left(N) < -ROUND_OFF * (stored + k * delta**2):
            roots = np.roots([-0.5 / k, -gamma / 2, a])
            N = roots.max() if np.isreal(roots).all() else -k * gamma / 2  # no force leaves nothing owed: the vertex
            N = min(max(N.real, 0), k * delta)
        if gamma > 0 and g + gamma > 0 and a - N * gamma < 0:
            N = max(0, a / gamma)
        self.taken += left(N) - self.e
        self.e, self.N = left(N), N
        if not self.closed:
            self.e = min(0, self.e)
        return N

    def rub(self, t, turned, way, bound=0.0):
        """The tangential force that leaves nothing owed; t: within the cone, turned: that of the step before in the
        present tangential plane, way: the tangential motion, bound: of the cone."""
        k, before = self.k, turned @ turned / 2 / self.k

        def left(t):
            return before - (turned + t) @ way / 2 - t @ t / 2 / k

        if self.closed and self.q + left(t) < -ROUND_OFF * (2 * before / 2 + t @ t / k):
            # On the line from the centre to t, left is a parabola with its top there.
            centre = -k / 2 * way
            top, ray = self.q + left(centre), t - centre
            s = np.sqrt(max(0, top / (ray @ ray / 2 / k))) if ray @ ray else 1
            t = centre + min(1, s) * ray
            if np.linalg.norm(t) > bound:
                t = bound * t / np.linalg.norm(t)
        self.dissipated += left(t)
        self.q = min(0, self.q + left(t))
        return t
