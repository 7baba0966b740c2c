# SPDX-License-Identifier: MIT
"""Mortar contact after its candidates were exchanged anew: matrices whose places stay the same are kept."""

import numpy as np
from dolfinx import fem

import dolfinx_impact as di
from impact_verify.contact_bodies import MASTER, SLAVE, steel, two_bodies


def test_integrals_survive_new_exchanges():
    """Both bodies fly together, further than the candidates hold: integrals and jumps are those of the start."""
    domain, tags = two_bodies("quadrilateral", (4, 2), (3, 2), start=(0.17,))
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    pair = di.ContactPair(tags, SLAVE, MASTER, search_distance=0.4)
    problem = di.StaticProblem(u, steel("plane_strain"), contact=[di.Lagrange(pair)])
    geometry = problem.contact[0].geometry
    rng = np.random.default_rng(1)
    moved = rng.uniform(-1, 1, len(u.x.array))
    geometry.update_gap(u.x.array)
    jump, exchanges = geometry.jump(moved), geometry.search.num_exchanges
    assert np.abs(jump).max() > 0.1
    for distance in (0.5, 1.0, 1.5, 2.0):
        there = np.tile([distance, 0.0], len(moved) // 2)
        geometry.begin_step(there)
        geometry.update_gap(there)
        _ = [fem.Function(u.function_space).x.petsc_vec for _ in range(3)]  # takes up what was set free
        assert np.allclose(geometry.jump(moved), jump, rtol=0.0, atol=1e-12)
    assert geometry.search.num_exchanges >= exchanges + 4
