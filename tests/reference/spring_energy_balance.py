# SPDX-License-Identifier: MIT
"""Energy balance of the spring of one node, docs/explicit/penalty.md, "Energy of the springs".

This is a second implementation: it takes roots of polynomials where the solvers have formulas.
"""

import numpy as np

ROUND_OFF = 1e-12


class SpringEnergyBalance:
    """Normal and tangential spring of a node.

    Args:
        k: stiffness [F/L].

    Attributes:
        normal_loss: energy that the normal force has taken since the start [F L].
        friction_loss: energy that the tangential force has dissipated since the start [F L].
    """

    def __init__(self, k):
        self.k, self.closed, self.N = k, False, 0.0
        self.e = self.q = self.normal_loss = self.friction_loss = 0.0

    def normal_force(self, g, gamma, delta):
        """Normal force of a step [F].

        Args:
            g: gap [L].
            gamma: change of the gap in the step [L].
            delta: overlap [L].
        """
        k, was_closed, self.closed = self.k, self.closed, delta > 0
        stored = self.N**2 / 2 / k
        if self.closed and not was_closed:
            stored = k / 2 * max(0, gamma - g) ** 2  # at the first step in contact
        a = self.e + stored - self.N * gamma / 2

        def left(N):
            return a - N * (gamma + N / k) / 2

        N = k * delta
        if left(N) < -ROUND_OFF * (stored + k * delta**2):
            roots = np.roots([-0.5 / k, -gamma / 2, a])
            N = (
                roots.max() if np.isreal(roots).all() else -k * gamma / 2
            )  # no force balances the energy: take the vertex
            N = min(max(N.real, 0), k * delta)
        if gamma > 0 and g + gamma > 0 and a - N * gamma < 0:
            N = max(0, a / gamma)
        self.normal_loss += left(N) - self.e
        self.e, self.N = left(N), N
        if not self.closed:
            self.e = min(0, self.e)
        return N

    def friction_force(self, t, previous, motion, bound=0.0):
        """Tangential force that does not add energy [F].

        Args:
            t: trial force inside the friction cone, shape (gdim) [F].
            previous: force of the previous step, rotated into the present tangential plane, shape (gdim) [F].
            motion: tangential motion of the step, shape (gdim) [L].
            bound: radius of the friction cone [F].
        """
        k, before = self.k, previous @ previous / 2 / self.k

        def left(t):
            return before - (previous + t) @ motion / 2 - t @ t / 2 / k

        if self.closed and self.q + left(t) < -ROUND_OFF * (2 * before / 2 + t @ t / k):
            # On the line through the centre and t, `left` is a parabola with its maximum at the centre.
            centre = -k / 2 * motion
            top, ray = self.q + left(centre), t - centre
            s = np.sqrt(max(0, top / (ray @ ray / 2 / k))) if ray @ ray else 1
            t = centre + min(1, s) * ray
            if np.linalg.norm(t) > bound:
                t = bound * t / np.linalg.norm(t)
        self.friction_loss += left(t)
        self.q = min(0, self.q + left(t))
        return t
