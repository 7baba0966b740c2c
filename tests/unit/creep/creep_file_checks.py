# SPDX-License-Identifier: MIT
"""Files of creep curves belong to one wheel: all its parameters are in them, to the last digit."""

import math

import numpy as np
import pytest
from mpi4py import MPI
from shared_folder import shared_folder

from dolfinx_impact.materials import StVenantKirchhoff
from impact_studies.creep.model import CreepModel
from impact_studies.creep.parameters import WheelOnRail

COMM = MPI.COMM_WORLD
SMALL = WheelOnRail(cells=1, reach=2.5, crown_radius=0.32, wheel_crown_radius=5e14)
CREEP = [5e-3, 6e-3]  # all points slip: nine points at the border of stick and slip are no example to converge


def check_each_parameter_belongs_to_the_file():
    """Each parameter alone, changed in the last digit: no sum over the mesh tells most of these wheels apart."""
    model = CreepModel(SMALL)
    with shared_folder() as path:
        model.curve(CREEP[:1], file=path / "curve.h5", progress=False)
        for name, value in SMALL.values().items():
            other = value + 1 if isinstance(value, int) else math.nextafter(value, math.inf)
            model.data = SMALL.changed(**{name: other})
            with pytest.raises(ValueError, match=f"curve.h5 has the sweep of another problem, {name} differs: remove"):
                model.curve(CREEP, file=path / "curve.h5", progress=False)
        model.data = SMALL.changed(wheel_crown_radius=math.inf)  # as flat in double precision
        with pytest.raises(ValueError, match="wheel_crown_radius differs"):
            model.curve(CREEP, file=path / "curve.h5", progress=False)
        model.data, model.sides = SMALL, 1
        with pytest.raises(ValueError, match="half differs"):
            model.curve(CREEP, file=path / "curve.h5", progress=False)


def check_models_that_are_nearly_the_same_are_refused():
    """Whole models, as a second run has them: another speed, load or law; then the wheel itself, which goes on."""
    with shared_folder() as path:
        file = path / "curve.h5"
        first = CreepModel(SMALL).curve(CREEP[:1], file=file, progress=False)
        before = file.read_bytes()
        others = {"speed": {"data": SMALL.changed(speed=30.0 * (1.0 + 1e-9))},
                  "load": {"data": SMALL.changed(load=1e5 * (1.0 + 1e-9))},
                  "law": {"data": SMALL, "law": StVenantKirchhoff}}  # fmt: skip
        for name, arguments in others.items():
            with pytest.raises(ValueError, match=f"{name} differs"):
                CreepModel(**arguments).curve(CREEP, file=file, progress=False)
            assert file.read_bytes() == before
        COMM.barrier()
        on = CreepModel(SMALL).curve(CREEP, file=file, progress=False)
        np.testing.assert_array_equal(on["force"][:1], first["force"])


def check_files_without_an_identity_are_refused():
    """And files with one by a sweep that states none, or other names."""
    model = CreepModel(SMALL)
    omega = model.problem.omega
    with shared_folder() as path:
        for name, mine, other in (
            ("a", None, {"load": 1.0}),
            ("b", {"load": 1.0}, {"spin": 1.0}),
            ("c", {"x": 1}, None),
        ):
            model.wheel.omega = omega
            model.problem.sweep(CREEP[:1], file=path / name, progress=False, identity=mine)
            model.wheel.omega = omega
            with pytest.raises(ValueError, match="of another problem, (load|spin|x) is known of one alone"):
                model.problem.sweep(CREEP, file=path / name, progress=False, identity=other)
        for bad in ("text", {"load": [1.0]}, {3: 1.0}):
            with pytest.raises(TypeError, match="identity must"):
                model.problem.sweep(CREEP, file=path / "d", progress=False, identity=bad)
        if COMM.size > 1:
            with pytest.raises(ValueError, match="identity"):
                model.problem.sweep(CREEP, file=path / "d", progress=False, identity={"load": float(COMM.rank)})
        assert not (path / "d").exists()
