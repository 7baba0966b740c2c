# SPDX-License-Identifier: MIT
"""What problems were described with cannot be changed afterwards, or is obeyed by all; on any number of ranks. See
on_ranks.py."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
ABOVE = (0.0, -1.0)  # normal of a plane above the body


class Pressed:
    """A square on its lower side, below a rigid plane that touches it, whose other attributes each check sets."""

    def __init__(self):
        self.mesh = mesh.create_unit_square(COMM, 3, 3)
        V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.u, self.velocity = fem.Function(V), fem.Function(V)
        top = mesh.locate_entities_boundary(self.mesh, 1, lambda x: np.isclose(x[1], 1.0))
        tags = mesh.meshtags(self.mesh, 1, np.sort(top), 1)
        self.plane = di.RigidPlane((0.0, 1.0), ABOVE)
        self.pair = di.ContactPair(tags, 1, self.plane)
        self.foot = fem.Constant(self.mesh, np.zeros(2))
        self.held = fem.dirichletbc(self.foot, fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0)), V)
        self.law = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain")

    def problem(self, kind, method):
        velocity = {} if kind is di.StaticProblem else {"velocity": self.velocity}
        return kind(self.u, self.law, bcs=[self.held], contact=[method(self.pair)], **velocity)


IN_TIME = [
    (di.ExplicitProblem, di.Penalty),
    (di.ExplicitProblem, di.Kinematic),
    (di.NewmarkProblem, di.Penalty),
    (di.NewmarkProblem, di.Lagrange),
]
CHANGES = {"displacement": (0.0, -0.01), "motion": lambda t: (0.0, -t, 0.0)}


def check_static_problems_follow_an_obstacle():
    for method in (di.Penalty, di.Lagrange):
        pressed = Pressed()
        problem = pressed.problem(di.StaticProblem, method)
        forces = []
        for depth in (0.01, 0.02):
            pressed.plane.displacement = (0.0, -depth)
            problem.solve(progress=False)
            forces.append(problem.contact[0].force[1])
        # Half of the depth gives half of the force: linear material, and the whole top is in contact.
        assert forces[0] < -0.1 and forces[1] == pytest.approx(2.0 * forces[0], rel=1e-6)


def check_problems_in_time_refuse_another_place_of_an_obstacle():
    """Before `advance`, and in its callbacks; on one rank as well."""
    for kind, method in IN_TIME:
        for name, value in CHANGES.items():
            pressed = Pressed()
            problem = pressed.problem(kind, method)
            before = getattr(pressed.plane, name)

            def change(problem, *time):
                if COMM.rank == COMM.size - 1:
                    setattr(pressed.plane, name, value)  # noqa: B023

            with pytest.raises(ValueError, match=f"the {name} of the rigid master was changed"):
                problem.advance(1e-3, dt=1e-3, callback=change, progress=False)
            time = problem.time
            with pytest.raises(ValueError, match=f"the {name} of the rigid master was changed"):
                problem.advance(2e-3, dt=1e-3, progress=False)
            assert problem.time == time
            setattr(pressed.plane, name, before)
            problem.advance(2e-3, dt=1e-3, progress=False)  # nothing was lost
            assert problem.time == pytest.approx(2e-3)


def check_problems_in_time_refuse_another_value_of_a_condition():
    """A Constant of a Dirichlet condition, as users of DOLFINx set it in a loop over time."""
    for kind, method in IN_TIME[::2]:
        pressed = Pressed()
        problem = pressed.problem(kind, method)

        def change(problem, *time):
            pressed.foot.value[1] = -1e-3  # noqa: B023

        with pytest.raises(ValueError, match="value of a Dirichlet condition was changed"):
            problem.advance(1e-3, dt=1e-3, callback=change, progress=False)
        with pytest.raises(ValueError, match="value of a Dirichlet condition was changed"):
            problem.advance(2e-3, dt=1e-3, progress=False)
        pressed.foot.value[1] = 0.0
        problem.advance(2e-3, dt=1e-3, progress=False)
        assert problem.time == pytest.approx(2e-3)
