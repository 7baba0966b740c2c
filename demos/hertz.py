# # A cylinder pressed on a block: Hertz
#
# A steel cylinder is pressed on a steel block. Nobody tells the two bodies where they touch: multipliers find the contact
# and its pressure. Hertz (1881) knows both for half-planes. With $1/E^* = \sum (1 - \nu_i^2) / E_i$ and the load $P$ per
# length,
#
# $$ a = \sqrt{\frac{4 P R}{\pi E^*}}, \qquad p(x) = \frac{2P}{\pi a} \sqrt{1 - x^2/a^2}, $$
#
# where $a$ is half of the width of the contact and $p$ the pressure. The block is much larger than the contact, so that
# it behaves like a half-plane.

import gmsh
import matplotlib.pyplot as plt
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.io import gmshio
from matplotlib.collections import PolyCollection
from mpi4py import MPI

import dolfinx_impact as di

comm = MPI.COMM_WORLD
E, nu, R, P, size = 207e9, 0.3, 0.46, 4e6, 0.15  # [Pa], [1], radius [m], load per length [N/m], of the block [m]
hertz = di.theory.hertz_line(P, R, np.inf, E, nu, E, nu)
a = hertz.half_width

# ## Mesh
#
# By symmetry a quarter of the cylinder and half of the block are enough. gmsh makes one mesh of both. They are separate
# surfaces, so they have separate nodes where they touch. A ball with small triangles surrounds the contact.

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
if comm.rank == 0:
    disc, square = gmsh.model.occ.addDisk(0, R, 0, R, R), gmsh.model.occ.addRectangle(0, 0, 0, R, R)
    cylinder = gmsh.model.occ.intersect([(2, disc)], [(2, square)])[0][0][1]
    block = gmsh.model.occ.addRectangle(0, -size, 0, size, size)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [cylinder, block], 1)
    ball = gmsh.model.mesh.field.add("Ball")
    for name, value in {"Radius": 1.5 * a, "Thickness": R, "VIn": a / 16, "VOut": R / 5}.items():
        gmsh.model.mesh.field.setNumber(ball, name, value)
    gmsh.model.mesh.field.setAsBackgroundMesh(ball)
    for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.model.mesh.generate(2)
domain = gmshio.model_to_mesh(gmsh.model, comm, 0, gdim=2)[0]
gmsh.finalize()

surfaces = {
    1: lambda x: np.isclose(np.hypot(x[0], x[1] - R), R),  # slave
    2: lambda x: np.isclose(x[1], 0.0),  # master
    3: lambda x: np.isclose(x[1], R),  # where the load acts
}
found = [mesh.locate_entities_boundary(domain, 1, where) for where in surfaces.values()]
facets, tags = np.concatenate(found), np.repeat([1, 2, 3], [len(f) for f in found]).astype(np.int32)
facet_tags = mesh.meshtags(domain, 1, np.sort(facets), tags[np.argsort(facets)])

# ## The problem
#
# The block stands on its lower side. The cylinder is held by the contact alone, apart from symmetry.

V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
u = fem.Function(V, name="displacement")


def fixed(axis, where):
    """Zero displacement along an axis."""
    facets = mesh.locate_entities_boundary(domain, 1, where)
    return fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(axis), 1, facets), V.sub(axis))


bcs = [fixed(0, lambda x: np.isclose(x[0], 0.0)), fixed(1, lambda x: np.isclose(x[1], -size))]
steel = di.LinearElastic(E=E, nu=nu, hypothesis="plane_strain")
load = di.Traction(facet_tags, 3, (0.0, -P / (2 * R)))
pair = di.ContactPair(facet_tags, slave=1, master=2)
problem = di.StaticProblem(u, steel, bcs=bcs, loads=[load], contact=[di.Lagrange(pair)])
report = problem.solve()
contact = problem.contact[0]

# ## Comparison

parts = comm.gather((contact.points[:, 0], contact.pressure))
W = fem.functionspace(domain, ("DG", 0))
stress = ufl.dev(steel.stress(u))
mises = fem.Function(W)
mises.interpolate(fem.Expression(ufl.sqrt(1.5 * ufl.inner(stress, stress)), W.element.interpolation_points()))
corners = domain.geometry.x[domain.geometry.dofmap[: domain.topology.index_map(2).size_local], :2]
peak = comm.allreduce(float(np.max(contact.pressure, initial=0)), MPI.MAX)
print(report.iterations, peak/hertz.peak_pressure, contact.area/a, contact.force[1]*2/P, V.dofmap.index_map.size_global*2)
