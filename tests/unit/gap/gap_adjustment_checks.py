# SPDX-License-Identifier: MIT
"""Offsets, clearances and adjusted gaps of contacts of every kind, on any number of ranks. See on_ranks.py.

A block lies over a floor, a rigid plane or another block, at a distance of its mesh that differs from point to point by
up to 0.01; Poisson's ratio is zero, so that what is pressed is uniform."""

import logging

import numpy as np
import pytest
from box_bodies import Boxes
from dolfinx import fem
from initial_penetration_checks import COMM, Lines
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di

E = 1000.0
STATIC = (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e8))
EXPLICIT = (di.Penalty, di.Kinematic, lambda pair: di.Penalty(pair, balanced=True))


class Block:
    """A unit block over a floor of the same height, `gap` above it, in plane strain or space; `wavy`: the block's
    underside is a wave about this gap [L]."""

    def __init__(self, dim=2, gap=0.0, rigid=False, wavy=0.0, cell=None):
        low, up = (0.0,) * (dim - 1), (1.0,) * (dim - 1)
        cell = cell or ("quadrilateral" if dim == 2 else "hexahedron")
        counts = [(4,) * dim, (3,) * dim]
        self.boxes = Boxes(
            [((*low, -1.0), (*up, 0.0), counts[1]), ((*low, gap), (*up, 1.0 + gap), counts[0])], cell
        )  # fmt: skip
        self.dim, self.V, self.u, self.law = dim, self.boxes.V, self.boxes.u, self.boxes.law
        self.tags = self.boxes.tags({3: (1, dim - 1, gap), 4: (0, dim - 1, 0.0), 5: (1, dim - 1, 1.0 + gap)})
        self.master = di.RigidPlane(np.zeros(dim), np.eye(dim)[-1]) if rigid else 4
        x = self.boxes.mesh.geometry.x
        on = np.abs(x[:, dim - 1] - gap) < 1e-9
        x[on, dim - 1] += wavy * np.cos(9.0 * x[on, 0])
        self.gap = gap

    def pair(self, **options):
        return di.ContactPair(self.tags, 3, self.master, **options)

    def held(self, down):
        """The head is moved down; the lower block is held at its foot, all sides glide."""
        up = self.dim - 1
        bcs = self.boxes.hold(0, up, -1.0, up) + self.boxes.hold(1, up, 1.0 + self.gap, up, value=-down)
        for axis in range(up):
            bcs += self.boxes.hold(0, axis, 0.0, axis) + self.boxes.hold(1, axis, 0.0, axis)
        return bcs

    def static(self, method, down, **options):
        return di.StaticProblem(self.u, self.law, bcs=self.held(down), contact=[method(self.pair(**options))])


def stiffness(rigid):
    """Force per approach of the blocks, of unit section."""
    return E if rigid else E / 2.0


def check_a_layer_is_met_where_it_ends():
    """A gap of 0.1 and layers of 0.03 and 0.05: the head has moved by 0.02 when they meet, by 0.03 at the end."""
    for dim, rigid, method in ((2, True, 0), (2, False, 0), (3, False, 1), (2, True, 1), (3, True, 0)):
        block = Block(dim, 0.1, rigid)
        problem = block.static(STATIC[method], 0.03, offset=(0.03, 0.05))
        problem.solve(steps=2, progress=False)
        contact = problem.contact[0]
        # A penalty of 1e8 gives way by 1e-5 of the bodies' stiffness.
        assert contact.force[dim - 1] == pytest.approx(0.01 * stiffness(rigid), rel=1e-4 if method else 1e-9)
        bare = Block(dim, 0.1, rigid).static(STATIC[method], 0.03)
        bare.solve(progress=False)
        assert bare.contact[0].force[dim - 1] == 0.0
        largest = COMM.allreduce(np.abs(contact.gap).max(initial=0.0), MPI.MAX)
        assert largest < 1e-6, "gaps are those between the layers"


def check_layers_of_nothing_are_missing_material():
    """A negative offset: blocks that touch meet 0.01 later."""
    block = Block(2, 0.0)
    problem = block.static(di.Lagrange, 0.03, offset=-0.01)
    problem.solve(steps=2, progress=False)
    assert problem.contact[0].force[1] == pytest.approx(0.02 * stiffness(False), rel=1e-9)


def check_a_clearance_whatever_the_meshes_say():
    """Wavy undersides, above the floor or in it: all points have the gap 0.005, and the block is pressed evenly."""
    for dim, gap, rigid, method in ((2, 0.05, True, 0), (2, -0.05, False, 1), (3, 0.02, False, 0), (2, 0.02, True, 1)):
        block = Block(dim, gap, rigid, wavy=0.01)
        problem = block.static(STATIC[method], 0.0, clearance=0.005, search_distance=None if rigid else 0.2)
        contact = problem.contact[0]
        problem.solve(progress=False)
        assert np.allclose(contact.gap, 0.005, rtol=0.0, atol=1e-14)
        assert contact.force[dim - 1] == 0.0 and np.abs(problem.u.x.array).max(initial=0.0) == 0.0
        number = COMM.allreduce(len(contact.points), MPI.SUM)
        assert contact.initial.num_adjusted == number
        farthest = np.abs(0.005 - (contact.points[:, dim - 1]) if len(contact.points) else np.zeros(1)).max()
        assert contact.initial.largest_adjustment == pytest.approx(COMM.allreduce(farthest, MPI.MAX), rel=1e-6)
        assert f"the gaps of {number} points are adjusted to 0.005 before anything is loaded" in contact.adjustment


def check_a_press_fit():
    """A negative clearance is an overlap: blocks between fixed ends are compressed by it."""
    for rigid, method in ((True, 0), (False, 0), (False, 1)):
        block = Block(2, 0.01, rigid)
        problem = block.static(STATIC[method], 0.0, clearance=-0.02)
        problem.solve(progress=False)
        assert problem.contact[0].force[1] == pytest.approx(0.02 * stiffness(rigid), rel=1e-4 if method else 1e-9)


def check_what_is_adjusted_and_what_is_not():
    """Points up to the limit are closed, others keep their gaps, and the message says how many, how far and where."""
    for method in (*STATIC, *EXPLICIT[:2]):
        block = Block(2, 0.0, True, wavy=0.01)
        explicit = method in EXPLICIT
        log = logging.getLogger("dolfinx_impact")
        log.addHandler(lines := Lines())
        found = []
        for options in ({}, {"adjust": 0.004}, {"adjust": 0.0}, {"remove_penetration": True}):
            contact = [method(block.pair(**options))]
            made = di.ExplicitProblem if explicit else di.StaticProblem
            problem = made(fem.Function(block.V), block.law, contact=contact)
            contact = problem.contact[0]
            gap = contact.gap.copy()
            if method is di.Kinematic:  # it knows gaps after a step
                gap = block.V.tabulate_dof_coordinates()[contact.nodes, 1]
                gap = gap if contact.initial is None else gap + contact.initial.offset
            found.append((gap, contact))
        log.removeHandler(lines)
        meshed, closed, overlap, removed = (gap for gap, _ in found)
        near = meshed <= 0.004
        assert np.allclose(closed[near], 0.0, atol=1e-15) and np.array_equal(closed[~near], meshed[~near])
        assert np.allclose(overlap, np.maximum(meshed, 0.0), atol=1e-15) and np.array_equal(overlap, removed)
        initial = found[1][1].initial
        assert initial.num_adjusted == COMM.allreduce(int(near.sum()), MPI.SUM)
        largest = COMM.allreduce(np.abs(meshed[near]).max(initial=0.0), MPI.MAX)
        assert initial.largest_adjustment == pytest.approx(largest, rel=1e-12)
        assert len(initial.where_adjusted) == 2
        if COMM.rank == 0:
            assert any(f"the gaps of {initial.num_adjusted} points are adjusted to 0 before" in t for t in lines.lines)
            assert any("removed, gaps count from there" in t for t in lines.lines)


def fall(method, block, until, **options):
    """A block that falls towards the floor at 1."""
    velocity = fem.Function(block.V)
    upper = block.V.tabulate_dof_coordinates()[:, block.dim - 1] > min(0.0, block.gap) + 1e-6
    upper |= np.abs(block.V.tabulate_dof_coordinates()[:, block.dim - 1] - block.gap) < 1e-9
    up = block.dim - 1
    held = [] if isinstance(block.master, di.RigidPlane) else block.boxes.hold(0, up, -1.0, *range(block.dim))
    body = np.flatnonzero(upper)
    velocity.x.array.reshape(-1, block.dim)[body, up] = -1.0
    run = di.ExplicitProblem(block.u, block.law, velocity=velocity, bcs=held, contact=[method(block.pair(**options))])
    run.advance(until=until, progress=False)
    return run


def check_an_explicit_block_lands_on_its_layer():
    """It lands when it has fallen by the gap less the layers, to a step, with its energy; a bare one falls farther."""
    for dim, rigid, method in ((2, True, 0), (2, False, 0), (2, False, 1), (3, False, 0), (2, True, 1), (2, False, 2)):
        times = []
        for options in ({"offset": (0.02, 0.03)}, {}):
            run = fall(EXPLICIT[method], Block(dim, 0.08, rigid), 0.1, **options)
            force = run.force_history[0][:, dim - 1]
            times.append(run.energy_history[np.flatnonzero(force > 0.0)[0], 0])
            assert abs(run.energy["drift"]) < 1e-2
        step = run.stable_step()
        assert abs(times[0] - 0.03) < 1.5 * step and abs(times[1] - 0.08) < 1.5 * step, (dim, rigid, method, times)


def check_an_adjusted_gap_has_no_energy():
    """A wavy block that overlaps its floor: closed at the start, nothing moves and there is no energy, in any problem;
    left as it is, it is pushed out."""
    for method in EXPLICIT[:2]:
        for rigid in (True, False):
            # A kinematic contact corrects an overlap in the first step, whatever it costs.
            for removed in (True, False) if method is di.Penalty else (True,):
                block = Block(2, -0.004, rigid, wavy=0.003)
                held = [] if rigid else block.boxes.hold(0, 1, -1.0, 0, 1)
                contact = [method(block.pair(adjust=0.0 if removed else None))]
                run = di.ExplicitProblem(block.u, block.law, bcs=held, contact=contact)
                run.advance(until=20 * run.stable_step(), progress=False)
                moved = COMM.allreduce(np.abs(run.u.x.array).max(initial=0.0), MPI.MAX)
                energies = [abs(run.energy[name]) for name in ("kinetic", "internal", "contact")]
                # Round-off of positions of size one, as stiff as 1e3.
                assert (moved < 1e-13 and max(energies) < 1e-20) if removed else moved > 1e-5, (method, rigid)
    block = Block(2, -0.004, True, wavy=0.003)
    implicit = di.NewmarkProblem(block.u, block.law, contact=[di.Penalty(block.pair(adjust=0.0), penalty=1e5)])
    implicit.advance(until=0.02, dt=5e-3, progress=False)
    assert np.abs(implicit.u.x.array).max(initial=0.0) < 1e-13 and abs(implicit.energy["contact"]) < 1e-20


def check_an_implicit_block_lands_on_its_layer():
    for method in (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e6)):
        block = Block(2, 0.05, True)
        velocity = fem.Function(block.V)
        velocity.x.array.reshape(-1, 2)[:, 1] = -1.0
        times = []
        run = di.NewmarkProblem(
            block.u, block.law, velocity=velocity, rho_inf=0.8, contact=[method(block.pair(offset=0.02))]
        )
        run.advance(
            until=0.04, dt=1e-3, callback=lambda p: times.append((p.time, p.contact[0].force[1])), progress=False
        )
        first = next(t for t, force in times if force > 0.0)
        assert abs(first - 0.03) < 1.1e-3  # a step


def check_restarts_have_the_same_gaps():
    """A restored run goes on with the layers and gaps of the reference configuration; another adjustment is refused."""
    for kind in ("static", "explicit"):
        options = {"adjust": 0.02, "offset": 0.004}

        def make(**given):
            block = Block(2, 0.01, False, wavy=0.002)
            pair = block.pair(**given)
            if kind == "static":
                return di.StaticProblem(block.u, block.law, bcs=block.held(0.01), contact=[di.Penalty(pair, 1e5)])
            velocity = fem.Function(block.V)
            velocity.x.array[1::2] = -0.1 * (block.V.tabulate_dof_coordinates()[:, 1] > 0.0)
            held = block.boxes.hold(0, 1, -1.0, 0, 1)
            return di.ExplicitProblem(block.u, block.law, velocity=velocity, bcs=held, contact=[di.Penalty(pair)])

        first = make(**options)
        if kind == "static":
            first.solve(progress=False)
        else:
            first.advance(until=0.01, progress=False)
        assert first.contact[0].force[1] > 0.0
        with shared_folder() as folder:
            first.save(folder / "state.h5")
            again = make(**options)
            again.restore(folder / "state.h5")
            with pytest.raises(ValueError, match="remove_penetration"):
                make().restore(folder / "state.h5")
        np.testing.assert_allclose(again.contact[0].gap, first.contact[0].gap, rtol=0.0, atol=1e-14)


def check_what_is_refused():
    block = Block(2, 0.0)
    for options, words in (
        ({"adjust": -1.0}, "adjust is -1"),
        ({"adjust": 0.1, "remove_penetration": True}, "remove_penetration is adjust=0.0"),
        ({"offset": (1.0, 2.0, 3.0)}, "offset has 3 numbers"),
        ({"clearance": np.nan}, "clearance"),
    ):
        with pytest.raises(ValueError, match=words):
            block.pair(**options)
    for method in (di.Lagrange, di.Penalty):
        with pytest.raises(ValueError, match="the search distance 0.1 is not larger than the offset 0.2"):
            di.StaticProblem(block.u, block.law, contact=[method(block.pair(offset=0.2, search_distance=0.1))])
    with pytest.raises(ValueError, match="the search distance 0.1 is not larger than the offset 0.2"):
        di.ExplicitProblem(
            fem.Function(block.V), block.law, contact=[di.Kinematic(block.pair(offset=0.2, search_distance=0.1))]
        )
