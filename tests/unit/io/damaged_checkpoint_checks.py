# SPDX-License-Identifier: MIT
"""Checkpoints that are damaged, foreign or impossible: refused on all ranks, nothing is changed. See on_ranks.py."""

import re
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from restart_checks import COMM, block_on_block, mesh_of, state
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.io import checkpoint

LAST = COMM.rank == COMM.size - 1
FLIPS = 500


def arrays(state):
    """All values of a state and its parts."""
    found = [np.ravel(state.array(name)) for name in state.names]
    return found + [values for name in state.parts for values in arrays(state.part(name))]


def everything(problem):
    """All that `restore` may change: motion, contact with its history, times, energies."""
    return np.concatenate([state(problem), *arrays(problem._cpp_object.saved_state())]).astype(float)


def after(problem, path, steps=60):
    problem.advance(steps * problem.stable_step(), progress=False)
    problem.save(path)
    return problem


def refused(problem, path, kinds, text="", same=True):
    """The error of restore, the same on all ranks, which leaves the problem as it was. Args: same: its text is, too."""
    before, plan = everything(problem), problem._stepper.schedule
    with pytest.raises(kinds) as error:
        problem.restore(path)
    said = str(error.value)
    assert len(set(COMM.allgather((type(error.value).__name__, said if same else "")))) == 1
    assert re.search(text, said), said
    np.testing.assert_array_equal(everything(problem), before)
    assert problem._stepper.schedule == plan
    return said


def check_single_bits():
    """Of any byte: refused with a word on what is damaged."""
    rng = np.random.default_rng(7)
    with shared_folder() as path:
        after(block_on_block(), path / "good.h5")
        whole = (path / "good.h5").read_bytes()
        problem = block_on_block()
        bits = rng.choice(8 * len(whole), FLIPS if COMM.size == 1 else FLIPS // 10, replace=False)
        told = set()
        for bit in bits:
            if COMM.rank == 0:
                data = bytearray(whole)
                data[bit // 8] ^= 1 << bit % 8
                (path / "bad.h5").write_bytes(data)
            COMM.barrier()
            with pytest.raises((RuntimeError, ValueError)) as error:
                problem.restore(path / "bad.h5")
            told.add(str(error.value).partition("cannot be read")[2])
            COMM.barrier()
        assert problem.step == 0 and not np.any(problem.u.x.array)
        assert any("table nodes/" in text for text in told) and any("structure" in text for text in told), told
        problem.restore(path / "good.h5")
        assert problem.step > 0


def check_cut_short_and_grown():
    with shared_folder() as path:
        after(block_on_block(), path / "good.h5")
        whole = (path / "good.h5").read_bytes()
        problem = block_on_block()
        lengths = [0, 1, 100, 2000, len(whole) // 2, len(whole) - 4096, len(whole) - 1]
        for data in (*(whole[:n] for n in lengths), whole + b"x" * 1000, b"\0" * len(whole), b"text\n" * 100):
            if COMM.rank == 0:
                (path / "bad.h5").write_bytes(data)
            COMM.barrier()
            refused(problem, path / "bad.h5", RuntimeError, "cannot be read")


def check_damaged_on_one_rank():
    """The last rank finds another file: one that is damaged in data that it reads, and one of another time."""
    with shared_folder() as path:
        problem = after(block_on_block(), path / "good.h5")
        other = after(block_on_block(), path / "later.h5", 90)
        assert other.step > problem.step
        data = bytearray((path / "good.h5").read_bytes())
        sections = _cpp.files.SealedFile(str(path / "good.h5")).sections
        offset, length = next((offset, length) for offset, length, is_data in sections if is_data)
        data[offset + length - 1] ^= 1
        if COMM.rank == 0:
            (path / "bad.h5").write_bytes(data)
        COMM.barrier()
        fresh = block_on_block()
        # One name that leads to another file there, as on a disk that the ranks do not share.
        try:
            for name, text in (("bad.h5", "is damaged"), ("later.h5", "another file")):
                if name == "bad.h5" or COMM.size > 1:
                    there = path / (name if LAST else "good.h5")
                    checkpoint.Path = lambda _, there=there: there
                    refused(fresh, path / "good.h5", RuntimeError, text, same=False)
        finally:
            checkpoint.Path = Path
        fresh.restore(path / "good.h5")
        assert fresh.step == problem.step


def reseal(path):
    """A seal for what stands in a file: as another program would write it."""
    data = path.read_bytes()
    path.write_bytes(data + _cpp.files.seal(data))


def changed(path, change):
    """A sealed copy of good.h5 in which `change(file)` was done. Collective."""
    import h5py

    if COMM.rank == 0:
        with seal_removed(path) as bad, h5py.File(bad, "a") as file:
            change(file)
        reseal(bad)
    COMM.barrier()
    return path / "bad.h5"


class seal_removed:
    """bad.h5: good.h5 without its seal."""

    def __init__(self, path):
        self.path = path

    def __enter__(self):
        good = self.path / "good.h5"
        size = _cpp.files.SealedFile(str(good)).size
        (self.path / "bad.h5").write_bytes(good.read_bytes()[:size])
        return self.path / "bad.h5"

    def __exit__(self, *_):
        return False


def attribute(name, value):
    return lambda file: file.attrs.__setitem__(name, value)


def without(name):
    def work(file):
        del (file.attrs if name in file.attrs else file)[name]

    return work


def table(name, change):
    def work(file):
        rows = change(file[name][:])
        del file[name]
        file.create_dataset(name, data=rows)

    return work


def entry(value, column=0):
    def change(rows):
        rows = rows.copy()
        rows.reshape(len(rows), -1)[0, column] = value
        return rows

    return change


def other_node(nodes):
    """The first node becomes the least that is not among them."""
    return np.concatenate([[min(set(range(len(nodes) + 1)) - set(nodes.tolist()))], nodes[1:]]).astype(nodes.dtype)


def check_content_that_cannot_be():
    """With a good seal, as a faulty program would write it: times, steps, plans, shapes, numbers of nodes, states."""
    bad = {
        "nan time": (attribute("time", np.nan), "time"),
        "negative time": (attribute("time", -1.0), "time"),
        "infinite time": (attribute("time", np.inf), "time"),
        "text for a time": (attribute("time", "soon"), "time"),
        "next time before": (attribute("next_time", 0.0), "time"),
        "negative step": (attribute("step", -5), "step"),
        "half a step": (attribute("step", 5.5), "step"),
        "nan step": (attribute("safe_step", np.nan), "safe_step"),
        "no step": (attribute("nominal_step", 0.0), "steps"),
        "short schedule": (attribute("schedule", np.array([0.0, 1.0])), "schedule"),
        "nan schedule": (attribute("schedule", np.array([0.0, np.nan, 0, 5, 1])), "schedule"),
        "schedule of another time": (attribute("schedule", np.array([0.0, 1.0, 0, 7, 1])), "schedule"),
        "energy": (attribute("largest", -1.0), "energies"),
        "contact's totals": (attribute("contact0", np.zeros(2)), "contact0"),
        "nan totals": (attribute("contact0", np.full(5, np.nan)), "contact0"),
        "format": (attribute("format", 2), "format"),
        "ranks": (attribute("ranks", 7), "ranks/"),
        "functions of time": (attribute("functions of time", np.zeros(3)), "functions of time"),
        "no step at all": (without("step"), "lacks step"),
        "no u": (without("nodes/u"), "nodes/u is missing"),
        "no history": (without("some/contact0_0/values"), "contact0_0/values is missing"),
        "another table": (lambda file: file.create_dataset("nodes/more", data=np.zeros(3)), "nodes/more"),
        "short u": (table("nodes/u", lambda d: d[:-3]), "nodes/u"),
        "narrow u": (table("nodes/u", lambda d: d[:, :1].copy()), "nodes/u"),
        "single precision": (table("nodes/u", lambda d: d.astype(np.float32)), "nodes/u"),
        "nan u": (table("nodes/u", entry(np.nan)), "nodes/u"),
        "infinite force": (table("nodes/springs", entry(np.inf)), "nodes/springs"),
        "nan work": (table("ranks/works", entry(np.nan)), "ranks/works"),
        "infinite work": (table("ranks/works", entry(np.inf)), "ranks/works"),
        "short works": (table("ranks/works", lambda d: d[:, :3].copy()), "ranks/works"),
        "works of other terms": (attribute("works", "residual, loads"), "works"),
        "nan energy": (table("ranks/common", entry(np.nan)), "ranks/common"),
        "infinite energy": (table("ranks/common", entry(np.inf)), "ranks/common"),
        "cells twice": (table("cells/input", entry(1)), "cells/input"),
        "cells of another mesh": (table("cells/input", lambda d: d[::-1].copy()), "nodes lie elsewhere"),
        "nodes beyond": (table("cells/nodes", lambda d: d + 100000), "cells/nodes"),
        "negative nodes": (table("cells/nodes", lambda d: d - 100000), "cells/nodes"),
        "nodes elsewhere": (table("nodes/x", lambda d: d * 1.001), "nodes lie elsewhere"),
        "contact's nodes beyond": (table("some/contact0_0/nodes", lambda d: d + 100000), "contact0_0/nodes"),
        "contact's nodes twice": (table("some/contact0_0/nodes", lambda d: 0 * d), "contact0_0/nodes"),
        "a contact's node": (table("some/contact0_0/nodes", other_node), "contact0_0|supports"),
        "state": (table("some/contact0_0/values", entry(2.0, -2)), "state"),
        "facet": (table("some/contact0_0/values", entry(1e9, -1)), "facets"),
        "half a facet": (table("some/contact0_0/values", entry(1.5, -1)), "facets"),
        "beside a facet": (table("some/contact0_0/values", entry(9.0, 4)), "beside"),
        "nan result": (table("some/results0/values", entry(np.nan, 3)), "results0/values"),
        "support": (table("some/supports/values", entry(0.5, 2)), "supports differ"),
    }
    with shared_folder() as path:
        after(block_on_block(), path / "good.h5")
        problem = after(block_on_block(), path / "mine.h5", 30)
        for name, (change, text) in bad.items():
            try:
                said = refused(problem, changed(path, change), (RuntimeError, ValueError), text)
                assert "h5py" not in said
            except BaseException:
                print(f"case: {name}", flush=True)
                raise
        fresh = block_on_block()
        fresh.restore(changed(path, lambda file: None))
        assert fresh.step > 0


def check_other_problems():
    """Each part of the signature, to the last digit."""
    up = np.nextafter

    def loaded(value, then=None, **options):
        load = di.BodyForce(value, **options)
        problem = block_on_block(loads=[load])
        if then is not None:
            load.constant.value[:] = then
        return problem

    made = mesh_of(COMM)

    def pulled(tag="top", value=(0.0, 1.0)):
        return block_on_block(loads=[di.Traction(made.facet_tags, made.tags[tag], value)])

    cases = (
        (block_on_block, {"young": up(1e3, 2e3)}, "material"),
        (block_on_block, {"law": di.NeoHookean}, "material"),
        (block_on_block, {"friction": up(0.3, 1.0)}, "contact"),
        (block_on_block, {"kind": di.Kinematic}, "contact"),
        (block_on_block, {"balanced": True}, "contact"),
        (block_on_block, {"penalty": 1e4}, "contact"),
        (block_on_block, {"damping": di.Rayleigh(up(0.1, 1.0), 1e-5)}, "damping"),
        (block_on_block, {"damping": di.Rayleigh(0.1, up(1e-5, 1.0))}, "damping"),
        (block_on_block, {"bulk_viscosity": (0.06, 1.2)}, "bulk viscosity|num_parts|another"),
        (block_on_block, {"mass_scaling": 1e-9}, "mass_scaling"),
        (block_on_block, {"lumping": "row_sum"}, "lumping"),
        (block_on_block, {"bcs": []}, "supports|functions"),
        (block_on_block, {"moving": False}, "supports|functions"),
        (block_on_block, {"loads": []}, "loads"),
        (loaded, {"value": (0.0, -9.81)}, "amplitude"),
        (loaded, {"value": (0.0, -9.82), "amplitude": lambda t: 1.0 - np.exp(-t)}, "loads"),
        (loaded, {"value": (0.0, -9.81), "amplitude": lambda t: 1.0 - np.exp(-2 * t)}, "functions of time"),
        (loaded, {"value": (0.0, -9.81), "amplitude": lambda t: 1.0 - np.exp(-t), "per_mass": False}, "loads"),
        (pulled, {}, "loads"),
    )
    with shared_folder() as path:
        good = after(block_on_block(), path / "good.h5")
        for make, options, text in cases:
            refused(make(**options), path / "good.h5", ValueError, text)
        same = loaded((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t))
        same.restore(path / "good.h5")
        np.testing.assert_array_equal(everything(same), everything(good))
        after(pulled(), path / "pulled.h5")
        for options in ({"tag": "bottom"}, {"value": (0.0, up(1.0, 2.0))}):
            refused(pulled(**options), path / "pulled.h5", ValueError, "loads")
        pulled().restore(path / "pulled.h5")
        # A value that was changed in the run is told, and has to be there again.
        after(loaded((0.0, 0.0), (1.0, 2.0)), path / "changed.h5")
        said = refused(loaded((0.0, 0.0)), path / "changed.h5", ValueError, "loads")
        assert "constant.value" in said
        loaded((0.0, 0.0), (1.0, 2.0)).restore(path / "changed.h5")
        # Functions of time may differ from now on.
        end = good.time
        later = loaded((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t) if t < 1.5 * end else 7.0)
        later.restore(path / "good.h5")
        assert MPI.COMM_WORLD.allreduce(later.step, MPI.MIN) == good.step
