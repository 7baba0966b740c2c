# SPDX-License-Identifier: MIT
"""Random variations of runs with contact.

Every run with contact is repeated from other initial states and with other steps, so that a difference between the
contact rules of the two sides cannot stay hidden by chance.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from dolfinx.mesh import Mesh

from dolfinx_impact import compat
from dolfinx_impact.common.types import FloatArray
from .scenario import USUAL_FRACTION, Scenario
from .placed_bodies import upper_nodes


class RandomVariation:
    """Random variation of a run: time step, rotation of the upper body, direction of its velocity, and its spin.

    Args:
        seed: seed of the random numbers; None leaves a run unchanged.
    """

    def __init__(self, seed: int | None = None) -> None:
        self.seed = seed
        rng = np.random.default_rng(seed)
        self.step_fraction = USUAL_FRACTION if seed is None else rng.uniform(0.7, 0.9)
        self.angles, self.direction, self.spin = rng.uniform(-1, 1, (3, 3)) * [[0.3], [0.5], [0.3]]
        self.phases = rng.uniform(0, 2 * np.pi, 3)

    def rotate_upper_body(self, domain: Mesh, top: Callable[[FloatArray], FloatArray] | None = None) -> None:
        """Rotate the upper body about its centre and keep its least height above the lower body.

        The body falls from the same gap then, and touches before it has turned or moved far.

        Args:
            domain: mesh of two bodies, which is changed.
            top: height of the lower body's upper face as a function of positions, shape (n, 3) to (n); None: the face
                is level [L].
        """
        if self.seed is None:
            return
        dim = domain.geometry.dim
        x, upper = domain.geometry.x, upper_nodes(domain)
        dofmap = compat.geometry_dofmap(domain)
        cells = dofmap[upper[dofmap].all(axis=1)]

        def height() -> float:
            # Facets may be nearer than their nodes where the lower body is curved: in the middle, or nearly there.
            places = 0.5 * (x[cells[:, :, None]] + x[cells[:, None, :]]).reshape(-1, 3)
            above = places[:, dim - 1] - (0.0 if top is None else top(places))
            return float(above.min())

        low, centre = height(), x[upper].mean(axis=0)
        x[upper, :dim] = ((x[upper] - centre) @ _rotation(self.angles, dim).T + centre)[:, :dim]
        x[upper, dim - 1] += low - height()

    def apply(self, case: Scenario) -> Scenario:
        """Vary the time step and the initial velocity of a run.

        Args:
            case: run.

        Returns:
            Run with another step, and a velocity that is rotated and has spin and waves added.
        """
        if self.seed is None:
            return case

        def velocity(positions: FloatArray) -> FloatArray:
            dim = positions.shape[1]
            v = case.velocity(positions)
            size = max(np.abs(v).max(), 0.02)
            moving = np.any(v != 0.0, axis=1)
            x = np.pad(positions, ((0, 0), (0, 3 - dim)))
            v = (np.pad(v, ((0, 0), (0, 3 - dim))) @ _rotation(self.direction, dim).T)[:, :dim]
            axis = self.spin if dim == 3 else [0.0, 0.0, self.spin[2]]
            if moving.any():
                v[moving] += np.cross(axis, x[moving] - x[moving].mean(axis=0))[:, :dim]
            v += 0.05 * size * np.sin(positions @ np.ones((dim, dim)) * 3 + self.phases[:dim])
            v[np.asarray(case.fixed_nodes, dtype=np.int64)] = 0.0
            return v

        name = f"{case.name}, variation {self.seed}"
        return replace(case, name=name, velocity=velocity, step_fraction=self.step_fraction)


def _rotation(angles: FloatArray, dim: int) -> FloatArray:
    """Rotation matrix of a vector of angles; in the plane about the third axis only."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angles if dim == 3 else [0.0, 0.0, angles[2]]).as_matrix()
