# SPDX-License-Identifier: MIT
"""Free rolling of rollers of different materials; Bentall and Johnson 1967."""

import math

import numpy as np
import pytest
from contact_model import Model, enforce
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat, meshes, theory

RADIUS, A, LOAD, SIZE = 50.0, 0.1, 16.20, 2.0  # mm, N/mm; SIZE of the blocks
ALUMINIUM, STEEL = (23e3, 0.31), (82e3, 0.28)  # shear moduli [MPa], Poisson's ratios


def young(body):
    return 2 * body[0] * (1 + body[1]), body[1]


def half_plane(x, depth, P, G, nu):
    """Displacements (n, 2) of a half-plane under P into it at the origin, plane strain; Flamant, Johnson 2.2.

    The second component is along the depth; it lacks a constant.
    """
    r2 = x**2 + depth**2
    along = x * depth / r2 - (1 - 2 * nu) * np.arctan2(x, depth)
    return P / (2 * math.pi * G) * np.column_stack([along, depth**2 / r2 - (1 - nu) * np.log(r2)])


class Rollers:
    """Two blocks, cut out of rollers around the path of the contact, rolled on each other by load steps.

    Seen from the contact at s, both surfaces are (x - s)^2/(2 R) = x^2/(2 R) - s x/R + s^2/(2 R): the outer sides turn
    by s/R and move by s^2/(2 R), and as the half-planes under the load at s do there. To first order the blocks turn
    without strain; what is left of second order is the same in both bodies. The upper one is shifted along x as well,
    in every step by as much as takes the tangential force away: rolling is free.

    Args:
        friction: coefficient [1]. h: of cells in the contact [L]. reach: from the middle, of the path [L].
        method: Penalty or Lagrange. coarse: cells along half a block's side where they are largest.
    """

    def __init__(self, friction, h, reach, method="Penalty", coarse=8, **options):
        block = dict(width=SIZE, height=SIZE, block_width=SIZE, block_height=SIZE, coarse=SIZE / coarse)
        recipe = meshes.make(
            "wedge", MPI.COMM_SELF, angle=math.pi / 2 - 1e-12, a=A, h=h, core=reach + 1.3 * A, symmetry="none", **block
        )
        self.bodies = {"slave_body": ALUMINIUM, "master_body": STEEL}
        law = {name: di.LinearElastic(*young(b), hypothesis="plane_strain") for name, b in self.bodies.items()}
        m = Model(recipe, law)
        x, cells = m.mesh.geometry.x, recipe.cell_tags.find(m.tags["slave_body"])
        upper = np.zeros(len(x), dtype=bool)
        upper[np.unique(compat.geometry_dofmap(m.mesh)[cells])] = True
        x[:, 1] += np.where(upper, 1, -1) * x[:, 0] ** 2 / (2 * RADIUS) * (1 - np.abs(x[:, 1]) / SIZE)
        self.far = fem.Function(m.V)
        self.sides = [self.outside(m, "slave_", "top"), self.outside(m, "", "bottom")]
        m.bcs += [fem.dirichletbc(self.far, nodes) for nodes in self.sides]
        self.x = m.V.tabulate_dof_coordinates()
        self.problem = m.problem(enforce(method, m.pair(friction=friction), **options))
        self.contact = self.problem.contact[0]
        # Under Hertz's pressure the mean of -ln |x| is 1/2 - ln(a/2): the middles of both surfaces meet.
        compliance = sum((1 - nu) / (math.pi * G) for G, nu in self.bodies.values())
        self.approach = compliance * LOAD * (0.5 - math.log(A / 2))
        # Tangential forces are judged by the smaller of what friction bears and what the materials' difference makes.
        beta = theory.dundurs(*young(ALUMINIUM), *young(STEEL)).beta
        self.scale = LOAD * min(friction, beta)
        self.s, self.shift, self.path = -reach, 0.0, []

    @staticmethod
    def outside(m, body, end):
        facets = np.concatenate([m.facets.find(m.tags[name]) for name in (end, body + "right", body + "left")])
        return fem.locate_dofs_topological(m.V, 1, facets)

    def move(self, load):
        s, values = self.s, self.far.x.array.reshape(-1, 2)
        for nodes, body, sign in zip(self.sides, self.bodies.values(), (1, -1)):
            x, y = self.x[nodes, 0], self.x[nodes, 1]
            u = half_plane(x - s, sign * y, load, *body) * [1, sign]
            u += sign * s / RADIUS * np.column_stack([y, s / 2 - x])
            if sign == 1:
                u += [self.shift, -self.approach * load / LOAD]
            values[nodes] = u
        self.problem.solve(max_iterations=40)

    def press(self, steps=10):
        for k in range(1, steps + 1):
            self.move(LOAD * (k / steps) ** 2)

    def shift_freely(self, guess):
        """Move with the shift that leaves no tangential force; it is near `guess`. Returns it.

        Friction depends on the path: each trial starts from the state before the step. Creep depends on what is left
        of the force over the friction it could reach, by a fifth of it where friction goes to zero.
        """
        u, before, found = self.problem.u.x.array, self.shift, []
        start, state = u.copy(), self.contact.state().copy()
        trial = guess
        while True:
            self.shift = before + trial
            self.move(LOAD)
            force = self.contact.force[0]
            if abs(force) < 2e-3 * self.scale:
                return trial
            found.append((trial, force))
            assert len(found) < 20
            # The force falls as the shift grows.
            low = max((pair for pair in found if pair[1] > 0), default=None)
            high = min((pair for pair in found if pair[1] < 0), default=None)
            if low and high:
                part = np.clip(low[1] / (low[1] - high[1]), 0.05, 0.95) if len(found) < 6 else 0.5
                trial = low[0] + part * (high[0] - low[0])
            else:
                trial += math.copysign(0.1 * guess, force)
            self.contact.state().assign(state)
            u[:] = start

    def roll(self, way, step, creep):
        """Roll on; `creep` is a guess. Returns the mean creep of the last half of the way, under LOAD."""
        first, shift = len(self.path), creep * step
        for _ in range(round(way / step)):
            self.s += step
            shift = self.shift_freely(shift)
            self.path.append((self.s, self.shift))
        begin, end = self.path[(first + len(self.path)) // 2 - 1], self.path[-1]
        # Creep goes with the half-width, the root of the load.
        return (end[1] - begin[1]) / (end[0] - begin[0]) / math.sqrt(self.contact.force[1] / LOAD)


@pytest.mark.slow
def test_bentall_johnson_without_slip():
    """Creep of free rolling against that of the program CONTACT for a friction coefficient of 10: 2 %.

    The upper body is softer and lags. Creep settles after two half-widths: its mean from 2.2 to 4.4 is off by -0.2, 0.6
    and 0.3 % with 8, 12 and 16 cells to the half-width, from 3.2 to 6.4 by 0.5 % with 12; half the step by -0.2 % (12).
    From 2.0 to 2.8 it is 2.0 % too high (16): not steady yet.
    """
    rollers = Rollers(friction=10.0, h=A / 12, reach=2.2 * A)
    rollers.press()
    exact = theory.hertz_line(LOAD, RADIUS, RADIUS, *young(ALUMINIUM), *young(STEEL))
    assert exact.half_width == pytest.approx(A, rel=1e-4)
    creep = rollers.roll(4.4 * A, A / 12, -3.6e-4)
    load, along = rollers.contact.force[1], rollers.contact.force[0]
    assert load == pytest.approx(LOAD, rel=0.02) and abs(along) < 1e-3 * load
    assert not np.any(rollers.contact.status == di.ContactStatus.slip)
    assert creep == pytest.approx(-3.591e-4, rel=0.02)
    # Friction holds it below that of rolling without friction.
    assert abs(creep) < theory.bentall_johnson(LOAD, RADIUS, RADIUS, *young(ALUMINIUM), *young(STEEL))


@pytest.mark.slow
@pytest.mark.parametrize(
    "friction, method, reach, exact", [(0.05, "Lagrange", 1.4, -4.294e-4), (1e-4, "Penalty", 0.25, -5.260e-4)]
)
def test_bentall_johnson_with_slip(friction, method, reach, exact):
    """Creep of free rolling with slip against that of the program CONTACT: 2 %.

    The blocks must be fine outside the contact too, where cells grow with the distance: their error does not fall
    with h. With 2, 4 and 8 cells along half a block's side creep is 5.1, 2.1 and 1.1 % too low for 0.05, 4.2, 1.9
    and 1.0 % for 1e-4 (with 16: 0.8 %); so is the load too high, by 1.0, 0.4 and 0.2 % for 0.05. With 8, 12 and 16
    cells to the half-width it is 2.4, 1.2 and 1.1 % too low for 0.05, with 8, 12, 16 and 24 it is 2.1, 1.3, 1.0 and
    0.7 % for 1e-4: about first order, 0.1 % if 16 and 24 are extrapolated. Blocks of twice the size, or rollers of ten
    times the radius under a tenth of the load, change creep by 0.2 % or less (1e-3, 24 cells, 2 along half a side).

    For 0.05 creep is steady after 1.4 half-widths; for 1e-4 at once. The other method gives -1.3 % for 0.05 (16 cells)
    and -2.1, 0.7, -0.6 and 0.2 % for 1e-4: multipliers scatter there, the penalty is taken for its even convergence.
    """
    rollers = Rollers(friction, A / 16, reach * A, method=method)
    rollers.press()
    creep = rollers.roll(2 * reach * A, A / 16, exact)
    load, along = rollers.contact.force[1], rollers.contact.force[0]
    assert load == pytest.approx(LOAD, rel=5e-3) and abs(along) < 2e-3 * friction * load
    assert np.any(rollers.contact.status == di.ContactStatus.slip)
    assert creep == pytest.approx(exact, rel=0.02)
    assert abs(creep) < abs(theory.bentall_johnson(LOAD, RADIUS, RADIUS, *young(ALUMINIUM), *young(STEEL)))
