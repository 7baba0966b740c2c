# # A drop hammer
#
# A hammer of 100 kg falls on a copper billet that stands on an anvil, and upsets it. Hammer and anvil are rigid. How
# far the hammer comes is not given, but follows: its energy $M v^2/2$ becomes plastic work, and friction at both ends
# makes a barrel of the billet. An ideal billet without friction, whose yield stress $Y$ does not harden, would take the
# energy
#
# $$ \tfrac12 M v^2 = Y\,V \ln(H/h), $$
#
# $V$ its volume, $H$ and $h$ its heights before and after. The demo has the three parts of such a problem: a rigid body
# with mass as the master of a pair, a law of finite plastic strain, an axisymmetric mesh.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.tri import Triangulation
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The billet
#
# Units are millimetres, newtons, seconds and tonnes. The mesh is half a section: the axis of symmetry is $r = 0$.

comm = MPI.COMM_WORLD
R, H, n = 10.0, 20.0, 8  # radius and height [mm], cells along the radius
billet = mesh.create_rectangle(comm, [(0.0, 0.0), (R, H)], [n, 2 * n], mesh.CellType.quadrilateral)
ends = [mesh.locate_entities_boundary(billet, 1, lambda x, z=z: np.isclose(x[1], z)) for z in (0.0, H)]
facets, values = np.concatenate(ends), np.repeat([1, 2], [len(end) for end in ends]).astype(np.int32)
order = np.argsort(facets)
tags = mesh.meshtags(billet, 1, facets[order], values[order])
V = fem.functionspace(billet, ("Lagrange", 1, (2,)))
on_axis = mesh.locate_entities_boundary(billet, 1, lambda x: np.isclose(x[0], 0.0))
axis = fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(0), 1, on_axis), V.sub(0))
Y = 400.0  # yield stress [MPa]
copper = di.J2Plasticity(
    117e3, 0.35, 8.93e-9, yield_stress=Y, hardening=100.0, finite_strain=True, hypothesis="axisymmetric"
)

# ## Hammer and anvil
#
# The hammer is a rigid plane with a mass; in an axisymmetric problem it moves along the axis. The anvil is an obstacle
# that stays.

M, v = 0.1, 4000.0  # [t], [mm/s]
hammer = di.RigidBody(di.RigidPlane((0.0, H + 0.01), (0.0, -1.0)), mass=M, centre=(0.0, H + 50.0), velocity=(0.0, -v))
anvil = di.RigidPlane((0.0, -0.01), (0.0, 1.0))
pairs = [di.ContactPair(tags, slave, master, friction=0.1) for slave, master in ((1, anvil), (2, hammer))]
u = fem.Function(V, name="displacement")
blow = di.ExplicitProblem(u, copper, bcs=[axis], contact=[di.Penalty(pair) for pair in pairs])

# ## The blow
#
# The hammer turns round when its energy is spent, and leaves with what the billet has stored as elastic energy.

path = [(0.0, hammer.position[1], hammer.velocity[1])]
while path[-1][2] < 0.0 or blow.contact[1].area > 0.0:
    blow.advance(until=blow.time + 2e-5, progress=False)
    path.append((blow.time, hammer.position[1], hammer.velocity[1]))
time, place, speed = np.array(path).T
height = H - (place[0] - place.min() - 0.02)  # at its least; both gaps were 0.01 mm
energy = dict(zip(("time", "kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "plastic"),
                  blow.energy_history[:, :9].T))  # fmt: skip
ideal = H * np.exp(-0.5 * M * v**2 / (Y * np.pi * R**2 * H))

# ## What came out

x = comm.gather((billet.geometry.x[:, :2], u.x.array.reshape(-1, 2)), root=0)
if comm.rank == 0:
    print(f"height {height:.2f} mm, of an ideal billet without hardening and friction {ideal:.2f} mm")
    print(f"the hammer leaves with {speed[-1]:.0f} mm/s of {v:.0f} mm/s after {1e3 * time[-1]:.2f} ms")
    print(f"of its energy {energy['plastic'][-1] / energy['kinetic'][0]:.1%} is plastic work, "
          f"{energy['friction'][-1] / energy['kinetic'][0]:.1%} went into friction")  # fmt: skip
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for places, moved in x:
        cells = Triangulation(*places.T)
        for side in (-1, 1):
            left.triplot(side * places[:, 0], places[:, 1], cells.triangles, color="0.85", lw=0.5)
            left.triplot(side * (places + moved)[:, 0], (places + moved)[:, 1], cells.triangles, color="C0", lw=0.5)
    left.set(xlabel="r [mm]", ylabel="z [mm]", aspect="equal")
    for name in ("kinetic", "plastic", "internal", "friction"):
        right.plot(1e3 * energy["time"], energy[name] / 1e3, label=name)
    right.set(xlabel="time [ms]", ylabel="energy [J]")
    right.legend()
    figure.savefig("drop_hammer.png", dpi=120)

# ## What must hold
#
# Hardening and friction leave the billet higher than the ideal one, by less than a tenth; no energy comes or goes.

assert ideal < height < 1.1 * ideal and 0.0 < speed[-1] < 0.1 * v and abs(blow.energy["drift"]) < 1e-3
