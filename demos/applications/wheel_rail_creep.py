# # Creep forces of a wheel on a rail, in 3D
#
# A locomotive's wheel turns a little faster than it travels; the rail feels a tractive force. How large is it? At small
# *creep* it grows in proportion, at large creep friction limits it. The curve between is what programs of vehicle
# dynamics ask for. Here finite elements find it, for the wheel of a Eurosprinter under 106.7 kN, and are compared with
# the program CONTACT, which takes the bodies for half-spaces; with its linear slope; and with Carter's theory for
# cylinders.
#
# `dolfinx-impact creep --load 106.7e3 --friction 0.33 ...` does the same from the command line.

import os

import numpy as np

import dolfinx_impact as di
from impact_studies.creep import figure
from impact_studies.creep.model import CreepModel, WheelOnRail
from dolfinx_impact.io import plots
from dolfinx_impact.io.run_folder import RunFolder

fast = os.environ.get("IMPACT_DEMO_FAST") == "1"
G, nu = 82e9, 0.28
published = {4e-4: 0.2588, 8e-4: 0.4742, 1.2e-3: 0.6482, 1.6e-3: 0.7831, 2.0e-3: 0.8816, 2.4e-3: 0.9467, 2.8e-3: 0.9832}
wheel = WheelOnRail(
    load=106.7e3, friction=0.33, radius=0.625, crown_radius=1.77672, E=2 * G * (1 + nu), nu=nu, speed=20.0,
    cells=3 if fast else 7,
)  # fmt: skip
run = RunFolder(name="wheel_rail_creep", parameters={"load": wheel.load, "friction": wheel.friction})

# ## The model
#
# A sector of the wheel and a length of rail, both as far as the stress of the contact reaches. Rows of cells follow the
# flow of the material. The approach is found that bears the load; then the wheel rolls freely, and creep counts from
# there.

model = CreepModel(wheel)
hertz = model.hertz
run.print(f"{model.num_unknowns} unknowns, contact of {1e3 * hertz.a:.2f} mm by {1e3 * hertz.b:.2f} mm (half-axes)")
run.print(f"largest pressure {model.peak_pressure / 1e6:.1f} MPa, Hertz {hertz.peak_pressure / 1e6:.1f} MPa")

# ## The curve

creep = np.array([0.0, 8e-4, 1.6e-3]) if fast else np.arange(0.0, 2.9e-3, 2e-4)
curve = model.curve(creep, progress=False)
run.print(f"{'creep':>8s} {'T/(f N)':>8s} {'CONTACT':>8s} {'torque [kN m]':>14s}")
for c, ratio, torque in zip(creep, curve["ratio"], curve["torque"]):
    known = next((value for at, value in published.items() if abs(at - c) < 1e-9), None)
    run.print(f"{c:8.1e} {ratio:8.4f} {f'{known:8.4f}' if known else 8 * ' '} {torque / 1e3:14.3f}")
run.table("curve", {"creep": (creep, "1"), "ratio": (curve["ratio"], "1"), "torque": (curve["torque"], "N m")})

# ## Stick and slip
#
# At a creep in the middle of the curve the material sticks at the leading edge, on the right, and slips behind.

middle = 0.5 * creep[-1]
if not fast:
    model.problem.motions[2].omega *= (1.0 + middle) / (1.0 + creep[-1])
    model.problem.solve()
tractions = figure.gather(model)
run.fields("wheel_rail_creep", [model.u])


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    picture, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    fine = np.linspace(0.0, 2.9e-3, 200)
    full = wheel.friction * hertz.a / wheel.radius
    left.plot(1e3 * fine, 1.0 - np.maximum(1.0 - fine / full, 0.0) ** 2, "0.6", label="Carter, cylinders with this a")
    slope = 3.788 * G * hertz.a * hertz.b / (wheel.friction * wheel.load)
    left.plot(1e3 * fine, slope * fine, "k--", label="linear theory, C11 = 3.788")
    left.plot(1e3 * np.array(list(published)), list(published.values()), "ks", label="CONTACT")
    left.plot(1e3 * creep, curve["ratio"], "C0o-", label=f"RollingProblem, {wheel.cells} cells in a half-axis")
    left.set(xlabel="creep [1e-3]", ylabel="force over friction times load", ylim=(0.0, 1.05))
    left.legend(loc="lower right")
    figure.draw_contact(right, model, tractions)
    right.set_title(f"tractions at a creep of {1e3 * (creep[-1] if fast else middle):.1f}e-3")
    plots.save(picture, run.file("wheel_rail_creep.png"))


run.pictures(draw)
run.print(f"results in {run.path}")
assert tractions is None or np.any(tractions.status == di.ContactStatus.stick), "nothing sticks"  # on rank 0
theirs = np.array([published[round(float(c), 6)] for c in creep if round(float(c), 6) in published])
ours = np.array([r for c, r in zip(creep, curve["ratio"]) if round(float(c), 6) in published])
error = np.abs(ours / theirs - 1.0).max()
assert error < (0.1 if fast else 0.03), f"creep forces differ from CONTACT's by {error:.3f}"
# SPDX-License-Identifier: MIT
