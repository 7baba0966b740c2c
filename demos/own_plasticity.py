# # A plastic law of one's own
#
# Ductile metals fail by voids that grow. In Gurson's law a metal with the volume fraction $f$ of voids yields at
#
# $$ \Phi = \frac{q^2}{Y^2} + 2 q_1 f \cosh\frac{3 q_2 p}{2 Y} - 1 - (q_1 f)^2 = 0 $$
#
# and flows along the gradient of $\Phi$; $q$ is von Mises' stress, $p$ the mean stress, $Y$ the metal's yield stress.
# Unknown at each point: the increments of the deviatoric, of the volumetric and of the metal's own plastic strain.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The law: history (zero at first), stress, elastic energy, and the equations, which the kernels solve


class Gurson(di.InelasticMaterial):
    history, unknown = {"plastic_strain": (), "voids": (), "deviator": (3,), "volume": ()}, (3,)
    Y0, H, f0, q1, q2 = 400e6, 1e9, 0.01, 1.5, 1.0  # [Pa, Pa, 1, 1, 1]

    def surface(self, q, p, Y, f):
        return q**2 / Y**2 + 2 * self.q1 * f * ufl.cosh(1.5 * self.q2 * p / Y) - 1 - (self.q1 * f) ** 2

    def respond(self, strain, history, unknown):
        (lmbda, mu), d, (dq, dv, da) = self.lame, history["deviator"], unknown
        kappa, size = lmbda + 2 * mu / 3, self.Y0 / (3 * mu)
        old = ufl.as_tensor([[d[0], d[2], 0], [d[2], d[1], 0], [0, 0, -d[0] - d[1]]])
        trial, p_trial = 2 * mu * (ufl.dev(strain) - old), kappa * (ufl.tr(strain) - history["volume"])
        q_trial = ufl.sqrt(1.5 * ufl.inner(trial, trial) + (1e-12 * self.Y0) ** 2)
        Y_old, f_old = self.Y0 + self.H * history["plastic_strain"], self.f0 + history["voids"]
        q, p, Y, f = q_trial - 3 * mu * dq, p_trial - kappa * dv, Y_old + self.H * da, (f_old + dv) / (1 + dv)
        by_q, by_p = 2 * q / Y, 3 * self.q1 * self.q2 * f * ufl.sinh(1.5 * self.q2 * p / Y)
        flow = [dv * by_q - dq * by_p, size * self.surface(q, p, Y, f), da - (q * dq + p * dv) / ((1 - f) * Y)]
        yields = ufl.gt(self.surface(q_trial, p_trial, Y_old, f_old), 0)
        residual = ufl.as_vector([ufl.conditional(yields, flow[i], unknown[i]) for i in range(3)])
        step = 1.5 * dq / q_trial * trial
        s, new = trial - 2 * mu * step, old + step
        alpha, volume = history["plastic_strain"] + da, history["volume"] + dv
        deviator = ufl.as_vector([new[0, 0], new[1, 1], new[0, 1]])
        history = {"plastic_strain": alpha, "voids": f - self.f0, "volume": volume, "deviator": deviator}
        stored = p**2 / (2 * kappa) + ufl.inner(s, s) / (4 * mu)
        return di.MaterialUpdate(s + p * ufl.Identity(3), history, stored, residual, 0 * unknown, size)


# ## A notched round bar, slowly: half of it; x is the radius. Its end moves by 0.15 mm.

comm, R, L, pull = MPI.COMM_WORLD, 5e-3, 15e-3, 0.15e-3  # [m]
bar = mesh.create_rectangle(comm, [(0, 0), (R, L)], [16, 40], mesh.CellType.quadrilateral)
bar.geometry.x[:, 0] *= 1 - 0.4 * np.exp(-((bar.geometry.x[:, 1] / 2e-3) ** 2))  # the notch
V = fem.functionspace(bar, ("Lagrange", 1, (2,)))


def fixed(axis, place, value=0.0):
    facets = mesh.locate_entities_boundary(bar, 1, lambda x: np.isclose(x[axis], place))
    return fem.dirichletbc(value, fem.locate_dofs_topological(V.sub(axis), 1, facets), V.sub(axis))


def largest(problem):
    return metal.f0 + comm.allreduce(problem.history["voids"].values.max(initial=0.0), MPI.MAX)


end, metal = fem.Constant(bar, 0.0), Gurson(E=200e9, nu=0.3, density=7800.0, hypothesis="axisymmetric")
held, way = [fixed(0, 0.0), fixed(1, 0.0)], np.linspace(0, pull, 16)[1:]
slow, slow_voids = di.StaticProblem(fem.Function(V), metal, bcs=[*held, fixed(1, L, end)]), []
for end.value in way:
    slow.solve()
    slow_voids.append(largest(slow))

# ## The same motion in 100 microseconds, by explicit steps

moved = di.PrescribedMotion(fixed(1, L, pull), lambda t: np.sin(np.pi / 2 * t / 1e-4) ** 2)
fast, fast_voids = di.ExplicitProblem(fem.Function(V), metal, velocity=fem.Function(V), bcs=[*held, moved]), []
for time in 1e-4 * 2 / np.pi * np.arcsin(np.sqrt(way / pull)):
    fast.advance(until=time, progress=False)
    fast_voids.append(largest(fast))

# ## Picture, and what must hold: inertia changes little at this speed, and the energies of the explicit run balance

picture = di.DeformedBody(slow.u, metal.f0 + slow.history["voids"].at_nodes())
if comm.rank == 0:
    print(f"largest void fraction, pulled slowly {slow_voids[-1]:.5f}, fast {fast_voids[-1]:.5f}")
    print(f"dissipated by plastic flow {fast.energy['plastic']:.4f} J")
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", gridspec_kw={"wspace": 0.15})
    picture.draw(left, "void fraction [1]", lengths=1e3, edges=False)
    left.set(xlim=(0, 6), ylim=(0, 8), xlabel="r [mm]", ylabel="z [mm]")
    right.plot(way * 1e3, slow_voids, "o", label="slowly")
    right.plot(way * 1e3, fast_voids, label="fast")
    right.set(xlabel="displacement of the end [mm]", ylabel="largest void fraction [1]")
    right.legend()
    figure.savefig("own_plasticity.png", dpi=120)
assert abs(fast_voids[-1] / slow_voids[-1] - 1) < 0.1 and abs(fast.energy["drift"]) < 1e-3
# SPDX-License-Identifier: MIT
