# SPDX-License-Identifier: MIT
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


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("density", [0.1, 1e5, 1e6])
@pytest.mark.parametrize("sweeps", [1, 2, 3])
def test_one_node_reaches_zero_gap_in_one_sweep(cell, degree, density, sweeps):
    m, masters, phi, f, gap = falling_tip(cell, degree, density, sweeps=sweeps)
    assert m < masters.min() if density < 1 else m > 16 * masters.max()
    expected = DEPTH / (H * (1 / m + np.sum(phi**2 / masters)))
    # Round-off of shape functions at a closest point that is settled to 1e-11.
    assert np.isclose(f[-1], expected, rtol=1e-10) and np.abs(f[:-1]).max() < 1e-12 * expected
    assert abs(gap) < 1e-11 * DEPTH


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("density", [1.0, 1e3])
@pytest.mark.parametrize("sweeps", [1, 3])
def test_one_node_on_fixed_masters(cell, degree, density, sweeps):
    """They give no way, so that the force is that of a wall."""
    m, _, _, f, gap = falling_tip(cell, degree, density, held=True, sweeps=sweeps)
    assert np.isclose(f[-1], m * DEPTH / H, rtol=1e-12)
    assert abs(gap) < 1e-12 * DEPTH


class Fall:
    """One step of a block of `upper` cells, width wide, onto a unit block of `lower` cells: slave nodes, masses m of
    nodes, phi (slaves, nodes of the master), and by sweeps the force on each slave and the gap left in parts of the
    depth."""

    def __init__(self, cell, lower, upper, density, width, degree=1):
        d = DIMS[cell]
        p, c = box(cell, lower, mapping=lambda x: x - np.eye(d)[-1])
        q, e = box(cell, upper, mapping=lambda x: [*(width * (x[:-1] - 0.5) + 0.5), x[-1] + HEIGHT])
        points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
        hypothesis = "plane_strain" if d == 2 else "3d"
        materials = {k: ir.Material(1.0, 0.3, rho, hypothesis) for k, rho in enumerate((1.0, density))}
        tags = np.repeat([0, 1], [len(c), len(e)])
        self.model = model = ir.Model(points, cells, cell, cell_tags=tags, materials=materials, degree=degree)
        self.surfaces = (
            facets_where(q, e, cell, lambda x: abs(x[-1] - HEIGHT) < 1e-9) + len(p),
            facets_where(p, c, cell, lambda x: abs(x[-1]) < 1e-9),
        )
        X, self.mass = model.field_points, model.mass(lumped=True)[::d]
        self.v0 = np.zeros_like(X)
        upper_nodes = np.unique(model.field_cells[len(c) :])
        self.v0[upper_nodes, -1] = -1
        self.slaves = upper_nodes[np.abs(X[upper_nodes, -1] - HEIGHT) < 1e-9]
        self.masters = np.setdiff1d(np.flatnonzero(np.abs(X[:, -1]) < 1e-9), upper_nodes)

    def ratio(self):
        """The lightest slave's mass to the heaviest master's."""
        return self.mass[self.slaves].min() / self.mass[self.masters].max()

    def sweep(self, sweeps):
        contact = ir.NodalKinematic(*self.surfaces, sweeps=sweeps)
        history = self.model.run_explicit(DT, 1, v0=self.v0.reshape(-1), contacts=[contact]).contacts[0]
        assert np.array_equal(np.sort(history.nodes), self.slaves)
        force = history.force[0].reshape(self.v0.shape)[history.nodes, -1]
        order = np.argsort(history.nodes)
        return force[order], history.gap[0][order] / DEPTH

    def phi(self):
        """Of the master's nodes at the slaves' places, by interpolation on the facets of its cells."""
        model, X = self.model, self.model.field_points
        top, values = set(self.masters.tolist()), np.zeros((len(self.slaves), len(X)))
        count = len(ir.facets(model.cell_type))
        local = [ir.facet_nodes(model.cell_type, model.degree, f) for f in range(count)]
        corners = [len(f) for f in ir.facets(model.cell_type)]
        for cell in model.field_cells:
            for nodes, n in ((cell[where], n) for where, n in zip(local, corners)):
                if not top.issuperset(nodes.tolist()):
                    continue
                for i, x in enumerate(X[self.slaves, :-1]):
                    # The corners' linear functions tell who is inside.
                    if interpolation(X[nodes[:n], :-1], x).min() > -1e-9:
                        values[i, nodes] = interpolation(X[nodes, :-1], x)
        assert np.allclose(values.sum(1), 1)
        return values[:, self.masters]


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
    fall = Fall(cell, lower, upper, density, width)
    assert fall.ratio() > 16
    phi = fall.phi()
    expected = DEPTH / (H * (1 / fall.mass[fall.slaves] + phi**2 @ (1 / fall.mass[fall.masters])))
    for sweeps in (1, 3, 30):
        force, left = fall.sweep(sweeps)
        assert np.abs(left).max() < 1e-11 and np.allclose(force, expected, rtol=1e-10)  # as for one node


COUNTS = {2: (((2, 1), (5, 1)), ((4, 1), (3, 1))), 3: (((2, 2, 1), (3, 3, 1)), ((3, 3, 1), (2, 2, 1)))}


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("mesh", [0, 1])
@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e4])
def test_sweeps_with_shared_masters(cell, degree, mesh, ratio):
    """Against the same sweeps with the matrix of the bodies' response G: none of its eigenvalues in units of its row
    sums is above 1, and what is left never exceeds the first depth."""
    lower, upper = COUNTS[DIMS[cell]][mesh]
    fall = Fall(cell, lower, upper, ratio / Fall(cell, lower, upper, 1.0, 0.9, degree).ratio(), 0.9, degree)
    assert np.isclose(fall.ratio(), ratio)
    phi, m = fall.phi(), fall.mass
    G = np.diag(1 / m[fall.slaves]) + (phi / m[fall.masters]) @ phi.T
    w = 1 / m[fall.slaves] + (np.abs(phi) * np.abs(phi).sum(0)) @ (1 / m[fall.masters])
    spectrum = np.linalg.eigvalsh(G / np.sqrt(np.outer(w, w)))
    assert 0 < spectrum.min() and spectrum.max() < 1 + 1e-12
    f, energy = np.zeros(len(w)), 0.0
    for sweep in range(1, 31):
        f = np.maximum(0, f + (1.0 if sweep % 2 else 1.5) * (DEPTH / H - G @ f) / w)
        # What the forces leave of the work that a contact without gap would take: less in every sweep.
        last, energy = energy, f @ (G @ f) / 2 - f.sum() * DEPTH / H
        assert energy < last + 1e-12 * abs(energy)
        if sweep in (1, 3, 10, 30):
            force, left = fall.sweep(sweep)
            # Round-off of 30 sweeps, which do not amplify it.
            assert np.allclose(force, f, rtol=0, atol=1e-10 * f.max())
            assert np.allclose(left, G @ f * H / DEPTH - 1, rtol=0, atol=1e-10)
            assert np.abs(left).max() <= 1


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("ratio", [1.0, 1e4])
def test_sweeps_converge_at_the_rate_of_the_spectrum(cell, ratio):
    """Fewer slaves than masters, all pressed: two sweeps leave (1 - lambda) (1 - 1.5 lambda) of every part."""
    lower, upper = ((7, 1), (5, 1)) if DIMS[cell] == 2 else ((3, 3, 1), (2, 2, 1))
    fall = Fall(cell, lower, upper, ratio / Fall(cell, lower, upper, 1.0, 0.9).ratio(), 0.9)
    phi, m = fall.phi(), fall.mass
    G = np.diag(1 / m[fall.slaves]) + (phi / m[fall.masters]) @ phi.T
    w = 1 / m[fall.slaves] + (np.abs(phi) * np.abs(phi).sum(0)) @ (1 / m[fall.masters])
    exact = np.linalg.solve(G, np.full(len(w), DEPTH / H))
    assert exact.min() > 0
    spectrum = np.linalg.eigvalsh(G / np.sqrt(np.outer(w, w)))
    rate = np.abs((1 - spectrum) * (1 - 1.5 * spectrum)).max()
    assert spectrum.min() < 0.9  # without masters in common all are 1, and the first sweep is the last
    sweeps = 2 * int(np.ceil(np.log(1e-13) / np.log(rate)))
    for count in (2 * (sweeps // 8), sweeps):
        force, left = fall.sweep(count)
        # In the norm in which the operator is symmetric; the rest is round-off as for one node.
        size = np.sqrt(np.sum(left**2 / w)), np.sqrt(np.sum(1 / w))
        assert size[0] < (rate ** (count // 2) + 1e-11) * size[1]
    assert np.abs(left).max() < 1e-10 and np.allclose(force, exact, rtol=1e-9)
