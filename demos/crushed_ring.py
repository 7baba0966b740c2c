# # A ring that is crushed
#
# A ring of steel is pressed flat between two plates. At first four plastic hinges turn, two under the plates and two at
# the sides, and the load is that of the hinges (DeRuntz and Hodge, Journal of Applied Mechanics 30, 1963),
#
# $$ P = \frac{4 M_p}{R}\,\frac{1}{\sqrt{1 - (\delta/2R)^2}} , \qquad M_p = \frac{2}{\sqrt 3}\,\frac{Y t^2}{4} , $$
#
# with the mean radius $R$, thickness $t$, yield stress $Y$ and approach $\delta$ of the plates. Then the ring touches
# itself, and nobody has said where: `GeneralContact` lets all outer facets touch each other. The plates are rigid
# obstacles, which are named in pairs; both kinds of contact go together.

import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
import basix.ufl
import ufl
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The ring
#
# Millimetres, newtons, seconds, tonnes. Two layers of cells, 80 of them around, in plane strain; the steel does
# not harden.

comm = MPI.COMM_WORLD
R, t, n, layers = 20.0, 2.0, 80, 2  # mean radius, thickness [mm], numbers of cells
outer = R + 0.5 * t
angle, radius = np.meshgrid(2 * np.pi * np.arange(n) / n, R + t * np.linspace(-0.5, 0.5, layers + 1), indexing="ij")
points = np.column_stack([(radius * np.sin(angle)).ravel(), (radius * np.cos(angle)).ravel()])
i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(layers), indexing="ij"))
here, there = i * (layers + 1) + j, (i + 1) % n * (layers + 1) + j
cells = np.column_stack([here, here + 1, there, there + 1])
if comm.rank > 0:
    points, cells = points[:0], cells[:0]  # the first rank shares them out
element = ufl.Mesh(basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))
ring = mesh.create_mesh(comm, cells, x=points, e=element)
ring.topology.create_connectivity(1, 2)
facets = mesh.exterior_facet_indices(ring.topology)
outside = np.hypot(*mesh.compute_midpoints(ring, 1, facets)[:, :2].T) > R
tags = mesh.meshtags(ring, 1, facets, np.where(outside, 1, 2).astype(np.int32))
E, Y = 210e3, 300.0  # modulus, yield stress [MPa]
steel = di.J2Plasticity(E, 0.3, 7.85e-9, yield_stress=Y, finite_strain=True, hypothesis="plane_strain")

# ## Plates and contact
#
# The plates come at 8 m/s each, far slower than waves run.

speed = 8e3  # [mm/s]
plates = []
for side in (1.0, -1.0):
    plate = di.RigidPlane((0.0, side * (outer + 1e-3)), (0.0, -side))
    plate.motion = lambda time, side=side: (0.0, -side * speed * time, 0.0)
    plates.append(di.Penalty(di.ContactPair(tags, 1, plate, friction=0.2)))
u = fem.Function(fem.functionspace(ring, ("Lagrange", 1, (2,))), name="displacement")
problem = di.ExplicitProblem(u, steel, contact=[*plates, di.GeneralContact(tags, friction=0.2)])
itself = problem.contact[2]

# ## The way down

pictures, path, met, most, deepest = [], [(0.0, 0.0)], np.inf, 0, 0.0
for part in np.arange(0.01, 0.925, 0.01):  # approach of the plates over the mean diameter
    problem.advance(until=part * R / speed, progress=False)
    path.append((part, 0.5 * (problem.contact[1].force[1] - problem.contact[0].force[1])))
    met = min(met, part if itself.num_springs[0] > 0 else np.inf)
    most, deepest = max(most, itself.num_springs[0]), max(deepest, itself.deepest)
    if np.isclose(part, [0.4, 0.8, 0.92]).any():
        pictures.append(di.DeformedBody(u, problem.von_mises))
approach, force = np.array(path).T
hinges = 4.0 * 2.0 / np.sqrt(3.0) * Y * t**2 / 4.0 / R / np.sqrt(1.0 - approach**2)

# ## What came out

ratio = np.mean(force[(approach > 0.2) & (approach < 0.6)] / hinges[(approach > 0.2) & (approach < 0.6)])
if comm.rank == 0:
    print(f"load over that of four hinges, approach of 0.2 to 0.6 diameters: {ratio:.2f}")
    print(f"the ring touches itself from {met:.2f} diameters on")
    print(f"plastic work {problem.energy['plastic'] / problem.energy['external']:.1%} of the work of the plates")
figure, axes = plt.subplot_mosaic([["load", 0], ["load", 1], ["load", 2]], figsize=(10, 5), layout="constrained")
for k, picture in enumerate(pictures):
    picture.draw(axes[k], label="stress [MPa]")
if comm.rank == 0:
    for k in range(3):
        axes[k].set(xlim=(-34, 34), xlabel="", ylabel="")
    axes["load"].plot(approach, force, label="computed")
    axes["load"].plot(approach, hinges, "k--", label="four hinges")
    axes["load"].axvline(met, color="0.7", lw=0.8)
    axes["load"].set(xlabel=r"approach $\delta/2R$", ylabel="load [N/mm]", ylim=(0.0, 500.0))
    axes["load"].legend()
    figure.savefig("crushed_ring.png", dpi=120)

# ## What must hold
#
# Hinges have a length, which the formula does not know: the load is somewhat larger. It rises when the faces meet.

assert 1.0 < ratio < 1.3 and 0.75 < met < 0.9 and force[-1] > 2.0 * hinges[-1]
assert most > 1 and deepest < 0.02 * t and abs(problem.energy["drift"]) < 1e-5
