# SPDX-License-Identifier: MIT
"""A plastic law that a user computes at quadrature points, with a tangent of the user's own, against J2Plasticity, on
the ranks of COMM_WORLD; see on_ranks.py."""

import functools

import basix
import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from static_problem_checks import clamp, space

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
E, NU, YIELD, HARDENING, DENSITY = 1000.0, 0.3, 2.0, 50.0, 1.0
DEGREE = 2  # of the rule: that of J2Plasticity on triangles of degree 2
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
SAME = 1e-9  # of the largest displacement: Newton's tolerance is 1e-10 of the force


@functools.cache
def square():
    """One mesh for both bodies that are compared: DOLFINx may partition a second one otherwise."""
    return mesh.create_unit_square(COMM, 3, 3)


class PointLaw:
    """Von Mises' plasticity in plane strain: radial return with linear hardening at the points of a rule, in NumPy."""

    def __init__(self):
        self.mesh = square()
        self.V = space(self.mesh, 2)
        self.u, self.v, self.du = fem.Function(self.V, name="u"), ufl.TestFunction(self.V), ufl.TrialFunction(self.V)
        self.bcs = [clamp(self.V), clamp(self.V, value=1.0, displacement=(0.01, 0.004))]
        tensors = [basix.ufl.quadrature_element("triangle", shape, "default", DEGREE) for shape in ((2, 2), (2,) * 4)]
        self.stress, self.modulus = (fem.Function(fem.functionspace(self.mesh, e)) for e in tensors)
        self.stress.name, self.modulus.name = "stress", "modulus"
        points, _ = basix.make_quadrature(basix.CellType.triangle, DEGREE)
        self.strains = di.PointValues(ufl.sym(ufl.grad(self.u)), points)
        shape = (*self.strains.values().shape[:2], 3, 3)
        self.plastic, self.equivalent = np.zeros(shape), np.zeros(shape[:2])
        self.evaluate(self.u)

    def residual(self):
        return ufl.inner(self.stress, ufl.sym(ufl.grad(self.v))) * ufl.dx(degree=DEGREE)

    def tangent(self):
        i, j, k, m = ufl.indices(4)
        change = ufl.as_tensor(self.modulus[i, j, k, m] * ufl.sym(ufl.grad(self.du))[k, m], (i, j))
        return ufl.inner(change, ufl.sym(ufl.grad(self.v))) * ufl.dx(degree=DEGREE)

    def evaluate(self, u):
        """Stress and consistent modulus at u, from the history of the last step."""
        assert u is self.u
        one, strain = np.eye(3), np.zeros(self.plastic.shape)
        strain[..., :2, :2] = self.strains.values().reshape(*strain.shape[:2], 2, 2)
        trace = np.trace(strain, axis1=2, axis2=3)[..., None, None]
        trial = 2 * MU * (strain - trace * one / 3 - self.plastic)
        size = np.sqrt(1.5 * np.sum(trial**2, axis=(2, 3)))
        flow = np.maximum(size - YIELD - HARDENING * self.equivalent, 0.0) / (3 * MU + HARDENING)
        with np.errstate(invalid="ignore", divide="ignore"):
            direction = np.where(flow[..., None, None] > 0.0, 1.5 * trial / size[..., None, None], 0.0)
            left = np.where(flow > 0.0, 1 - 3 * MU * flow / size, 1.0)
        self._trial = self.plastic + flow[..., None, None] * direction, self.equivalent + flow
        stress = left[..., None, None] * trial + (LAMBDA + 2 * MU / 3) * trace * one
        deviator = 0.5 * (np.einsum("ik,jm->ijkm", one, one) + np.einsum("im,jk->ijkm", one, one))
        deviator -= np.einsum("ij,km->ijkm", one, one) / 3
        turned = 4 / 3 * MU * np.where(flow > 0.0, 1 / (1 + HARDENING / (3 * MU)) - (1 - left), 0.0)
        modulus = (LAMBDA + 2 * MU / 3) * np.einsum("ij,km->ijkm", one, one)
        modulus = modulus + 2 * MU * left[..., None, None, None, None] * deviator
        modulus -= turned[..., None, None, None, None] * np.einsum("...ij,...km->...ijkm", direction, direction)
        for function, values in ((self.stress, stress[..., :2, :2]), (self.modulus, modulus[..., :2, :2, :2, :2])):
            function.x.array[: values.size] = values.ravel()

    def accept(self, u):
        """A step ends."""
        self.plastic, self.equivalent = self._trial

    def follow(self, problem):
        """Of an explicit run: the stress at the present time, and the end of the step."""
        self.evaluate(problem.u)
        self.accept(problem.u)


def given_to(body, kind, **more):
    """Supports, and for problems in time a velocity at the start; the body is then held at one side only."""
    if kind is di.StaticProblem:
        return {"bcs": body.bcs} | more
    velocity = fem.Function(body.V)
    velocity.interpolate(lambda x: np.array([0.5 * x[0], 0.3 * x[0]]))
    return {"bcs": body.bcs[:1], "velocity": velocity} | more


def package(kind):
    """The body with the package's law, and its problem."""
    body = PointLaw()
    law = di.J2Plasticity(E, NU, DENSITY, yield_stress=YIELD, hardening=HARDENING, hypothesis="plane_strain")
    return body, kind(body.u, law, **given_to(body, kind))


def own(kind, **more):
    """The body with its own law, and its problem."""
    body = PointLaw()
    given = given_to(body, kind, residual=body.residual(), tangent=body.tangent())
    if kind is not di.StaticProblem:
        given["density"] = DENSITY
    if kind is not di.ExplicitProblem:
        given |= {"evaluate": body.evaluate, "accept": body.accept}
    return body, kind(body.u, **(given | more))


def assert_same_plastic_flow(own, other):
    """Displacements, and a plastic strain that is worth the name."""
    size = COMM.allreduce(np.abs(other.u.x.array).max(), MPI.MAX)
    difference = COMM.allreduce(np.abs(own.u.x.array - other.u.x.array).max(), MPI.MAX)
    assert difference < SAME * size, f"{difference:.1e} of {size:.1e}"
    assert COMM.allreduce(own.equivalent.max(initial=0.0), MPI.MAX) > YIELD / E


def check_static():
    """In four steps. The tangent is the right one: in the first step Newton's method goes the way that it goes with the
    package's tangent, and converges quadratically. Forces of supports are the same."""
    (body, problem), (other, known) = own(di.StaticProblem), package(di.StaticProblem)
    reports = [p.solve(steps=4, rtol=1e-12) for p in (problem, known)]
    assert_same_plastic_flow(body, other)
    norms = [np.array(report.residual_norms[0]) for report in reports]
    assert len(norms[0]) == len(norms[1]) and np.allclose(norms[0][:4], norms[1][:4], rtol=1e-6), norms
    assert all(len(of_step) <= 7 for of_step in reports[0].residual_norms)
    forces = [p.reactions().x.array for p in (problem, known)]
    assert np.abs(forces[0] - forces[1]).max(initial=0.0) < 1e-9 * np.abs(forces[1]).max(initial=1.0)


def check_implicit():
    (body, problem), (other, known) = own(di.NewmarkProblem), package(di.NewmarkProblem)
    for p in (problem, known):
        p.advance(0.02, dt=0.002, rtol=1e-12, progress=False)
    assert_same_plastic_flow(body, other)


def check_explicit():
    """The stress is that of the time at which the callback is called; the elastic tangent bounds the step."""
    (body, problem), (other, known) = own(di.ExplicitProblem), package(di.ExplicitProblem)
    assert problem.stable_step() == pytest.approx(known.stable_step(), rel=1e-12)
    problem.advance(0.02, dt=2e-4, callback=body.follow, progress=False)
    known.advance(0.02, dt=2e-4, progress=False)
    assert_same_plastic_flow(body, other)


def check_what_is_refused():
    body = PointLaw()
    residual, tangent = body.residual(), body.tangent()
    steel = di.LinearElastic(E, NU, DENSITY, hypothesis="plane_strain")
    table = (
        ({"residual": residual}, "stress, a function at quadrature points.*tangent="),
        ({"residual": residual, "tangent": tangent}, "give evaluate="),
        ({"residual": residual, "evaluate": body.evaluate}, "evaluate needs tangent"),
        ({"residual": residual, "tangent": tangent, "accept": body.accept}, "accept belongs to evaluate"),
        ({"residual": residual, "tangent": residual, "evaluate": body.evaluate}, "trial function"),
        ({"material": steel, "tangent": tangent}, "for a residual of your own"),
    )
    for given, words in table:
        for kind, more in ((di.StaticProblem, {}), (di.NewmarkProblem, {"density": DENSITY})):
            with pytest.raises(ValueError, match=words):
                kind(body.u, **given, **(more if "residual" in given else {}))


def check_errors_of_one_rank():
    """Raised on all ranks, and the next solve works; writing to u is an error."""
    body, problem = own(di.StaticProblem)
    evaluate, bad = body.evaluate, {"error": True}

    def fails(u):
        evaluate(u)
        if bad.get("error") and COMM.rank == COMM.size - 1:
            raise ArithmeticError("no return to the yield surface")
        if bad.get("writes"):
            u.x.array[:] = 1.0

    body, problem = own(di.StaticProblem, evaluate=lambda u: fails(u))
    evaluate = body.evaluate
    with pytest.raises(ArithmeticError, match="no return"):
        problem.solve()
    bad.update(error=False, writes=True)
    with pytest.raises(ValueError, match="evaluate has written to the displacement"):
        problem.solve()
    body.u.x.array[:] = 0.0
    bad.update(writes=False)
    assert problem.solve(steps=4).converged
