"""Kinematic contact of the hand-written solver where slaves are heavier than masters."""

import impact_reference as ir
import numpy as np
import pytest
from contact_tip import DIMS, Tip
from reference_meshes import CELLS, box, facets_where
from test_reference_explicit_momentum import interpolation

DT, HEIGHT = 0.05, 0.01
H = DT**2 / 2  # the first step starts with half a step
DEPTH = DT - HEIGHT  # with the speed 1


def falling_tip(cell, degree, density, held=False, **options):
    """One step of a tip that falls beside the middle of a facet: the slave's mass, the masters', shape functions, force
    on the slave, and the gap at its end."""
    d = DIMS[cell]
    place = np.array([0.8, 0.1, 0.0][: d - 1] + [HEIGHT])
    tip = Tip(cell, np.array([place]), degree, density=density)
    model, X = tip.model, tip.model.field_points
    v0 = -tip.moves * np.eye(d)[-1]
    fixed = np.flatnonzero((tip.moves == 0).reshape(-1)) if held else ()
    contact = ir.NodalKinematic(tip.slave, tip.master, **options)
    run = model.run_explicit(DT, 1, v0=v0.reshape(-1), fixed_dofs=fixed, contacts=[contact])
    f, mass = run.contacts[0].force[0].reshape(-1, d), model.mass(lumped=True)[::d]
    masters = np.flatnonzero((np.abs(X[:, -1]) < 1e-12) & (tip.moves[:, 0] == 0))
    if cell == "tetrahedron":  # two triangles on top
        masters = masters[np.abs(f[masters]).max(1) > 0]
    phi = interpolation(X[masters][:, :-1], place[:-1])
    z = (X + run.u[1].reshape(-1, d))[:, -1]
    assert np.count_nonzero(run.contacts[0].status[0]) == 1
    return mass[tip.node], mass[masters], phi, f[tip.node], z[tip.node] - phi @ z[masters]


def alpha(m, masters, phi):
    return (1 + np.sum(phi**2 * m / masters)) * (1 - np.sum(phi**2 * m / (masters + np.abs(phi) * m)))


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("density", [0.1, 1e5, 1e6])
def test_one_node_reaches_zero_gap_in_one_sweep(cell, degree, density):
    m, masters, phi, f, gap = falling_tip(cell, degree, density, sweeps=1)
    assert m < masters.min() if density < 1 else m > 16 * masters.max()
    expected = DEPTH / (H * (1 / m + np.sum(phi**2 / masters)))
    # alpha_i is a difference of 1 and what the masters share: of 1e-4 where the slave is 1e4 times heavier.
    assert np.isclose(f[-1], expected, rtol=1e-10) and np.abs(f[:-1]).max() < 1e-12 * expected
    assert abs(gap) < 1e-11 * DEPTH
    if density == 1e6 and degree == 1:
        assert alpha(m, masters, phi) > 1.3  # what would be asked for without it


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("density", [1.0, 1e3])
def test_one_node_on_fixed_masters(cell, density):
    """Every sweep leaves 1 - 1 / alpha_i of the gap: alpha_i takes masses prescribed or not."""
    for sweeps in (1, 2, 3, 200):
        m, masters, phi, f, gap = falling_tip(cell, 1, density, held=True, sweeps=sweeps)
        left = (1 - 1 / alpha(m, masters, phi)) ** sweeps
        assert np.isclose(f[-1], m * DEPTH / H * (1 - left), rtol=1e-12)
        assert np.isclose(gap, -DEPTH * left, rtol=0, atol=1e-13)
    assert left < 1e-12


def falling_block(cell, lower, upper, density, width, sweeps):
    """One step of a block of `upper` cells, width wide, onto a unit block of `lower` cells: the ratio of the lightest
    slave's mass to the lightest master's and the gaps that are left, in parts of the depth."""
    d = DIMS[cell]
    p, c = box(cell, lower, mapping=lambda x: x - np.eye(d)[-1])
    q, e = box(cell, upper, mapping=lambda x: [*(width * (x[:-1] - 0.5) + 0.5), x[-1] + HEIGHT])
    points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
    hypothesis = "plane_strain" if d == 2 else "3d"
    materials = {k: ir.Material(1.0, 0.3, rho, hypothesis) for k, rho in enumerate((1.0, density))}
    model = ir.Model(points, cells, cell, cell_tags=np.repeat([0, 1], [len(c), len(e)]), materials=materials)
    slave = facets_where(q, e, cell, lambda x: abs(x[-1] - HEIGHT) < 1e-9) + len(p)
    master = facets_where(p, c, cell, lambda x: abs(x[-1]) < 1e-9)
    v0 = np.zeros_like(points)
    v0[len(p) :, -1] = -1
    contact = ir.NodalKinematic(slave, master, sweeps=sweeps)
    history = model.run_explicit(DT, 1, v0=v0.reshape(-1), contacts=[contact]).contacts[0]
    assert (history.status[0] > 0).all()
    mass = model.mass(lumped=True)[::d]
    return mass[np.unique(slave)].min() / mass[np.unique(master)].max(), np.abs(history.gap[0]).max() / DEPTH


@pytest.mark.parametrize("density", [600, 1e4])
@pytest.mark.parametrize(
    "cell, lower, upper, width",
    [
        # Slaves so far apart that no two share a master.
        ("quadrilateral", (7, 1), (2, 1), 0.9),
        ("triangle", (7, 1), (2, 1), 0.9),
        ("hexahedron", (5, 5, 1), (2, 2, 1), 0.9),
        # Matching nodes.
        ("quadrilateral", (3, 1), (3, 1), 1.0),
        ("triangle", (3, 1), (3, 1), 1.0),
        ("hexahedron", (2, 2, 1), (2, 2, 1), 1.0),
        ("tetrahedron", (2, 2, 1), (2, 2, 1), 1.0),
    ],
)
def test_heavy_slaves_with_masters_of_their_own(cell, lower, upper, width, density):
    for sweeps in (1, 3, 30):
        ratio, left = falling_block(cell, lower, upper, density, width, sweeps)
        assert ratio > 16
        assert left < 1e-11  # as for one node
