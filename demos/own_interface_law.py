# # A law of the interface of one's own
#
# A block is held by a spring and stands on a floor that moves. The friction falls with the slip velocity,
#
# $$ \mu(v) = \mu_k + (\mu_s - \mu_k)\,e^{-|v|/v_c} , $$
#
# so that the block sticks to the floor, is carried along until the spring is stronger, slips back, and sticks again. The
# pressure grows exponentially as the gap closes, as that of rough surfaces does: $p = p_0 e^{-g/c}$.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## The law: functions of what it needs, and numbers that may be changed later

p0, c, load = 4.0, 0.02, 1.0  # [Pa, m, Pa]
mu_s, mu_k, v_c, speed, spring = 0.5, 0.2, 0.3, 0.2, 1.0  # [1, 1, m/s, m/s, N/m]


def pressure(gap, parameters):
    return parameters.p0 * ufl.exp(-gap / c)


def friction(slip_rate):
    return mu_k + (mu_s - mu_k) * ufl.exp(-ufl.sqrt(ufl.dot(slip_rate, slip_rate) + 1e-20) / v_c)


def energy(gap, parameters):
    return parameters.p0 * c * ufl.exp(-gap / c)


law = di.InterfaceLaw(
    pressure, energy=energy, friction=friction, tangential=1e3, parameters={"p0": p0}, reach=0.2, name="rough surfaces"
)
report = di.verify.self_check(law, length=c, velocity=v_c)

# ## A block, its spring, and the floor

block = mesh.create_rectangle(MPI.COMM_WORLD, [[0.0, 0.1], [1.0, 1.1]], [2, 2], mesh.CellType.quadrilateral)
V = fem.functionspace(block, ("Lagrange", 1, (2,)))
sides = [mesh.locate_entities_boundary(block, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.1, 1.1)]
facets, values = np.concatenate(sides), np.repeat([1, 2], [len(s) for s in sides]).astype(np.int32)
tags = mesh.meshtags(block, 1, facets[np.argsort(facets)], values[np.argsort(facets)])
material = di.LinearElastic(E=2e3, nu=0.0, density=1.0, hypothesis="plane_strain")


def problem(kind, floor, **options):
    pair = di.ContactPair(tags, slave=1, master=floor)
    return kind(fem.Function(V), material, contact=[di.Penalty(pair, law=law)], **options)


# Static: under the load the gap is $c \log(p_0/p)$. The spring holds the block sideways.

loads = [di.Traction(tags, 2, (0.0, -load)), di.Foundation(tags, 2, (spring, 0.0))]
still = problem(di.StaticProblem, di.RigidPlane((0.0, 0.0), (0.0, 1.0)), loads=loads)
still.solve()
gap, exact_gap = still.contact[0].gap, c * np.log(p0 / load)
gap_error = block.comm.allreduce(np.abs(gap / exact_gap - 1).max(initial=0.0), MPI.MAX)

# ## Explicit steps, for tangential stiffnesses that grow

end, history = 25.0, {}
for stiffness in (10.0, 40.0, 160.0):
    law.set(friction_stiffness=stiffness)
    floor = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    floor.motion = lambda t: (speed * t, 0.0)
    run = problem(di.ExplicitProblem, floor, loads=loads)
    run.u.x.array[1::2] = exact_gap - 0.1
    rows = []
    run.advance(until=end, callback=lambda run: rows.append((run.time, run.contact[0].force[0])), progress=False)
    history[stiffness] = np.array(rows)
