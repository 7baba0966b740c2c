# SPDX-License-Identifier: MIT
"""Figures of docs/plasticity.md: `python3 docs/plasticity_figures.py [FOLDER] [NAME...]`, default docs/figures, all.

Runs the models of tests/verification/test_plastic_*.py and draws Taylor's bar, the load under Prandtl's punch and the
thick sphere beside closed forms and published values.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "verification")]

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from demo_figures import shrink  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from test_plastic_punch import DEPTHS, Punch  # noqa: E402
from test_plastic_punch import E as MODULUS  # noqa: E402
from test_plastic_punch import Y as STRENGTH  # noqa: E402
from test_plastic_taylor import LENGTH, PUBLISHED, RADIUS, TaylorBar  # noqa: E402
from test_plastic_vessels import A, B, E, NU, Vessel, Y  # noqa: E402

from dolfinx_impact.theory import plasticity as theory  # noqa: E402


def taylor_bar():
    """Shape with the plastic strain at 80 microseconds; radius of the face and length against time."""
    bar = TaylorBar((8, 80), contact=False)
    times = np.arange(0.0, 81.0, 2.0)
    history = [(1e3 * RADIUS, 1e3 * LENGTH)] + [bar.at(1e-6 * t) for t in times[1:]]
    figure, (shape, curves) = plt.subplots(1, 2, figsize=(9, 4.2), width_ratios=(1, 1.5), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.12)
    x = 1e3 * (bar.V.tabulate_dof_coordinates()[:, :2] + bar.u.x.array.reshape(-1, 2))
    corners = x[bar.V.dofmap.list[:, [0, 1, 3, 2]]]
    strain = bar.run.history["plastic_strain"].values.mean(axis=1)
    corners, strain = np.concatenate([corners, corners * [-1, 1]]), np.tile(strain, 2)
    cells = shape.add_collection(
        PolyCollection(corners, array=strain, cmap="viridis", edgecolors="white", linewidths=0.2)
    )
    figure.colorbar(cells, label="equivalent plastic strain [1]")
    shape.plot([-9, 9], [0, 0], "k", linewidth=1)
    shape.plot([-7.22, 7.22], [-0.4, -0.4], "C3", linewidth=2, label="face, published")
    shape.plot([-5, 5], [21.42, 21.42], "C3:", linewidth=2, label="length, published")
    shape.set(aspect="equal", xlabel="r [mm]", ylabel="z [mm]", xlim=(-9, 9), ylim=(-1, 27))
    shape.legend(loc="upper center", fontsize=7)
    for column, name in enumerate(("radius of the face", "length")):
        curves.plot(times, np.array(history)[:, column], f"C{column}", label=f"{name}, 8 by 80 cells")
        curves.plot(PUBLISHED[:, 0], PUBLISHED[:, 1 + column], f"C{column}o", fillstyle="none", label="published")
    curves.set(xlabel="time [µs]", ylabel="radius, length [mm]", ylim=(0, None))
    curves.legend(fontsize=8)
    curves.grid(alpha=0.3)
    return figure


def prandtl_punch():
    """Mean pressure against depth, with and without the mean dilatation."""
    figure, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
    depths = np.concatenate([DEPTHS[0] * np.array([0.2, 0.4, 0.6, 0.8]), DEPTHS])
    for label, style, parameters in (
        ("smooth, B-bar", "C0o-", dict(h=1 / 32)),
        ("rough, B-bar", "C1.-", dict(h=1 / 32, rough=True, ratio=1.15)),
        ("smooth, without B-bar", "C3.--", dict(h=1 / 32, average=False)),
    ):
        pressures = Punch(**parameters).push(depths)
        axes.plot(
            np.concatenate([[0], depths]) * MODULUS / STRENGTH, np.concatenate([[0], pressures]), style, label=label
        )
    axes.axhline(theory.prandtl_pressure(STRENGTH), color="k", linewidth=1, label="Prandtl, 2.9685 Y")
    axes.set(xlabel="depth times E/(Y half-width) [1]", ylabel="mean pressure over Y [1]", ylim=(0, None))
    axes.legend()
    axes.grid(alpha=0.3)
    return figure


def thick_sphere():
    """Displacements of both surfaces against the pressure."""
    figure, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
    sphere, fronts = Vessel("axisymmetric", 1, (32, 32)), np.arange(100.0, 191.0, 10.0)
    found = []
    for front in fronts:
        sphere.press(theory.plastic_sphere(A, B, E, NU, Y, front=front).pressure)
        found.append((sphere.load.constant.value.item(), sphere.widening(A), sphere.widening(B)))
    found = np.array(found)
    exact = [theory.plastic_sphere(A, B, E, NU, Y, front=c) for c in np.linspace(A, B, 101)]
    pressures = np.array([0.0] + [x.pressure for x in exact])
    inner = np.array([0.0] + [x.inner_displacement for x in exact])
    outer = np.array([0.0] + [x.outer_displacement for x in exact])
    for column, (name, curve) in enumerate((("inner", inner), ("outer", outer))):
        axes.plot(curve, pressures, f"C{column}", label=f"{name} surface, Hill")
        axes.plot(found[:, 1 + column], found[:, 0], f"C{column}o", fillstyle="none", label="32 by 32 cells")
    axes.axhline(exact[0].limit, color="k", linewidth=1, label="limit, 2 Y ln 2")
    axes.set(xlabel="radial displacement [mm]", ylabel="pressure [GPa]", ylim=(0, 0.36))
    axes.legend(loc="lower right")
    axes.grid(alpha=0.3)
    return figure


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else HERE / "figures")
    folder.mkdir(parents=True, exist_ok=True)
    every = {f.__name__: f for f in (taylor_bar, prandtl_punch, thick_sphere)}
    for name in sys.argv[2:] or every:
        target = folder / f"plasticity_{name}.png"
        with tempfile.TemporaryDirectory() as results:
            picture = Path(results) / target.name
            every[name]().savefig(picture, dpi=110)
            shrink(picture, target)
        print(f"{target}: {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
