# SPDX-License-Identifier: MIT
"""Every recipe: valid cells, the right size, all promised tags, curved nodes on the true surface; bad parameters."""

import numpy as np
import pytest
from dolfinx import fem
from mesh_modules import CASES, exact, mesh_input, meshes, quality, volumes
from mpi4py import MPI

from dolfinx_impact import compat

RECIPES = {name for name, _, _ in CASES.values()}
QUALITY = {"quadrilateral": 0.3, "hexahedron": 0.3, "triangle": 0.25, "tetrahedron": 0.005}
CUBE = {"block_3d", "two_blocks_3d", "two_bars_3d", "sphere", "sphere_whole", "cone", "wheel_3d"}
CUBE |= {"punch_3d", "wedge_3d", "joint_3d", "joint_3d_wheel", "joint_3d_rolling", "rolling_contact"}
HEXAHEDRA = {"insulated", "insulated_bars", "insulated_apart", "insulated_whole"}
CUBE |= HEXAHEDRA


def cells_of(case):
    if case in HEXAHEDRA:
        return ("hexahedron",)
    return ("hexahedron", "tetrahedron") if case in CUBE else ("quadrilateral", "triangle")


EVERY = [(case, cell, degree) for case in CASES for cell in cells_of(case) for degree in (1, 2)]


def test_names_are_complete():
    assert set(meshes.names()) == RECIPES


@pytest.mark.covering(1)
@pytest.mark.timeout(60)
@pytest.mark.parametrize("case, cell, degree", EVERY, ids=["-".join(map(str, e)) for e in EVERY])
def test_cells_size_and_tags(case, cell, degree):
    name, parameters, curved = CASES[case]
    m = meshes.make(name, MPI.COMM_SELF, cell=cell, degree=degree, **parameters)
    assert m.mesh.topology.cell_name() == cell and compat.coordinate_element(m.mesh).degree == degree
    assert quality(m.mesh) > QUALITY[cell]
    found, wanted = volumes(m.mesh, m.cell_tags), exact(name, m.parameters)
    assert set(found) == {meshes.BODIES[body] for body in wanted}
    tolerance = 1e-9 if not curved else (2e-2 if degree == 1 else 2e-3)
    for body, size in wanted.items():
        assert found[meshes.BODIES[body]] == pytest.approx(size, rel=tolerance), body
    report = mesh_input.check_mesh(m.mesh, m.cell_tags, m.facet_tags)
    numbers = {m.tags[key] for key in m.tags if key in meshes.FACETS}
    assert set(report.facet_counts) == numbers and set(report.cell_counts) == set(found)
    assert cell in ("triangle", "tetrahedron") or report.num_negative == 0


@pytest.mark.parametrize("case", CASES)
def test_every_outer_facet_has_one_tag(case):
    name, parameters, _ = CASES[case]
    m = meshes.make(name, MPI.COMM_SELF, **parameters)
    dim = m.mesh.topology.dim
    m.mesh.topology.create_connectivity(dim - 1, dim)
    connectivity = m.mesh.topology.connectivity(dim - 1, dim)
    outer = np.flatnonzero(np.diff(connectivity.offsets) == 1)
    assert np.array_equal(np.sort(m.facet_tags.indices), outer)


PROMISED = {
    "block_3d": "bottom top left right front back",
    "two_blocks_3d": "bottom top left right front back slave_left slave_right slave_front slave_back slave_surface "
    "master_surface",
    "cylinder": "symmetry_x top bottom right slave_surface master_surface",
    "cylinder_whole": "load bottom left right slave_surface master_surface free",
    "sphere": "symmetry_x symmetry_y top bottom right back slave_surface master_surface",
    "punch": "symmetry_x top bottom right slave_right slave_surface master_surface",
    "wedge_3d": "symmetry_x top bottom right slave_right slave_surface master_surface front back slave_front "
    "slave_back",
    "cone": "symmetry_x symmetry_y top bottom right back slave_surface master_surface slave_right slave_back",
    "two_bars": "slave_left slave_surface master_surface right bottom free",
    "wheel_2d": "hub slave_surface master_surface bottom left right free",
    "wheel_3d": "hub slave_surface master_surface bottom left right free symmetry_y slave_back",
    "joint_2d": "left right bottom master_surface",
    "joint_2d_wheel": "left right bottom master_surface joint_left joint_right post_left post_right hub "
    "slave_surface free",
    "joint_2d_rolling": "left right bottom master_surface joint_left joint_right hub slave_surface free",
    "joint_3d": "left right bottom master_surface free symmetry_y",
    "insulated": "left right bottom master_surface hub slave_surface slave_back free symmetry_y",
    "insulated_whole": "left right bottom master_surface hub slave_surface slave_front slave_back free",
    "insulated_bars": "left right bottom master_surface hub slave_surface slave_back free symmetry_y web bar_face",
    "insulated_apart": "left right bottom master_surface hub slave_surface slave_front slave_back free web bar_face "
    "joint_left joint_right post_left post_right",
    "joint_3d_rolling": "left right bottom master_surface joint_left joint_right hub slave_surface slave_back free "
    "symmetry_y",
}


def test_folded_cells_are_an_error():
    """A coarse curved bore of a thin wheel: gmsh folds tetrahedra there, and the recipe must not hand them on."""
    parameters = {"a": 0.01, "hub_radius": 0.02, "coarse": 0.2, "wheel_width": 0.035}
    try:
        m = meshes.make("wheel_on_rail_3d", MPI.COMM_SELF, cell="tetrahedron", degree=2, **parameters)
    except RuntimeError as error:
        assert "folded" in str(error) and "smaller cells" in str(error)
    else:
        assert quality(m.mesh) > 0


@pytest.mark.parametrize("tied, number", [("none", 2), ("bars", 3), ("all", 5)])
def test_parts_of_a_joint_that_are_tied_have_nodes_of_their_own(tied, number):
    """Rails and end post, bars with their glue, wheel: what shares nodes is one part."""
    name, parameters, _ = CASES["insulated"]
    plan, _, _ = meshes.layout(name, **{**parameters, "tied": tied})
    nodes = {body.name: set() for body in plan.bodies}
    for body in plan.bodies:
        nodes[body.name].update(p for block in body.blocks for p in block)
    parts = []
    for own in nodes.values():
        met = [part for part in parts if part & own]
        parts = [part for part in parts if not part & own] + [own.union(*met)]
    assert len(parts) == number  # rails whose end post is apart do not touch each other
    assert nodes["glue"] & nodes["joint_bar"]
    assert bool(nodes["glue"] & nodes["master_body"]) == (tied == "none")


@pytest.mark.parametrize("case", PROMISED)
def test_promised_tags(case):
    name, parameters, _ = CASES[case]
    plan, _, _ = meshes.layout(name, **parameters)
    assert set(plan.outer_facets()) == set(PROMISED[case].split())


def test_separate_bodies_share_no_node():
    m = meshes.make("wheel_on_rail_2d", MPI.COMM_SELF)
    nodes = [set(compat.geometry_dofmap(m.mesh)[m.cell_tags.find(tag)].ravel()) for tag in (1, 2)]
    assert not nodes[0] & nodes[1]
    glued = meshes.make("rail_joint_2d", MPI.COMM_SELF, end_post="glued")
    nodes = [set(compat.geometry_dofmap(glued.mesh)[glued.cell_tags.find(tag)].ravel()) for tag in (1, 3)]
    assert len(nodes[0] & nodes[1]) > 2


def contact_nodes(m, name):
    """Coordinates of all geometry nodes on a tagged surface."""
    space = fem.functionspace(m.mesh, ("Lagrange", compat.coordinate_element(m.mesh).degree))
    dofs = fem.locate_dofs_topological(space, m.mesh.topology.dim - 1, m.facet_tags.find(m.tags[name]))
    return space.tabulate_dof_coordinates()[dofs]


@pytest.mark.parametrize("degree", [1, 2])
def test_nodes_lie_on_the_true_surface(degree):
    m = meshes.make("cylinder_on_half_plane", MPI.COMM_SELF, degree=degree, gap=1e-3)
    x = contact_nodes(m, "slave_surface")
    assert np.allclose(np.hypot(x[:, 0], x[:, 1] - 0.051), 0.05, rtol=1e-12)
    m = meshes.make("sphere_on_half_space", MPI.COMM_SELF, degree=degree)
    assert np.allclose(np.linalg.norm(contact_nodes(m, "slave_surface") - (0, 0, 0.01), axis=1), 0.01, rtol=1e-12)
    m = meshes.make(
        "wheel_on_rail_3d", MPI.COMM_SELF, degree=degree, wheel_crown_radius=0.33, symmetry="quarter", a=0.01
    )
    x = contact_nodes(m, "slave_surface")
    tread = 0.46 - (0.33 - np.sqrt(0.33**2 - x[:, 1] ** 2))
    assert np.allclose(np.hypot(x[:, 0], x[:, 2] - 0.46), tread, rtol=1e-9)
    x = contact_nodes(m, "master_surface")
    assert np.allclose(np.hypot(x[:, 1], x[:, 2] + 0.30), 0.30, rtol=1e-12)


@pytest.mark.parametrize("name, joined", [("rail_joint_2d", 0.03), ("rail_joint_3d", True)])
def test_the_way_of_a_wheel(name, joined):
    """Rounded and raised rail ends, a turned wheel that is round, whose lowest point is where it should be."""
    m = meshes.make(
        name, MPI.COMM_SELF, wheel=True, end_post="none", h=4e-3, core=0.03, corner=2e-3, step=1e-4, joined=joined,
        wheel_x=-0.02, wheel_turn=0.02 / 0.46,
    )  # fmt: skip
    up = m.mesh.geometry.dim - 1
    rail, rim = contact_nodes(m, "master_surface"), contact_nodes(m, "slave_surface")
    crown = np.zeros(len(rail)) if up == 1 else np.sqrt(0.3**2 - rail[:, 1] ** 2) - 0.3
    middle = np.abs(rail[:, 1]) < 1e-9 if up == 2 else slice(None)
    x, drop = rail[middle, 0], (rail[:, up] - crown)[middle]
    assert np.allclose(drop[(x < -6.1e-3)], 0.0, atol=1e-12) and np.allclose(drop[x > 6.1e-3], 1e-4, atol=1e-12)
    assert drop[np.abs(x + 4e-3) < 1e-9].item() == pytest.approx(-1e-3) and np.abs(x).min() == pytest.approx(4e-3)
    assert np.allclose(np.hypot(rim[:, 0] + 0.02, rim[:, up] - 0.46), 0.46, rtol=1e-12)
    # The fine zone, 30 mm to either side, is turned forward by 20 mm.
    angle = np.arcsin((rim[:, 0] + 0.02) / 0.46)
    assert angle.min() == pytest.approx(-0.01 / 0.46, rel=1e-6) and angle.max() == pytest.approx(0.05 / 0.46, rel=1e-6)


def test_curved_volumes_converge():
    errors = {1: [], 2: []}
    for degree in errors:
        for h in (2e-3, 1e-3):
            m = meshes.make("cylinder_on_half_plane", MPI.COMM_SELF, degree=degree, h=h, coarse=10 * h)
            disc = np.pi * 0.05**2 / 4
            errors[degree].append(abs(volumes(m.mesh, m.cell_tags)[2] / disc - 1))
    assert errors[1][0] / errors[1][1] > 3 and errors[2][0] / errors[2][1] > 8, errors


def test_contact_is_graded():
    m = meshes.make("cylinder_on_half_plane", MPI.COMM_SELF, a=5e-3, h=2.5e-4)
    x = contact_nodes(m, "slave_surface")
    steps = np.diff(np.sort(x[x[:, 0] < 5e-3, 0]))
    assert np.all(steps <= 2.5e-4 * (1 + 1e-6)) and np.all(steps > 1e-4)


def test_rail_section_is_close_to_60e1():
    m = meshes.make("wheel_on_rail_3d", MPI.COMM_SELF, a=0.01, rail_length=0.2)
    area = 2 * volumes(m.mesh, m.cell_tags)[1] / 0.2
    assert area == pytest.approx(76.7e-4, rel=0.05)
    assert m.parameters["radius"] == 0.46 and m.parameters["crown_radius"] == 0.30
    z = m.mesh.geometry.x[compat.geometry_dofmap(m.mesh)[m.cell_tags.find(1)].ravel(), 2]
    assert np.ptp(z) == pytest.approx(0.172)


@pytest.mark.parametrize(
    "name, parameters, words",
    [
        ("wheel", {}, "no mesh recipe 'wheel'; there are: block"),
        ("block", {"widht": 1.0}, "no parameter ['widht']; it takes cell, degree, size"),
        ("block", {"cell": "wedge"}, "quadrilateral or triangle"),
        ("block", {"cell": "hexahedron"}, "block in 2D"),
        ("block", {"degree": 3}, "degree = 3"),
        ("block", {"size": (1.0, -1.0)}, "size[1] = -1.0"),
        ("block", {"cells": (4, 2.5)}, "cells[1] = 2.5"),
        ("block", {"size": (1, 1, 1)}, "as many as lengths"),
        ("block", {"distortion": 0.6}, "distortion = 0.6"),
        ("two_blocks", {"incline": 1.2}, "incline = 1.2"),
        ("two_blocks", {"gap": float("nan")}, "gap = nan"),
        ("cylinder_on_half_plane", {"radius": -1.0}, "radius = -1.0"),
        ("cylinder_on_half_plane", {"radius": "big"}, "radius = 'big'"),
        ("cylinder_on_half_plane", {"symmetry": "third"}, "one of none, half"),
        ("cylinder_on_half_plane", {"a": 0.2}, "core ="),
        ("sphere_on_half_space", {"h": 0.0}, "h = 0.0"),
        ("punch", {"fillet": 0.5}, "fillet = 0.5"),
        ("wedge", {"angle": 2.0}, "between 0 and pi/2"),
        ("cone", {"height": 1e-3}, "lower than the flank"),
        ("two_bars", {"gap": -1.0}, "gap = -1.0"),
        ("wheel_on_rail_2d", {"hub_radius": 0.4}, "hub_radius = 0.4"),
        ("wheel_on_rail_3d", {"crown_radius": 0.01}, "crown_radius = 0.01"),
        ("insulated_joint_3d", {"tied": "welds"}, "tied = 'welds': one of none, bars, all"),
        ("rail_joint_2d", {"end_post": "welded"}, "one of glued, loose, none"),
        ("rail_joint_2d", {"corner": 2e-3}, "no end post"),
        ("rail_joint_2d", {"corner": 3e-3, "end_post": "none", "joined": 0.01}, "between 4 corner"),
        ("rail_joint_2d", {"step": 1e-4}, "torn"),
        ("rail_joint_2d", {"core": 1e-3}, "core = 0.001"),
        ("rail_joint_2d", {"wheel": True, "wheel_turn": float("nan")}, "wheel_turn = nan"),
    ],
)
def test_bad_parameters(name, parameters, words):
    with pytest.raises(ValueError) as caught:
        meshes.make(name, MPI.COMM_SELF, **parameters)
    assert words in str(caught.value)


def test_the_profile_of_a_head_is_the_same_along_the_joint():
    """Nodes that rails and end post share move once: along a line of the tread the height is that of the profile."""
    y = np.linspace(-0.036, 0.036, 9)
    profile = [(float(v), float(-15.0 * v**2)) for v in y]
    small = {"h": 10e-3, "coarse": 0.1, "rail_length": 0.5, "bar_length": 0.3, "symmetry": "none"}
    m = meshes.make("insulated_joint_3d", MPI.COMM_SELF, head_profile=profile, **small)
    x = m.mesh.geometry.x
    tops = {}
    for body in ("master_body", "end_post", "second_rail"):
        nodes = np.unique(compat.geometry_dofmap(m.mesh)[m.cell_tags.find(m.tags[body])])
        inner = x[nodes][np.abs(x[nodes, 1]) < 1e-9]  # the middle of the head, where the profile is zero
        tops[body] = inner[inner[:, 2] > -1e-3]
        assert len(tops[body]) >= 2 and np.abs(tops[body][:, 2]).max() < 1e-12, body
        side = x[nodes][np.abs(x[nodes, 1] - 0.036) < 1e-6]
        assert side[:, 2].max() == pytest.approx(-15.0 * 0.036**2, abs=1e-9), body
    assert np.abs(tops["end_post"][:, 0]).max() == pytest.approx(4e-3)
