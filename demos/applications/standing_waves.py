# # Standing waves: critical speeds
#
# Waves run along a body in both directions. Seen from an axle or from a load that travels, those that run the same way
# as the material flows are faster, those against it slower. At the *critical speed* the slowest of them stands still:
# the load pumps into one place of its shape all the time. Two bodies show it on a mesh that stands still:
#
# - a roller of foam that spins: its *Campbell diagram*, frequencies against spin;
# - a rail on a soft layer under a load that travels: its steady shape, with an exact solution.
#
# Frequencies are the roots of $s^2 M + s G + K - W$, $s = \mathrm{i} \omega$. A wave that stands still has $s = 0$, so
# that the stiffness of the moving body, $K - W$, is singular there.

import os

import basix.ufl
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di
from dolfinx_impact.io import plots
from dolfinx_impact.io.gather import gather_field
from dolfinx_impact.io.run_folder import RunFolder

comm = MPI.COMM_WORLD
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"
around, count, parts = (48, 8, (0.0, 0.3)) if fast else (128, 14, np.linspace(0.0, 0.9, 19))
run = RunFolder(name="standing_waves", parameters={"around": around, "count": count})


def tagged(domain, facets=None):
    """One tag 1 on all cells, or on some facets."""
    index_map = domain.topology.index_map(2)
    everywhere = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
    entities = everywhere if facets is None else np.sort(facets)
    dim = 2 if facets is None else 1
    return mesh.meshtags(domain, dim, entities, np.full(len(entities), 1, dtype=np.int32))


# ## The roller
#
# A ring of quadrilaterals, displacements of degree 2, bonded to a hub. Strains are finite: the spin stretches the foam,
# which makes it stiffer, and a law of small strains would not know of it.

HUB, RIM = 0.030, 0.050  # radii [m]
points, cells = np.zeros((0, 2)), np.zeros((0, 4), dtype=np.int64)
if comm.rank == 0:
    radii, angle = np.linspace(HUB, RIM, 6), 2 * np.pi * np.arange(around) / around
    points = np.array([[r * np.cos(t), r * np.sin(t)] for t in angle for r in radii])
    start, layers = len(radii) * np.arange(around), np.arange(len(radii) - 1)
    corner = (start[:, None] + layers).ravel()
    beside = (np.roll(start, -1)[:, None] + layers).ravel()
    cells = np.column_stack([corner, corner + 1, beside, beside + 1])
ring = mesh.create_mesh(comm, cells, x=points, e=basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))
V = fem.functionspace(ring, ("Lagrange", 2, (2,)))
hub = mesh.locate_entities_boundary(ring, 1, lambda x: np.hypot(x[0], x[1]) < 1.01 * HUB)
held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, hub), V)
foam = di.NeoHookean(E=2e6, nu=0.3, density=300.0, hypothesis="plane_strain")
spin = di.Spin(point=(0.0, 0.0), axis=(0.0, 0.0, 1.0), omega=10.0)
roller = di.RollingProblem(fem.Function(V), foam, tagged(ring), {1: spin}, bcs=[held])

# `critical_factor` says how much faster the body might move until $K - W$ is singular, with the stiffness of the
# present state. It is taken here at a slow spin, as a scale.

roller.solve()
scale = spin.omega * roller.critical_factor()
diagram = roller.campbell(np.asarray(parts) * scale, count)
omega, frequencies = diagram["omega"], diagram["frequencies"]
factor = roller.critical_factor()
run.print(f"critical spin, stiffness of the roller at rest: {scale:.1f} rad/s, {scale * RIM:.2f} m/s at the rim")
run.print(f"stiffness at {omega[-1]:.1f} rad/s:                      {omega[-1] * factor:.1f} rad/s")
columns = {f"frequency_{i + 1}": (column, "rad/s") for i, column in enumerate(frequencies.T)}
run.table("campbell", {"omega": (omega, "rad/s"), **columns})

# ## The rail
#
# A beam of unit width on a layer of soft material, held at its far ends. It flows under a load that stands still.
# For the theory the layer is a bed of springs of stiffness $k$, as $\nu = 0$ there, with some shear. The beam is stiff
# $B = EI$, has the mass $m$ per length, and the deflection $w$ obeys
#
# $$ B\, w'''' + (m v^2 - S)\, w'' + k\, w = F \delta(x), $$
#
# where $S$ is the shear stiffness of the layer. Its waves are slowest at $m v_c^2 = 2 \sqrt{k B} + S$. With
# $\alpha = (m v^2 - S) / 2 \sqrt{k B}$ and $\beta = \sqrt[4]{k / 4 B}$ the solution is
#
# $$ w = \frac{F \beta}{2 k}\, e^{-\lambda \beta |x|}
#    \left(\frac{\cos \kappa \beta x}{\lambda} + \frac{\sin \kappa \beta |x|}{\kappa}\right), \quad
#    \lambda = \sqrt{1 - \alpha},\ \kappa = \sqrt{1 + \alpha}. $$

LENGTH, HEIGHT, LAYER, FORCE = 80.0, 0.1, 0.1, 1e5  # [m], [N/m]
E, density, bed = 210e9, 7850.0, 2e6  # [Pa, kg/m^3, Pa]
along = 161 if fast else 641  # an odd number: a cell under the load
strip = mesh.create_rectangle(
    comm, [(-LENGTH / 2, -LAYER), (LENGTH / 2, HEIGHT)], (along, 2), mesh.CellType.quadrilateral
)
# Two layers of cells, of which the upper one is the beam.
middles = mesh.compute_midpoints(strip, 2, tagged(strip).indices)
material = mesh.meshtags(strip, 2, tagged(strip).indices, np.where(middles[:, 1] > 0.0, 2, 1).astype(np.int32))
laws = {
    1: di.LinearElastic(bed, 0.0, density=1.0, hypothesis="plane_strain"),
    2: di.LinearElastic(E, 0.0, density=density, hypothesis="plane_strain"),
}
U = fem.functionspace(strip, ("Lagrange", 2, (2,)))
outside = mesh.locate_entities_boundary(
    strip, 1, lambda x: np.isclose(x[1], -LAYER) | np.isclose(np.abs(x[0]), LENGTH / 2)
)
ends = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(U, 1, outside), U)
width = LENGTH / along
under = mesh.locate_entities_boundary(strip, 1, lambda x: np.isclose(x[1], HEIGHT) & (np.abs(x[0]) < 0.51 * width))
load = di.Traction(tagged(strip, under), 1, (0.0, -FORCE / width))
flow, u = di.Translation((-1.0, 0.0)), fem.Function(U, name="displacement")
rail = di.RollingProblem(u, di.MaterialMap(material, laws), tagged(strip), {1: flow}, bcs=[ends], loads=[load])
B, k, shear, mass = E * HEIGHT**3 / 12, bed / LAYER, bed / 2 * LAYER / 3, density * HEIGHT + LAYER / 3
exact_critical = np.sqrt((2 * np.sqrt(k * B) + shear) / mass)
critical = rail.critical_factor()  # the stiffness of linear elasticity stays: this is the critical speed itself
run.print(f"critical speed of the rail: {critical:.2f} m/s; beam theory {exact_critical:.2f} m/s")


def deflection(v, x):
    """Exact deflection at the places x at a speed [m]."""
    alpha, beta = (mass * v**2 - shear) / (2 * np.sqrt(k * B)), (k / (4 * B)) ** 0.25
    decay, wave, far = np.sqrt(1 - alpha), np.sqrt(1 + alpha), beta * np.abs(x)
    return FORCE * beta / (2 * k) * np.exp(-decay * far) * (np.cos(wave * far) / decay + np.sin(wave * far) / wave)


shapes = []
for part in (0.0, 0.8, 0.95):
    flow.velocity = (-part * exact_critical, 0.0)
    rail.solve()
    field = gather_field(u)
    if comm.rank == 0:
        axis = np.abs(field.points[:, 1] - HEIGHT / 2) < 1e-6
        order = np.argsort(field.points[axis, 0])
        x, w = field.points[axis, 0][order], -field.values[axis, 1][order]
        exact = deflection(part * exact_critical, x)
        shapes.append((part, x, w, exact))
        run.print(f"{part:4.2f} of it: deflection {1e3 * w.max():7.4f} mm, exact {1e3 * exact.max():7.4f} mm")
    run.fields(f"rail_{round(100 * part)}", [u])

# Beyond the critical speed the steady state is not a stable one, and the solver refuses it.

flow.velocity, refused = (-1.02 * critical, 0.0), ""
try:
    rail.solve()
except RuntimeError as error:
    refused = str(error)
run.print(f"1.02 of it: {refused}")

# ## Picture


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
    speed = np.repeat(omega[:, None] * RIM, frequencies.shape[1], axis=1)
    for sign, label, colour in ((1, "with the spin", plots.COLOURS[0]), (-1, "against the spin", plots.COLOURS[1])):
        chosen = sign * frequencies > 0
        hertz = np.abs(frequencies[chosen]) / (2 * np.pi)
        left.plot(speed[chosen], hertz, "o", ms=4, mfc="none", color=colour, label=label)
    left.set(xlabel="speed of the rim [m/s]", ylabel="frequency [Hz]", xlim=(-1, None), ylim=(0, None))
    left.set_title(f"roller: its {frequencies.shape[1]} lowest frequencies", fontsize=10)
    left.legend(fontsize=9, title="waves that run", title_fontsize=9)
    for (part, x, w, exact), colour in zip(shapes, plots.COLOURS):
        near = np.abs(x) < 16.0
        right.plot(x[near], 1e3 * exact[near], color=colour, label=f"{part:.2f} of the critical speed")
        right.plot(x[near][::8], 1e3 * w[near][::8], "o", ms=4, mfc="none", color=colour)
    right.invert_yaxis()
    right.set(xlabel="place along the rail, from the load [m]", ylabel="deflection [mm]")
    right.set_title("rail: lines are the exact solution", fontsize=10)
    right.legend(fontsize=9, loc="lower right")
    plots.save(figure, run.file("standing_waves.png"))


run.pictures(draw)
run.print(f"results in {run.path}")

# ## What must hold
#
# The beam theory neglects the beam's shear and its rotary inertia: (height over wave length)^2, 2e-4 here. Near the
# critical speed the deflection multiplies errors of the speed, as it grows with $1 / \sqrt{1 - \alpha}$.
# The coarse cells of the tests miss twice as much.

assert abs(critical / exact_critical - 1) < 0.01
for part, x, w, exact in shapes:
    assert np.abs(w - exact).max() < (0.1 if part > 0.9 else 0.04 if fast else 0.02) * exact.max()
assert "critical" in refused
assert np.all(frequencies[0] > 0.0) and np.any(frequencies[1:] < 0.0)
# SPDX-License-Identifier: MIT
