# SPDX-License-Identifier: MIT
"""A steel tube that is crushed along its axis and buckles into folds, which touch each other and the tube itself.

Mean load of a fold: Alexander, An approximate analysis of the collapse of thin cylindrical shells under axial loading,
Quarterly Journal of Mechanics and Applied Mathematics 13 (1960), P = K Y t^(3/2) D^(1/2), K about 6.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from flying_bodies import Flying
from mpi4py import MPI

import dolfinx_impact as di

R, T, LENGTH, Y = 10.0, 1.2, 36.0, 300.0  # mean radius, thickness, length [mm], yield stress [MPa]
HARDENING = 500.0  # [MPa]
SPEED, WAY = 30e3, 22.0  # of the upper plate [mm/s], its way [mm]


def tube(p):
    """Map of the unit box: around, through the thickness inward, along."""
    angle, r = -2.0 * np.pi * p[:, 0], R + T * (0.5 - p[:, 1])
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), LENGTH * p[:, 2]])


@pytest.mark.slow
def test_a_tube_buckles_into_itself(tmp_path):
    steel = di.J2Plasticity(210e3, 0.3, 7.85e-9, yield_stress=Y, hardening=HARDENING, finite_strain=True)
    bodies = Flying([((32, 2, 44), tube, (0.0, 0.0, 0.0))], "hexahedron", steel, MPI.COMM_SELF)
    lower, upper = (di.RigidPlane((0.0, 0.0, z), (0.0, 0.0, n)) for z, n in ((-1e-3, 1.0), (LENGTH + 1e-3, -1.0)))
    upper.motion = lambda t: (0.0, 0.0, -SPEED * t)
    plates = [di.Penalty(di.ContactPair(bodies.tags, 1, plate, friction=0.3)) for plate in (lower, upper)]
    problem = bodies.problem(contact=[*plates, di.GeneralContact(bodies.tags, friction=0.2)])
    general = problem.contact[2]
    load, most, deepest = [], 0, 0.0
    for part in np.linspace(0.0, 1.0, 111)[1:]:
        problem.advance(until=part * WAY / SPEED, progress=False)
        load.append(0.5 * (problem.contact[0].force[2] - problem.contact[1].force[2]))
        most, deepest = max(most, general.num_springs[0]), max(deepest, general.deepest)
    folder = Path(os.environ.get("IMPACT_PICTURES", tmp_path))
    di.DeformedBody(problem.u, problem.von_mises).save(folder / "buckled_tube.png", label="von Mises stress [MPa]")
    energy = problem.energy
    # The steel hardens: mean plastic strain e and mean flow stress by the plastic work W = V (Y e + H e^2 / 2).
    work = energy["plastic"] / (2.0 * np.pi * R * T * LENGTH)
    strain = (np.sqrt(Y**2 + 2.0 * HARDENING * work) - Y) / HARDENING
    mean, alexander = np.mean(load[20:]), 6.0 * work / strain * T**1.5 * np.sqrt(2.0 * R)
    print(f"mean load {mean:.0f} N, Alexander {alexander:.0f} N; {most} nodes, deepest {deepest / T:.3f} t; {energy}")
    assert most > 20 and deepest < 0.1 * T
    assert 0.9 < mean / alexander < 1.8  # hinges of a thickness of a sixth of the fold, two layers of cells
    assert energy["plastic"] > 0.8 * energy["external"] and abs(energy["drift"]) < 1e-3
