# SPDX-License-Identifier: MIT
"""Pictures of the recipes: `xvfb-run -a python -m dolfinx_impact.meshes.figures [FOLDER]`, default results/meshes."""

import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np

from dolfinx_impact import compat
from . import make

COLOURS = ["#9ecae1", "#fdae6b", "#a1d99b", "#bcbddc", "#d9d9d9", "#fff7a8"]  # by body number
_VTK = {"triangle": 5, "quadrilateral": 9, "tetrahedron": 10, "hexahedron": 12}
_ORDER = {"quadrilateral": [0, 1, 3, 2], "hexahedron": [0, 1, 3, 2, 4, 5, 7, 6]}

# figure -> panels (recipe, parameters, centre of the view, half its height; None: everything, direction of the view)
FIGURES = {
    "blocks": [
        ("block", {"distortion": 0.25}, None, None, None),
        ("two_blocks", {"incline": 0.4, "gap": 0.05}, None, None, None),
        ("two_bars", {"lengths": (0.05, 0.05), "striker_cells": (20, 3), "target_cells": (20, 4)}, None, None, None),
    ],
    "round": [
        ("cylinder_on_half_plane", {"whole": True, "symmetry": "none", "height": 0.1}, None, None, None),
        ("cylinder_on_half_plane", {}, (0.01, 0, 0), 0.015, None),
        ("sphere_on_half_space", {"symmetry": "half"}, None, None, (1, -2, 0.6)),
    ],
    "indenters": [
        ("punch", {"fillet": 2e-3, "gap": 1e-3, "h": 1e-3, "block_height": 0.04}, None, None, None),
        ("wedge", {"symmetry": "none", "h": 1e-3, "gap": 5e-4}, (0, 0, 0), 0.02, None),
        ("cone", {"symmetry": "half", "gap": 1e-3}, None, None, (1, -2, 0.6)),
    ],
    "wheel_on_rail_2d": [
        ("wheel_on_rail_2d", {}, None, None, None),
        ("wheel_on_rail_2d", {}, (0, 0, 0), 0.03, None),
    ],
    "wheel_on_rail_3d": [
        ("wheel_on_rail_3d", {}, None, None, (1, 1.6, 0.5)),
        ("wheel_on_rail_3d", {"symmetry": "none"}, (0, 0, -0.04), 0.14, (1, -0.35, 0.1)),
    ],
    "rail_joint": [
        ("rail_joint_2d", {"wheel": True, "wheel_x": -0.05}, (0, 0, 0), 0.12, None),
        ("rail_joint_3d", {}, (0, 0.03, -0.08), 0.11, (1, 1.6, 0.4)),
    ],
    "insulated_joint": [
        ("insulated_joint_3d", {"rail_length": 0.6}, (0, 0, 0.12), 0.5, (1, 1.6, 0.4)),
        ("insulated_joint_3d", {"rail_length": 0.6}, (0, 0, -0.05), 0.1, (-0.6, -1.6, 0.5)),
    ],
}


def grid(made):
    """The mesh as a PyVista grid of straight cells, with the body numbers."""
    import pyvista

    mesh = made.mesh
    kind, count = mesh.topology.cell_name(), mesh.topology.index_map(mesh.topology.dim).size_local
    corners = compat.geometry_dofmap(mesh)[:count][:, _ORDER.get(kind, range(mesh.topology.dim + 1))]
    cells = np.hstack([np.full((count, 1), corners.shape[1]), corners]).ravel()
    out = pyvista.UnstructuredGrid(cells, np.full(count, _VTK[kind], dtype=np.uint8), mesh.geometry.x)
    body = np.zeros(count)
    body[made.cell_tags.indices] = made.cell_tags.values
    out.cell_data["body"] = body
    return out


def draw(panels, path, size=400):
    """Draw one figure; each panel is (recipe, parameters, centre, half height, direction)."""
    import pyvista
    from PIL import Image

    plotter = pyvista.Plotter(
        off_screen=True, shape=(1, len(panels)), border=False, window_size=(size * len(panels), size)
    )
    for k, (recipe, parameters, centre, half_height, direction) in enumerate(panels):
        plotter.subplot(0, k)
        plotter.set_background("white")
        plotter.enable_parallel_projection()
        made = make(recipe, MPI.COMM_SELF, **parameters)
        plotter.add_mesh(
            grid(made),
            scalars="body",
            clim=(1, len(COLOURS)),
            cmap=COLOURS,
            show_edges=True,
            show_scalar_bar=False,
            lighting=direction is not None,
        )
        if direction is None:
            plotter.view_xy()
        else:
            plotter.view_vector(direction, (0, 0, 1))
        if centre is None:
            plotter.camera.zoom(1.25)
        else:
            offset = np.array(plotter.camera.position) - np.array(plotter.camera.focal_point)
            plotter.camera.focal_point, plotter.camera.position = centre, np.array(centre) + offset
            plotter.camera.parallel_scale = half_height
    image = Image.fromarray(plotter.screenshot(return_img=True))
    image.quantize(48, dither=Image.Dither.NONE).save(path, optimize=True)  # a few tens of kB
    plotter.close()


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/meshes")
    folder.mkdir(parents=True, exist_ok=True)
    for name, panels in FIGURES.items():
        draw(panels, folder / f"{name}.png")
        print(folder / f"{name}.png")


if __name__ == "__main__":
    main()
