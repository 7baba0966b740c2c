# SPDX-License-Identifier: MIT
"""Cost of explicit dynamics: whole steps against DOLFINx's force alone, contact, output, memory, ranks.

Times are processor times of this process, so that other programs have little influence. Runs on several ranks, contact
and output are measured by wall-clock time.
"""

import gc
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias, Union

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace
from mpi4py import MPI
from scipy.spatial import cKDTree

from dolfinx_impact import _cpp, compat, materials
from dolfinx_impact import meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.mpi_launcher import on_ranks
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.contact import ContactPair, GeneralContact, Kinematic, Penalty, Tie
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.forms import quadrature
from dolfinx_impact.loads import Traction
from dolfinx_impact.materials import FULL, REDUCED, Material
from dolfinx_impact.plasticity import J2Plasticity
from .rows import Job, Row, row
from .setup import CASES, FAST, FINITE, STRICT, Case, MaterialClass, Setup

CELLS_PER_S = "million cells/s"
# Cells along the interface and through the thickness.
SHARE_BLOCKS = (32, 32)  # 1.5 % of the nodes are slaves
COST_BLOCKS = (64, 4)  # thin blocks, in which contact is a large part of the step
TIED_BLOCKS = (100, 4)  # 10,201 slave nodes
ROUND = 0.3  # duration of a round, in processor time [s]
SPEED = 0.005  # sliding and closing speed over the wave speed [1]
# Of Setup's displacement, for steps alone: where cells deform by a third, and fast, the stable step is found anew every
# few steps, which takes as long as fifty of them [1].
AMPLITUDE = 1e-2
HAND_WRITTEN = (("hexahedron", 1), ("tetrahedron", 1), ("tetrahedron", 2))  # cells and degrees
ContactClass: TypeAlias = type[Union[Penalty, Kinematic]]


def initial_velocity(V: FunctionSpace, speed: float = 1e-3) -> Function:
    """Velocity field without zeros, because arithmetic with zeros can be faster.

    Args:
        V: space of the displacement.
        speed: amplitude [L/T].

    Returns:
        Velocity [L/T].
    """
    velocity, dim = fem.Function(V), V.mesh.geometry.dim
    velocity.interpolate(lambda x: speed * np.array([np.cos(3 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
    return velocity


def step_seconds(problem: ExplicitProblem, steps: int, rounds: int = 3) -> tuple[float, float]:
    """Processor time per step of `advance`.

    Args:
        problem: problem, which is advanced.
        steps: number of steps per round.
        rounds: number of rounds, after a shorter one that is not counted.

    Returns:
        Best and median time of the rounds [s].
    """
    times = []
    for k in range(rounds + 1):
        dt = 0.9 * problem._stepper.safe_step
        count = steps if k else max(2, steps // 5)  # the first round warms up
        begin, first = time.process_time(), problem.step
        problem.advance(problem.time + count * dt, progress=False)
        if k:
            times.append((time.process_time() - begin) / (problem.step - first))
    return min(times), float(np.median(times))


def own_form(u: Function) -> ufl.Form:
    """Linear elasticity as a user writes it, with the package's quadrature rule; it is compiled at run time.

    Args:
        u: displacement in space.

    Returns:
        Residual.
    """
    V, mesh = u.function_space, u.function_space.mesh
    cell, degree = mesh.topology.cell_name(), V.element.basix_element.degree
    rule = quadrature.metadata(quadrature.stiffness_degree(cell, degree, compat.coordinate_element(mesh).degree, "3d"))
    mu, lam = (fem.Constant(mesh, np.float64(x)) for x in (1e3 / 2.6, 300.0 / (1.3 * 0.4)))
    strain = ufl.sym(ufl.grad(u))
    stress = 2 * mu * strain + lam * ufl.tr(strain) * ufl.Identity(3)
    return ufl.inner(stress, ufl.grad(ufl.TestFunction(V))) * ufl.dx(domain=mesh, metadata=rule)


def step_rows(
    cases: Sequence[Case],
    law: MaterialClass = materials.LinearElastic,
    steps: int = 0,
    baselines: Collection[str] = ("A", "B"),
    own: Collection[str] = (),
) -> list[Row]:
    """Measure whole steps against assemble_vector alone.

    Args:
        cases: cell, degree and cells per side.
        law: class of the material.
        steps: number of steps per round; 0 takes as many as last ROUND seconds.
        baselines: baselines of bench/force.py, "A" or "B".
        own: cells for which a residual of the user is measured too.

    Returns:
        Rows.

    Raises:
        RuntimeError: the initial acceleration differs from that of assemble_vector's force, or stable steps were found
            among those that are timed.
    """
    rows = []
    for cell, degree, n in cases:
        setup = Setup(cell, degree, n, law)
        setup.u.x.array[:] *= AMPLITUDE
        label, name = f"{cell} P{degree}", law.law_class.name
        material = law(1e3, 0.3, 1.0, "3d")
        u_start = setup.u.x.array.copy()
        problem = ExplicitProblem(setup.u, material, velocity=initial_velocity(setup.V))
        acceleration = problem.acceleration.x.array * problem.mass.array
        count = steps or max(5, math.ceil(ROUND / step_seconds(problem, 5, 1)[0]))
        anew = problem._cpp_object.safe_step.num_found
        ours = step_seconds(problem, count)[1]
        anew = problem._cpp_object.safe_step.num_found - anew
        if anew > 0:
            raise RuntimeError(
                f"{label}: {anew} stable steps were found anew among those to be timed: no timing counts"
            )
        setup.u.x.array[:] = u_start
        found = {}
        for key, flags in (("A", STRICT), ("B", FAST)):
            if key in baselines:
                found[key], force = setup.baseline(flags)
                if key == "A":
                    check(label, acceleration, -force)
        force_alone = setup.ours()[0]
        rate = setup.num_cells / ours * 1e-6
        for key, seconds in found.items():
            base = setup.num_cells / seconds * 1e-6
            rows.append(row(f"{name} whole step / {key} (force)", label, 1, rate, CELLS_PER_S, base))
        base = setup.num_cells / force_alone * 1e-6
        rows.append(row(f"{name} whole step / own force", label, 1, rate, CELLS_PER_S, base))
        if cell in own:
            rows.append(own_row(setup, label, problem, count))
        if law is materials.LinearElastic and (cell, degree) in HAND_WRITTEN and _cpp.bench.HandWrittenStep.widths():
            setup.u.x.array[:] = u_start
            rows.append(hand_written_row(setup, label, steps or max(count, 100)))
    return rows


def check(label: str, found: FloatArray, expected: FloatArray) -> None:
    """Refuse a timing of forces that differ.

    Args:
        label: cell and degree.
        found: force of the step, shape (num_dofs) [F].
        expected: force of assemble_vector, shape (num_dofs) [F].

    Raises:
        RuntimeError: the forces differ by more than round-off.
    """
    difference = np.max(np.abs(found - expected)) / np.max(np.abs(expected))
    if not difference < 1e-11:
        raise RuntimeError(f"{label}: step and assemble_vector differ by {difference:.1e}: no timing counts")


def own_row(setup: Setup, label: str, package: ExplicitProblem, steps: int) -> Row:
    """Measure a residual of the user against the package's kernel, in alternating rounds.

    Args:
        setup: body.
        label: cell and degree.
        package: problem with the package's kernel.
        steps: number of steps per round.

    Returns:
        Row.

    Raises:
        RuntimeError: the residual was found among the package's kernels.
    """
    u = fem.Function(setup.V, name="u")
    own = ExplicitProblem(u, residual=own_form(u), density=1.0, velocity=initial_velocity(setup.V))
    for part in own._bodies.internal._parts:
        if part.compiled.source == "package":
            raise RuntimeError("the residual of one's own was found in the package: nothing is compared")
    times = [(step_seconds(own, steps, 1)[0], step_seconds(package, steps, 1)[0]) for _ in range(3)]
    mine, theirs = np.median(times, axis=0)
    count = setup.num_cells * 1e-6
    return row("own residual / package, whole step", label, 1, count / mine, CELLS_PER_S, count / theirs)


def hand_written_row(setup: Setup, label: str, steps: int, rounds: int = 3, integration: str = FULL) -> Row:
    """Measure the package's step against one that is written by hand for the cell and the law, in alternating rounds.

    What an `advance` does once, as for energies and results, is counted in: rounds need many steps.

    Args:
        setup: body; the run starts from its displacement.
        label: cell and degree.
        steps: number of steps per round.
        rounds: number of rounds, after one that is not counted.
        integration: of the material, "full", or "reduced" for hexahedra with one point and hourglass control.

    Returns:
        Row; the baseline is the faster one of the widths that the processor has.

    Raises:
        RuntimeError: the displacements of the two differ.
    """
    V, velocity = setup.V, initial_velocity(setup.V)
    u = fem.Function(V)
    u.x.array[:] = start = setup.u.x.array.copy()
    package = ExplicitProblem(u, materials.LinearElastic(1e3, 0.3, 1.0, "3d", integration), velocity=velocity)
    mu, lam = 1e3 / 2.6, 300.0 / (1.3 * 0.4)
    cells = np.ascontiguousarray(V.dofmap.list, dtype=np.int32)
    mass = np.ascontiguousarray(package.mass.array[::3])
    by_hand = [
        _cpp.bench.HandWrittenStep(
            V.tabulate_dof_coordinates().ravel(),
            cells.ravel(),
            cells.shape[1],
            mu,
            lam,
            mass,
            width,
            one_point=integration == REDUCED,
        )
        for width in _cpp.bench.HandWrittenStep.widths()
    ]
    for loop in by_hand:
        loop.start(start, velocity.x.array)
    dt, times = 0.9 * package._stepper.safe_step, []
    for k in range(rounds + 1):
        before, first, begin = package.time, package.step, time.process_time()
        package.advance(before + (steps if k else max(2, steps // 5)) * dt, progress=False)
        count = package.step - first
        found = [(time.process_time() - begin) / count]
        for loop in by_hand:
            begin = time.process_time()
            loop.run(count, (package.time - before) / count)
            found.append((time.process_time() - begin) / count)
        times.append(found)
        moved = np.max(np.abs(u.x.array - start))
        for loop in by_hand if k == 0 else []:
            difference = np.max(np.abs(loop.displacement() - u.x.array)) / moved
            if not difference < 1e-9:
                raise RuntimeError(
                    f"{label}: our steps and those written by hand differ by {difference:.1e}: no timing counts"
                )
    ours, *hand = np.median(times[1:], axis=0)
    millions = setup.num_cells * 1e-6
    what = "whole step" if integration == FULL else f"{integration} whole step"
    return row(f"linear_elastic {what} / written by hand", label, 1, millions / ours, CELLS_PER_S,
               millions / min(hand))  # fmt: skip


@lru_cache(maxsize=1)
def two_blocks(n: int, layers: int) -> Any:
    """Mesh of the blocks, which measurements that follow each other share.

    Args:
        n: number of cells along each side of the interface.
        layers: number of cells through the thickness.

    Returns:
        Mesh with its tags.
    """
    size = layers / n
    return meshes.make(
        "two_blocks", MPI.COMM_SELF, cell="hexahedron", gap=1e-4 / n, lower=(1.1, 1.1, size), upper=(1.0, 1.0, size),
        lower_cells=(n, n, layers), upper_cells=(n, n, layers),
    )  # fmt: skip


class Blocks:
    """A block that is pressed on a clamped one and slides on it; the meshes do not match at the interface.

    Args:
        n: number of cells along each side of the interface.
        layers: number of cells through the thickness.
        contact: class of the contact; None for no contact.
        friction: Coulomb's friction coefficient [1].
        moving: whether the upper block is thrown on the lower one; else the load moves it.
        options: further arguments of the contact.
    """

    def __init__(
        self, n: int, layers: int, contact: Any = None, friction: float = 0.0, moving: bool = True, **options: Any
    ) -> None:
        model, height = two_blocks(n, layers), layers / n
        V = self.V = fem.functionspace(model.mesh, ("Lagrange", 1, (3,)))
        law = materials.LinearElastic(1e3, 0.3, 1.0, "3d")
        tags, tag = model.facet_tags, model.tags
        low = fem.locate_dofs_topological(V, 2, tags.find(tag["bottom"]))
        bcs = [fem.dirichletbc(np.zeros(3), low, V)]
        velocity, speed = fem.Function(V), SPEED * law.wave_speed * moving
        velocity.interpolate(lambda x: np.where(x[2] > height * (1 + 1e-9), 1.0, 0.0) * speed * np.array(
            [[1.0], [0.3], [-1.0]]))  # fmt: skip
        pair = ContactPair(tags, slave=tag["slave_surface"], master=tag["master_surface"], friction=friction)
        self.num_cells: int = model.mesh.topology.index_map(3).size_local
        self.num_nodes: int = V.dofmap.index_map.size_local
        self.num_slaves = (n + 1) ** 2
        self.master_facets = tags.find(tag["master_surface"])
        contacts: list[Any] = []
        if contact is not None:
            general = issubclass(contact, GeneralContact)
            contacts = [contact(tags, friction=friction) if general else contact(pair, **options)]
        self.problem = ExplicitProblem(
            fem.Function(V), law, velocity=velocity, bcs=bcs, loads=[Traction(tags, tag["top"], (0.0, 0.0, -2.0))],
            contact=contacts,
        )  # fmt: skip


CONTACTS: tuple[tuple[str, ContactClass, float], ...] = (
    ("penalty", Penalty, 0.0),
    ("penalty, friction", Penalty, 0.3),
    ("kinematic", Kinematic, 0.0),
    ("kinematic, friction", Kinematic, 0.3),
)


def contact_seconds(problem: ExplicitProblem, steps: int) -> tuple[float, float]:
    """Wall-clock time per step of contact, by the integrator's clock, and of the whole step.

    Args:
        problem: problem, which is advanced.
        steps: number of steps.

    Returns:
        Time of contact and of the whole step [s].
    """
    first, begin, spent = problem.step, time.perf_counter(), problem._cpp_object.integrator.contact_seconds
    problem.advance(problem.time + steps * 0.9 * problem._stepper.safe_step, progress=False)
    count = problem.step - first
    return (problem._cpp_object.integrator.contact_seconds - spent) / count, (time.perf_counter() - begin) / count


def contact_rows(
    share: tuple[int, int] = SHARE_BLOCKS,
    cost: tuple[int, int] = COST_BLOCKS,
    steps: tuple[int, int] = (30, 25),
    rounds: tuple[int, int] = (5, 12),
) -> list[Row]:
    """Measure the share of contact in a step, and its cost per slave node and step.

    The bodies slide all the time and are in contact over most of the surface. Times include searches and are medians of
    several rounds.

    Args:
        share: cells along the interface and through the thickness of the blocks that give the share.
        cost: the same of the blocks that give the cost.
        steps: number of steps per round for either.
        rounds: number of rounds for either.

    Returns:
        Rows.
    """
    rows = []
    cases = zip(("share", "cost"), (share, cost), steps, rounds)
    for what, (n, layers), num_steps, num_rounds in cases:
        for name, kind, friction in CONTACTS:
            model = Blocks(n, layers, kind, friction)
            contact_seconds(model.problem, num_steps)
            times: list[tuple[float, float]] = []
            touching: list[float] = []
            for _ in range(num_rounds):
                times.append(contact_seconds(model.problem, num_steps))
                touching.append(float(np.mean(model.problem.contact[0].status > 0)))
            contact, whole = np.median(times, axis=0)
            label = f"{model.num_slaves} of {model.num_nodes} nodes"
            if what == "share":
                rows.append(row(f"contact, {name}: share of a step", label, 1, 1e3 * contact, "ms", 1e3 * whole))
            rows.append(row(f"contact, {name}, goal {100 if friction else 50}", label, 1,
                            1e9 * contact / model.num_slaves, "ns/slave node/step",
                            100 if friction else 50))  # fmt: skip
            if what == "share" and kind is Penalty and _cpp.bench.HandWrittenContact.available():
                rows.append(hand_written_contact_row(model, name, friction, 1e9 * contact / model.num_slaves))
            if what == "cost":
                rows.append(row(f"  {name}: nodes that touch", label, 1, float(np.mean(touching)), "", 1.0))
    return rows


def facet_nodes(V: FunctionSpace, facets: IntArray) -> IntArray:
    """Find the nodes of facets of hexahedra of degree 1.

    Args:
        V: displacement space.
        facets: facets of this rank.

    Returns:
        Nodes in DOLFINx's order, shape (num_facets, 4).
    """
    topology, layout = V.mesh.topology, V.dofmap.dof_layout
    for dims in ((2, 3), (3, 2)):
        topology.create_connectivity(*dims)
    cells = [topology.connectivity(2, 3).links(facet)[0] for facet in facets]
    sides = [np.flatnonzero(topology.connectivity(3, 2).links(c) == f)[0] for c, f in zip(cells, facets, strict=True)]
    places = [layout.entity_closure_dofs(2, side) for side in sides]
    return np.array([V.dofmap.cell_dofs(c)[p] for c, p in zip(cells, places, strict=True)], dtype=np.int32)


def hand_written_contact_row(model: Blocks, name: str, friction: float, ours: float, rounds: int = 40) -> Row:
    """Measure penalty contact that is written by hand, in the state of a run, with all data out of the caches.

    What is written by hand moves positions, projects, evaluates springs and friction and adds forces. It has no search,
    its nodes stay over their facets, and it keeps no energies and no results: less than any contact can do with.

    Args:
        model: run of penalty contact.
        name: of the contact, for the row.
        friction: Coulomb's friction coefficient [1].
        ours: time of the package's contact per slave node and step [ns].
        rounds: number of evaluations, of which the median counts.

    Returns:
        Row.

    Raises:
        RuntimeError: no node touches; the gaps of the two differ by more than what nodes move in a step.
    """
    problem, V = model.problem, model.V
    contact, x = problem.contact[0], V.tabulate_dof_coordinates()
    if not np.any(contact.status > 0):
        raise RuntimeError("no node touches: there is nothing to compare")
    slaves = contact.nodes[: len(contact.nodes) // 4 * 4].astype(np.int32)
    nodes = facet_nodes(V, model.master_facets)
    below = nodes[cKDTree(x[nodes].mean(axis=1)[:, :2]).query(x[slaves, :2], p=np.inf)[1]]  # they are squares
    edges = x[below[:, 1:3]] - x[below[:, :1]]
    turned = np.cross(edges[:, 0], edges[:, 1])[:, 2] < 0.0
    below[turned] = below[turned][:, [0, 2, 1, 3]]
    by_hand = _cpp.bench.HandWrittenContact(x.ravel(), slaves, below.ravel().astype(np.int32), 1.0, friction)
    u = problem.u.x.array.copy()
    du = 0.9 * problem._stepper.safe_step * problem.velocity.x.array
    seconds = float(np.median([by_hand.evaluate(u, du, True) for _ in range(rounds)]))
    closed = contact.status[: len(slaves)] > 0
    difference = np.abs(by_hand.gap() - contact.gap[: len(slaves)])[closed].max()
    if not difference < 2 * np.abs(du).max():
        raise RuntimeError(f"gaps of contact differ from those written by hand by {difference:.1e}: no timing counts")
    label = f"{model.num_slaves} of {model.num_nodes} nodes"
    return row(f"contact, {name} / written by hand", label, 1, ours, "ns/slave node/step", 1e9 * seconds / len(slaves))


def general_rows(cost: tuple[int, int] = COST_BLOCKS, steps: int = 25, rounds: int = 8) -> list[Row]:
    """Measure contact without pairs against a balanced pair of the surfaces that meet, in alternating rounds.

    All outer facets of both blocks belong to the one, a third of whose nodes touch; the other one has the nodes of the
    two faces. Times include searches and are medians.

    Args:
        cost: cells along the interface and through the thickness of the blocks.
        steps: number of steps per round.
        rounds: number of rounds.

    Returns:
        Rows: cost per node of the surface and step, without and with friction; and the nodes that touch.
    """
    rows = []
    for name, friction in (("", 0.0), (", friction", 0.3)):
        general = Blocks(*cost, GeneralContact, friction)
        pair = Blocks(*cost, Penalty, friction, balanced=True)
        num_nodes, num_paired = len(general.problem.contact[0].nodes), 2 * pair.num_slaves
        times = [[contact_seconds(model.problem, steps)[0] for model in (general, pair)] for _ in range(rounds + 1)]
        ours, theirs = np.median(times[1:], axis=0)
        label = f"{num_nodes} of {general.num_nodes} nodes"
        unit = "ns/surface node/step"
        rows.append(row(f"contact without pairs{name} / balanced pair", label, 1, 1e9 * ours / num_nodes, unit,
                        1e9 * theirs / num_paired))  # fmt: skip
        touching = float(np.sum(general.problem.contact[0].status > 0))
        rows.append(row(f"  without pairs{name}: nodes that touch", label, 1, touching / num_nodes, "", 1.0))
    return rows


def tie_rows(cost: tuple[int, int] = TIED_BLOCKS, steps: int = 25, rounds: int = 8) -> list[Row]:
    """Measure tied blocks against the same ones that know nothing of each other, in alternating rounds.

    Meshes do not match at the joint. Times of steps are medians.

    Args:
        cost: cells along the joint and through the thickness of the blocks.
        steps: number of steps per round.
        rounds: number of rounds.

    Returns:
        Rows: set-up of the problem, and a whole step.
    """
    two_blocks(*cost)  # is no part of either set-up
    begin = time.perf_counter()
    alone = Blocks(*cost, moving=False)
    between = time.perf_counter()
    tied = Blocks(*cost, Tie, moving=False)
    setups = time.perf_counter() - between, between - begin
    times = [[contact_seconds(model.problem, steps)[1] for model in (tied, alone)] for _ in range(rounds + 1)]
    label = f"{tied.num_slaves} of {tied.num_nodes} nodes"
    pairs = (("set-up", setups), ("step", np.median(times[1:], axis=0)))
    return [row(f"tied blocks / apart, {what}", label, 1, 1e3 * a, "ms", 1e3 * b) for what, (a, b) in pairs]


def output_rows(n: int, steps: int = 1000, rounds: int = 2) -> list[Row]:
    """Measure the share of output in the time loop: frames every 100 steps and a checkpoint per round.

    Args:
        n: cells per side.
        steps: number of steps per round.
        rounds: number of rounds.

    Returns:
        Rows.
    """
    setup, problem = explicit_problem(MPI.COMM_SELF, n)
    writing = 0.0
    with tempfile.TemporaryDirectory() as folder:
        recorder = problem.record(Path(folder) / "run", every=100)
        # The first frame, which contains the mesh, is written before the loop and not counted.
        begin, first, before = time.perf_counter(), problem.step, recorder.seconds
        for _ in range(rounds):
            problem.advance(problem.time + steps * 0.9 * problem._stepper.safe_step, progress=False)
            saved = time.perf_counter()
            problem.save(Path(folder) / "checkpoint.h5")
            writing += time.perf_counter() - saved
        loop, writing = time.perf_counter() - begin, writing + recorder.seconds - before
        count = problem.step - first
        recorder.close()
    label = f"hexahedron P1, {setup.num_cells} cells"
    return [row("output: share of the loop", label, 1, 1e3 * writing / count, "ms/step", 1e3 * loop / count)]


def resident() -> int:
    """Size of this process in memory.

    Returns:
        Resident set [B].
    """
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def explicit_problem(comm: MPI.Intracomm, n: int, material: Material | None = None) -> tuple[Setup, ExplicitProblem]:
    """Explicit problem of a cube of hexahedra.

    Args:
        comm: communicator of the mesh.
        n: cells per side.
        material: its material; None: linear elasticity.

    Returns:
        Body and problem.
    """
    setup = Setup("hexahedron", 1, n, comm=comm)
    law = materials.LinearElastic(1e3, 0.3, 1.0, "3d") if material is None else material
    return setup, ExplicitProblem(setup.u, law, velocity=initial_velocity(setup.V))


def run_on_ranks(what: str, ranks: int, n: int) -> dict[str, float]:
    """Run this module in processes of its own.

    Args:
        what: "memory", "history" (memory with plasticity) or "rate".
        ranks: number of ranks.
        n: cells per side.

    Returns:
        Measured values by name.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.json"
        own = [sys.executable, "-m", "impact_studies.bench.explicit", what, str(n), str(path)]
        subprocess.run([*on_ranks(ranks), *own], check=True, capture_output=True)
        return json.loads(path.read_text())


def memory_rows(n: int = 48) -> list[Row]:
    """Measure the memory per cell: the resident set after some steps less that after a small problem.

    Args:
        n: cells per side.

    Returns:
        Rows.
    """
    found = run_on_ranks("memory", 1, n)
    label = f"hexahedron P1, {found['cells']} cells"
    return [row("explicit run: memory per cell, goal 0.8", label, 1, found["kB"], "kB", 0.8)]


def rank_rows(ranks: int, n: int = 48) -> list[Row]:
    """Measure whole steps per core on several ranks, and the messages between them.

    The baselines are one rank with as many cells per rank, and the same number of separate runs at the same time, which
    share the memory bandwidth and send no messages.

    Args:
        ranks: number of ranks.
        n: cells per side on one rank.

    Returns:
        Rows.
    """
    one, several = run_on_ranks("rate", 1, n), run_on_ranks("rate", ranks, int(round(n * ranks ** (1 / 3))))
    with ThreadPoolExecutor(ranks) as pool:
        runs = pool.map(lambda _: run_on_ranks("rate", 1, n), range(ranks))
        separate = float(np.mean([found["rate"] for found in runs]))
    unit, cell = CELLS_PER_S + "/core", "hexahedron P1"
    return [
        row("linear_elastic whole step, per core", cell, ranks, several["rate"], unit, one["rate"]),
        row("  beside as many separate runs", cell, ranks, several["rate"], unit, separate),
        row("  messages per step and rank", cell, ranks, several["messages"], "", 2.0 * (ranks - 1)),
        row("  sent per step and rank, 8 B a value", cell, ranks, several["values"] * 8e-3, "kB",
            several["cells"] * 8e-3),
    ]  # fmt: skip


def _memory(n: int, plastic: bool = False) -> dict[str, float]:
    """Number of cells, and memory per cell [kB]."""

    def material() -> Material | None:
        return J2Plasticity(1e3, 0.3, 1.0, yield_stress=1e-3, hardening=100.0) if plastic else None

    explicit_problem(MPI.COMM_SELF, 4, material())[1].advance(0.1, progress=False)
    gc.collect()
    before = resident()
    setup, problem = explicit_problem(MPI.COMM_SELF, n, material())
    del setup.b  # of other measurements
    problem.advance(20 * 0.9 * problem._stepper.safe_step, progress=False)
    gc.collect()
    return {"cells": setup.num_cells, "kB": (resident() - before) / setup.num_cells * 1e-3}


def _rate(n: int, steps: int = 60, rounds: int = 3) -> dict[str, float]:
    """Million cells per second and rank, cells per rank, and most messages and values of a rank in a step."""
    comm, rates = MPI.COMM_WORLD, []
    setup, problem = explicit_problem(comm, n)
    cells = comm.allreduce(setup.num_cells, MPI.SUM) / comm.size
    for _ in range(rounds + 1):
        comm.Barrier()
        begin, first, sent = time.perf_counter(), problem.step, np.array(problem._cpp_object.integrator.traffic)
        problem.advance(problem.time + steps * 0.9 * problem._stepper.safe_step, progress=False)
        comm.Barrier()
        rates.append(cells * (problem.step - first) / (time.perf_counter() - begin) * 1e-6)
        sent = (np.array(problem._cpp_object.integrator.traffic) - sent) / (problem.step - first)
    messages, values = comm.allreduce(sent[0], MPI.MAX), comm.allreduce(sent[1], MPI.MAX)
    return {"rate": float(np.median(rates[1:])), "cells": cells, "messages": messages, "values": values}


def jobs(large: bool = False, ranks: int = 0) -> list[Job]:
    """Measurements of explicit dynamics.

    Args:
        large: take larger models and more rounds.
        ranks: include whole steps on this number of ranks; 0 for none.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    solids = [c for c in CASES if c[0] in ("tetrahedron", "hexahedron")]
    out: list[Job] = [(f"explicit step, {c[0]} P{c[1]}", partial(step_rows, (c,), own=("hexahedron",))) for c in solids]
    neo_hookean = partial(step_rows, law=materials.NeoHookean, baselines=("A",))
    out += [(f"explicit step, neo_hookean, {c[0]} P{c[1]}", partial(neo_hookean, (c,))) for c in FINITE]
    out.append(("explicit contact", partial(contact_rows, rounds=(5, 12) if large else (3, 8))))
    out.append(("explicit contact without pairs", partial(general_rows, rounds=6 if large else 4)))
    out.append(("explicit steps of tied bodies", partial(tie_rows, rounds=6 if large else 5)))
    out += [("explicit output", partial(output_rows, n)) for n in ((48, 20) if large else (20,))]
    out.append(("explicit memory", partial(memory_rows, 64 if large else 40)))
    return out + ([(f"explicit steps on {ranks} ranks", partial(rank_rows, ranks))] if ranks > 1 else [])


if __name__ == "__main__":
    what, n, path = sys.argv[1:]
    result = _rate(int(n)) if what == "rate" else _memory(int(n), plastic=what == "history")
    if MPI.COMM_WORLD.rank == 0:
        Path(path).write_text(json.dumps(result))
