# SPDX-License-Identifier: MIT
"""The contact patch test on any partition of the meshes: some ranks have no slave facets. See on_ranks.py."""

import functools

from mpi4py import MPI
from pressed_blocks import PressedBlocks, free_sides, hooke

import dolfinx_impact as di

# What the benchmark asks for; more in test_contact_patch.py.
EXACT = 1e-10
CHI = 1e7
CELLS = (("quadrilateral", 2, 2), ("tetrahedron", 3, 1))


def check_a_uniform_stress_passes():
    for cell, dim, degree in CELLS:
        strains = free_sides(dim, 0.3, -0.01)
        stress = hooke(strains, 0.3)
        penalty = {"method": functools.partial(di.Penalty, penalty=CHI), "rigid": True, "sink": -stress[-1] / CHI}
        augmented = functools.partial(di.Penalty, penalty=CHI, augmented=True, tolerance=1e-13)
        for more in ({"method": di.Lagrange}, penalty, {"method": augmented, "rigid": True}):
            blocks = PressedBlocks(cell, degree, strains, 0.3, comm=MPI.COMM_WORLD, **more)
            errors = (blocks.displacement_error(), blocks.stress_error(stress), blocks.pressure_error(-stress[-1]))
            force = abs(blocks.contact.force[-1] / stress[-1]) - 1
            assert max(*errors, abs(force)) < EXACT, (cell, degree, more, errors, force)
