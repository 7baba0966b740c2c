# SPDX-License-Identifier: MIT
"""Packages that lie beside the library are reached by `di.verify` and by the names that they had in it."""

import importlib
import subprocess
import sys
import types

import pytest

import dolfinx_impact as di
from dolfinx_impact.common.moved_packages import (
    MOVED,
    _MovedModule,
    _MovedModuleFinder,
    find_moved_modules,
    present_name,
)


def test_the_door_leads_to_the_package():
    import impact_verify

    assert di.verify.cross_check is impact_verify.cross_check
    assert di.verify.self_check is impact_verify.self_check
    assert di.verify.OwnForm is impact_verify.OwnForm
    with pytest.raises(AttributeError, match="nothing_there"):
        di.verify.nothing_there


@pytest.mark.parametrize(
    "former, now",
    [
        ("dolfinx_impact.verify.report", "impact_verify.report"),
        ("dolfinx_impact.verify.selfcheck.run", "impact_verify.selfcheck.self_check"),
        ("dolfinx_impact.verify.run", "impact_verify.levels"),
        ("impact_verify.run", "impact_verify.levels"),
        ("dolfinx_impact.creep", "impact_studies.creep"),
        ("dolfinx_impact.creep.model", "impact_studies.creep.model"),
        ("dolfinx_impact.rail_joint.run", "impact_studies.rail_joint.joint_command"),
        ("dolfinx_impact.bench.rows", "impact_studies.bench.rows"),
    ],
)
def test_former_names_are_the_same_modules(former, now):
    code = f"""
import importlib, sys, warnings
import dolfinx_impact
assert {now!r} not in sys.modules
with warnings.catch_warnings(record=True) as found:
    warnings.simplefilter("always")
    import {former} as module
    from {former.rpartition(".")[0]} import {former.rpartition(".")[2]} as again
assert module is again is sys.modules[{now!r}] is importlib.import_module({now!r}), module
assert module.__name__ == {now!r}
said = [str(w.message) for w in found if w.category is DeprecationWarning]
print([text for text in said if text.startswith({former + " is "!r})])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == repr([f"{former} is {now} now: import that"])


def test_a_former_name_of_a_module_that_is_loaded():
    now = importlib.import_module("dolfinx_impact.assembly.material_history")
    with pytest.warns(DeprecationWarning, match="is dolfinx_impact.assembly.material_history now"):
        former = importlib.import_module("dolfinx_impact.assembly.history")
    assert former is now and former.MaterialHistory.__module__ == now.__name__


def test_the_package_beside_finds_former_names_without_the_library():
    code = "import warnings; warnings.simplefilter('ignore'); from impact_verify.run import LEVELS; print(len(LEVELS))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and int(done.stdout) > 5, done.stderr


def test_each_package_is_there_and_others_have_not_moved():
    for now in MOVED.values():
        assert importlib.import_module(now).__name__ == now
    assert present_name("dolfinx_impact.benchmarks") is None and present_name("dolfinx_impact.io") is None
    assert present_name("dolfinx_impact.verify") is None
    with pytest.raises(ModuleNotFoundError, match="impact_studies.creep.nothing"):
        importlib.import_module("dolfinx_impact.creep.nothing")


def test_the_finder_takes_former_names_only_and_is_there_once():
    finder = _MovedModuleFinder()
    assert finder.find_spec("dolfinx_impact.io.frames") is None and finder.find_spec("json") is None
    spec = finder.find_spec("dolfinx_impact.bench.rows")
    assert isinstance(spec.loader, _MovedModule) and spec.name == "dolfinx_impact.bench.rows"
    find_moved_modules()
    assert sum(isinstance(f, _MovedModuleFinder) for f in sys.meta_path) == 1
    assert isinstance(sys.meta_path[0], _MovedModuleFinder)


def test_the_module_takes_the_place_of_an_empty_one(monkeypatch):
    former, now = "dolfinx_impact.bench.rows", importlib.import_module("impact_studies.bench.rows")
    monkeypatch.delitem(sys.modules, former, raising=False)
    empty = types.ModuleType(former)
    loader = _MovedModule()
    assert loader.create_module(None) is None
    with pytest.warns(DeprecationWarning, match="is impact_studies.bench.rows now"):
        loader.exec_module(empty)
    assert sys.modules.pop(former) is now
