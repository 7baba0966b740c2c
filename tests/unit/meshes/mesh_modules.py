# SPDX-License-Identifier: MIT
"""The modules under test, installed or straight from the checkout, and what the tests here measure with."""

import importlib
import sys
import types
from pathlib import Path

import basix
import numpy as np

from dolfinx_impact import compat

CHECKOUT = Path(__file__).resolve().parents[3]

try:
    meshes = importlib.import_module("dolfinx_impact.meshes")
    mesh_input = importlib.import_module("dolfinx_impact.io.mesh_reader")
except ImportError:  # the package is not built: the sources themselves
    sys.path.insert(0, str(CHECKOUT))
    package = types.ModuleType("dolfinx_impact")
    package.__path__ = [str(CHECKOUT / "python" / "dolfinx_impact")]
    sys.modules["dolfinx_impact"] = package
    meshes = importlib.import_module("meshes")
    mesh_input = importlib.import_module("dolfinx_impact.io.mesh_reader")
committed = importlib.import_module(meshes.__name__ + ".committed")
wheel_rail = importlib.import_module(meshes.__name__ + ".wheel_rail")


def jacobians(mesh, at_vertices):
    """Jacobians (cells, points, gdim, tdim) of the owned cells at quadrature points (and vertices), and the weights."""
    cell = getattr(basix.CellType, mesh.topology.cell_name())
    cmap, tdim, gdim = compat.coordinate_element(mesh), mesh.topology.dim, mesh.geometry.dim
    element = basix.create_element(basix.ElementFamily.P, cell, cmap.degree, basix.LagrangeVariant(cmap.variant))
    points, weights = basix.make_quadrature(cell, 2 * cmap.degree + 1)
    if at_vertices:
        points = np.vstack([points, basix.geometry(cell)])
    shape = element.tabulate(1, points)[1:, :, :, 0]
    dofs = compat.geometry_dofmap(mesh)[: mesh.topology.index_map(tdim).size_local]
    return np.einsum("dqn,cng->cqgd", shape, mesh.geometry.x[dofs][:, :, :gdim]), weights


def quality(mesh):
    """Smallest det J / product of the lengths of J's columns; negative for a folded cell, either orientation."""
    jacobian, _ = jacobians(mesh, True)
    scaled = np.linalg.det(jacobian) / np.prod(np.linalg.norm(jacobian, axis=2), axis=2)
    return float(np.max([scaled.min(axis=1), -scaled.max(axis=1)], axis=0).min(initial=1.0))


def volumes(mesh, cell_tags):
    """Tag -> area or volume, over all ranks."""
    jacobian, weights = jacobians(mesh, False)
    part = np.abs(np.linalg.det(jacobian)) @ weights
    owned = cell_tags.indices < len(part)
    sums = {}
    for tag in range(1, 7):
        chosen = cell_tags.indices[owned & (cell_tags.values == tag)]
        sums[tag] = mesh.comm.allreduce(float(part[chosen].sum()))
    return {tag: value for tag, value in sums.items() if value > 0}


def exact(name, p):
    """Body name -> exact area or volume of a recipe with parameters p, for the default bodies."""
    pi = np.pi
    if name == "block":
        return {"master_body": np.prod(p["size"])}
    if name == "two_blocks":
        return {"master_body": np.prod(p["lower"]), "slave_body": np.prod(p["upper"])}
    if name == "two_bars":
        across = np.prod(p["section"])
        return {"slave_body": p["lengths"][0] * across, "master_body": p["lengths"][1] * across}
    if name == "cylinder_on_half_plane":
        sides = 1 if p["symmetry"] == "half" else 2
        disc = pi * p["radius"] ** 2 / (2 if p["whole"] else 4)
        return {"master_body": sides * p["width"] * p["height"], "slave_body": sides * disc}
    if name == "sphere_on_half_space":
        quarters = {"quarter": 1, "half": 2, "none": 4}[p["symmetry"]]
        ball = pi * p["radius"] ** 3 / (3 if p["whole"] else 6)
        return {"master_body": quarters * p["width"] ** 2 * p["height"], "slave_body": quarters * ball}
    if name in ("punch", "wedge"):
        sides = (1 if p["symmetry"] == "half" else 2) * (p["depth"] or 1.0)
        master = p["block_width"] * p["block_height"]
        if name == "punch":
            slave = p["half_width"] * p["height"] - (1 - pi / 4) * p["fillet"] ** 2
        else:
            rise = p["width"] / np.tan(p["angle"])
            slave = p["width"] * ((p["height"] or rise + 0.8 * p["width"]) - rise / 2)
        return {"master_body": sides * master, "slave_body": sides * slave}
    if name == "cone":
        quarters = {"quarter": 1, "half": 2, "none": 4}[p["symmetry"]]
        mean = (np.sqrt(2) + np.arcsinh(1.0)) / 3  # of the distance from a corner, over the unit square
        slave = p["width"] ** 2 * (p["height"] - mean * p["width"] / np.tan(p["angle"]))
        return {"master_body": quarters * p["block_width"] ** 2 * p["block_height"], "slave_body": quarters * slave}
    halves = {"quarter": 0.25, "half": 0.5, "none": 1.0}[p.get("symmetry", "none")]
    radius = p.get("radius", p.get("wheel_radius"))
    wheel = halves * pi * (radius**2 - p.get("hub_radius", 0.0) ** 2) * p.get("wheel_width", 1.0)
    if name == "wheel_on_rail_2d":
        return {"master_body": halves * p["rail_length"] * p["rail_height"], "slave_body": wheel}
    if name == "rolling_contact_3d":
        size, R = p["reach"] * max(p["a"], p["b"]), p["crown_radius"]
        drop = R * size - (size * np.sqrt(R**2 - size**2) + R**2 * np.arcsin(size / R)) / 2
        sector = size / radius * (radius**2 - (radius - size) ** 2)
        return {"master_body": 2 * size * (size**2 - drop), "slave_body": size * sector}
    if name == "wheel_on_rail_3d":
        area = wheel_rail.rail_area(p["crown_radius"], p["rail_height"])
        return {"master_body": halves * area * p["rail_length"], "slave_body": wheel}
    area = p["rail_height"]
    if name == "insulated_joint_3d":
        area = halves * wheel_rail.rail_area(p["crown_radius"], p["rail_height"])
        web = p["rail_height"] - wheel_rail.HEAD_DEPTH - wheel_rail.FOOT_DEPTH
        layer, rail = 2 * halves * web * p["bar_length"], area * (p["rail_length"] - p["gap"] / 2)
        return {
            "master_body": rail, "second_rail": rail, "slave_body": wheel,
            "end_post": area * p["gap"], "glue": p["glue"] * layer, "joint_bar": p["bar"] * layer,
        }  # fmt: skip
    if name == "rail_joint_3d":
        area = halves * wheel_rail.rail_area(p["crown_radius"], p["rail_height"])
    bodies = {"master_body": area * p["rail_length"], "second_rail": area * p["rail_length"]}
    if p["end_post"] != "none":
        bodies["end_post"] = area * p["gap"]
    elif p["joined"] and name == "rail_joint_2d":
        bodies["end_post"] = (p["rail_height"] - p["joined"]) * p["gap"]
    elif p["joined"]:
        bodies["end_post"] = halves * wheel_rail.web_and_foot_area(p["rail_height"]) * p["gap"]
    if p["wheel"]:
        bodies["slave_body"] = wheel
    return bodies


# (recipe, parameters, whether its boundary is curved); the names make the parametrisation readable
CASES = {
    "block": ("block", {}, False),
    "block_3d": ("block", {"size": (1.0, 2.0, 0.5), "cells": (4, 5, 3)}, False),
    "two_blocks": ("two_blocks", {}, False),
    "two_blocks_3d": (
        "two_blocks",
        {"lower": (1, 1, 0.5), "upper": (1, 1, 0.5), "lower_cells": (4, 4, 2), "upper_cells": (5, 3, 3)},
        False,
    ),
    "two_bars": ("two_bars", {}, False),
    "two_bars_3d": (
        "two_bars",
        {"section": (0.01, 0.01), "striker_cells": (20, 2, 2), "target_cells": (20, 3, 3)},
        False,
    ),
    "cylinder": ("cylinder_on_half_plane", {}, True),
    "cylinder_whole": ("cylinder_on_half_plane", {"whole": True, "symmetry": "none", "gap": 1e-3}, True),
    "sphere": ("sphere_on_half_space", {}, True),
    "sphere_whole": ("sphere_on_half_space", {"whole": True, "symmetry": "half", "a": 2e-3}, True),
    "punch": ("punch", {}, False),
    "punch_round": ("punch", {"fillet": 2e-3, "symmetry": "none"}, True),
    "punch_3d": ("punch", {"depth": 0.01, "depth_cells": 2, "h": 1.5e-3}, False),
    "wedge": ("wedge", {}, False),
    "wedge_3d": ("wedge", {"depth": 0.01, "a": 8e-3}, False),
    "cone": ("cone", {}, True),
    "wheel_2d": ("wheel_on_rail_2d", {}, True),
    "wheel_3d": ("wheel_on_rail_3d", {"a": 0.011, "rail_length": 0.4, "coarse": 0.08}, True),
    "rolling_contact": ("rolling_contact_3d", {"cells": 4}, True),
    "joint_2d": ("rail_joint_2d", {}, False),
    "joint_2d_wheel": ("rail_joint_2d", {"wheel": True, "end_post": "loose", "wheel_x": 0.1}, True),
    "joint_2d_rolling": (
        "rail_joint_2d",
        {
            "wheel": True,
            "end_post": "none",
            "h": 2e-3,
            "core": 0.03,
            "corner": 2e-3,
            "step": 1e-4,
            "joined": 0.03,
            "wheel_x": -0.02,
            "wheel_turn": 0.04,
        },
        True,
    ),
    "joint_3d_rolling": (
        "rail_joint_3d",
        {
            "wheel": True,
            "end_post": "none",
            "h": 8e-3,
            "coarse": 0.08,
            "core": 0.03,
            "corner": 2e-3,
            "step": 1e-4,
            "joined": True,
            "wheel_x": -0.02,
            "wheel_turn": 0.04,
        },
        True,
    ),
    "joint_3d": ("rail_joint_3d", {"h": 8e-3}, True),
    "insulated": ("insulated_joint_3d", {"h": 8e-3, "coarse": 0.1, "rail_length": 0.6}, True),
    "insulated_bars": ("insulated_joint_3d", {"h": 10e-3, "coarse": 0.1, "rail_length": 0.5, "tied": "bars"}, True),
    "insulated_apart": (
        "insulated_joint_3d",
        {"h": 10e-3, "coarse": 0.1, "rail_length": 0.5, "symmetry": "none", "tied": "all", "tied_size": 0.7},
        True,
    ),
    "insulated_whole": (
        "insulated_joint_3d",
        {"h": 10e-3, "coarse": 0.1, "rail_length": 0.5, "symmetry": "none"},
        True,
    ),
    "joint_3d_wheel": ("rail_joint_3d", {"wheel": True, "end_post": "none", "h": 8e-3, "coarse": 0.08}, True),
}
