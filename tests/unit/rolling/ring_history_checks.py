# SPDX-License-Identifier: MIT
"""Internal variables of bodies that spin: rings of graded cells, in the plane and about an oblique axis in space."""

import basix
import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from over_ranks import largest

import dolfinx_impact as di
from dolfinx_impact import compat

COMM = MPI.COMM_WORLD
INNER, OUTER, LAYERS = 1.0, 2.0, 2
E, NU, Y = 200e3, 0.3, 300.0


def tagged(domain):
    """All cells with the tag 1."""
    index_map = domain.topology.index_map(domain.topology.dim)
    count = index_map.size_local + index_map.num_ghosts
    return mesh.meshtags(domain, domain.topology.dim, np.arange(count, dtype=np.int32), np.full(count, 1, np.int32))


class Ring:
    """A ring or a sector, whose cells along circles are of different lengths.

    Args:
        around: cells along a circle.
        part: part of the circle.
        turn: rotation of the body about z, or any rotation in space for the ring of hexahedra.
        thick: whether it is one of hexahedra, with one layer along the axis.
    """

    def __init__(self, around=24, part=1.0, turn=None, thick=False):
        self.dim, self.around = 3 if thick else 2, around
        self.rotation = np.eye(3) if turn is None else turn
        k = np.arange(around + (part < 1.0))
        angle = 2 * np.pi * part * (k / around + 0.03 * np.sin(2 * np.pi * k / around))
        r, z = np.linspace(INNER, OUTER, LAYERS + 1), np.array([-0.2, 0.2] if thick else [0.0])
        A, R, Z = np.meshgrid(angle, r, z, indexing="ij")
        x = np.stack([R * np.cos(A), R * np.sin(A), Z], axis=-1).reshape(-1, 3) @ self.rotation.T
        i, j = (n.ravel() for n in np.meshgrid(np.arange(around), np.arange(LAYERS), indexing="ij"))
        corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
        cells = np.column_stack(
            [(((i + a) % len(k)) * (LAYERS + 1) + j + b) * len(z) + c for c in range(len(z)) for a, b in corners]
        ).astype(np.int64)
        if COMM.rank > 0:
            cells, x = cells[:0], x[:0]
        kind = "hexahedron" if thick else "quadrilateral"
        element = basix.ufl.element("Lagrange", kind, 1, shape=(self.dim,))
        shared = compat.create_cell_partitioner(mesh.GhostMode.shared_facet)
        self.mesh = mesh.create_mesh(COMM, cells, x=x[:, : self.dim].copy(), e=element, partitioner=shared)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (self.dim,)))
        self.axis = self.rotation[:, 2]

    def frames(self, x):
        """Columns along radius, circle and axis at some places, (n, 3, 3)."""
        x = np.pad(x, ((0, 0), (0, 3 - x.shape[1])))
        radial = x - (x @ self.axis)[:, None] * self.axis
        radial /= np.linalg.norm(radial, axis=1)[:, None]
        axis = np.tile(self.axis, (len(x), 1))
        return np.stack([radial, np.cross(axis, radial), axis], axis=2)

    def angles(self, x):
        """Angles about the axis, from that at which the mesh begins, (n)."""
        local = np.pad(x, ((0, 0), (0, 3 - x.shape[1]))) @ self.rotation
        return np.arctan2(local[:, 1], local[:, 0])

    def bump(self, x):
        """Displacements of a load that half of the ring does not see, at places (3, n)."""
        local = self.rotation.T @ x
        r, z = np.hypot(local[0], local[1]), local[2]
        s = np.maximum(0.0, -local[0] / r) ** 3
        t = np.maximum(0.0, -local[0] / r) ** 2 * local[1]
        values = np.stack([4e-3 * s * (r - 1.3), 3e-3 * t + 2e-3 * s * z, 2e-3 * s * (r - INNER) + 1e-3 * t])
        return (self.rotation @ values)[: self.dim]

    def problem(self, u=None, omega=1.0, bcs=None, average=False, loads=(), **law):
        """A problem of steel; with `u` all displacements are prescribed."""
        law = {"yield_stress": Y, "hardening": 5e3} | law
        if self.dim == 2:
            law = {"hypothesis": "plane_strain"} | law
        steel = di.J2Plasticity(E, NU, density=1e-12, average=average, **law)
        if u is not None:
            whole = fem.Function(self.V)
            whole.interpolate(u)
            index_map = self.V.dofmap.index_map
            every = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
            bcs = [fem.dirichletbc(whole, every)]
        spin = di.Spin(np.zeros(self.dim), self.axis, omega)
        return di.RollingProblem(fem.Function(self.V), steel, tagged(self.mesh), {1: spin}, bcs=bcs, loads=loads)

    def points(self, problem, names, strain=True):
        """Streamline, place along it, coordinates, strain and internal variables of the points of all ranks."""
        field = problem.history[names[0]]
        space, num = field.function().function_space, len(field.values)
        rule, _ = basix.make_quadrature(getattr(basix.CellType, self.mesh.topology.cell_name()), field.degree)
        cells = np.arange(num, dtype=np.int32)
        gradient = fem.Expression(ufl.sym(ufl.grad(problem.u)), rule).eval(self.mesh, cells)
        strain = np.zeros((num * len(rule), 3, 3))
        strain[:, : self.dim, : self.dim] = gradient.reshape(len(strain), self.dim, self.dim)
        x = space.tabulate_dof_coordinates()[space.dofmap.list[:num]].reshape(-1, 3)
        cell = np.repeat(np.asarray(self.mesh.topology.original_cell_index[:num]), len(rule))
        # Coordinates in the reference cell: along the radius, the circle, the axis.
        place = np.tile(np.round(rule, 9), (num, 1))
        across = np.column_stack([cell % LAYERS, place[:, 0], place[:, 2:]])
        found = [problem.history[name].values for name in names]
        values = [v.reshape(len(x), int(np.prod(v.shape[2:]))) for v in found]
        parts = COMM.allgather((across, cell // LAYERS + place[:, 1], x, strain, *values))
        across, along, x, strain, *values = (np.concatenate(column) for column in zip(*parts))
        _, line = np.unique(across, axis=0, return_inverse=True)
        return line.ravel(), along, x, strain, *values


def radial_return(strains, hardening=5e3, kinematic=0.0):
    """Equivalent plastic strains and plastic strains along a path of strains (n, 3, 3); Simo and Hughes 3.3."""
    G, plastic, total, out = E / 2 / (1 + NU), np.zeros((3, 3)), 0.0, []
    for e in strains:
        trial = 2 * G * (e - np.eye(3) * np.trace(e) / 3 - plastic) - 2 / 3 * kinematic * plastic
        size = np.linalg.norm(trial)
        excess = size - np.sqrt(2 / 3) * (Y + hardening * total)
        if excess > 0.0:
            step = excess / (2 * G + 2 / 3 * (hardening + kinematic))
            plastic, total = plastic + step * trial / size, total + np.sqrt(2 / 3) * step
        out.append((total, *plastic.ravel()))
    return np.array(out)


def tensor(values):
    """Deviators (n, 3, 3) from their components."""
    out = np.zeros((len(values), 3, 3))
    for k, (i, j) in enumerate([(0, 0), (1, 1), (0, 1), (1, 2), (0, 2)][: values.shape[1]]):
        out[:, i, j] = out[:, j, i] = values[:, k]
    out[:, 2, 2] = -out[:, 0, 0] - out[:, 1, 1]
    return out


def oblique():
    """A rotation of space that leaves no axis alone."""
    Q, _ = np.linalg.qr(np.array([[1.0, 0.4, -0.3], [0.2, 1.0, 0.7], [0.5, -0.6, 1.0]]))
    return Q * np.sign(np.linalg.det(Q))


def follow(ring, problem, turns, sense, **law):
    """Compare the history where material is loaded with the law along each circle, in axes that turn with it."""
    names = ("plastic_strain", "plastic_strain_tensor")
    line, along, x, strain, alpha, plastic = ring.points(problem, names)
    B = ring.frames(x)
    strain, plastic = (B.transpose(0, 2, 1) @ T @ B for T in (strain, tensor(plastic)))
    largest = alpha.max()
    assert largest > 5e-4 and len(np.unique(line)) == 2 * LAYERS * (2 if ring.dim == 3 else 1)
    for number in np.unique(line):
        at = np.flatnonzero(line == number)
        at = at[np.argsort(sense * ((along[at] - sense * 1e-9) % ring.around))]
        found = np.column_stack([alpha[at], plastic[at].reshape(-1, 9)])
        expected = radial_return(np.tile(strain[at], (turns, 1, 1)), **law)[-len(at) :]
        loaded = np.abs(ring.angles(x[at])) > np.pi / 2
        # Round-off of the strains, which are of the order of 1e-3: 1e-13 of it, over the strains that become plastic.
        np.testing.assert_allclose(found[loaded], expected[loaded], atol=1e-10 * largest)


def check_history_on_circles():
    """Given displacements: after so many turns, the law along each circle repeated as often."""
    for ring, omega in ((Ring(), 1.0), (Ring(), -2.0), (Ring(around=12, turn=oblique(), thick=True), 1.0)):
        problem = ring.problem(ring.bump, omega)
        problem.solve(turns=1)
        assert len(problem.turn_changes) == 1
        follow(ring, problem, 1, np.sign(omega))
        problem.solve(turns=2)  # goes on with the history of the turn before
        follow(ring, problem, 3, np.sign(omega))


def check_kinematic_hardening_turns_with_the_material():
    """Prager: the cycle of plastic strain repeats after the second turn, also if the equivalent strain grows."""
    ring = Ring()
    law = {"hardening": 0.0, "kinematic": 8e3}
    problem = ring.problem(ring.bump, **law)
    problem.solve()
    turns = len(problem.turn_changes)
    assert 2 <= turns <= 20 and problem.turn_changes[-1] < 1e-5 < problem.turn_changes[0]
    follow(ring, problem, turns, 1.0, **law)


def check_a_sector_takes_in_virgin_material():
    """Material flows in at one cut or the other; turns are not asked for."""
    ring = Ring(part=0.5)
    for omega in (1.0, -1.0):
        problem = ring.problem(ring.bump, omega)
        problem.solve()
        follow(ring, problem, 1, omega)
        again = problem.history["plastic_strain"].values.copy()
        problem.solve()
        np.testing.assert_allclose(problem.history["plastic_strain"].values, again, atol=1e-12)
        assert len(problem.turn_changes) == 0
    with pytest.raises(ValueError, match="there is none"):
        problem.solve(turns=1)


def components(T, deviator, dim):
    """Components that the history keeps of symmetric tensors (n, 3, 3)."""
    places = [(0, 0), (1, 1), (0, 1), (1, 2), (0, 2)] if deviator else [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    return np.stack([T[:, i, j] for i, j in places[: len(places) - (0 if dim == 3 else 2)]], axis=1)


def hub(ring):
    """The inner surface stands still."""
    dofs = fem.locate_dofs_geometrical(ring.V, lambda x: np.linalg.norm(np.cross(x.T, ring.axis), axis=1) < 1.0001)
    return [fem.dirichletbc(np.zeros(ring.dim), dofs, ring.V)]


def strain_before(ring, problem, kinematic):
    """Set plastic strains and back stresses that are the same at all angles, in axes along radius and circle."""
    T = 1e-4 * np.array([[2.0, 1.5, 0.7], [1.5, -1.2, -0.9], [0.7, -0.9, -0.8]])
    if ring.dim == 2:
        T[2, :2] = T[:2, 2] = 0.0
    for name, scale in (("plastic_strain_tensor", 1.0), ("back_stress", 2e5))[: 2 if kinematic else 1]:
        field = problem.history[name]
        space, num = field.function().function_space, len(field.values)
        B = ring.frames(space.tabulate_dof_coordinates()[space.dofmap.list[:num]].reshape(-1, 3))
        deviator = field.shape[0] in (3, 5)
        field.values = components(scale * B @ T @ B.transpose(0, 2, 1), deviator, ring.dim).reshape(field.values.shape)


LAWS = ({}, {"kinematic": 5e3}, {"finite_strain": True}, {"finite_strain": True, "kinematic": 5e3})


def check_a_rigid_turn_leaves_the_stress_of_a_ring_that_was_strained():
    """Plastic strain of equal components along radius and circle turns into itself: the steady state of the ring that
    spins is that of the ring that stands, for which nothing is carried. 1e-9: the tolerance of equilibrium."""
    for ring in (Ring(), Ring(around=12, turn=oblique(), thick=True)):
        for law in LAWS if ring.dim == 2 else LAWS[1:2]:  # kernels of finite strain take a minute to compile
            problem = ring.problem(bcs=hub(ring), **law)
            standing = di.StaticProblem(fem.Function(ring.V), problem.material, bcs=problem.bcs)
            for p in (problem, standing):
                strain_before(ring, p, "kinematic" in law)
            standing.solve(rtol=1e-12)
            problem.solve(turns=1, rtol=1e-12)
            size = largest(np.abs(standing.u.x.array))
            assert size > 1e-5
            np.testing.assert_allclose(problem.u.x.array, standing.u.x.array, atol=1e-9 * size)
            for name in standing.history:
                values = standing.history[name].values
                found = problem.history[name].values
                # Local equations are solved to 1e-14 at each of 48 points or less; of C_p^-1, the unit tensor is 1.
                size = max(largest(np.abs(values)), 1e-30)
                np.testing.assert_allclose(found, values, rtol=0, atol=max(1e-9 * size, 1e-12))
            stress = standing.history["stress"].values
            size = largest(np.abs(stress))
            np.testing.assert_allclose(problem.history["stress"].values, stress, atol=1e-9 * size)


def check_stress_turns_with_a_ring_that_is_turned():
    """Finite strain: a rigid turn by prescribed displacements turns the stress of a ring that was strained."""
    ring, phi = Ring(), 0.8
    R = np.array([[np.cos(phi), -np.sin(phi), 0], [np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
    for law in LAWS[2:]:
        stresses = []
        for turn in (np.eye(3), R):
            problem = ring.problem(lambda x: (turn @ x - x)[:2], **law)
            strain_before(ring, problem, "kinematic" in law)
            problem.solve(turns=1)
            values = problem.history["stress"].values.reshape(-1, 4)
            T = np.zeros((len(values), 3, 3))
            for k, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1)]):
                T[:, i, j] = T[:, j, i] = values[:, k]
            stresses.append(T)
        before, after = stresses
        size = largest(np.abs(before))
        assert size > 10.0
        np.testing.assert_allclose(after, R @ before @ R.T, atol=1e-9 * size)


def pressed(ring, size):
    """A pressure on half of the outer surface, from the side of the axis -x, with its peak there."""
    domain = ring.mesh
    outer = mesh.locate_entities_boundary(domain, ring.dim - 1, lambda x: np.hypot(x[0], x[1]) > OUTER - 1e-4)
    tags = mesh.meshtags(domain, ring.dim - 1, np.sort(outer), np.full(len(outer), 1, np.int32))
    x = ufl.SpatialCoordinate(domain)
    p = size * ufl.max_value(-x[0] / OUTER, 0.0) ** 8
    return [di.Traction(tags, 1, -p / OUTER * x)]


def check_a_load_below_first_yield_leaves_no_history():
    """And displacements are those of an elastic ring; 1e-9: the tolerance of equilibrium."""
    ring = Ring()
    problem = ring.problem(bcs=hub(ring), loads=pressed(ring, 100.0))
    report = problem.solve()
    assert list(problem.turn_changes) == [0.0] and len(report.iterations) == 2
    assert not np.any(problem.history["plastic_strain"].values)
    assert not np.any(problem.history["plastic_strain_tensor"].values)
    steel = di.LinearElastic(E, NU, density=1e-12, hypothesis="plane_strain")
    u = fem.Function(ring.V)
    elastic = di.RollingProblem(u, steel, tagged(ring.mesh), problem.motions, bcs=hub(ring), loads=pressed(ring, 100.0))
    elastic.solve()
    np.testing.assert_allclose(problem.u.x.array, u.x.array, atol=1e-9 * largest(np.abs(u.x.array)))


def check_plastic_flow_of_a_ring_dissipates():
    """From point to point the equivalent plastic strain does not fall, and stress does no negative work on the plastic
    strain, in axes that turn with the material; the load flows plastically again in each turn, less and less."""
    ring = Ring(around=48)
    problem = ring.problem(bcs=hub(ring), loads=pressed(ring, 600.0), average="auto", kinematic=2e4)
    problem.solve(turns=3)
    changes = problem.turn_changes
    assert len(changes) == 3 and changes[0] == pytest.approx(1.0) and changes[0] > changes[1] > changes[2] > 0.0
    names = ("plastic_strain", "plastic_strain_tensor", "stress", "back_stress")
    line, along, x, _, alpha, plastic, stress, back = ring.points(problem, names)
    B, T = ring.frames(x), np.zeros((len(x), 3, 3))
    for k, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1)]):
        T[:, i, j] = T[:, j, i] = stress[:, k]
    plastic, T, beta = (B.transpose(0, 2, 1) @ values @ B for values in (tensor(plastic), T, tensor(back)))
    assert alpha.max() > 1e-3
    most = 0.0
    for number in np.unique(line):
        at = np.flatnonzero(line == number)
        at = at[np.argsort(along[at] % ring.around)]  # turns begin opposite to the load, near where the mesh begins
        at = at[np.abs(ring.angles(x[at])) > 0.5]
        grown, flow = np.diff(alpha[at, 0]), np.diff(plastic[at], axis=0)
        work = np.einsum("nij,nij->n", (T - beta)[at][1:], flow)
        most = max(most, grown.max())
        assert grown.min() >= -1e-12
        # The law: (stress - back stress) : d eps_p = Y(alpha) d alpha, with the state at the end of the step.
        np.testing.assert_allclose(work, (Y + 5e3 * alpha[at, 0][1:]) * grown, atol=1e-7 * Y * alpha.max())
    assert most > 1e-5
