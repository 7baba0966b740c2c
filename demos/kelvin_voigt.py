# # A damped bar: Kelvin and Voigt's solid
#
# A spring and a dashpot side by side: the stress is $E \varepsilon + \eta \dot\varepsilon$. The rate is that of the
# velocity, a function that the form contains beside the displacement, and that the problem updates. A bar that is held
# on its left vibrates in its first mode, $\sin(\pi x / 2 L)$. With $\omega = \frac{\pi}{2 L} \sqrt{E/\rho}$ and the
# damping ratio $\zeta = \eta \omega / 2 E$ its end moves as
#
# $$ u(t) = a\, e^{-\zeta \omega t} \left(\cos \omega_d t + \frac{\zeta \omega}{\omega_d} \sin \omega_d t\right), \quad
#    \omega_d = \omega \sqrt{1 - \zeta^2}. $$

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Bar and mode

L, H, E, density, zeta, start = 1.0, 0.05, 2.0e9, 1000.0, 0.05, 1e-3  # lengths [m], modulus [Pa], density [kg/m^3]
omega = np.pi / (2 * L) * np.sqrt(E / density)
eta = 2 * zeta * E / omega  # viscosity [Pa s]
comm = MPI.COMM_WORLD
bar = mesh.create_rectangle(comm, [(0.0, 0.0), (L, H)], [40, 2], mesh.CellType.quadrilateral)
V = fem.functionspace(bar, ("Lagrange", 1, (2,)))
held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0)), V)


def mode(x):
    return np.array([start * np.sin(np.pi * x[0] / (2 * L)), 0.0 * x[0]])


# ## The form
#
# Without contraction across the bar each fibre is a bar by itself. Terms with the velocity count as damping: the energy
# balance shows what they dissipate.

period = 2 * np.pi / (omega * np.sqrt(1 - zeta**2))


def released(kind, dt):
    """Times, displacements of the end, and energies of a problem that is released in the first mode."""
    u, velocity, v = fem.Function(V, name="displacement"), fem.Function(V, name="velocity"), ufl.TestFunction(V)
    u.interpolate(mode)
    stress = E * ufl.sym(ufl.grad(u)) + eta * ufl.sym(ufl.grad(velocity))
    residual = ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(degree=2)
    problem = kind(u, residual=residual, density=density, velocity=velocity, bcs=[held])
    x = V.tabulate_dof_coordinates()[: V.dofmap.index_map.size_local]
    end = np.flatnonzero(np.isclose(x[:, 0], L) & np.isclose(x[:, 1], 0.0))
    moved = []

    def watch(problem):
        here = [float(u.x.array[2 * k]) for k in end]
        moved.append((problem.time, sum(comm.allgather(here), [])[0]))

    problem.advance(3 * period, dt=dt, callback=watch, progress=False)
    return np.array(moved).T, problem.energy


runs = {"explicit": released(di.ExplicitProblem, "auto"), "implicit": released(di.NewmarkProblem, period / 100)}

# ## Picture and numbers


def exact(t):
    decay, damped = zeta * omega, omega * np.sqrt(1 - zeta**2)
    return start * np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))


errors = {name: np.max(np.abs(u - exact(t))) / start for name, ((t, u), _) in runs.items()}
left = start**2 * E * H * np.pi**2 / (16 * L)  # energy of the mode at the start [J/m]
if comm.rank == 0:
    figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
    times = np.linspace(0, 3 * period, 400)
    axes.plot(times / period, 1e3 * exact(times), "0.6", lw=4, label="closed form")
    for (name, ((t, u), energy)), style in zip(runs.items(), ("C0", "C3--")):
        print(f"{name}: {len(t) - 1} steps, differs from the closed form by {100 * errors[name]:.2f} % of the start;")
        print(f"  dissipated {energy['damping']:.4f} J/m of {left:.4f}, drift of the balance {energy['drift']:.1e}")
        axes.plot(t / period, 1e3 * u, style, lw=1.2, label=name)
    axes.set(xlabel="time / period", ylabel="displacement of the end [mm]", xlim=(0, 3))
    axes.axhline(0.0, color="0.8", lw=0.8)
    axes.legend()
    figure.savefig("kelvin_voigt.png", dpi=120)

# ## What must hold
#
# 40 cells have the frequency of the mode to 0.006 %. The explicit force takes the velocity of half a step before, an
# error of first order in the step; Newmark's period is too long by $(\omega \Delta t)^2/12$, 0.6 % of a radian in three
# periods.

dissipated = 1 - np.exp(-6 * zeta * omega * period)  # of the energy, in three periods
assert errors["explicit"] < 0.01 and errors["implicit"] < 0.01
assert all(abs(energy["damping"] / left - dissipated) < 1e-3 for _, energy in runs.values())
# SPDX-License-Identifier: MIT
