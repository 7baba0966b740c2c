# SPDX-License-Identifier: MIT
"""Bodies of small strain that turn far are told, on any number of ranks. See on_ranks.py."""

import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.large_rotation import largest_rotation

COMM = MPI.COMM_WORLD
CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
LAWS = {
    di.LinearElastic: {},
    di.J2Plasticity: {"yield_stress": 1e3, "hardening": 1.0},
}


def body(cell, degree=1):
    """A unit block and its displacement space."""
    dim, kind = (2 if cell in CELLS[:2] else 3), getattr(mesh.CellType, cell)
    made = mesh.create_unit_square(COMM, 2, 2, kind) if dim == 2 else mesh.create_unit_cube(COMM, 2, 2, 2, kind)
    return dim, made, fem.functionspace(made, ("Lagrange", degree, (dim,)))


def turned(dim, angle):
    """Displacement of a rotation about the middle, in space about an oblique axis."""
    if dim == 2:
        R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    else:
        n = np.array([1.0, 2.0, 2.0]) / 3.0
        cross = np.array([[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]])
        R = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return lambda x: (R - np.eye(dim)) @ (x[:dim] - 0.5)


def check_rotations_of_cells():
    """Of cells that only turn: exact, up to half a turn; degrees and cells alike. A stretch is no rotation."""
    for cell in CELLS:
        for degree in (1, 2, 3):
            dim, made, V = body(cell, degree)
            cells = np.arange(made.topology.index_map(dim).size_local, dtype=np.int32)
            u = fem.Function(V)
            for angle in (0.0, 0.3, 2.0, 3.1):
                u.interpolate(turned(dim, angle))
                for c in cells[:20]:
                    found, which = largest_rotation(u, cells[c : c + 1], 0.0)
                    assert found == pytest.approx(angle, abs=1e-12) and which in (c, -1)
                beyond = min(angle + 0.1, 1.5)
                assert len(cells) == 0 or largest_rotation(u, cells, beyond)[0] == pytest.approx(
                    angle if angle > beyond else 0.0, abs=1e-12
                )
            u.interpolate(lambda x: 0.4 * x[:dim] * np.arange(1, dim + 1)[:, None])
            assert largest_rotation(u, cells, 1e-12) == (0.0, -1)


def check_the_cell_that_has_turned_furthest():
    """One node moves across: the cells around it turn, that with the largest rotation is found whatever the others."""
    for cell in CELLS:
        dim, made, V = body(cell, 1)
        cells = np.arange(made.topology.index_map(dim).size_local, dtype=np.int32)
        u = fem.Function(V)
        u.interpolate(lambda x: np.vstack([np.sin(5.0 * x[(i + 1) % dim] + i) * 0.3 for i in range(dim)]))
        each = [largest_rotation(u, cells[c : c + 1], 0.0)[0] for c in cells]
        angle, which = largest_rotation(u, cells, 0.05)
        assert len(cells) == 0 or (angle == max(each) > 0.05 and each[which] == angle)


def check_what_rotations_are_looked_for():
    dim, made, V = body("triangle", 1)
    cells, u = np.zeros(0, dtype=np.int32), fem.Function(V)
    for beyond in (-0.1, 1.6, np.nan):
        with pytest.raises(ValueError, match="from 0 to below pi/2"):
            largest_rotation(u, cells, beyond)


def runs(dim, V, law, angle):
    """An explicit and an implicit run of a block that begins turned, and a static solve in which it is held so."""

    def given():
        u = fem.Function(V)
        u.interpolate(turned(dim, angle))
        return u

    def explicit():
        di.ExplicitProblem(given(), law).advance(1e-3, progress=False)

    def implicit():
        di.NewmarkProblem(given(), law).advance(1e-3, dt=1e-3, progress=False)

    def static():
        u, value = fem.Function(V), given()
        everywhere = np.arange(V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts, dtype=np.int32)
        di.StaticProblem(u, law, bcs=[fem.dirichletbc(value, everywhere)]).solve()

    return explicit, implicit, static


def told(run):
    """Texts of the warnings about rotations that a run gives on this rank."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run()
    return [str(w.message) for w in found if "have turned" in str(w.message)], found


def check_bodies_of_small_strain_that_turn_are_told():
    """Once, with the angle and what it does, as coming from the user's line; 0.1 rad, and laws of finite strain, are
    not."""
    for cell in CELLS[1:3] if COMM.size == 1 else CELLS[1:2]:
        dim, _, V = body(cell)
        hypothesis = {"hypothesis": "plane_strain"} if dim == 2 else {}
        for kind, more in LAWS.items():
            for run in runs(dim, V, kind(1.0, 0.3, density=1.0, **more, **hypothesis), 0.5):
                texts, found = told(run)
                assert len(texts) == (1 if COMM.rank == 0 else 0)
                if texts:
                    assert f"{kind.__name__} is a law of small strain" in texts[0]
                    assert "turned by up to 0.5" in texts[0] and "strain of -12 %" in texts[0]
                    assert any(w.filename == __file__ for w in found if "have turned" in str(w.message))
            for run in runs(dim, V, kind(1.0, 0.3, density=1.0, **more, **hypothesis), 0.1):
                assert not told(run)[0]
        for law in (di.NeoHookean(1.0, 0.3, 1.0, **hypothesis), di.StVenantKirchhoff(1.0, 0.3, 1.0, **hypothesis)):
            for run in runs(dim, V, law, 0.5):
                assert not told(run)[0]


def check_a_body_that_spins_is_told_once():
    """From the first call that turns it far on; a part of the mesh that turns is named though the other rests."""
    dim, made, V = body("quadrilateral")
    v = fem.Function(V)
    v.interpolate(lambda x: np.array([-(x[1] - 0.5), x[0] - 0.5]))
    problem = di.ExplicitProblem(fem.Function(V), di.LinearElastic(1e4, 0.3, 1.0, "plane_strain"), velocity=v)
    counts = [len(told(lambda t=t: problem.advance(t, progress=False))[0]) for t in (0.1, 0.5, 0.7)]
    assert COMM.bcast(counts) == [0, 1, 0]
