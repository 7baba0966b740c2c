# SPDX-License-Identifier: MIT
"""Streamlines of points, identities of sweeps and what a rolling problem calls, each by itself."""

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.rolling.point_lines import PointLines
from dolfinx_impact.rolling.rolling_problem import _SolveInCpp
from dolfinx_impact.rolling.sweep import Fingerprint

NX, NY, POINTS = 4, 3, 2  # cells along and across the flow, points per direction of a cell


def strip():
    """A rectangle of NX x NY squares, with the space of its 2 x 2 points."""
    domain = mesh.create_rectangle(MPI.COMM_SELF, [(0, 0), (NX, NY)], (NX, NY), mesh.CellType.quadrilateral)
    return fem.functionspace(domain, basix.ufl.quadrature_element("quadrilateral", degree=3))


def all_cells(space):
    return np.arange(space.mesh.topology.index_map(2).size_local, dtype=np.int32)


@pytest.mark.parametrize("velocity, length", [((2.0, 0.0), NX), ((-1.0, 0.0), NX), ((0.0, 3.0), NY)])
def test_straight_flow_takes_each_history_from_its_neighbour_upstream(velocity, length):
    space = strip()
    lines = PointLines(space, [(all_cells(space), di.Translation(velocity))])
    assert not lines.fault and not lines.closes and len(lines.exits) == 0
    assert lines.count == NX * NY * POINTS**2 == len(lines.mine) and lines.longest == POINTS * length
    x = space.tabulate_dof_coordinates()[space.dofmap.list].reshape(-1, 3)
    sources, earlier = lines.sources(np.ones(lines.count, dtype=bool))
    assert not earlier.any()
    direction = np.array([*velocity, 0.0]) / np.linalg.norm(velocity)
    inlet = sources < 0
    assert inlet.sum() == POINTS * (NX * NY // length)
    assert np.ptp(x[inlet] @ direction) < 1e-12 and (x[inlet] @ direction).max() < (x[~inlet] @ direction).min()
    step = x[~inlet] - x[sources[~inlet]]
    along = step @ direction
    assert np.abs(step - along[:, None] * direction).max() < 1e-12  # the same streamline
    assert 0.0 < along.min() and along.max() < 0.6  # nearest points upstream: gaps of two-point rules in unit cells
    # Where nothing changes, nothing arrives; with one point that changes all behind it have its history.
    assert (lines.sources(np.zeros(lines.count, dtype=bool))[0] == -1).all()
    changes = np.zeros(lines.count, dtype=bool)
    changes[first := int(np.flatnonzero(inlet)[0])] = True
    assert (lines.sources(changes)[0] == first).sum() == lines.longest - 1


def ring(cells=12):
    """A ring of cells around the origin."""
    angles, radii = np.arange(cells) * 2 * np.pi / cells, (1.0, 2.0)
    x = np.array([(r * np.cos(a), r * np.sin(a)) for a in angles for r in radii])
    quads = [(2 * k, 2 * k + 1, 2 * ((k + 1) % cells), 2 * ((k + 1) % cells) + 1) for k in range(cells)]
    domain = mesh.create_mesh(
        MPI.COMM_SELF, np.array(quads), x=x, e=basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    )
    return fem.functionspace(domain, basix.ufl.quadrature_element("quadrilateral", degree=3))


@pytest.mark.parametrize("omega", [1.0, -2.0])
def test_circles_close_at_their_seam(omega):
    space = ring()
    lines = PointLines(space, [(all_cells(space), di.Spin((0, 0), (0, 0, 1), omega))])
    assert not lines.fault and lines.closes and lines.longest == 24 and len(lines.exits) == 2
    flowing = np.exp(-((np.abs(lines.angle) / 0.4) ** 2))  # about the angle zero: the seam is opposite
    lines.place_seams(flowing)
    assert np.abs(np.abs(lines.angle[lines.exits]) - np.pi).max() < 2 * np.pi / 12
    sources, earlier = lines.sources(np.ones(lines.count, dtype=bool))
    assert earlier.sum() == 2 and set(sources[earlier]) == set(lines.exits)
    turn = np.angle(np.exp(1j * (lines.angle - lines.angle[sources]))) * np.sign(omega)
    assert turn.min() > 0.0 and turn.max() < 2 * np.pi / 12


def test_a_body_with_a_hole_in_its_streamlines_says_where():
    space = strip()
    cells = all_cells(space)
    middle = mesh.compute_midpoints(space.mesh, 2, cells)
    inner = np.flatnonzero((np.abs(middle[:, 0] - 1.5) < 0.1) & (np.abs(middle[:, 1] - 1.5) < 0.1))
    lines = PointLines(space, [(np.setdiff1d(cells, inner).astype(np.int32), di.Translation((1.0, 0.0)))])
    assert "no streamline of quadrature points goes through it" in lines.fault


def test_what_tells_two_problems_apart():
    first = Fingerprint({"friction": "0.3", "count": 4, "sums of mesh": np.array([1.0, 2.0])}, np.array([5.0]))
    same = {"friction": "0.3", "count": np.int64(4), "sums of mesh": np.array([1.0, 2.0 + 1e-10])}
    assert first.difference(same, np.array([5.0 + 1e-9])) == ""
    for changed, words in (
        ({"friction": "0.4"}, "friction differs"),
        ({"sums of mesh": np.array([1.0, 2.1])}, "mesh differs"),
        ({"sums of mesh": np.array([1.0])}, "mesh differs"),
        ({"identity of case": "b"}, "case is known of one alone"),
    ):
        assert first.difference({**same, **changed}, np.array([5.0])) == words
    assert first.difference(same, np.array([5.1])) == first.difference(same, np.array([5.0, 5.0])) == "motions differ"


def test_a_solve_hands_on_its_arguments_and_keeps_the_warning():
    class Problem:
        def solve(self, *args, **told):
            self.given = args, told
            return "report", "warning"

    problem = Problem()
    solve = _SolveInCpp(problem, 3.0)
    assert solve.warning == "" and solve(2, 1e-8, 0.0, 20, None, tell="all") == "report"
    assert problem.given == ((2, 1e-8, 0.0, 20, None, 3.0), {"tell": "all"}) and solve.warning == "warning"
