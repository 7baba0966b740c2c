# SPDX-License-Identifier: MIT
"""Where friction finds the edge of the contact, and that the mesh of creep curves allows for it; docs/rolling.md."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes
from impact_studies.creep.model import CreepModel, WheelOnRail

R, E, NU, SPEED = 500.0, 207e3, 0.3, 1000.0  # [mm, N/mm^2, 1, mm/s]
SMALL = 2e-6  # creep [1]: nothing slips yet


def braked_wheel(cells, depths):
    """Carter's wheel with `cells` in a length of 1 mm, pressed down to depths: half-width by Hertz over a cell, number
    of the last node in contact, and the force of a small creep over Carter's."""
    made = meshes.make(
        "wheel_on_rail_2d", MPI.COMM_SELF, radius=R, hub_radius=100.0, a=1.0, h=1.0 / cells, rail_length=400.0,
        rail_height=200.0,
    )  # fmt: skip
    tags, V = made.tags, fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    axle, foot = (fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags[name])) for name in ("hub", "bottom"))
    hub, spin = fem.Function(V), di.Spin((0.0, R), (0.0, 0.0, 1.0), omega=-SPEED / R)
    motions = {tags["slave_body"]: spin, tags["master_body"]: di.Translation((-SPEED, 0.0))}
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=0.3)
    rolling = di.RollingProblem(
        fem.Function(V), di.LinearElastic(E, NU, 7.85e-9, "plane_strain"), made.cell_tags, motions,
        contact=[di.Lagrange(pair)], bcs=[fem.dirichletbc(hub, axle), fem.dirichletbc(np.zeros(2), foot, V)],
    )  # fmt: skip
    contact, rows = rolling.contact[0], []
    for depth in depths:
        hub.x.array.reshape(-1, 2)[axle] = (0.0, -depth)
        spin.omega = -SPEED / R
        rolling.solve(torque=0.0)
        force = rolling.sweep(creep=[0.0, SMALL], progress=False)["force"]
        a = di.theory.hertz_line(force[0, 1], R, np.inf, E, NU, E, NU).half_width
        carter = np.pi * a * SMALL * E / (4.0 * (1.0 - NU**2))
        last = round(contact.points[contact.pressure > 0.0, 0].max() * cells)
        rows.append((a * cells, last, (force[1, 0] - force[0, 0]) / carter))
    return np.array(rows).T


@pytest.mark.parametrize("cells", [6, pytest.param(12, marks=pytest.mark.slow)])
def test_friction_finds_the_edge_at_a_fixed_distance_from_the_last_node(cells):
    """0.40 cells beyond it, wherever the edge is: the force has an error of the distance between both, over a.

    Limit: 0.05 cells, as the coefficient has two digits.
    """
    edge, last, ratio = braked_wheel(cells, np.array([6.2e-3, 6.6e-3, 7.0e-3]))
    assert np.ptp(edge - last) > 0.2  # the edge lies in several places between nodes
    np.testing.assert_allclose(ratio * edge - last, 0.40, atol=0.05)


@pytest.mark.parametrize("cells", (3, 4, 5, 6, 8, 11))
def test_rows_of_nodes_end_at_the_same_distance_from_the_edge(cells):
    """On the slave's surface of `rolling_contact_3d`; rows of fewer nodes than three on either side may differ."""
    a, b = 8e-3, 5e-3
    made = meshes.make("rolling_contact_3d", MPI.COMM_SELF, a=a, b=b, cells=cells, reach=4.0)
    facets = made.facet_tags.find(made.tags["slave_surface"])
    nodes = surface_nodes(made.mesh, facets)
    along, across = np.arcsin(nodes[:, 0] / 0.46) * 0.46 / a, nodes[:, 1] / b
    found = []
    for y in np.unique(across.round(6)):
        half = np.sqrt(max(0.0, 1.0 - y**2))
        x = np.sort(along[np.abs(across - y) < 1e-5])
        inside = np.count_nonzero((x > 1e-6) & (x < half))
        if inside >= 2:
            step = x[x > half][0] - x[x < half][-1]
            found.append((half - x[x < half][-1]) / step)
    assert len(found) >= cells - 1
    np.testing.assert_allclose(found, 0.3, atol=0.01)


def surface_nodes(domain, facets):
    """Places of the vertices of facets, (n, 3)."""
    from dolfinx import mesh

    return domain.geometry.x[np.unique(mesh.entities_to_geometry(domain, 2, facets))]


def test_with_a_path_cells_are_alike():
    """An explicit run rolls over them."""
    made = meshes.make("rolling_contact_3d", MPI.COMM_SELF, a=8e-3, b=5e-3, cells=4, reach=4.0, path=1.0)
    nodes = surface_nodes(made.mesh, made.facet_tags.find(made.tags["slave_surface"]))
    along = np.unique((np.arcsin(nodes[:, 0] / 0.46) * 0.46 / 8e-3).round(6))
    np.testing.assert_allclose(np.diff(along), 0.25, rtol=1e-3)


# Kalker's coefficients of a locomotive's wheel, by CONTACT: steel, 130 kN, half-axes of 7.854 and 5.908 mm.
LOCOMOTIVE = {"load": 130e3, "friction": 0.3, "E": 207e9, "density": 7800.0, "speed": 1.0, "reach": 4.0}
C11, C22, C23 = 4.607, 4.161, 1.869


def unit(model):
    """G a b [N]."""
    return model.data.E / 2.6 * model.hertz.a * model.hertz.b


@pytest.mark.parametrize("cells", [3, *(pytest.param(n, marks=pytest.mark.slow) for n in (4, 5, 6, 7, 8))])
def test_longitudinal_creep(cells):
    """Half a model. Bodies that end at four half-axes are stiffer than half-spaces, and give 1 to 2 % more."""
    model = CreepModel(WheelOnRail(cells=cells, **LOCOMOTIVE))
    force = model.curve([2.5e-5], progress=False)["force"][0]
    assert force[0] / (2.5e-5 * unit(model)) == pytest.approx(C11, rel=0.03)
    assert force[2] == pytest.approx(130e3, rel=1e-3)
    assert model.peak_pressure == pytest.approx(model.hertz.peak_pressure, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("cells, limit", ((3, 0.05), (4, 0.05), (5, 0.05), (6, 0.03)))
def test_lateral_and_spin_creep(cells, limit):
    """The whole model; creepages of both signs, as free rolling need not be free of a lateral force on a mesh.

    Limits 3 %, for spin 5 % with fewer cells than the default of 6: its force goes with the square of the length of
    each row. Found: docs/rolling.md.
    """
    model = CreepModel(WheelOnRail(cells=cells, **LOCOMOTIVE), whole=True)
    creep, spin = 5e-5, 5e-3
    force = model.curve(lateral=[creep, -creep, 0.0, 0.0], spin=[0.0, 0.0, spin, -spin], progress=False)["force"]
    lateral, spun = ((force[k + 1, 1] - force[k, 1]) / 2 / unit(model) for k in (0, 2))
    assert abs(lateral / creep) == pytest.approx(C22, rel=0.03)
    assert abs(spun) / (spin * np.sqrt(model.hertz.a * model.hertz.b)) == pytest.approx(C23, rel=limit)
