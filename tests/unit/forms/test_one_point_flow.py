# SPDX-License-Identifier: MIT
"""Forms of hourglass modes that flow: which cells they are for, and what their history is."""

import basix.ufl
import pytest
import ufl

from dolfinx_impact.forms import one_point_flow, registry
from dolfinx_impact.forms.hardening import LinearHardening
from dolfinx_impact.forms.inelastic import Flow, Symbols, Update
from dolfinx_impact.forms.materials import LinearElastic
from dolfinx_impact.forms.plasticity import J2


def space(cell, dim):
    mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
    return ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))


def kinematics(cell="hexahedron", dim=3, hypothesis="3d", finite=True):
    V = space(cell, dim)
    return V, one_point_flow.OnePointKinematics(V.ufl_domain(), LinearElastic(1.0, 0.3, hypothesis), finite)


@pytest.mark.parametrize("cell, dim, hypothesis", [("hexahedron", 3, "3d"), ("quadrilateral", 2, "plane_strain")])
def test_strains_of_the_modes(cell, dim, hypothesis):
    V, found = kinematics(cell, dim, hypothesis)
    modes = found.modes(ufl.Coefficient(V))
    assert isinstance(modes, one_point_flow.Modes)
    assert len(modes.keys) == len(set(modes.keys)) == one_point_flow.num_strains(dim)
    assert set(modes.strain) == set(modes.keys) == set(modes.derivative(ufl.Coefficient(V)))
    forces = modes.forces(dict.fromkeys(modes.keys, 1.0))
    assert isinstance(forces, one_point_flow.ModeForces) and forces.on_mean.ufl_shape == (dim, dim)
    _, small = kinematics(cell, dim, hypothesis, finite=False)
    assert small.modes(ufl.Coefficient(V)).forces(dict.fromkeys(modes.keys, 1.0)).on_mean is None


def test_the_history_of_the_law_and_of_the_modes():
    law = J2(1.0, 0.3, 3, LinearHardening(0.01, 0.1))
    response = one_point_flow.OnePointResponse(law, 3)
    assert response.history == {**law.history, one_point_flow.HOURGLASS_STRAIN: (12,)}
    V, found = kinematics(finite=False)
    symbols = Symbols(response, V.ufl_domain(), 1)
    update = found.respond(response, ufl.Coefficient(V), symbols)
    assert isinstance(update, one_point_flow.OnePointUpdate) and set(update.outputs) == set(response.history)


def test_a_law_that_does_not_say_where_it_flows():
    class Silent:
        history, unknown = {}, None

        def respond(self, strain, history, unknown):
            return Update(strain, {}, 0.5 * ufl.inner(strain, strain))

    V, found = kinematics(finite=False)
    response = one_point_flow.OnePointResponse(Silent(), 3)
    symbols = Symbols(response, V.ufl_domain(), 1)
    with pytest.raises(ValueError, match="needs the stress at which a law flows"):
        found.respond(response, ufl.Coefficient(V), symbols)


def test_flow_has_its_values():
    flow = Flow(stress=2.0, increment=0.1)
    assert (flow.stress, flow.increment, flow.slope, flow.direction, flow.left, flow.yields) == (
        2.0, 0.1, 0, None, None, None,
    )  # fmt: skip


@pytest.mark.parametrize("cell, dim, hypothesis", [("tetrahedron", 3, "3d"), ("quadrilateral", 2, "axisymmetric")])
def test_what_they_are_not_for(cell, dim, hypothesis):
    with pytest.raises(ValueError, match="one point with hourglass control is for quadrilateral and hexahedron"):
        kinematics(cell, dim, hypothesis)


def test_the_catalogue():
    built = registry.build("j2.finite.voce.reduced.force", "quadrilateral", 1, 1, "plane_stress")
    assert built.law is not None and one_point_flow.HOURGLASS_STRAIN in built.law.history
    registry.build("elastic_stiffness.finite.reduced", "hexahedron", 1)
    with pytest.raises(ValueError, match="degree 1"):
        registry.build("j2.small.linear.reduced.force", "hexahedron", 2)
