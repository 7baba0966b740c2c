# SPDX-License-Identifier: MIT
"""Springs of explicit penalty contact without a given penalty: what they follow from, and what they do not."""

import warnings

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

import dolfinx_impact as di
from dolfinx_impact._cpp.problems import highest_frequency

SHAPES = {
    "triangle": mesh.CellType.triangle,
    "quadrilateral": mesh.CellType.quadrilateral,
    "tetrahedron": mesh.CellType.tetrahedron,
    "hexahedron": mesh.CellType.hexahedron,
}
ROOM = 0.19 / 0.81  # of the squared frequency, that steps of 0.9 of the stable one leave


class Block:
    """A block whose bottom stands on a rigid plane, one hundredth of a cell deep.

    Args:
        cells: numbers of cells.
        size: edges.
        stiff: factor of the stiffness of the upper half.
        inner: how far inner vertices are moved, in cells.
        law: "linear", "plastic" or "own": a residual without a material.
    """

    def __init__(self, cell, cells, size, degree=1, hypothesis=None, stiff=1.0, inner=0.0, law="linear", left=0.0):
        dim = len(cells)
        make = mesh.create_rectangle if dim == 2 else mesh.create_box
        high = [left + size[0], *size[1:]]
        self.domain = make(MPI.COMM_SELF, [[left] + [0.0] * (dim - 1), high], cells, SHAPES[cell])
        x = self.domain.geometry.x
        for c in range(dim):
            inside = (x[:, c] > (left if c == 0 else 0.0) + 1e-9) & (x[:, c] < high[c] - 1e-9)
            x[inside, c] += inner * size[c] / cells[c] * np.sin(7.0 * np.arange(np.count_nonzero(inside)))
        self.V = fem.functionspace(self.domain, ("Lagrange", degree, (dim,)))
        base = mesh.locate_entities_boundary(self.domain, dim - 1, lambda x: np.isclose(x[dim - 1], 0.0))
        self.tags = mesh.meshtags(self.domain, dim - 1, np.sort(base), np.full(len(base), 1, dtype=np.int32))
        self.dim, self.law, self.hypothesis, self.size, self.cells = dim, law, hypothesis, size, cells
        middles = mesh.compute_midpoints(self.domain, dim, np.arange(self.num_cells, dtype=np.int32))
        tags = np.where(middles[:, dim - 1] > 0.5 * size[-1], 2, 1).astype(np.int32)
        self.cell_tags = mesh.meshtags(self.domain, dim, np.arange(self.num_cells, dtype=np.int32), tags)
        self.stiff = stiff

    @property
    def num_cells(self):
        return self.domain.topology.index_map(self.domain.topology.dim).size_local

    def materials(self):
        if self.law == "plastic":
            return di.J2Plasticity(100.0, 0.3, 2.0, yield_stress=1.0, hypothesis=self.hypothesis)
        soft, hard = (di.LinearElastic(100.0 * f, 0.3, 2.0, self.hypothesis) for f in (1.0, self.stiff))
        return soft if self.stiff == 1.0 else di.MaterialMap(self.cell_tags, {1: soft, 2: hard})

    def problem(self, method=di.Penalty, **given):
        u = fem.Function(self.V)
        depth = 0.01 * self.size[-1] / self.cells[-1]
        u.x.array[self.dim - 1 :: self.dim] = -depth
        normal = np.eye(self.dim)[-1]
        pair = di.ContactPair(self.tags, 1, di.RigidPlane(np.zeros(self.dim), normal))
        arguments = {"velocity": fem.Function(self.V), "contact": [method(pair)], **given}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # cells that lock
            if self.law != "own":
                return di.ExplicitProblem(u, self.materials(), **arguments)
            strain, v = ufl.sym(ufl.grad(u)), ufl.TestFunction(self.V)
            stress = 58.0 * ufl.tr(strain) * ufl.Identity(self.dim) + 77.0 * strain
            residual = ufl.inner(stress, ufl.grad(v)) * ufl.dx
            return di.ExplicitProblem(u, residual=residual, density=2.0, **arguments)

    def stiffness(self, fraction=0.9, **given):
        """Stiffness of the closed nodes after steps of this fraction of the stable one, in the order of places."""
        problem = self.problem(**given)
        dt = fraction * problem.stable_step()
        problem.advance(dt, dt=dt, progress=False)
        contact = problem.contact[0]
        assert np.all(contact.stiffness > 0)
        return contact.stiffness[np.lexsort(np.round(contact.points[:, :-1], 6).T)]


BODIES = {
    "quadrilateral": dict(cell="quadrilateral", cells=(3, 4), size=(3.0, 2.0), hypothesis="plane_strain"),
    "flat quadrilateral": dict(cell="quadrilateral", cells=(3, 4), size=(3.0, 0.3), hypothesis="plane_strain"),
    "sheet": dict(cell="triangle", cells=(3, 4), size=(3.0, 4.0), hypothesis="plane_stress"),
    "turned": dict(cell="quadrilateral", cells=(3, 4), size=(3.0, 4.0), hypothesis="axisymmetric", left=0.5),
    "on the axis": dict(cell="quadrilateral", cells=(3, 4), size=(3.0, 4.0), hypothesis="axisymmetric"),
    "tetrahedron": dict(cell="tetrahedron", cells=(2, 2, 2), size=(1.0, 1.0, 1.0)),
    "hexahedron": dict(cell="hexahedron", cells=(2, 3, 2), size=(1.0, 1.5, 0.4)),
    "plastic": dict(cell="hexahedron", cells=(2, 2, 2), size=(1.0, 1.0, 1.0), law="plastic"),
    "own residual": dict(cell="triangle", cells=(3, 4), size=(3.0, 4.0), hypothesis="plane_strain", law="own"),
}
GENERATED = [
    (name, degree) for name in BODIES for degree in (1, 2) if degree == 1 or name not in ("plastic", "own residual")
]


@pytest.mark.parametrize("name, degree", GENERATED)
def test_springs_follow_from_the_body_alone(name, degree):
    """The step does not change them, nor a part that is stiff, as long as another lies between."""
    body = {**BODIES[name], "degree": degree, "inner": 0.1}
    plain = Block(**body).stiffness()
    np.testing.assert_allclose(Block(**body).stiffness(0.02), plain, rtol=1e-12)
    if body.get("law") is None:
        np.testing.assert_allclose(Block(**body, stiff=100.0).stiffness(), plain, rtol=1e-12)


@pytest.mark.parametrize("name, degree", GENERATED)
def test_steps_bear_the_springs(name, degree):
    """The frequencies of body and springs, along all axes, stay below those of 0.9 of the stable step."""
    block = Block(**{**BODIES[name], "degree": degree, "inner": 0.1})
    problem = block.problem()
    contact, dt = problem.contact[0], 0.9 * problem.stable_step()
    problem.advance(dt, dt=dt, progress=False)
    diagonal = np.zeros(problem.num_owned)
    for c in range(block.dim):
        diagonal[contact.nodes * block.dim + c] = contact.stiffness
    matrix = PETSc.Mat().createAIJ((len(diagonal),) * 2, nnz=1, comm=MPI.COMM_SELF)
    rows = np.arange(len(diagonal) + 1, dtype=np.int32)
    matrix.setValuesCSR(rows, rows[:-1], diagonal)
    matrix.assemble()
    K = di.Tangent(problem._frequencies.tangent).assemble()
    K.axpy(1.0, matrix)
    highest = highest_frequency(K, 1.0 / problem.mass.array[: problem.num_owned])
    assert highest * dt <= 2.0 * (1 + 1e-9)  # round-off of the eigenvalue solver
    assert contact.stiffness.min() > 0.02 * contact.stiffness.max(), "no node is forgotten"


def test_half_a_layer_or_what_the_mass_bears():
    """Of rectangles with the edges a and h: M a/(2 h) a node (half at the ends), if their highest frequency allows."""
    modulus = 100.0 * 0.7 / (1.3 * 0.4)
    for height, layer in ((0.8, True), (0.03, False)):
        block = Block("quadrilateral", (4, 5), (0.4, 5 * height), hypothesis="plane_strain")
        area = 0.1 * np.array([0.5, 1, 1, 1, 0.5])
        found, half = block.stiffness(), 0.5 * modulus * area / height
        squared = (2 / block.problem().stable_step()) ** 2
        mass = 2.0 * 0.5 * height * area
        expected = np.minimum(half, ROOM * mass * squared)
        np.testing.assert_allclose(found, expected, rtol=1e-9)
        assert np.all(found == pytest.approx(half)) == layer


def two_blocks(factor):
    """Two matching blocks of squares, the upper one's stiffness by a factor, that overlap by a hundredth of a cell."""
    xy = np.stack(np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5)), axis=-1).reshape(-1, 2)
    corner = np.add.outer(5 * np.arange(4), np.arange(4)).ravel()
    quads = np.stack([corner, corner + 1, corner + 5, corner + 6], axis=1)
    points, cells = np.vstack([xy, xy + [0.0, 0.9975]]), np.vstack([quads, quads + 25])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    domain = mesh.create_mesh(MPI.COMM_SELF, cells, x=points, e=element)
    near = lambda y: mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], y))  # noqa: E731
    facets = np.concatenate([near(0.9975), near(1.0)])
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, 1, facets[order], np.repeat([1, 2], 4).astype(np.int32)[order])
    middle = mesh.compute_midpoints(domain, 2, np.arange(32, dtype=np.int32))[:, 1]
    cell_tags = mesh.meshtags(domain, 2, np.arange(32, dtype=np.int32), (middle > 0.99).astype(np.int32))
    laws = {k: di.LinearElastic(100.0 * f, 0.3, 2.0, "plane_strain") for k, f in enumerate((1.0, factor))}
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    problem = di.ExplicitProblem(
        fem.Function(V), di.MaterialMap(cell_tags, laws), velocity=fem.Function(V),
        contact=[di.Penalty(di.ContactPair(tags, 1, 2))],
    )  # fmt: skip
    contact = problem.contact[0]
    inner = (contact.points[:, 0] > 0.1) & (contact.points[:, 0] < 0.9)
    return contact.stiffness[inner]


@pytest.mark.parametrize("fraction", [1.0, 0.9, 0.45])
@pytest.mark.parametrize("cell", SHAPES)
def test_springs_by_the_step(cell, fraction):
    """penalty="step": half of the nodal mass over the square of the step, 0.9 of the stable one or longer, whatever the
    material; the forces of the start are those of the steps. A checkpoint of other springs is another problem's."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    block = Block(cell, (2,) * dim, (1.0,) * dim, hypothesis="plane_strain" if dim == 2 else None)
    problem = block.problem(lambda pair: di.Penalty(pair, penalty="step"))
    dt = fraction * problem.stable_step()
    assert problem.stable_step() == block.problem().stable_step()
    problem.advance(2 * dt, dt=dt, progress=False)
    contact = problem.contact[0]
    masses = problem.mass.array[::dim][contact.nodes]
    longest = max(dt, 0.9 * problem.stable_step())
    assert np.all(contact.stiffness == pytest.approx(0.5 * masses / longest**2, rel=1e-12))
    assert problem.contact_step == longest
    force = np.abs(problem.force_history[0][:, dim - 1])
    assert 0.4 * force[0] < force[1] <= force[0], "of one stiffness, in the first step of a swing"
    assert contact.options != block.problem().contact[0].options


def test_springs_by_the_step_are_explicit():
    block = Block("quadrilateral", (2, 2), (1.0, 1.0), hypothesis="plane_strain")
    pair = di.ContactPair(block.tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
    assert "penalty='step'" in repr(di.Penalty(pair, penalty="step"))
    with pytest.raises(ValueError, match="'step' is a penalty of explicit dynamics"):
        di.StaticProblem(fem.Function(block.V), block.materials(), contact=[di.Penalty(pair, penalty="step")])


@pytest.mark.parametrize("factor", [1.0, 1e-4, 1e4])
def test_springs_of_two_bodies_in_series(factor):
    """Half a layer of each, that of the master divided by two as nodes may weigh on it that way, 1 + A_j/A_i."""
    half = 0.5 * 100.0 * 0.7 / (1.3 * 0.4)  # squares: M a/(2 a)
    np.testing.assert_allclose(two_blocks(factor), 1 / (1 / (factor * half) + 2 / half), rtol=1e-9)


def test_no_stiffness_at_rest_leaves_mass_and_step():
    """A cubic spring in each cell has none: k = m/(2 dt^2)."""
    block = Block("quadrilateral", (3, 3), (1.0, 1.0), hypothesis="plane_strain")
    u, v = fem.Function(block.V), ufl.TestFunction(block.V)
    u.x.array[1::2] = -0.001
    residual = 50.0 * ufl.inner(ufl.grad(u), ufl.grad(u)) * ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
    pair = di.ContactPair(block.tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
    problem = di.ExplicitProblem(u, residual=residual, density=2.0, velocity=fem.Function(block.V),
                                 contact=[di.Penalty(pair)])  # fmt: skip
    problem.advance(1e-3, dt=1e-3, progress=False)
    contact = problem.contact[0]
    np.testing.assert_allclose(contact.stiffness, 0.5 * problem.mass.array[::2][contact.nodes] / 1e-6, rtol=1e-12)
