# SPDX-License-Identifier: MIT
"""Contact without pairs of the hand-written solver alone: closed forms of one spring, momentum, energy, refusals."""

import impact_reference as ir
import numpy as np
import pytest

GENERAL = {"friction": 0.3}


def grid(low, high, counts):
    """Points and cells of a box of quadrilaterals or hexahedra, and its outer facets."""
    dim = len(counts)
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dim)
    number = np.arange(len(points)).reshape([n + 1 for n in counts])
    loop = [(0, 0), (1, 0), (1, 1), (0, 1)]
    corners = loop if dim == 2 else [(*c, z) for z in (0, 1) for c in loop]
    cells = [[number[tuple(np.add(at, c))] for c in corners] for at in np.ndindex(*counts)]
    return points, np.array(cells)


def outer(cells, kind):
    local = np.array(ir.facets(kind))
    every = cells[:, local].reshape(-1, local.shape[1])
    _, place, count = np.unique(np.sort(every, axis=1), axis=0, return_inverse=True, return_counts=True)
    return every[count[place.reshape(-1)] == 1]


def bodies(boxes, hypothesis="plane_strain", **options):
    """Model of some boxes, contact of all their outer facets, and the first node of each."""
    points, cells, first = [], [], [0]
    for box in boxes:
        p, c = grid(*box[:3])
        p = p if len(box) < 4 else box[3](p)
        points.append(p)
        cells.append(c + first[-1])
        first.append(first[-1] + len(p))
    points, cells = np.vstack(points), np.vstack(cells)
    kind = "quadrilateral" if points.shape[1] == 2 else "hexahedron"
    law = ir.Material(
        1.0,
        0.3,
        1.0,
        hypothesis if kind == "quadrilateral" else "3d",
        "linear_elastic" if hypothesis == "axisymmetric" else "neo_hookean",
    )
    model = ir.Model(points, cells, kind, law)
    return model, ir.GeneralContact(outer(cells, kind), **options), first


def test_one_node_behind_a_face():
    """A corner of the upper square behind the lower one's face: a spring at the node and on the facet's ends.

    Of a balanced pair of the same surfaces, whose springs count the ends' compliance once more, it is the stiffer one.
    """
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    depth = 0.01
    lower = ((-2.0, -1.0), (2.0, 0.0), (2, 2))
    upper = ((0.0, 0.0), (1.0, 1.0), (2, 2), lambda p: p @ turn.T + (1.0, -depth))  # its corner over a facet's middle
    model, general, first = bodies((lower, upper))
    found = model.run_explicit(0.01, 1, contacts=[general]).contacts[0]
    force = found.force[0].reshape(-1, 2)
    upper_facets = general.facets.min(axis=1) >= first[1]
    pair = ir.NodalPenalty(general.facets[upper_facets], general.facets[~upper_facets], balanced=True)
    named = model.run_explicit(0.01, 1, contacts=[pair]).contacts[0].force[0].reshape(-1, 2)
    push = force[first[1], 1]
    assert 1.05 < push / named[first[1], 1] < 1.5 and force[first[1], 0] == pytest.approx(0.0, abs=1e-16)
    corners = np.flatnonzero((model.points[:, 1] == 0.0) & (model.points[:, 0] >= 0.0) & (np.arange(len(force)) < 9))
    assert force[corners] == pytest.approx(np.tile([0.0, -0.5 * push], (2, 1)), abs=1e-15)
    assert np.count_nonzero(np.abs(force[:, 1]) > 1e-15) == 3
    assert found.gap[0].min() == pytest.approx(-depth, rel=1e-12)


def test_two_edges():
    """Boxes that lie crosswise on their edges: a force along the common perpendicular, on the ends of both edges."""

    def turned(a, b, lift):
        def place(p):
            q, r = p.copy(), np.sqrt(0.5)
            q[:, a], q[:, b] = r * (p[:, a] - p[:, b]), r * (p[:, a] + p[:, b])
            q[:, 2] += lift
            return q

        return place

    depth, high = 0.01, 2.0 * np.sqrt(2.0)
    lower = ((-1.0,) * 3, (1.0,) * 3, (1, 1, 1), turned(0, 2, 0.0))
    upper = ((-1.0,) * 3, (1.0,) * 3, (1, 1, 1), turned(1, 2, high - depth))
    model, general, first = bodies((lower, upper))
    force = model.run_explicit(0.01, 1, contacts=[general]).contacts[0].force[0].reshape(-1, 3)
    pushed = np.flatnonzero(np.abs(force).max(axis=1) > 1e-15)
    assert len(pushed) == 4 and np.sum(pushed >= first[1]) == 2
    assert force[pushed[2:]] == pytest.approx(np.tile([0.0, 0.0, force[pushed[2], 2]], (2, 1)), abs=1e-15)
    assert force[pushed[2], 2] == pytest.approx(-force[pushed[0], 2], rel=1e-12) and force[pushed[2], 2] > 0.0
    assert force.sum(axis=0) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("dim", (2, 3))
def test_momentum_and_energy(dim):
    one, more = ((2,) * dim, (3,) * dim)
    low, above = np.zeros(dim), np.array([0.31, 0.17, 1.002][3 - dim :])
    above[-1] = 1.002
    model, general, first = bodies(((low, low + 1.0, more), (above, above + 0.8, one)), **GENERAL)
    v = np.zeros((len(model.points), dim))
    v[first[1] :, -1], v[first[1] :, 0] = -0.1, 0.08
    result = model.run_explicit(0.08, 100, v0=v.ravel(), contacts=[general])
    mass = model.mass(lumped=True).reshape(-1, dim)
    x, v = model.points + result.u.reshape(-1, *v.shape), result.v_half.reshape(-1, *v.shape)
    momentum, middle = (mass * v).sum(axis=1), x[:-1] + 0.5 * np.diff(x, axis=0)
    pad = [(0, 0), (0, 0), (0, 3 - dim)]
    spin = (mass[:, :1] * np.cross(np.pad(middle, pad), np.pad(v[:-1], pad))).sum(axis=1)
    assert np.abs(momentum - momentum[0]).max() < 1e-14
    assert np.abs(spin - spin[0]).max() < 1e-13
    assert result.energies["friction"][-1] > 1e-6 and result.energies["contact"].max() > 1e-5
    # The elastic energy of finite strain is the work of the trapezoidal rule, so that the balance is exact.
    assert np.abs(result.energies["drift"]).max() < 1e-12


def test_rings_keep_axial_momentum():
    low, above = np.array([1.0, 0.0]), np.array([1.31, 1.002])
    boxes = ((low, low + 1.0, (3, 3)), (above, above + 0.8, (2, 2)))
    model, general, first = bodies(boxes, hypothesis="axisymmetric", **GENERAL)
    v = np.zeros((len(model.points), 2))
    v[first[1] :, 1] = -0.1
    result = model.run_explicit(0.08, 60, v0=v.ravel(), contacts=[general])
    momentum = (model.mass(lumped=True).reshape(-1, 2) * result.v_half.reshape(-1, *v.shape))[..., 1].sum(axis=1)
    assert np.abs(momentum - momentum[0]).max() < 1e-13 and result.energies["contact"].max() > 1e-5


def test_what_is_refused():
    points, cells = grid((1.0, 0.0), (2.0, 1.0), (2, 2))
    facets = outer(cells, "quadrilateral")
    flat = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.3, 1.0, "plane_strain"))
    with pytest.raises(ValueError, match="friction"):
        flat.run_explicit(0.01, 1, contacts=[ir.GeneralContact(facets, -0.1)])
