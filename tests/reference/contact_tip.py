"""A body with a tip over a unit body, every node prescribed: single states of explicit contact, written by hand."""

import impact_reference as ir
import numpy as np
from reference_meshes import boundary, box, facets_where

DIMS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


class Tip:
    """The unit body below zero along the last axis, one cell along each (two simplices or six); a small cube that
    stands on its corner, whose facets at the tip are the slave. The tip follows path (num_steps + 2, gdim). roof: two
    cells that slope down from their common edge in the middle."""

    def __init__(self, cell, path, degree=1, axisymmetric=False, start=0.0, roof=0.0):
        d = DIMS[cell]
        turn = np.array([[1, -1], [1, 1.0]]) / 2**0.5 if d == 2 else _cube_on_its_corner()
        p, c = box(cell, (1,) * d)
        low, c_low = box(cell, (1,) * d if roof == 0 else (2,) + (1,) * (d - 1))
        low = low - np.eye(d)[-1] + start * np.eye(d)[0]
        top = low[:, -1] == 0
        low[:, -1] -= roof * np.abs(low[:, 0] - 0.5)
        points, cells = np.vstack([low, 0.2 * p @ turn.T + path[0]]), np.vstack([c_low, c + len(low)])
        hypothesis = "axisymmetric" if axisymmetric else "plane_strain" if d == 2 else "3d"
        self.model = ir.Model(points, cells, cell, ir.Material(1.0, 0.3, 1.0, hypothesis), degree=degree)
        sides = [facets_where(p, c, cell, lambda x, k=k: x[k] == 0) for k in range(d)]
        self.slave = np.vstack(sides) + len(low)
        tops = set(np.flatnonzero(top))
        self.master = np.array([f for f in boundary(c_low, cell) if tops.issuperset(f)])
        self.path, self.gdim = path, d
        self.node = int(np.argmin(np.linalg.norm(self.model.field_points - path[0], axis=1)))
        upper = np.zeros(len(self.model.field_points), dtype=bool)
        upper[np.unique(self.model.field_cells[len(c_low) :])] = True
        self.moves = np.where(upper[:, None], 1.0, 0.0) * np.ones(d)

    def run(self, contact, **options):
        """Steps of 1."""
        levels = np.arange(float(len(self.path)))
        motion = np.array([(self.moves * (x - self.path[0])).reshape(-1) for x in self.path])
        every = np.arange(self.model.num_dofs)
        return self.model.run_explicit(
            1.0, len(self.path) - 2, fixed_dofs=every, values=(levels, motion), contacts=[contact], **options
        )

    def row(self, run):
        """Of the tip among the slave's nodes."""
        return int(np.flatnonzero(run.contacts[0].nodes == self.node)[0])


def _cube_on_its_corner():
    up = np.ones(3) / 3**0.5
    side = np.array([1, -1, 0]) / 2**0.5
    return np.array([side, np.cross(up, side), up])
