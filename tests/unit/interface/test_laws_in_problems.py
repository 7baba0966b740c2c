# SPDX-License-Identifier: MIT
"""Laws of the interface in static, implicit and explicit problems."""

import dolfinx_impact as di
import law_checks
import numpy as np
import pytest
from blocks import BOTTOM, TOP, Blocks
from dolfinx_impact import interface
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(law_checks)

LAWS = {
    "exponential": lambda: interface.exponential_pressure(2e3, 0.1),
    "damped": lambda: interface.damped_contact(1e4, 2.0),
    "friction": lambda: interface.linear_pressure(1e4, friction=0.3),
    "falling friction": lambda: interface.linear_pressure(1e4, friction=interface.falling_friction(0.5, 0.2, 0.02)),
    "cohesive": lambda: interface.cohesive_zone(1e4, 200.0, 8.0, 300.0, 12.0),
    "anisotropic": lambda: interface.anisotropic_friction(1e4, (0.6, 0.2), (1.0, 0.5, 0.0)),
    "energy": lambda: di.InterfaceLaw(energy=lambda gap, slip: 5e3 * gap**2 + 2e3 * slip[0] ** 2 + 1e3 * gap * slip[1]),
}


# In the plane a limit that depends on the direction has no meaning.
CELLS = [(name, cell) for name in LAWS for cell in ("quadrilateral", "hexahedron")[name == "anisotropic" :]]


@pytest.mark.parametrize("name, cell", CELLS)
def test_tangent_is_the_derivative_of_the_forces(name, cell):
    """After an increment with history, against differences of the contact forces, on surfaces that turn."""
    lower, upper = law_checks.CASES[cell]
    blocks = Blocks(cell, lower, upper, narrow=0.1)
    law = LAWS[name]()
    material = law_checks.stiff(blocks.dim)
    bcs = [*blocks.held(BOTTOM, *range(blocks.dim)), *blocks.held(TOP, *range(blocks.dim))]
    problem = di.StaticProblem(blocks.u, material, bcs=bcs, contact=[di.Penalty(blocks.pair(), law=law)])
    contact = problem.contact[0]._cpp_object
    contact.set_time_step(0.5)
    first = blocks.random(0.02).x.array.copy()
    first.reshape(-1, blocks.dim)[:, -1] *= 0.5
    contact.begin_step(np.zeros_like(first), None)
    contact.update_gap(first)
    contact.update_active_set(True, None)
    contact.accept_step()
    state = first + blocks.random(0.01, seed=2).x.array
    contact.begin_step(first, None)

    def forces(u):
        contact.update_gap(u)
        return np.array(contact.contact_forces())

    middle = forces(state)
    tangent = contact.tangent().copy()
    direction = blocks.random(1.0, seed=3).x.array
    # A step across a kink (open, stick, slip) is no derivative: they are few, and the median over steps leaves them.
    product = tangent.createVecLeft()
    vector = tangent.createVecRight()
    vector.array[:] = direction[: vector.local_size]
    tangent.mult(vector, product)
    errors = []
    for h in (1e-6, 5e-7):
        slope = -(forces(state + h * direction) - forces(state - h * direction)) / (2 * h)
        errors.append(np.abs(slope - product.array).max() / np.abs(product.array).max())
    assert np.any(middle) and min(errors) < 2e-7, errors


def test_what_a_law_depends_on():
    for name, (rates, shear) in {
        "exponential": (False, False), "damped": (True, False), "friction": (False, True),
        "falling friction": (True, True), "cohesive": (False, True),
    }.items():  # fmt: skip
        made = LAWS[name]().compiled(2, law_checks.MPI.COMM_SELF)
        assert (made.has_rates, made.has_shear) == (rates, shear), name
