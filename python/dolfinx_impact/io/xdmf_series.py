# SPDX-License-Identifier: MIT
"""Series of frames in XDMF with HDF5, without ADIOS2: rank 0 writes what it gathers.

h5py reads the numbers, ParaView the .xdmf file. Both files are complete after every frame, and a disk that is full
leaves them as they were (hdf5.py).
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx import fem

from ..common.collective import common
from ..common.described import Described
from ..common.types import AnyArray, FloatArray
from . import hdf5
from .gather import Gathered, gather_field
from .output_folder import OutputFolder

if TYPE_CHECKING:
    import h5py

# XDMF's names of cells by name and number of nodes; those of VTK's order of nodes, as DOLFINx's XDMFFile writes them.
TOPOLOGIES = {
    ("interval", 2): "Polyline",
    ("interval", 3): "Edge_3",
    ("triangle", 3): "Triangle",
    ("triangle", 6): "Triangle_6",
    ("quadrilateral", 4): "Quadrilateral",
    ("quadrilateral", 9): "Quadrilateral_9",
    ("tetrahedron", 4): "Tetrahedron",
    ("tetrahedron", 10): "Tetrahedron_10",
    ("hexahedron", 8): "Hexahedron",
    ("hexahedron", 27): "Hexahedron_27",
    ("prism", 6): "Wedge",
}
ATTRIBUTES = {1: "Scalar", 3: "Vector", 9: "Tensor"}


class XdmfSeries(Described):
    """Series of frames in two files, NAME.xdmf and NAME.h5. Collective.

    Datasets of NAME.h5: `mesh/points` (num_nodes, 3) and `mesh/cells` (num_cells, nodes per cell), nodes of the
    functions; `time`; for each function `fields/<name>/<frame>`, (num_nodes, components), with its unit as an
    attribute. Vectors of a plane mesh have a third component of zero, as ParaView wants them.

    Args:
        folder: folder that the series is written into.
        name: name of the series, ending in .xdmf.
        functions: Lagrange functions of one element, named.
        units: pairs of a name, without a unit in brackets, and its unit.

    Attributes:
        path: path of the .xdmf file.

    Raises:
        RuntimeError: no room, or the folder cannot be written; on all ranks.
        ValueError: XDMF has no cells of this type and degree; on all ranks.
    """

    def __init__(
        self,
        folder: OutputFolder,
        name: str,
        functions: Sequence[fem.Function],
        units: Sequence[tuple[str, str]] = (),
    ) -> None:
        self.folder, self.path, self._functions = folder, folder.file(name), list(functions)
        self._data, self._units = self.path.with_suffix(".h5"), dict(units)
        self._times: list[float] = []
        V = functions[0].function_space
        self._cell = V.mesh.topology.cell_name(), V.dofmap.list.shape[1]
        if self._cell not in TOPOLOGIES or not V.ufl_element().family_name == "P":
            raise common(ValueError(
                f"{name}: XDMF has no {self._cell[0]} cells of {self._cell[1]} nodes: write the ending .bp, which "
                "ParaView reads, or fields of degree 1 or 2"
            ))  # fmt: skip
        self._sizes = (0, 0)  # numbers of nodes and cells, on rank 0
        gathered = gather_field(functions[0])
        folder.write(self._data.name, lambda: hdf5.create(self._data, lambda file: self._begin(file, gathered)))

    def _begin(self, file: h5py.File, gathered: Gathered) -> None:
        """Fill the new file of numbers, on rank 0."""
        from dolfinx.cpp.io import perm_vtk
        from dolfinx.cpp.mesh import to_type

        assert gathered.points is not None and gathered.cells is not None  # on rank 0
        order = np.argsort(perm_vtk(to_type(self._cell[0]), self._cell[1]))
        file.create_dataset("mesh/points", data=_three(gathered.points))
        file.create_dataset("mesh/cells", data=gathered.cells[:, order].astype(np.int64))
        file.create_dataset("time", (0,), maxshape=(None,), dtype=float, chunks=True)
        self._sizes = len(gathered.points), len(gathered.cells)

    def write(self, now: float) -> None:
        """Add a frame with the present values. Collective.

        Args:
            now: time of the frame [T].

        Raises:
            FolderGone: the series was removed; on all ranks.
            RuntimeError: no room; on all ranks. Earlier frames are complete.
        """
        values = [gather_field(f).values for f in self._functions]

        def add(file: h5py.File) -> None:
            file["time"].resize(len(self._times) + 1, axis=0)
            file["time"][-1] = now
            for f, rows in zip(self._functions, values):
                assert rows is not None  # on rank 0
                place = f"fields/{_plain(f.name)}/{len(self._times)}"
                if place in file:  # of a frame whose text could not be written
                    del file[place]
                dataset = file.create_dataset(place, data=_shown(rows))
                if _plain(f.name) in self._units:
                    dataset.attrs["units"] = self._units[_plain(f.name)]

        def work() -> None:
            hdf5.update(self._data, add)
            hdf5.write_whole(self.path, self._text([*self._times, now]))

        self.folder.write(self._data.name, work)
        self._times.append(now)

    def _text(self, times: Sequence[float]) -> str:
        """The .xdmf file with frames at some times, on rank 0."""
        root = ElementTree.Element("Xdmf", Version="3.0")
        domain = ElementTree.SubElement(root, "Domain")
        series = ElementTree.SubElement(
            domain, "Grid", Name=self.path.stem, GridType="Collection", CollectionType="Temporal"
        )
        nodes, cells = self._sizes
        for frame, now in enumerate(times):
            grid = ElementTree.SubElement(series, "Grid", Name="mesh", GridType="Uniform")
            ElementTree.SubElement(grid, "Time", Value=repr(float(now)))
            kind, per_cell = TOPOLOGIES[self._cell], self._cell[1]
            topology = ElementTree.SubElement(
                grid, "Topology", TopologyType=kind, NumberOfElements=str(cells), NodesPerElement=str(per_cell)
            )
            self._item(topology, "mesh/cells", (cells, per_cell), "Int")
            geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
            self._item(geometry, "mesh/points", (nodes, 3), "Float")
            for f in self._functions:
                columns = _columns(f.function_space.dofmap.bs)
                attribute = ElementTree.SubElement(
                    grid, "Attribute", Name=f.name, AttributeType=ATTRIBUTES.get(columns, "Matrix"), Center="Node"
                )
                self._item(attribute, f"fields/{_plain(f.name)}/{frame}", (nodes, columns), "Float")
                if _plain(f.name) in self._units:
                    ElementTree.SubElement(attribute, "Information", Name="units", Value=self._units[_plain(f.name)])
        ElementTree.indent(root)
        return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"

    def _item(self, parent: Any, place: str, shape: tuple[int, int], kind: str) -> None:
        """Add a reference to a dataset."""
        item = ElementTree.SubElement(
            parent, "DataItem", Dimensions=f"{shape[0]} {shape[1]}", NumberType=kind, Precision="8", Format="HDF"
        )
        item.text = f"{self._data.name}:/{place}"

    def close(self) -> None:
        """Check that the series is there: its files are complete after every frame. Collective.

        Raises:
            FolderGone: the series was removed; on all ranks.
        """
        self.folder.write(self._data.name, lambda: os.stat(self._data))


def _plain(name: str) -> str:
    """Name of a function's datasets: without its unit, and no path."""
    return name.partition(" [")[0].replace("/", "_")


def _columns(components: int) -> int:
    """Number of components that are written."""
    return 3 if components == 2 else components


def _three(points: FloatArray) -> FloatArray:
    """Points with three coordinates."""
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def _shown(rows: AnyArray) -> AnyArray:
    """Values with the components that are written."""
    return np.pad(rows, ((0, 0), (0, _columns(rows.shape[1]) - rows.shape[1])))
