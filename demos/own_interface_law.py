# # A law of the interface of one's own
#
# A block is held by a spring and stands on a floor that moves. The friction falls with the slip velocity,
# $\mu(v) = \mu_k + (\mu_s - \mu_k)\,e^{-|v|/v_c}$: the block sticks to the floor, is carried along until the spring is
# stronger, slips back, and sticks again. The pressure grows as the gap closes, as that of rough surfaces,
# $p = p_0 e^{-g/c}$.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The law: functions of what they need, and its checks (derivatives, dissipation, rotation)

p0, c, load = 4.0, 0.02, 1.0  # [Pa, m, Pa]
mu_s, mu_k, v_c, speed, spring = 0.5, 0.2, 0.3, 0.2, 1.0  # [1, 1, m/s, m/s, N/m]


def friction(slip_rate):
    return mu_k + (mu_s - mu_k) * ufl.exp(-ufl.sqrt(ufl.dot(slip_rate, slip_rate) + 1e-20) / v_c)


rough = dict(pressure=lambda gap: p0 * ufl.exp(-gap / c), energy=lambda gap: p0 * c * ufl.exp(-gap / c), reach=0.2)
law = di.InterfaceLaw(**rough, friction=friction, tangential=20.0)
report = di.verify.self_check(law, length=c, velocity=v_c)

# ## A block, and its contact with a floor

block = mesh.create_rectangle(MPI.COMM_WORLD, [[0.0, 0.1], [1.0, 1.1]], [2, 2], mesh.CellType.quadrilateral)
V = fem.functionspace(block, ("Lagrange", 1, (2,)))
sides = [mesh.locate_entities_boundary(block, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.1, 1.1)]
facets, values = np.concatenate(sides), np.repeat([1, 2], [len(s) for s in sides]).astype(np.int32)
tags = mesh.meshtags(block, 1, facets[np.argsort(facets)], values[np.argsort(facets)])
material = di.LinearElastic(E=2e3, nu=0.0, density=1.0, hypothesis="plane_strain")
loads = [di.Foundation(tags, 1, (spring, 0.0)), di.Traction(tags, 2, (0.0, -load))]


def problem(kind, law, u, loads, **options):
    floor = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    if kind is di.ExplicitProblem:
        floor.motion = lambda t: (speed * t, 0.0, 0.0)
    pair = di.ContactPair(tags, slave=1, master=floor)
    return kind(u, material, loads=loads, contact=[di.Penalty(pair, law=law)], **options)


# ## Static, without the friction, which needs time: the gap is $c \log(p_0/p)$

still = problem(di.StaticProblem, di.InterfaceLaw(**rough), fem.Function(V), loads)
still.solve()
height = c * np.log(p0 / load)
gap_error = block.comm.allreduce(np.abs(still.contact[0].gap / height - 1).max(initial=0.0), MPI.MAX)

# ## Explicit steps, for tangential stiffnesses that grow; a guide keeps the block from rocking

dofs = fem.locate_dofs_geometrical((V.sub(1), V.sub(1).collapse()[0]), lambda x: np.full(x.shape[1], True))[0]
guide = fem.dirichletbc(height - 0.1, dofs, V.sub(1))
end, history, owned = 12.0, {}, slice(0, 2 * V.dofmap.index_map.size_local, 2)
for stiffness in (20.0, 80.0, 320.0):
    law.set(friction_stiffness=stiffness)
    u, rows = fem.Function(V), []
    u.x.array[1::2] = height - 0.1
    run = problem(di.ExplicitProblem, law, u, loads[:1], bcs=[guide])
    run.advance(end, callback=lambda run: rows.append((run.time, run.u.x.array[owned].sum())), progress=False)
    total = block.comm.allreduce(np.array(rows), MPI.SUM) / (block.comm.size, V.dofmap.index_map.size_global)
    history[stiffness] = total.T

# ## The exact motion of a rigid block: it sticks up to $\mu_s$, and slips until it is as fast as the floor

h, x, v, sticks, exact = 1e-3, 0.0, 0.0, False, []
for _ in range(round(end / h) + 1):
    exact.append(x)
    mu = mu_k + (mu_s - mu_k) * np.exp(-abs(speed - v) / v_c)
    w = speed if sticks else v + h * (load * mu * np.sign(speed - v) - spring * x)
    x += 0.5 * h * (v + w)
    sticks, v = (sticks or v < speed <= w) and spring * x < mu_s * load, w
exact = np.array(exact)
errors = {k: np.abs(found - np.interp(t, h * np.arange(len(exact)), exact)).max() for k, (t, found) in history.items()}

if MPI.COMM_WORLD.rank == 0:
    print(f"{sum(f.passed for f in report.findings)} checks of the law passed; static gap {height:.5f} m")
    for k, error in errors.items():
        print(f"tangential stiffness {k:3.0f} N/m^3: {error:.3f} m from the rigid block")
    figure, axis = plt.subplots(figsize=(8, 3.6), layout="constrained")
    axis.plot(h * np.arange(len(exact)), exact, "k", lw=2.5, label="rigid block, exact")
    for (k, rows), style in zip(history.items(), ("C3:", "C1--", "C0-")):
        axis.plot(*rows, style, label=f"tangential stiffness {k:g} N/m³")
    axis.set(xlabel="time [s]", ylabel="displacement [m]", title="A block on a moving floor, with friction that falls")
    axis.legend()
    figure.savefig("own_interface_law.png", dpi=120)

assert report.passed and gap_error < 1e-9
assert errors[320.0] < 0.6 * errors[80.0] < 0.6 * errors[20.0] and errors[320.0] < 0.06
