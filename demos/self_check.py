# # A self-check that finds a mistake
#
# Perhaps no second solver knows your law. What must hold of any law can still be checked. This demo writes the stress
# of a Mooney-Rivlin rubber by hand, with a mistake that no solver complains about: Newton's method converges, stresses
# look plausible. With $C = F^T F$, $J = \det F$ and the invariants $I_1, I_2$ of $C$ the second Piola-Kirchhoff stress
# is
#
# $$ S = 2 c_1 J^{-2/3} \left(I - \tfrac13 I_1 C^{-1}\right)
#      + 2 c_2 J^{-4/3} \left(I_1 I - C - \tfrac23 I_2 C^{-1}\right) + \kappa (J - 1) J C^{-1} $$
#
# The mistake: $\tfrac13 I_2$ where $\tfrac23 I_2$ should be.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The law as a function of a mesh
#
# It returns the residual and its unknown. The checks call it with small meshes of their own, of several cells. In a
# file my_rubber.py `dolfinx-impact verify my_rubber.py rubber` checks it, with a page of results.


def rubber(mesh, factor=2 / 3, stress_at_rest=0.0):
    V = fem.functionspace(mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V, name="displacement"), ufl.TestFunction(V)
    c1, c2, kappa = (fem.Constant(mesh, modulus) for modulus in (0.5e6, 0.4e6, 4e6))  # [Pa]
    a, b = fem.Constant(mesh, factor), fem.Constant(mesh, stress_at_rest)
    H = ufl.grad(u)
    F = ufl.Identity(3) + ufl.as_tensor([[H[0, 0], H[0, 1], 0], [H[1, 0], H[1, 1], 0], [0, 0, 0]])  # plane strain
    C, J = F.T * F, ufl.det(F)
    I1, I2, inverse = ufl.tr(C), (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2, ufl.inv(C)
    S = 2 * c1 * J ** (-2 / 3) * (ufl.Identity(3) - I1 / 3 * inverse) + kappa * (J - 1) * J * inverse
    S += 2 * c2 * J ** (-4 / 3) * (I1 * ufl.Identity(3) - C - a * I2 * inverse - b * inverse)
    P = ufl.as_tensor([[(F * S)[i, j] for j in range(2)] for i in range(2)])
    return di.verify.OwnForm(ufl.inner(P, ufl.grad(v)) * ufl.dx(degree=3), u, parameters={"kappa": kappa})


def with_mistake(mesh):
    return rubber(mesh, 1 / 3)


def free_at_rest(mesh):
    return rubber(mesh, 1 / 3, 1.0)  # the mistake, and a constant that somebody added so that the body rests


forms = {"with mistake": with_mistake, "free at rest": free_at_rest, "right": rubber}
reports = {name: di.verify.self_check(form, cells=["triangle"]) for name, form in forms.items()}

# ## What the mistake would do: work in a cycle of stretches along x and y, which ends where it began

square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
corners = np.array([(1.0, 1.0), (1.4, 1.0), (1.4, 1.2), (1.0, 1.2), (1.0, 1.0)])
way = np.concatenate([np.linspace(a, b, 26)[:-1] for a, b in zip(corners, corners[1:])] + [corners[-1:]])


def work(own):
    x, force = own.u.function_space.tabulate_dof_coordinates()[:, :2], di.InternalForce(own.residual)
    total = [0.0]
    for a, b in zip(way, way[1:]):
        own.u.x.array[:] = (x * ((a + b) / 2 - 1)).ravel()
        total.append(total[-1] + force.apply().array @ (x * (b - a)).ravel())
    return np.array(total)


cycles = {name: work(form(square)) for name, form in (("mistake", free_at_rest), ("right", rubber))}

# ## Findings and picture

if MPI.COMM_WORLD.rank == 0:
    for name, report in reports.items():
        made = [found for found in report.rows if found.applies]
        print(f"{name}: {sum(found.passed for found in made if found.name != 'ranks')} checks passed")
        for found in report.failures():
            print(f"  {found.name}: {found.note.partition(': ')[0]}")
    print(
        f"work in a cycle: {cycles['mistake'][-1] / 1e3:.4f} kJ/m^3 with the mistake, {cycles['right'][-1] / 1e3:.4f}"
    )
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", width_ratios=(3, 2))
    for axis in axes:  # the whole cycle, and its end enlarged
        for (name, values), style in zip(cycles.items(), ("C3", "C0--")):
            axis.plot(np.arange(len(values)) / 25, values / 1e3, style, label=name)
        axis.set(xlabel="corner of the cycle of stretches", ylabel="work per volume [kJ/m³]", xlim=(0, 4))
        axis.set_xticks(range(5), [f"({a:g}, {b:g})" for a, b in corners])
        axis.axhline(0.0, color="0.7", lw=0.8)
    axes[0].legend()
    axes[1].set(xlim=(3.5, 4), ylim=(-3, 30), title=f"{cycles['mistake'][-1] / 1e3:.1f} kJ/m³ remain with the mistake")
    figure.savefig("self_check.png", dpi=120)

# ## What must hold: the mistakes are found, the right law passes, and its work comes back

assert not reports["with mistake"].passed and not reports["free at rest"].passed and reports["right"].passed
assert {"symmetry", "energy"} <= {found.name for found in reports["free at rest"].failures()}
assert abs(cycles["right"][-1]) < 1e-3 * abs(cycles["mistake"]).max() < abs(cycles["mistake"][-1])
# SPDX-License-Identifier: MIT
