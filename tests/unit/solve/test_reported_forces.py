# SPDX-License-Identifier: MIT
"""A state is converged only if the forces that its contacts report balance those of the bodies at all free nodes."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.contact.penalty.quadrature_penalty import QuadraturePenalty

METHODS = {"Lagrange": (di.Lagrange, LagrangeContact), "Penalty": (di.Penalty, QuadraturePenalty)}


def blocks(method, kind, friction=0.0, **options):
    """Two blocks, pressed on each other by 1/100 of their height: a function that solves, and the problem."""
    m = meshes.make("two_blocks", MPI.COMM_SELF, lower_cells=(4, 2), upper_cells=(5, 2))
    V = fem.functionspace(m.mesh, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    ends = [fem.locate_dofs_topological(V, 1, m.facet_tags.find(m.tags[n])) for n in ("bottom", "top")]
    bcs = [fem.dirichletbc(np.array([0.0, d]), dofs, V) for d, dofs in zip((0.0, -0.005), ends)]
    if kind == "Newmark":
        bcs[1] = di.PrescribedMotion(bcs[1], lambda t: t / 0.1)
    pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"], friction=friction)
    law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
    if kind == "static":
        problem = di.StaticProblem(u, law, bcs=bcs, contact=[method(pair)], **options)
        return problem.solve, problem
    problem = di.NewmarkProblem(u, law, velocity=fem.Function(V), bcs=bcs, contact=[method(pair)])
    return lambda: problem.advance(0.1, dt=0.1, progress=False), problem


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("kind", ("static", "Newmark"))
@pytest.mark.parametrize("name", METHODS)
def test_wrong_forces_of_a_contact_are_not_accepted(name, kind, friction, monkeypatch, contacts_in_python):
    """The force on one node of the slave is reported a thousandth too large: the node and the pair are named."""
    method, contact_class = METHODS[name]
    solve, problem = blocks(method, kind, friction)
    contact = problem.contact[0]
    node = int(contact.slave.nodes[0, 0] if name == "Penalty" else contact.nodes[0])
    right = contact_class.contact_forces

    def wrong(self):
        forces = right(self)
        forces[2 * node + 1] *= 1.001
        return forces

    monkeypatch.setattr(contact_class, "contact_forces", wrong)
    place = ", ".join(f"{v:.4g}" for v in problem.space.tabulate_dof_coordinates()[node, :2])
    with pytest.raises(RuntimeError, match="do not balance those of the bodies") as error:
        solve()
    assert f"missing at the node ({place})" in str(error.value) and contact.pair.name in str(error.value)
    assert "smaller parts" not in str(error.value), "smaller increments do not help"


@pytest.mark.parametrize("snes", ("newtonls", "newtontr"))
def test_methods_of_petsc_are_checked_too(snes, monkeypatch, contacts_in_python):
    options = {"snes_type": snes, "ksp_type": "preonly", "pc_type": "lu"}
    solve, problem = blocks(di.Penalty, "static", options=options)
    right = QuadraturePenalty.contact_forces
    monkeypatch.setattr(QuadraturePenalty, "contact_forces", lambda self: 0.999 * right(self))
    with pytest.raises(RuntimeError, match="do not balance those of the bodies"):
        solve()


def test_two_contacts_are_summed_up(monkeypatch, contacts_in_python):
    """Each is right by itself, but one of them is reported twice, as by two pairs that take the same force."""
    m = meshes.make("two_blocks", MPI.COMM_SELF, lower_cells=(4, 2), upper_cells=(5, 2))
    V = fem.functionspace(m.mesh, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    bottom = fem.locate_dofs_topological(V, 1, m.facet_tags.find(m.tags["bottom"]))
    pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"])
    lid = di.RigidPlane((0.0, float(m.mesh.geometry.x[:, 1].max())), (0.0, -1.0))
    lid.displacement = (0.0, -0.005)
    bcs = [fem.dirichletbc(np.zeros(2), bottom, V)]
    sideways, _ = V.sub(0).collapse()
    dofs = fem.locate_dofs_topological((V.sub(0), sideways), 1, m.facet_tags.find(m.tags["top"]))
    bcs.append(fem.dirichletbc(fem.Function(sideways), dofs, V.sub(0)))
    contacts = [di.Lagrange(pair), di.Lagrange(di.ContactPair(m.facet_tags, m.tags["top"], lid))]
    problem = di.StaticProblem(u, di.LinearElastic(1e3, 0.3, 1.0, "plane_strain"), bcs=bcs, contact=contacts)
    assert problem.solve().converged
    np.testing.assert_allclose(problem.contact[0].force[1], -problem.contact[1].force[1], rtol=1e-9)
    right, second = LagrangeContact.contact_forces, problem.contact[1]
    factor = lambda contact: 2.0 if contact is second else 1.0  # noqa: E731
    monkeypatch.setattr(LagrangeContact, "contact_forces", lambda self: factor(self) * right(self))
    lid.displacement = (0.0, -0.006)
    with pytest.raises(RuntimeError, match="do not balance.*contacts: .*, ") as error:
        problem.solve()
    assert all(c.pair.name in str(error.value) for c in problem.contact)
