# SPDX-License-Identifier: MIT
"""Cells with one point whose hourglass modes flow with the law: patch, rotation, plastic hinge, Taylor's bar, energies,
restart. docs/one_point.md has the theory."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from meshes_and_supports import block
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.inelastic_part import InelasticParts
from dolfinx_impact.assembly.operators import InternalForce
from dolfinx_impact.forms.one_point_flow import HOURGLASS_STRAIN, num_strains

# A few cells that are bent on purpose: their modes have more than 5 % of the energy, and they turn.
pytestmark = pytest.mark.filterwarnings("ignore:hourglass modes", "ignore:J2Plasticity is a law of small strain")
E, NU, YIELD = 1.0, 0.3, 0.01
GRADIENT = np.array([[0.3, 0.02, -0.1], [-0.15, -0.2, 0.01], [0.1, -0.2, -0.025]])
CASES = [
    ("hexahedron", "3d", False, 0.02, None),
    ("hexahedron", "3d", True, 0.02, None),
    ("hexahedron", "3d", True, di.Voce(0.02, 10.0), 0.05),
    ("quadrilateral", "plane_strain", True, 0.02, None),
    ("quadrilateral", "plane_stress", False, 0.02, None),
    ("quadrilateral", "plane_stress", True, 0.02, None),
]


def steel(hypothesis="3d", finite=True, hardening=0.0, kinematic=None, integration="reduced", yield_stress=YIELD):
    return di.J2Plasticity(
        E, NU, 1.0, yield_stress, hardening, kinematic, finite, hypothesis=hypothesis, integration=integration
    )


class Body:
    """Internal force of a displacement that is given in steps, after each of which the history is committed."""

    def __init__(self, domain, material):
        dim = domain.geometry.dim
        self.V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
        self.u = fem.Function(self.V, name="u")
        form, law = InelasticParts(self.u, material).force(ufl.TestFunction(self.V))
        self.operator = InternalForce(form, law=law)

    def force(self, values, commit=True):
        self.u.x.array[:] = values
        found = self.operator.apply().array.copy()
        if commit:
            self.operator.history.commit()
        return found

    def values(self, name):
        return self.operator.history.values(name)


def linear(V, gradient):
    dim, u = V.mesh.geometry.dim, fem.Function(V)
    u.interpolate(lambda x: gradient[:dim, :dim] @ x[:dim])
    return u.x.array.copy()


@pytest.mark.parametrize("cell, hypothesis, finite, hardening, kinematic", CASES)
def test_patch(cell, hypothesis, finite, hardening, kinematic):
    """A linear displacement that grows through the yield stress has the forces of full integration on distorted cells,
    and no plastic strain of the modes."""
    bodies = [
        Body(block(cell, 2, distortion=0.1), steel(hypothesis, finite, hardening, kinematic, integration))
        for integration in ("full", "reduced")
    ]
    for share in (0.02, 0.5, 1.0):
        full, reduced = (b.force(linear(b.V, share * GRADIENT)) for b in bodies)
        # Round-off of Newton's method at the points, relative to the yield stress.
        np.testing.assert_allclose(reduced, full, atol=1e-12 * np.abs(full).max())
    assert bodies[1].values("plastic_strain").min() > 0.1
    modes = bodies[1].values(HOURGLASS_STRAIN)
    assert modes.shape[1:] == (1, num_strains(bodies[1].V.mesh.geometry.dim))
    assert np.abs(modes).max() < 1e-13
    assert bodies[1].values("plastic_strain").shape[1] == 1  # an eighth or a quarter of the points


@pytest.mark.parametrize("cell, hypothesis, finite, hardening, kinematic", [c for c in CASES if c[2]])
def test_a_rotation_turns_the_forces_of_a_flowing_body(cell, hypothesis, finite, hardening, kinematic):
    domain, rng = block(cell, 2, distortion=0.1), np.random.default_rng(1)
    dim = domain.geometry.dim
    turn, _ = np.linalg.qr(rng.standard_normal((dim, dim)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    body, other = (Body(domain, steel(hypothesis, finite, hardening, kinematic)) for _ in range(2))
    x = linear(body.V, np.eye(3)).reshape(-1, dim)
    bend = 0.03 * rng.uniform(-1, 1, x.size)
    for share in (0.5, 1.0):
        own = body.force(share * bend).reshape(-1, dim)
        moved = (x + share * bend.reshape(-1, dim)) @ turn.T - x
        turned = other.force(moved.ravel()).reshape(-1, dim)
        np.testing.assert_allclose(turned, own @ turn.T, atol=1e-11 * np.abs(own).max())
    assert np.abs(body.values(HOURGLASS_STRAIN)).max() > 1e-3
    np.testing.assert_allclose(other.values(HOURGLASS_STRAIN), body.values(HOURGLASS_STRAIN), atol=1e-11)


def hinge(through, material, steps=50):
    """Moment over that at collapse of a block that is bent in plane strain to 20 times its elastic curvature.

    The displacement is given, without a change of volume: u_x = c x z, u_z = -c (x^2 + z^2)/2. The moment is the work
    of the nodal forces for a change of the curvature, over the length 1/2; exact at collapse is 2/sqrt(3) Y/4 of the
    section 1 by 1.
    """
    low, high = (0.0, 0.0, -0.5), (0.5, 1.0, 0.5)
    body = Body(mesh.create_box(MPI.COMM_SELF, [low, high], (2, 1, through), mesh.CellType.hexahedron), material)
    bent, curvature = fem.Function(body.V), 20 * 2 * YIELD / E
    bent.interpolate(lambda x: curvature * np.array([x[0] * x[2], 0 * x[0], -(x[0] ** 2 + x[2] ** 2) / 2]))
    for step in range(1, steps + 1):
        force = body.force(step / steps * bent.x.array)
    return (force @ bent.x.array) / curvature / 0.5 / (2 / np.sqrt(3) * YIELD / 4)


@pytest.mark.parametrize("through", [1, 2, 3, 4])
def test_moment_of_a_plastic_hinge(through):
    """The full plastic moment whatever the number of cells across. A single cell keeps the ratio of the moments of its
    elastic plate, which costs sqrt(1 - nu + nu^2) against 2/sqrt(3): 2.6 % here."""
    limit = np.sqrt(3) / 2 / np.sqrt(1 - NU + NU**2) if through == 1 else 1.0
    assert hinge(through, steel(finite=False)) == pytest.approx(limit, rel=0.01 if through % 2 else 0.005)


def test_modes_that_do_not_flow_would_be_too_stiff():
    """With the yield stress out of reach modes are those of the elastic laws. Full integration with B-bar has 1.026 in
    two cells."""
    assert hinge(1, steel(finite=False, yield_stress=1e3)) > 10 * hinge(1, steel(finite=False))
    assert hinge(2, steel(finite=False, integration="full")) == pytest.approx(1.026, abs=0.005)


@pytest.mark.parametrize("hypothesis", ["3d", "plane_strain", "plane_stress"])
def test_far_below_the_yield_stress_it_is_the_elastic_cell(hypothesis):
    cell = "hexahedron" if hypothesis == "3d" else "quadrilateral"
    found = []
    laws = steel(hypothesis, False, yield_stress=1e3), di.LinearElastic(E, NU, 1.0, hypothesis, "reduced")
    for law in laws:
        problem = moving(block(cell, 3, distortion=0.1), law)
        problem.advance(1.0, dt=0.02, progress=False)
        found.append((problem.u.x.array, problem.energy, problem.stable_step()))
    (u, energy, step), (v, elastic, elastic_step) = found
    np.testing.assert_allclose(u, v, atol=1e-12 * np.abs(v).max())
    for name in ("internal", "hourglass", "kinetic"):
        assert energy[name] == pytest.approx(elastic[name], rel=1e-10)
    assert step == pytest.approx(elastic_step, rel=1e-12)


@pytest.mark.parametrize("cell, hypothesis, finite", [c[:3] for c in CASES if c[3] == 0.02])
def test_forces_of_the_modes_are_derivatives_of_their_energy(cell, hypothesis, finite):
    """By differences, of large displacements far below the yield stress, on distorted cells."""
    body, rng = Body(
        block(cell, 2, distortion=0.1), steel(hypothesis, finite, yield_stress=1e3)
    ), np.random.default_rng(4)
    start, direction = (0.1 * rng.uniform(-1, 1, len(body.u.x.array)) for _ in range(2))

    def energy(values):
        body.force(values, commit=False)
        return body.operator._cpp_object.sum("elastic")

    h = 1e-4
    # The error of differences of the second order, and Newton's method across the plane in plane stress.
    change = (energy(start + h * direction) - energy(start - h * direction)) / (2 * h)
    assert body.force(start, commit=False) @ direction == pytest.approx(change, rel=1e-6)


def moving(domain, law, speed=0.1):
    """Free body that is bent and twisted by its velocity at the start."""
    dim = domain.geometry.dim
    V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: speed * np.array([np.cos(3 * x[i] + 2 * x[(i + 1) % dim]) for i in range(dim)]))
    return di.ExplicitProblem(fem.Function(V), law, velocity=velocity)


@pytest.mark.parametrize("hypothesis, finite", [("3d", False), ("3d", True), ("plane_stress", True)])
def test_energies_of_a_run(hypothesis, finite):
    """Plastic work never decreases, modes' energy is a part of the internal one, the total is kept."""
    cell = "hexahedron" if hypothesis == "3d" else "quadrilateral"
    problem = moving(block(cell, 4, distortion=0.05), steel(hypothesis, finite, 0.02), 0.07)
    plastic = [0.0]
    for step in range(1, 31):
        problem.advance(0.1 * step, dt=0.02, progress=False)
        energy = problem.energy
        assert 0.0 < energy["hourglass"] < 0.5 * energy["internal"]
        plastic.append(energy["plastic"])
    # Between half steps the work of a step is off by a second order of it.
    assert np.diff(plastic).min() > -1e-3 * energy["total"]
    assert energy["plastic"] > 0.2 * energy["total"] and abs(energy["drift"]) < 1e-12
    stress = problem.stress.values
    assert stress.shape[1] == 1 and problem.history["von_mises"].values.max() > YIELD


def test_materials_by_tag():
    """A part with one point that stays elastic and one that flows: energies of both, the total is kept."""
    domain = block("hexahedron", 4, distortion=0.05)
    cells = np.arange(64, dtype=np.int32)
    tags = mesh.meshtags(domain, 3, cells, np.where(cells < 32, 1, 2).astype(np.int32))
    rubber = di.NeoHookean(E, NU, 1.0, "3d", "reduced")
    problem = moving(domain, di.MaterialMap(tags, {1: rubber, 2: steel(hardening=0.02)}), 0.05)
    problem.advance(2.0, dt=0.02, progress=False)
    energy = problem.energy
    assert 0.0 < energy["hourglass"] < energy["internal"] and energy["plastic"] > 0.1 * energy["total"]
    assert abs(energy["drift"]) < 1e-12
    assert np.abs(problem.history[HOURGLASS_STRAIN].values[cells >= 32]).max() > 1e-4
    assert np.abs(problem.history[HOURGLASS_STRAIN].values[cells < 32]).max() == 0.0


def test_restart_goes_on_to_the_bit(tmp_path):
    def made():
        return moving(block("hexahedron", 3, distortion=0.1), steel(hardening=di.Voce(0.02, 10.0)))

    whole, first, second = made(), made(), made()
    dt = 0.5 * whole.stable_step()
    whole.advance(40 * dt, dt=dt, progress=False)
    first.advance(20 * dt, dt=dt, progress=False)
    first.save(tmp_path / "half.h5")
    second.restore(tmp_path / "half.h5")
    second.advance(40 * dt, dt=dt, progress=False)
    assert np.array_equal(second.u.x.array, whole.u.x.array)
    for name in ("plastic_strain", HOURGLASS_STRAIN):
        assert np.array_equal(second.history[name].values, whole.history[name].values)
    assert np.abs(whole.history[HOURGLASS_STRAIN].values).max() > 1e-4


def taylor_bar(integration, n=(3, 30), time=30e-6):
    """Radius of the face and length of a quarter of Taylor's copper bar (test_plastic_taylor.py) at a time [mm]."""
    length, radius = 32.4e-3, 3.2e-3
    domain = mesh.create_box(MPI.COMM_SELF, [(0, 0, 0), (1, 1, length)], (n[0], n[0], n[1]), mesh.CellType.hexahedron)
    x, y = domain.geometry.x[:, 0].copy(), domain.geometry.x[:, 1].copy()
    domain.geometry.x[:, 0] = radius * x * np.sqrt(1 - y**2 / 2)
    domain.geometry.x[:, 1] = radius * y * np.sqrt(1 - x**2 / 2)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    u, velocity = fem.Function(V, name="u"), fem.Function(V)
    velocity.interpolate(lambda x: np.array([0 * x[0], 0 * x[0], np.where(x[2] > 1e-9, -227.0, 0.0)]))
    bcs = []
    for k in range(3):
        W = V.sub(k).collapse()[0]
        dofs = fem.locate_dofs_geometrical((V.sub(k), W), lambda x, k=k: np.isclose(x[k], 0, atol=1e-9))
        bcs.append(fem.dirichletbc(fem.Function(W), dofs, V.sub(k)))
    copper = di.J2Plasticity(
        117e9, 0.35, 8930.0, yield_stress=400e6, hardening=100e6, finite_strain=True, integration=integration
    )
    run = di.ExplicitProblem(u, copper, velocity=velocity, bcs=bcs)
    run.advance(time, progress=False)
    x = V.tabulate_dof_coordinates()
    rim, top = (np.argmin(np.linalg.norm(x - p, axis=1)) for p in ((radius, 0, 0), (0, 0, length)))
    moved = x + u.x.array.reshape(-1, 3)
    return 1e3 * np.array([moved[rim, 0], moved[top, 2]]), run.energy


@pytest.mark.parametrize("time", [30e-6, pytest.param(80e-6, marks=pytest.mark.slow)])
def test_taylors_bar(time):
    """Radius and length as with full integration, 3 % and 1 %; the modes have little of the work."""
    full, _ = taylor_bar("full", time=time)
    found, energy = taylor_bar("reduced", time=time)
    print(f"radius {found[0]:.3f} against {full[0]:.3f} mm, length {found[1]:.3f} against {full[1]:.3f} mm")
    assert found[0] == pytest.approx(full[0], rel=0.03) and found[1] == pytest.approx(full[1], rel=0.01)
    assert energy["hourglass"] < 1e-3 * energy["plastic"] and abs(energy["drift"]) < 1e-3


class Perfect(di.InelasticMaterial):
    """Perfect plasticity of small strain by the law of the package, as a law of one's own.

    Args:
        says: whether it says at which stress it flows.
    """

    unknown = None
    finite_strain = False

    def __init__(self, says):
        super().__init__(E, NU, 1.0, integration="reduced")
        self.says = says
        self.history = {"plastic": (6,)}

    def respond(self, strain, history, unknown):
        h = history["plastic"]
        plastic = ufl.as_tensor([[h[0], h[3], h[5]], [h[3], h[1], h[4]], [h[5], h[4], h[2]]])
        mu, kappa = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
        trial = 2 * mu * ufl.dev(strain - plastic)
        q = ufl.sqrt(1.5 * ufl.inner(trial, trial) + 1e-30)
        step = ufl.conditional(ufl.gt(q, YIELD), (q - YIELD) / (3 * mu), 0)
        more = 1.5 * step / q * trial
        stress = trial - 2 * mu * more + kappa * ufl.tr(strain) * ufl.Identity(3)
        new = plastic + more
        elastic = ufl.dev(strain - new)
        return di.MaterialUpdate(
            stress,
            {"plastic": ufl.as_vector([new[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))])},
            mu * ufl.inner(elastic, elastic) + kappa / 2 * ufl.tr(strain) ** 2,
            flow=di.MaterialFlow(stress=YIELD, increment=step) if self.says else None,
        )


def test_a_law_of_ones_own():
    """With its flow it is that of the package, without it is refused with what to write."""
    domain, rng = block("hexahedron", 2, distortion=0.1), np.random.default_rng(3)
    own, ours = Body(domain, Perfect(True)), Body(domain, steel(finite=False))
    bend = 0.05 * rng.uniform(-1, 1, len(own.u.x.array))
    for share in (0.3, 1.0):
        a, b = own.force(share * bend), ours.force(share * bend)
        np.testing.assert_allclose(a, b, atol=1e-10 * np.abs(b).max())
    assert np.abs(own.values(HOURGLASS_STRAIN)).max() > 1e-3
    with pytest.raises(ValueError, match="flow=MaterialFlow"):
        moving(domain, Perfect(False))
