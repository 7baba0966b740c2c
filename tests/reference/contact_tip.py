# SPDX-License-Identifier: MIT
"""A body with a tip over a unit body, every node prescribed: single states of explicit contact, written by hand."""

import impact_reference as ir
import numpy as np
from reference_meshes import boundary, box, facets_where

DIMS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


class Tip:
    """The unit body below zero along the last axis, one cell along each (two simplices or six); a small cube that
    stands on its corner, whose facets at the tip are the slave. The tip follows path (num_steps + 2, gdim). roof: two
    cells that slope down from their common edge in the middle. density: of the cube. E: of both."""

    def __init__(self, cell, path, degree=1, axisymmetric=False, start=0.0, roof=0.0, density=1.0, E=1.0):
        d = DIMS[cell]
        turn = np.array([[1, -1], [1, 1.0]]) / 2**0.5 if d == 2 else _cube_on_its_corner()
        p, c = box(cell, (1,) * d)
        low, c_low = box(cell, (1,) * d if roof == 0 else (2,) + (1,) * (d - 1))
        low = low - np.eye(d)[-1] + start * np.eye(d)[0]
        top = low[:, -1] == 0
        low[:, -1] -= roof * np.abs(low[:, 0] - 0.5)
        points, cells = np.vstack([low, 0.2 * p @ turn.T + path[0]]), np.vstack([c_low, c + len(low)])
        hypothesis = "axisymmetric" if axisymmetric else "plane_strain" if d == 2 else "3d"
        materials = {k: ir.Material(E, 0.3, rho, hypothesis) for k, rho in enumerate((1.0, density))}
        tags = np.repeat([0, 1], [len(c_low), len(c)])
        self.model = ir.Model(points, cells, cell, cell_tags=tags, materials=materials, degree=degree)
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

    def press(self, contact, closed, **options):
        """Steps of 1 of kinematic contact, which looks at predictions: loads on the tip, free along the last axis and
        of no stiffness to speak of, have it on path there. Where it closes (num_steps + 1) it ends at zero; the cube
        goes with it. Gives the run and the tip's places."""
        places, z = self.path.copy(), self.path[:, -1]
        places[1:][np.asarray(closed, dtype=bool), -1] = 0
        before = np.diff(np.concatenate([places[:1], places[:-1]])[:, -1])  # steps before those to rows 1, 2, ...
        time = np.where(np.arange(len(before)) == 0, 0.5, 1.0)
        dof = self.gdim * (self.node + 1) - 1
        load = np.zeros(self.model.num_dofs)
        load[dof] = self.model.mass(lumped=True)[dof]
        levels = np.arange(float(len(places)))
        amplitudes = (levels[:-1], (z[1:] - places[:-1, -1] - before) / time)
        fixed = np.delete(np.arange(self.model.num_dofs), dof)
        motion = np.array([(self.moves * (x - places[0])).reshape(-1)[fixed] for x in places])
        run = self.model.run_explicit(
            1.0,
            len(places) - 2,
            fixed_dofs=fixed,
            values=(levels, motion),
            loads=[(load, amplitudes)],
            contacts=[contact],
            **options,
        )
        return run, places

    def row(self, run):
        """Of the tip among the slave's nodes."""
        return int(np.flatnonzero(run.contacts[0].nodes == self.node)[0])


def _cube_on_its_corner():
    up = np.ones(3) / 3**0.5
    side = np.array([1, -1, 0]) / 2**0.5
    return np.array([side, np.cross(up, side), up])
