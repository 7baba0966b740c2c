# SPDX-License-Identifier: MIT
"""Packages that lie beside this one now, and modules with another name: they are still found under the former one."""

import importlib
import sys
import warnings
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {  # what belongs to a package that has moved is before the package
    "dolfinx_impact.assembly.history": "dolfinx_impact.assembly.material_history",
    "dolfinx_impact.dynamics.implicit.problem": "dolfinx_impact.dynamics.implicit.newmark_problem",
    "dolfinx_impact.rolling.contact": "dolfinx_impact.rolling.rolling_contact",
    "dolfinx_impact.rolling.problem": "dolfinx_impact.rolling.rolling_problem",
    "dolfinx_impact.statics.problem": "dolfinx_impact.statics.static_problem",
    "dolfinx_impact.theory.bodies": "dolfinx_impact.theory.elastic_bodies",
    "dolfinx_impact.bench.contact": "impact_studies.bench.contact_rows",
    "dolfinx_impact.bench.run": "impact_studies.bench.bench_command",
    "dolfinx_impact.creep.run": "impact_studies.creep.creep_command",
    "dolfinx_impact.rail_joint.run": "impact_studies.rail_joint.joint_command",
    "dolfinx_impact.verify.run": "impact_verify.levels",
    "impact_verify.run": "impact_verify.levels",
    "dolfinx_impact.verify.selfcheck.run": "impact_verify.selfcheck.self_check",
    "dolfinx_impact.bench": "impact_studies.bench",
    "dolfinx_impact.creep": "impact_studies.creep",
    "dolfinx_impact.rail_joint": "impact_studies.rail_joint",
    "dolfinx_impact.verify": "impact_verify",
}
DOOR = "dolfinx_impact.verify"  # a package of the library still; the modules below it have moved


def present_name(name: str) -> str | None:
    """Name that a module has now.

    Args:
        name: its former name, with dots.

    Returns:
        The name; None for a module that has not moved.
    """
    for old, new in MOVED.items():
        if (name == old and name != DOOR) or name.startswith(old + "."):
            return new + name.removeprefix(old)
    return None


class _MovedModule(Loader):
    """Puts the module itself in the place of the empty one that was made for its former name."""

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        former = module.__name__
        now = present_name(former)
        assert now is not None
        moved = importlib.import_module(now)
        warnings.warn(f"{former} is {now} now: import that", DeprecationWarning, stacklevel=2)
        sys.modules[former] = moved


class _MovedModuleFinder(MetaPathFinder):
    """Finds modules by their former names, before other finders load them once more under these."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if present_name(fullname) is None:
            return None
        return ModuleSpec(fullname, _MovedModule())


def find_moved_modules() -> None:
    """Let imports by former names find the modules where they are now."""
    if not any(isinstance(finder, _MovedModuleFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _MovedModuleFinder())
