# SPDX-License-Identifier: MIT
"""Checkpoints of explicit runs: written, read and continued. See on_ranks.py."""

import os
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.io import checkpoint
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD


MADE = {}


def mesh_of(comm):
    """One mesh for all: DOLFINx may number it otherwise when it is made once more on several ranks."""
    if comm.handle not in MADE:
        size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (14, 5), "upper_cells": (12, 5)}
        MADE[comm.handle] = meshes.make("two_blocks", comm, **size)
    return MADE[comm.handle]


def block_on_block(comm=COMM, kind=di.Penalty, friction=0.3, law=di.LinearElastic, moving=True, young=1e3, **options):
    """A block thrown obliquely on another one; problem, not run yet."""
    made = mesh_of(comm)
    tags = made.tags
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    upper = made.cell_tags.find(tags["slave_body"]) if "slave_body" in tags else None
    nodes = np.unique(V.dofmap.list[upper].ravel())
    v.x.array.reshape(-1, 2)[nodes] = (0.5, -0.4)
    v.x.scatter_forward()
    bottom = fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags["bottom"]))
    base = fem.dirichletbc(np.array([0.0, 0.002]), bottom, V)
    still = fem.dirichletbc(np.zeros(2), bottom, V)
    bcs = [di.PrescribedMotion(base, lambda t: np.sin(20 * t)) if moving else still]
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=friction)
    steel = law(young, 0.3, 1.0, "plane_strain")
    loads = [di.BodyForce((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t))]
    others = {"bcs": bcs, "loads": loads, "damping": di.Rayleigh(0.1, 1e-5)}
    of_problem = ("bcs", "loads", "damping", "bulk_viscosity", "scheme", "lumping", "mass_scaling")
    others |= {name: options.pop(name) for name in of_problem if name in options}
    return di.ExplicitProblem(u, steel, velocity=v, contact=[kind(pair, **options)], **others)


def state(problem):
    """Motion, and what is told of the contact."""
    parts = [f.x.array for f in (problem.u, problem.velocity, problem.acceleration)]
    for c in problem.contact:
        parts += [c.force, c.moment, [c.area, c.dissipated]]
        parts += [
            np.ravel(getattr(c, name)) for name in ("gap", "normal", "pressure", "traction", "slip", "status", "points")
        ]
    return np.concatenate(parts)


VARIANTS = (
    {},
    {"law": di.NeoHookean, "balanced": True},
    {"kind": di.Kinematic},
    {"friction": 0.0, "law": di.StVenantKirchhoff},
)


def check_a_restored_run_is_the_uninterrupted_one():
    """Bit for bit on the same ranks, inside a call of advance, contact closed; both write the same checkpoints
    (writing one looks for contact anew)."""
    with shared_folder() as path:
        for variant in VARIANTS:
            whole, kept = block_on_block(**variant), {}
            end = 420 * whole.stable_step()

            def keep(problem, kept=kept):
                if problem.step in (100, 333):
                    problem.save(path / f"{problem.step}.h5")
                    kept.setdefault(problem.step, state(problem))

            whole.advance(end, callback=keep, progress=False)
            assert whole.contact[0].area >= 0.0
            touched = False
            for step in (100, 333):
                again = block_on_block(**variant)
                again.restore(path / f"{step}.h5")
                assert again.step == step and again.time > 0.0
                np.testing.assert_array_equal(state(again), kept[step])
                again.advance(end, callback=keep, progress=False)
                assert again.step == whole.step and again.time == whole.time
                np.testing.assert_array_equal(state(again), state(whole))
                for name, value in whole.energy.items():
                    assert abs(again.energy[name] - value) < 1e-9 * whole.energy["kinetic"] or name == "drift", name
                touched = touched or again.energy["friction"] > 0.0 or variant.get("friction") == 0.0
            assert touched


def saved(path):
    """A problem after some steps, its checkpoint in the folder, and what is in that file."""
    problem = block_on_block()
    problem.advance(20 * problem.stable_step(), progress=False)
    good = path / "good.h5"
    problem.save(good)
    return problem, good, good.read_bytes()


def check_errors():
    """Unwritable folders, full disks and files of other problems: the same error on all ranks, the old file stays."""
    with shared_folder() as path:
        problem, good, before = saved(path)
        (path / "file").touch()
        COMM.barrier()
        with pytest.raises(RuntimeError, match="could not be written"):
            problem.save(path / "file" / "under.h5")
        with pytest.raises(RuntimeError, match="cannot be read"):
            problem.restore(path / "none.h5")
        if COMM.rank == 0:
            (path / "broken.h5").write_bytes(before[: len(before) // 2])
        COMM.barrier()
        with pytest.raises(RuntimeError, match="cannot be read"):
            problem.restore(path / "broken.h5")
        for other, text in (
            (block_on_block(young=2e3), "material"),
            (block_on_block(friction=0.2), "contact"),
            (block_on_block(kind=di.Kinematic), "contact"),
        ):
            with pytest.raises(ValueError, match=f"another problem: {text}"):
                other.restore(good)
        domain = mesh.create_rectangle(COMM, [[0.0, 0.0], [1.0, 1.0]], [12, 5], mesh.CellType.quadrilateral)
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        steel = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
        with pytest.raises((ValueError, RuntimeError), match="another|number of cells"):
            di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V)).restore(good)
        COMM.barrier()
        assert good.read_bytes() == before and not [f for f in os.listdir(path) if f.endswith(".part")]


def check_errors_on_one_rank():
    """A folder that the last rank has not, a file that it cannot read or that is another there: errors on all ranks."""
    with shared_folder() as path:
        problem, good, before = saved(path)
        step, last = problem.step, COMM.rank == COMM.size - 1

        def raised(kind, work):
            with pytest.raises(kind) as error:
                work()
            return str(error.value)

        def at(elsewhere, work):
            """As if the name of the good file led elsewhere on the last rank."""
            checkpoint.Path = lambda p: elsewhere if last else Path(p)
            try:
                work(good)
            finally:
                checkpoint.Path = Path

        for elsewhere in (path / "none" / "good.h5", path / "good.h5" / "good.h5"):
            # On one rank nothing is wrong with a folder that can be made.
            if COMM.size > 1 or elsewhere.parent == good:
                said = raised(RuntimeError, lambda e=elsewhere: at(e, problem.save))
                assert "could not be written" in said and re.search("No such file|Not a directory", said), said
            said = raised(RuntimeError, lambda e=elsewhere: at(e, problem.restore))
            assert "cannot be read" in said
            COMM.barrier()
            assert good.read_bytes() == before and not [f for f in os.listdir(path) if f.endswith(".part")]
        stiffer = block_on_block(young=2e3)
        stiffer.save(path / "stiffer.h5")
        said = raised(ValueError, lambda: at(path / "stiffer.h5", problem.restore))
        assert "another problem: material" in said
        problem.restore(good)
        assert problem.step == step


def check_an_unstable_run_with_contact_starts_anew():
    """Back at the last good state nothing of the overflow is left: energies and friction are numbers."""
    problem = block_on_block()
    problem.advance(150 * problem.stable_step(), progress=False)
    step = problem.step
    dt = 2.5 * problem.stable_step("eigenvalue")
    with pytest.raises(RuntimeError, match="went unstable"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the step is unsafe is told on rank 0
        problem.advance(problem.time + 1e4, dt=dt, progress=False, unsafe=True)
    assert problem.step >= step and all(np.isfinite(value) for value in problem.energy.values())
    problem.advance(problem.time + 100 * problem.stable_step(), progress=False)
    assert np.all(np.isfinite(state(problem))) and abs(problem.energy["drift"]) < 0.1


def check_a_load_that_is_zero_at_the_start_acts_later():
    """Components of a load that are set between two calls of advance."""
    domain = mesh.create_rectangle(COMM, [[0.0, 0.0], [2.0, 1.0]], [4, 2], mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    steel, load = di.LinearElastic(1.0, 0.3, 2.0, "plane_strain"), di.BodyForce((0.0, 0.0))
    problem = di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V), loads=[load])
    problem.advance(1.0, progress=False)
    load.constant.value[:] = (3.0, -1.0)
    problem.advance(2.0, progress=False)
    # From rest, with one step's trapezoid on: v = g t to the order of half a step.
    rows = problem.velocity.x.array.reshape(-1, 2)
    np.testing.assert_allclose(rows, np.tile([3.0, -1.0], (len(rows), 1)), rtol=0.2)
    np.testing.assert_allclose(
        problem.acceleration.x.array.reshape(-1, 2), np.tile([3.0, -1.0], (len(rows), 1)), rtol=1e-9
    )
