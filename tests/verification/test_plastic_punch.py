# SPDX-License-Identifier: MIT
"""Prandtl's punch, benchmark J-3: the limit load of a flat rigid punch on a half-plane, (2 + pi) Y/sqrt(3) (Souza Neto,
Peric, Owen 2008, section 7.5.4).

Found with linear quadrilaterals, cells of 1/32 of the half-width at the edge of the punch: 1.2 % (smooth) and 2.4 %
(rough) above the exact load. The punch takes half a cell beyond its edge along, which is 1.6 % of its width. With cells
of degree 2 and 1/16: 0.7 % and 1.2 %.
"""

import numpy as np
import pytest
from dolfinx import fem
from meshes_and_supports import clamp, rectangle, tagged

import dolfinx_impact as di
from dolfinx_impact.theory import plasticity as theory

Y, E, NU = 1.0, 1000.0, 0.3
FAR = 5.0  # width and depth of the block over the half-width of the punch; the mechanism is 3 wide and 1.3 deep


def growing(first, length, ratio):
    """Places from 0 to a length, whose distances begin with about `first` and grow by a ratio."""
    n = int(np.ceil(np.log1p(length * (ratio - 1) / first) / np.log(ratio)))
    x = np.concatenate([[0.0], np.cumsum(ratio ** np.arange(n))])
    return x * length / x[-1]


class Punch:
    """Half of a punch of half-width 1 on a block, pushed down; cells grow away from its edge.

    Args:
        h: smallest cells [L].
        average: of J2Plasticity.
        rough: whether the surface sticks to the punch.
        ratio: sizes of neighbouring cells [1].
        degree: degree of the displacement [1].
    """

    def __init__(self, h, average="auto", rough=False, ratio=1.3, degree=1):
        x = np.concatenate([1 - growing(h, 1.0, ratio)[::-1], 1 + growing(h, FAR - 1, ratio)[1:]])
        y = -growing(h, FAR, ratio)[::-1]
        n = len(x) - 1, len(y) - 1
        domain = rectangle("quadrilateral", (0.0, 0.0), (1.0, 1.0), n)
        for axis, places in enumerate((x, y)):
            domain.geometry.x[:, axis] = places[np.rint(domain.geometry.x[:, axis] * n[axis]).astype(int)]
        tags = tagged(
            domain,
            punch=lambda x: np.isclose(x[1], 0) & (x[0] < 1 + 1e-9),
            bottom=lambda x: np.isclose(x[1], -FAR),
            symmetry=lambda x: np.isclose(x[0], 0),
            far=lambda x: np.isclose(x[0], FAR),
        )
        self.u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (2,))), name="u")
        V = self.u.function_space
        self.down = fem.Constant(domain, 0.0)
        self.dofs = fem.locate_dofs_topological(V.sub(1), 1, tags.find(1))
        bcs = [fem.dirichletbc(self.down, self.dofs, V.sub(1)), clamp(V, tags, 2)]
        bcs += [clamp(V, tags, tag, 0) for tag in ((3, 4, 1) if rough else (3, 4))]
        steel = di.J2Plasticity(E, NU, yield_stress=Y, hypothesis="plane_strain", average=average)
        self.problem = di.StaticProblem(self.u, steel, bcs=bcs)

    def push(self, depths):
        """Mean pressures at depths [F/L^2]."""
        pressures = []
        for depth in depths:
            self.down.value = -depth
            self.problem.solve(cut_backs=3)
            pressures.append(-self.problem.reactions().x.array[self.dofs].sum())
        return np.array(pressures)


DEPTHS = np.linspace(0.0, 0.04, 9)[1:]


@pytest.mark.long_rows(where=lambda rough: not rough)
@pytest.mark.parametrize("rough", [False, True], ids=["smooth", "rough"])
def test_limit_load(rough):
    """J-3: 3 % above the exact load at most (fields with the constraints of the mesh bound it from above), not below,
    and constant once it is reached."""
    pressures = Punch(1 / 32, rough=rough, ratio=1.15).push(DEPTHS)
    print(pressures / Y)
    assert theory.prandtl_pressure(Y) == pytest.approx(2.968500, rel=1e-6)
    assert 2.968500 * Y < pressures[-1] < 1.03 * 2.968500 * Y
    assert pressures[-1] == pytest.approx(pressures[-2], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("rough", [False, True], ids=["smooth", "rough"])
def test_limit_load_of_degree_2(rough):
    """The same limits for cells of degree 2, twice as large, whose dilatation is linear in each."""
    pressures = Punch(1 / 16, rough=rough, degree=2).push(DEPTHS)
    print(pressures / Y)
    assert 2.968500 * Y < pressures[-1] < 1.03 * 2.968500 * Y
    assert pressures[-1] == pytest.approx(pressures[-2], rel=1e-3)


def test_projections_of_degree_2():
    """With cells of 1/8 full integration is too stiff, and its load grows on; a mean per cell bears too little."""
    full, default, mean = (Punch(1 / 8, average, degree=2).push(DEPTHS) / 2.968500 for average in (False, "auto", True))
    print(full, default, mean)
    growth = [p[-1] / p[-2] - 1 for p in (full, default)]
    assert mean[-1] < 1.0 < default[-1] < 1.02 and full[-1] > 1.03
    assert growth[1] < 1e-4 < 3e-4 < growth[0]


def test_error_of_the_limit_load_falls_with_the_cells():
    """It is that of half a cell at the edge, of first order."""
    errors = [Punch(h).push(DEPTHS)[-1] / theory.prandtl_pressure(Y) - 1 for h in (1 / 8, 1 / 16)]
    print(errors)
    assert errors[1] < 0.6 * errors[0]


def test_one_large_increment():
    """Twice the depth of collapse at once: Newton's method needs its line search, and finds the same load."""
    in_steps, at_once = (Punch(1 / 16).push(depths)[-1] for depths in (DEPTHS, DEPTHS[-1:]))
    assert at_once == pytest.approx(in_steps, rel=2e-3)


def test_without_the_mean_dilatation_the_load_grows_on():
    """The check above must see cells that lock."""
    pressures = Punch(1 / 16, average=False).push(DEPTHS)
    print(pressures / Y)
    assert pressures[-1] > 1.05 * theory.prandtl_pressure(Y) and pressures[-1] > 1.005 * pressures[-2]
