# # A wheel rolls over an insulated rail joint, in space
#
# Track circuits find trains by the current that wheels and axle lead from rail to rail. Where one circuit ends, the
# rail is cut and an insulating end post is glued in between. These joints fail early: steel flows over the gap, the
# glue comes off, cracks start at the edges of the railhead. Why? The end post is softer than steel. The running surface
# gives way below the wheel, the wheel falls into the dip, a few hundredths of a millimetre deep, and strikes the edge
# of the next rail.
#
# This demo computes one passage in two stages, as Pang (2008) did: a static one that presses the wheel on the rail, and
# a dynamic one in which it rolls over the joint. `docs/rail_joint.md` leads through the theory and the results.
#
# Run it by `make demo`, or `dolfinx-impact demo rail_joint --ranks 2`. The command `dolfinx-impact joint` takes other
# parameters, by name or from a file.

import os
import time

from mpi4py import MPI

from impact_studies.rail_joint import Case, RailJoint

comm, started = MPI.COMM_WORLD, time.perf_counter()
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"  # coarse cells, a shorter way, for tests

# ## Parameters
#
# Everything has a default: a wheel of 0.46 m under 130 kN at 120 km/h, a 60E1-like rail on sleepers, an end post of
# 8 mm of epoxy with glass fibres, joint bars glued to the web. `RailJoint.from_toml` reads them from a file, in which
# `speed = "160 km/h"` may stand. The mesh has four cells in the half-axis of the contact (`preset="coarse"`), 8 and 16
# with "medium" and "fine".

joint = RailJoint()
if fast:
    joint = joint.changed(
        cells=1, coarse=0.08, begin=-0.022, end=0.014, rail_length=0.7, bar_length=0.4, yield_stress=600e6
    )

# ## Model and stages
#
# By symmetry one half is computed. Steel near the path may yield (J2 plasticity with Armstrong and Frederick's
# kinematic hardening); the wheel turns and follows St. Venant and Kirchhoff's law; end post and glue are elastic.
#
# * *Preload*: multipliers press the wheel on the rail, without friction; centrifugal forces of its turning act on it.
# * *Start*: displacement, plastic history and contact forces go over to the explicit problem
#   (`ExplicitProblem.from_static`). Nodes get the velocities of steady rolling: the dent stays below the wheel while
#   the material passes through it.
# * *Rolling*: central differences, penalty contact, Coulomb friction of 0.3, no damping but that of the pads.
# * *Unloading*: the wheel is lifted off; what stays are residual stress and plastic strain.
#
# `Case` does all this in a folder of its own. It writes checkpoints, and `resume=True` goes on from one.

case = Case(joint, comm=comm, frames=6 if fast else 25)
found = case.solve()
case.run.print(f"results in {case.run.path}, {time.perf_counter() - started:.1f} s in all on {comm.size} rank(s)")

# ## What must hold
#
# The static force is the load, to the tolerance of the preload. Before the joint, the force is the static one: within
# 3 %, as the rail end begins to give way, and 10 % with the tests' cells, which are as long as the half-axis of the
# contact. At the joint the force drops and then exceeds the load. The balance of energies misses less than 1 % of what
# the passage exchanges.

assert abs(found.static_force / joint.load - 1.0) < 1e-4
assert abs(found.mean_before - 1.0) < (0.10 if fast else 0.03)
assert found.least_force < found.mean_before and found.dynamic_factor > 1.0
assert found.energy_missed < 0.01
# SPDX-License-Identifier: MIT
