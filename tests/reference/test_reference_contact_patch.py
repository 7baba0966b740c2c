# SPDX-License-Identifier: MIT
"""Contact patch tests of the hand-written solver, BENCHMARKS P-1 to P-4, on meshes that do not match."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import DEGREES, Pair, blocks, gdim_of, material
from partial_facet_integrals import LoadedFacet
from reference_meshes import CELLS, box

E, PUSH = 1e6, 0.01
# Round-off of stresses: 1e-16 x E x displacement gradient of cells of size 1/4, some 1e-12; the benchmark wants 1e-10.
EXACT = 1e-10


def pushed(pair, sides, push=PUSH):
    """Bottom and top held along the last axis, `sides` along theirs at the coordinate 0."""
    d = pair.gdim
    conditions = [(lambda x: x[-1] < -1 + 1e-9, d - 1, 0.0), (lambda x: x[-1] > 1 - 1e-9, d - 1, -push)]
    conditions += [(lambda x, k=k: abs(x[k]) < 1e-9, k, 0.0) for k in sides]
    return pair.held(*conditions)


def stresses(pair, u):
    """Normal stress along the last axis at every point, and the largest of the other components."""
    stress, _ = pair.model.stress(u)
    stress = stress.reshape(-1, stress.shape[-1])
    k = pair.gdim - 1
    return stress[:, k], np.abs(np.delete(stress, k, axis=1)).max()


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("basis", ["dual", "standard", "linear"])
def test_free_sides(cell, degree, geometry_degree, basis):
    """P-2, P-3: nu = 0.3, uniaxial stress (plane strain in 2D), exact displacement, on two blocks of height 1."""
    d = gdim_of(cell)
    pair = blocks(cell, degree, geometry_degree, E=E, nu=0.3)
    fixed, values = pushed(pair, range(d - 1))
    contact = ir.Contact(pair.model, pair.slave, pair.master, prescribed=fixed)
    s = contact.solve_lagrange(fixed, values, basis=basis)
    stress, other = stresses(pair, s.u)
    exact = -E * PUSH / 2 / ((1 - 0.3**2) if d == 2 else 1)
    assert np.allclose(stress, exact, rtol=EXACT) and other < EXACT * abs(exact)
    closed = s.status > 0
    assert np.array_equal(closed, np.isfinite(s.gap))
    assert np.allclose(s.pressure[closed], -exact, rtol=EXACT)
    assert np.abs(s.gap[closed]).max() < 1e-15  # lengths are of order 1
    assert np.allclose(s.u.reshape(-1, d)[np.abs(pair.model.field_points[:, -1]) < 1e-9, -1], -PUSH / 2, atol=1e-14)
    force = s.contact_force.reshape(-1, d)
    assert np.allclose(np.abs(force[:, -1]).sum(), -2 * exact, rtol=1e-9)
    assert np.allclose((s.contact_force + s.reactions).reshape(-1, d).sum(0), 0, atol=1e-9 * abs(exact))


def test_no_lateral_strain():
    """P-1: blocks 1 x 0.5, nu = 0: sigma_y = -1e4, u_y = -0.005 at the interface."""
    pair = blocks("quadrilateral", mapping=lambda x: x * [1, 0.5], E=E, nu=0.0)
    conditions = [(lambda x: x[1] < -0.5 + 1e-9, (0, 1), 0.0)]
    conditions += [(lambda x: x[1] > 0.5 - 1e-9, 1, -0.01), (lambda x: x[1] > 0.5 - 1e-9, 0, 0.0)]
    fixed, values = pair.held(*conditions)
    s = ir.Contact(pair.model, pair.slave, pair.master).solve_lagrange(fixed, values)
    stress, other = stresses(pair, s.u)
    assert np.allclose(stress, -1e4, rtol=EXACT) and other < EXACT * 1e4
    on = np.abs(pair.model.field_points[:, 1]) < 1e-9
    assert np.allclose(s.u.reshape(-1, 2)[on, 1], -0.005, atol=1e-14)


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_inclined_interface(cell, degree):
    """P-4: blocks turned by 30 degrees, pushed along the normal by tractions: the turned uniaxial stress."""
    d = gdim_of(cell)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    R = np.eye(d)
    R[np.ix_([0, d - 1], [0, d - 1])] = [[c, -s], [s, c]]
    pair = blocks(cell, degree, degree, mapping=lambda x: R @ x, E=E, nu=0.3)
    normal, back = R[:, -1], lambda x: R.T @ x
    model = pair.model
    top = pair.facets(True, lambda x: back(x)[-1] > 1 - 1e-9)
    bottom = pair.facets(False, lambda x: back(x)[-1] < -1 + 1e-9)
    p = 5e3
    load = model.traction(top, -p * normal) + model.traction(bottom, p * normal)
    # the exact solution, at rest at the origin, is prescribed at enough nodes of either body to hold it
    exact = (
        (-p / E * np.outer(normal, normal) + 0.3 * p / E * (np.eye(d) - np.outer(normal, normal)))
        if d == 3
        else (
            -p * (1 - 0.09) / E * np.outer(normal, normal) + 0.3 * 1.3 * p / E * (np.eye(2) - np.outer(normal, normal))
        )
    )
    fixed, values = [], []
    for node, x in enumerate(model.field_points):
        y = back(x)
        if abs(abs(y[-1]) - 1) < 1e-9 and np.all(np.minimum(abs(y[:-1]), abs(y[:-1] - 1)) < 1e-9):
            fixed += [d * node + k for k in range(d)]
            values += list(exact @ x)
    assert len(fixed) >= 4 * d
    contact = ir.Contact(model, pair.slave, pair.master)
    solution = contact.solve_lagrange(fixed, np.array(values), load)
    error = solution.u.reshape(-1, d) - model.field_points @ exact.T
    # finite rotation of normals with the lateral strain does not change a plane interface: exact for small strain
    assert np.abs(error).max() < 1e-10 * np.abs(exact).max()
    closed = solution.status > 0
    assert np.allclose(solution.pressure[closed], p, rtol=1e-8)
    assert np.allclose(solution.traction[closed], 0, atol=1e-8 * p)


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("swap", [False, True])
def test_inclined_interface_that_meets_rollers(cell, degree, swap):
    """P-4, 30 degrees: no shear on the interface where the stresses along x and z are equal. Nodes on the rollers x = 0
    keep the normal of the incline: it is none of a plane of symmetry."""
    d = gdim_of(cell)
    pair = blocks(cell, degree, mapping=lambda x: x + np.tan(np.pi / 6) * x[0] * (1 - abs(x[-1])) * np.eye(d)[-1], E=E)
    model = pair.model
    strain = np.array([-0.01, -0.005, -0.01] if d == 3 else [-0.01, -0.01])
    stress = E / 1.3 * (strain + 0.3 / 0.4 * strain.sum())
    load = np.zeros(model.num_dofs)
    conditions = []
    for k in range(d):
        low, high = (0, 1) if k < d - 1 else (-1, 1)
        conditions.append((lambda x, k=k, low=low: x[k] < low + 1e-9, k, low * strain[k]))
        faces = [
            pair.facets(upper, lambda x, k=k, high=high: x[k] > high - 1e-9) for upper in (False, True)[d - 1 == k :]
        ]
        load += sum(model.traction(f, stress[k] * np.eye(d)[k]) for f in faces)
    fixed, values = pair.held(*conditions)
    sides = (pair.master, pair.slave) if swap else (pair.slave, pair.master)
    s = ir.Contact(model, *sides, prescribed=fixed).solve_lagrange(fixed, values, load)
    assert np.abs(s.u.reshape(-1, d) - model.field_points * strain).max() < EXACT * 0.01
    closed = s.status > 0
    assert np.allclose(s.pressure[closed], -stress[-1], rtol=EXACT)


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("basis", ["dual", "standard", "linear"])
def test_narrower_block(cell, degree, swap, basis):
    """P-5: the upper block ends inside facets of the lower one, on the rest of which the same pressure is a load. The
    slave is the narrower or (swap) the wider one: nodes it has beside the contact hand their functions over."""
    d, low, high = gdim_of(cell), 0.2, 0.8
    down, narrow = -np.eye(d)[-1], np.array([high - low, 1.0, 1.0])[:d]
    boxes = box(cell, (6, 2, 1)[:d], 1, lambda x: x + down), box(
        cell, (4, 1, 1)[:d], 1, lambda x: x * narrow + low * np.eye(d)[0]
    )
    pair = Pair(*boxes, cell, material(cell, E=E), degree)
    model = pair.model
    faces = [pair.facets(upper, lambda x: abs(x[-1]) < 1e-9) for upper in (True, False)]
    strain = np.array([-0.3 / 0.7 * -PUSH, -PUSH] if d == 2 else [0.3 * PUSH, 0.3 * PUSH, -PUSH])
    pressure = E * PUSH / ((1 - 0.3**2) if d == 2 else 1)
    load = np.zeros((len(model.field_points), d))
    wide = [set(f) for f in faces[1]]
    for cell_nodes, vertices in zip(model.field_cells, model.cells):
        if any(w <= set(vertices) for w in wide):
            nodes = cell_nodes[np.abs(model.field_points[cell_nodes, -1]) < 1e-9]
            facet = LoadedFacet(model.field_points[nodes][:, :-1], degree)
            load[nodes, -1] -= pressure * facet.outside(low, high)
    conditions = [(lambda x, z=z: abs(x[-1] - z) < 1e-9, d - 1, z * strain[-1]) for z in (-1, 1)]
    conditions += [(lambda x: x[0] < 1e-9, 0, 0.0)]
    conditions += [(lambda x: abs(x[0] - low) < 1e-9 and x[-1] > 0.5, 0, low * strain[0])]
    conditions += [(lambda x: x[1] < 1e-9, 1, 0.0)] if d == 3 else []
    fixed, values = pair.held(*conditions)
    contact = ir.Contact(model, *faces[:: -1 if swap else 1], prescribed=fixed)
    s = contact.solve_lagrange(fixed, values, load.ravel(), basis=basis)
    assert np.abs(s.u.reshape(-1, d) - model.field_points * strain).max() < EXACT * PUSH
    closed = s.status > 0
    assert np.allclose(s.pressure[closed], pressure, rtol=EXACT)
    assert np.isclose(contact.mortar(s.u, basis).cover[closed].sum(), high - low, rtol=1e-10)


@pytest.mark.parametrize("hypothesis", ["plane_stress", "axisymmetric"])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("method", ["lagrange", "penalty"])
def test_hypotheses(hypothesis, cell, degree, method):
    """Uniaxial stress again; in axisymmetric problems the force is that on the whole disc, pi times the pressure."""
    pair = blocks(cell, degree, 1, E=E, nu=0.3, hypothesis=hypothesis)
    fixed, values = pushed(pair, [0])
    contact = ir.Contact(pair.model, pair.slave, pair.master, prescribed=fixed)
    if method == "lagrange":
        s = contact.solve_lagrange(fixed, values)
        stress, _ = pair.model.stress(s.u)
        assert np.allclose(stress[..., 1], -E * PUSH / 2, rtol=EXACT)
        assert np.allclose(s.pressure[s.status > 0], E * PUSH / 2, rtol=EXACT)
    else:
        s = contact.solve_penalty(fixed, values, chi=1e10)
    area = np.pi if hypothesis == "axisymmetric" else 1
    # penalty: E / (2 chi) = 5e-5 softer
    force = np.abs(s.contact_force.reshape(-1, 2)[:, 1]).sum() / 2
    assert np.isclose(force, area * E * PUSH / 2, rtol=1e-9 if method == "lagrange" else 1e-3)


@pytest.mark.long_rows(where=lambda cell: cell == "hexahedron")
@pytest.mark.parametrize("law", ["st_venant_kirchhoff", "neo_hookean"])
@pytest.mark.parametrize("cell", ["triangle", "hexahedron"])
def test_large_strain(cell, law):
    """Squeezed by 20 %: homogeneous, the pressure is the nominal one."""
    d = gdim_of(cell)
    pair = blocks(cell, 2, 2, E=E, nu=0.3, law=law)
    fixed, values = pushed(pair, range(d - 1), push=0.4)
    contact = ir.Contact(pair.model, pair.slave, pair.master, prescribed=fixed)
    s = contact.solve_lagrange(fixed, values, steps=2)
    closed = s.status > 0
    # the one-element answer by the same cells, which other tests verify: nominal force per reference area
    single = blocks(cell, 1, 1, lower=(1,) * d, upper=(1,) * d, E=E, nu=0.3, law=law)
    alone, held = pushed(single, range(d - 1), push=0.4)
    both = single.model.solve_static(
        np.concatenate([alone, [d * n + d - 1 for n in np.flatnonzero(abs(single.model.field_points[:, -1]) < 1e-9)]]),
        np.concatenate([held, np.full(2**d, -0.2)]),
        steps=2,
    )
    nominal = -both.reactions.reshape(-1, d)[single.model.field_points[:, -1] > 1 - 1e-9, -1].sum()
    assert nominal > 0.1 * E
    assert np.allclose(s.pressure[closed], nominal, rtol=1e-8)  # tolerance of the other solver: 1e-10 of the forces


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_penalty(cell, degree):
    """Matching meshes: uniform penetration p / chi. Others: the weak integrals miss by the quadrature error only."""
    d, chi = gdim_of(cell), 1e8
    cut = (3,) * (d - 1) + (1,)
    spread = []
    for lower in (cut, (2,) * (d - 1) + (1,)):
        pair = blocks(cell, degree, degree, lower=lower, upper=cut, E=E, nu=0.3)
        fixed, values = pushed(pair, range(d - 1))
        s = ir.Contact(pair.model, pair.slave, pair.master).solve_penalty(fixed, values, chi=chi)
        stress, _ = stresses(pair, s.u)
        modulus = E / ((1 - 0.3**2) if d == 2 else 1)
        p = modulus * PUSH / (2 + modulus / chi)
        assert np.isclose(s.pressure @ s.points.weight, p, rtol=1e-3)
        assert np.allclose(-chi * s.gap, s.pressure, rtol=1e-12)
        spread.append(max(np.ptp(s.pressure), np.ptp(stress)) / p)
        if lower == cut:
            assert np.allclose(s.gap, -p / chi, rtol=1e-9)
    assert spread[0] < 1e-9 < 1e-4 < spread[1] < 0.3


@pytest.mark.parametrize("cell", CELLS)
def test_penalty_augmented(cell):
    """Uzawa's method with linear multipliers: the pressure without penetration whatever chi, on matching meshes."""
    d = gdim_of(cell)
    cut = (2,) * (d - 1) + (1,)
    pair = blocks(cell, lower=cut, upper=cut, E=E, nu=0.3)
    fixed, values = pushed(pair, range(d - 1))
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    exact = E * PUSH / 2 / ((1 - 0.3**2) if d == 2 else 1)
    for chi in (2e7, 1e8):
        s = contact.solve_penalty(fixed, values, chi=chi, augmented=True)
        # multipliers change by less than 1e-8 of the size 2 in the end: 2e-8 / 5e-3 of the displacement
        assert np.abs(s.gap).max() < 2.5e-8
        assert np.allclose(s.pressure, exact, rtol=1e-5)
        plain = contact.solve_penalty(fixed, values, chi=chi)
        assert plain.gap.min() < -4e-5
    # the state keeps its multipliers: nothing is left to do in a second step without loads
    again = contact.solve_penalty(fixed, values, chi=1e8, augmented=True, start=s)
    assert np.allclose(again.u, s.u, atol=1e-8) and sum(again.iterations) <= 2
