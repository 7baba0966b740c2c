# SPDX-License-Identifier: MIT
"""Cost of explicit dynamics: whole steps against DOLFINx's force alone, contact, output, memory, ranks.

Times are processor time of this process, so that other people's programs count as little as can be; of several ranks
and of output wall time.
"""

import gc
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from .. import ContactPair, ExplicitProblem, Kinematic, Penalty, Traction, materials, meshes
from . import run as bench
from ..forms import quadrature

CELLS_PER_S = "million cells/s"
# Cells on each side of the interface: (thick enough for 1.5 % of the nodes to be slaves; thin, so that contact shows)
SHARE_BLOCKS = (32, 32)
COST_BLOCKS = (64, 4)
ROUND = 0.2  # processor seconds
SPEED = 0.005  # sliding and closing, of the wave speed


def start(V, speed=1e-3):
    """Velocity field without zeros, so that no wave front is as cheap as zeros are."""
    velocity, dim = fem.Function(V), V.mesh.geometry.dim
    velocity.interpolate(lambda x: speed * np.array([np.cos(3 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
    return velocity


def step_seconds(problem, steps, rounds=3):
    """Processor seconds per step of `advance`, best and median of the rounds."""
    times = []
    for k in range(rounds + 1):
        dt = 0.9 * problem._stepper.safe_step
        count = steps if k else max(2, steps // 5)  # the first round warms up
        begin, first = time.process_time(), problem.step
        problem.advance(problem.time + count * dt, progress=False)
        if k:
            times.append((time.process_time() - begin) / (problem.step - first))
    return min(times), float(np.median(times))


def own_form(u):
    """Linear elasticity as a user writes it, with the package's quadrature rule; compiled at run time."""
    V, mesh = u.function_space, u.function_space.mesh
    cell, degree = mesh.topology.cell_name(), V.element.basix_element.degree
    rule = quadrature.metadata(quadrature.stiffness_degree(cell, degree, mesh.geometry.cmap.degree, "3d"))
    mu, lam = fem.Constant(mesh, 1e3 / 2.6), fem.Constant(mesh, 300.0 / (1.3 * 0.4))
    strain = ufl.sym(ufl.grad(u))
    stress = 2 * mu * strain + lam * ufl.tr(strain) * ufl.Identity(3)
    return ufl.inner(stress, ufl.grad(ufl.TestFunction(V))) * ufl.dx(domain=mesh, metadata=rule)


def step_rows(cases, law=materials.LinearElastic, steps=0, baselines=("A", "B"), own=()):
    """Whole steps against assemble_vector alone; for cells in `own`, with a residual of the user's own as well. A round
    has as many steps as last ROUND seconds, if not told.

    Raises:
        RuntimeError: the acceleration of the start is not that of assemble_vector's force.
    """
    rows = []
    for cell, degree, n in cases:
        setup = bench.Setup(cell, degree, n, law)
        label, name = f"{cell} P{degree}", law.law_class.name
        material = law(1e3, 0.3, 1.0, "3d")
        u_start = setup.u.x.array.copy()
        problem = ExplicitProblem(setup.u, material, velocity=start(setup.V))
        acceleration = problem.acceleration.x.array * problem.mass.array
        count = steps or max(5, math.ceil(ROUND / step_seconds(problem, 5, 1)[0]))
        ours = step_seconds(problem, count)[1]
        setup.u.x.array[:] = u_start
        found = {}
        for key, flags in (("A", bench.STRICT), ("B", bench.FAST)):
            if key in baselines:
                found[key], force = setup.baseline(flags)
                if key == "A":
                    check(label, acceleration, -force)
        force_alone = setup.ours()[0]
        rate = setup.num_cells / ours * 1e-6
        for key, seconds in found.items():
            base = setup.num_cells / seconds * 1e-6
            rows.append(bench.row(f"{name} whole step / {key} (force)", label, 1, rate, CELLS_PER_S, base))
        base = setup.num_cells / force_alone * 1e-6
        rows.append(bench.row(f"{name} whole step / own force", label, 1, rate, CELLS_PER_S, base))
        if cell in own:
            rows.append(own_row(setup, label, problem, count))
    return rows


def check(label, found, expected):
    difference = np.max(np.abs(found - expected)) / np.max(np.abs(expected))
    if not difference < 1e-11:
        raise RuntimeError(f"{label}: step and assemble_vector differ by {difference:.1e}: no timing counts")


def own_row(setup, label, package, steps):
    """A residual of one's own against the package's kernel, turn by turn."""
    u = fem.Function(setup.V, name="u")
    own = ExplicitProblem(u, residual=own_form(u), density=1.0, velocity=start(setup.V))
    for part in own._internal._parts:
        if part.compiled.source == "package":
            raise RuntimeError("the residual of one's own was found in the package: nothing is compared")
    times = [(step_seconds(own, steps, 1)[0], step_seconds(package, steps, 1)[0]) for _ in range(3)]
    mine, theirs = np.median(times, axis=0)
    count = setup.num_cells * 1e-6
    return bench.row("own residual / package, whole step", label, 1, count / mine, CELLS_PER_S, count / theirs)


class Blocks:
    """A block pressed and thrown on a clamped one, sliding; meshes that do not match.

    Args:
        n, layers: cells along each side of the interface, and down.
        contact: None, or a class; friction: coefficient.
    """

    def __init__(self, n, layers, contact=None, friction=0.0):
        height = layers / n
        model = meshes.make(
            "two_blocks", MPI.COMM_SELF, cell="hexahedron", gap=1e-4 / n, lower=(1.1, 1.1, height),
            upper=(1.0, 1.0, height), lower_cells=(n, n, layers), upper_cells=(n, n, layers),
        )  # fmt: skip
        V = self.V = fem.functionspace(model.mesh, ("Lagrange", 1, (3,)))
        law = materials.LinearElastic(1e3, 0.3, 1.0, "3d")
        tags, tag = model.facet_tags, model.tags
        low = fem.locate_dofs_topological(V, 2, tags.find(tag["bottom"]))
        bcs = [fem.dirichletbc(np.zeros(3), low, V)]
        velocity, speed = fem.Function(V), SPEED * law.wave_speed
        velocity.interpolate(lambda x: np.where(x[2] > height * (1 + 1e-9), 1.0, 0.0) * speed * np.array(
            [[1.0], [0.3], [-1.0]]))  # fmt: skip
        pair = ContactPair(tags, slave=tag["slave_surface"], master=tag["master_surface"], friction=friction)
        self.num_cells = model.mesh.topology.index_map(3).size_local
        self.num_nodes = V.dofmap.index_map.size_local
        self.num_slaves = (n + 1) ** 2
        self.problem = ExplicitProblem(
            fem.Function(V), law, velocity=velocity, bcs=bcs, loads=[Traction(tags, tag["top"], (0.0, 0.0, -2.0))],
            contact=[] if contact is None else [contact(pair)],
        )  # fmt: skip


CONTACTS = (
    ("penalty", Penalty, 0.0),
    ("penalty, friction", Penalty, 0.3),
    ("kinematic", Kinematic, 0.0),
    ("kinematic, friction", Kinematic, 0.3),
)


def contact_seconds(problem, steps):
    """Wall-clock seconds per step of contact, as the integrator's own clock tells, and of everything."""
    first, begin, spent = problem.step, time.perf_counter(), problem._cpp_object.contact_seconds
    problem.advance(problem.time + steps * 0.9 * problem._stepper.safe_step, progress=False)
    count = problem.step - first
    return (problem._cpp_object.contact_seconds - spent) / count, (time.perf_counter() - begin) / count


def contact_rows(share=SHARE_BLOCKS, cost=COST_BLOCKS, steps=(30, 25), rounds=(5, 12)):
    """Contact's share of a step; nanoseconds per slave node and step. The bodies slide all the time, are in touch over
    most of the surface, and searches are counted in. Medians of several stretches."""
    rows = []
    cases = zip(("share", "cost"), (share, cost), steps, rounds)
    for what, (n, layers), num_steps, num_rounds in cases:
        for name, kind, friction in CONTACTS:
            model = Blocks(n, layers, kind, friction)
            contact_seconds(model.problem, num_steps)
            times, touching = [], []
            for _ in range(num_rounds):
                times.append(contact_seconds(model.problem, num_steps))
                touching.append(np.mean(model.problem.contact[0].status > 0))
            contact, whole = np.median(times, axis=0)
            label = f"{model.num_slaves} of {model.num_nodes} nodes"
            if what == "share":
                rows.append(bench.row(f"contact, {name}: share of a step", label, 1, 1e3 * contact, "ms", 1e3 * whole))
            rows.append(bench.row(f"contact, {name}, goal {100 if friction else 50}", label, 1,
                                  1e9 * contact / model.num_slaves, "ns/slave node/step",
                                  100 if friction else 50))  # fmt: skip
            if what == "cost":
                rows.append(bench.row(f"  {name}: nodes that touch", label, 1, np.mean(touching), "", 1.0))
    return rows


def output_rows(n, steps=1000, rounds=2):
    """Frames every 100 steps and a checkpoint every 1,000: share of the loop, by wall-clock time."""
    setup, problem = explicit_problem(MPI.COMM_SELF, n)
    writing = 0.0
    with tempfile.TemporaryDirectory() as folder:
        recorder = problem.record(Path(folder) / "run", every=100)
        # The first frame, which brings the mesh, was written before the loop: it is no part of it.
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
    return [bench.row("output: share of the loop", label, 1, 1e3 * writing / count, "ms/step", 1e3 * loop / count)]


def resident():
    """Resident set of this process [B]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def explicit_problem(comm, n):
    setup = bench.Setup("hexahedron", 1, n, comm=comm)
    law = materials.LinearElastic(1e3, 0.3, 1.0, "3d")
    return setup, ExplicitProblem(setup.u, law, velocity=start(setup.V))


def child(what, ranks, n):
    """Run this module on some ranks; returns what it writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.json"
        own = [sys.executable, "-m", "dolfinx_impact.bench.explicit", what, str(n), str(path)]
        subprocess.run((["mpirun", "-n", str(ranks)] if ranks > 1 else []) + own, check=True, capture_output=True)
        return json.loads(path.read_text())


def memory_rows(n=48):
    """Bytes per cell: resident set after some steps less that of a process that has run a small problem."""
    found = child("memory", 1, n)
    label = f"hexahedron P1, {found['cells']} cells"
    return [bench.row("explicit run: memory per cell, goal 0.8", label, 1, found["kB"], "kB", 0.8)]


def rank_rows(ranks, n=48):
    """Whole steps per core on several ranks against one, with as many cells a rank; the same beside separate runs on
    the other cores, which share the memory with it and send nothing; what a rank sends."""
    one, several = child("rate", 1, n), child("rate", ranks, int(round(n * ranks ** (1 / 3))))
    with ThreadPoolExecutor(ranks) as pool:
        separate = np.mean([found["rate"] for found in pool.map(lambda _: child("rate", 1, n), range(ranks))])
    unit, cell = CELLS_PER_S + "/core", "hexahedron P1"
    return [
        bench.row("linear_elastic whole step, per core", cell, ranks, several["rate"], unit, one["rate"]),
        bench.row("  beside as many separate runs", cell, ranks, several["rate"], unit, separate),
        bench.row("  messages per step and rank", cell, ranks, several["messages"], "", 2.0 * (ranks - 1)),
        bench.row("  sent per step and rank, 8 B a value", cell, ranks, several["values"] * 8e-3, "kB",
                  several["cells"] * 8e-3),
    ]  # fmt: skip


def _memory(n):
    explicit_problem(MPI.COMM_SELF, 4)[1].advance(0.1, progress=False)
    gc.collect()
    before = resident()
    setup, problem = explicit_problem(MPI.COMM_SELF, n)
    problem.advance(20 * 0.9 * problem._stepper.safe_step, progress=False)
    gc.collect()
    return {"cells": setup.num_cells, "kB": (resident() - before) / setup.num_cells * 1e-3}


def _rate(n, steps=60, rounds=3):
    """Million cells per second and rank, cells per rank; messages and values that a rank sends in a step, at most."""
    comm, rates = MPI.COMM_WORLD, []
    setup, problem = explicit_problem(comm, n)
    cells = comm.allreduce(setup.num_cells, MPI.SUM) / comm.size
    for _ in range(rounds + 1):
        comm.Barrier()
        begin, first, sent = time.perf_counter(), problem.step, np.array(problem._cpp_object.traffic)
        problem.advance(problem.time + steps * 0.9 * problem._stepper.safe_step, progress=False)
        comm.Barrier()
        rates.append(cells * (problem.step - first) / (time.perf_counter() - begin) * 1e-6)
        sent = (np.array(problem._cpp_object.traffic) - sent) / (problem.step - first)
    messages, values = comm.allreduce(sent[0], MPI.MAX), comm.allreduce(sent[1], MPI.MAX)
    return {"rate": float(np.median(rates[1:])), "cells": cells, "messages": messages, "values": values}


def jobs(large=False, ranks=0):
    """What the command measures of explicit dynamics: pairs (text, function that returns rows).

    Args:
        large: larger models and more rounds.
        ranks: also whole steps on so many ranks; 0: without.
    """
    solids = [c for c in bench.CASES if c[0] in ("tetrahedron", "hexahedron")]
    out = [(f"explicit step, {c[0]} P{c[1]}", partial(step_rows, (c,), own=("hexahedron",))) for c in solids]
    neo_hookean = partial(step_rows, law=materials.NeoHookean, baselines=("A",))
    out += [(f"explicit step, neo_hookean, {c[0]} P{c[1]}", partial(neo_hookean, (c,))) for c in bench.FINITE]
    out.append(("explicit contact", partial(contact_rows, rounds=(7, 25) if large else (5, 12))))
    out += [("explicit output", partial(output_rows, n)) for n in ((48, 20) if large else (20,))]
    out.append(("explicit memory", partial(memory_rows, 64 if large else 40)))
    return out + ([(f"explicit steps on {ranks} ranks", partial(rank_rows, ranks))] if ranks > 1 else [])


if __name__ == "__main__":
    what, n, path = sys.argv[1:]
    result = _memory(int(n)) if what == "memory" else _rate(int(n))
    if MPI.COMM_WORLD.rank == 0:
        Path(path).write_text(json.dumps(result))
