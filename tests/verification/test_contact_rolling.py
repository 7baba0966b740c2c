"""Free rolling of rollers of different materials; Bentall and Johnson 1967."""

import math

import numpy as np
import pytest
from contact_model import Model, enforce
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes, theory

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
    """

    def __init__(self, friction, h, reach, **options):
        block = dict(width=SIZE, height=SIZE, block_width=SIZE, block_height=SIZE, coarse=SIZE / 2)
        recipe = meshes.make(
            "wedge", MPI.COMM_SELF, angle=math.pi / 2 - 1e-12, a=A, h=h, core=reach + 1.3 * A, symmetry="none", **block
        )
        self.bodies = {"slave_body": ALUMINIUM, "master_body": STEEL}
        law = {name: di.LinearElastic(*young(b), hypothesis="plane_strain") for name, b in self.bodies.items()}
        m = Model(recipe, law)
        x, cells = m.mesh.geometry.x, recipe.cell_tags.find(m.tags["slave_body"])
        upper = np.zeros(len(x), dtype=bool)
        upper[np.unique(m.mesh.geometry.dofmap[cells])] = True
        x[:, 1] += np.where(upper, 1, -1) * x[:, 0] ** 2 / (2 * RADIUS) * (1 - np.abs(x[:, 1]) / SIZE)
        self.far = fem.Function(m.V)
        self.sides = [self.outside(m, "slave_", "top"), self.outside(m, "", "bottom")]
        m.bcs += [fem.dirichletbc(self.far, nodes) for nodes in self.sides]
        self.x = m.V.tabulate_dof_coordinates()
        self.problem = m.problem(enforce("Penalty", m.pair(friction=friction), **options))
        self.contact = self.problem.contact[0]
        # Under Hertz's pressure the mean of -ln |x| is 1/2 - ln(a/2): the middles of both surfaces meet.
        compliance = sum((1 - nu) / (math.pi * G) for G, nu in self.bodies.values())
        self.approach = compliance * LOAD * (0.5 - math.log(A / 2))
        self.stiffness = 1 / (compliance * (math.log(2 * SIZE / A) + 0.5))  # roughly, along x: that of the correction
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

    def roll(self, way, step, creep):
        """Roll on; `creep` is a guess. Returns the mean creep of the last half of the way."""
        first = len(self.path)
        for _ in range(round(way / step)):
            self.s += step
            self.shift += creep * step + self.contact.force[0] / self.stiffness
            self.move(LOAD)
            self.path.append((self.s, self.shift))
        begin, end = self.path[(first + len(self.path)) // 2 - 1], self.path[-1]
        return (end[1] - begin[1]) / (end[0] - begin[0])


@pytest.mark.slow
def test_bentall_johnson_without_slip():
    """Creep of free rolling against that of the program CONTACT for a friction coefficient of 10: 2 %.

    The upper body is softer and lags. With 8, 12 and 16 cells to the half-width the error is 3.3, 2.1 and 1.2 %;
    half the step changes it by 0.2 %.
    """
    rollers = Rollers(friction=10.0, h=A / 16, reach=1.6 * A)
    rollers.press()
    exact = theory.hertz_line(LOAD, RADIUS, RADIUS, *young(ALUMINIUM), *young(STEEL))
    assert exact.half_width == pytest.approx(A, rel=1e-4)
    guess = -3.6e-4
    rollers.roll(1.2 * A, A / 16, guess)
    creep = rollers.roll(1.6 * A, A / 16, guess)
    load, along = rollers.contact.force[1], rollers.contact.force[0]
    assert load == pytest.approx(LOAD, rel=0.02) and abs(along) < 1e-3 * load
    assert not np.any(rollers.contact.status == di.ContactStatus.slip)
    # Creep goes with the half-width, the root of the load.
    creep /= math.sqrt(load / LOAD)
    assert creep == pytest.approx(-3.591e-4, rel=0.02)
    # Friction holds it below that of rolling without friction.
    assert abs(creep) < theory.bentall_johnson(LOAD, RADIUS, RADIUS, *young(ALUMINIUM), *young(STEEL))
