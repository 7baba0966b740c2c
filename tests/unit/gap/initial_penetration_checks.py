# SPDX-License-Identifier: MIT
"""Initial penetration: surfaces before the first load step, on the ranks of COMM_WORLD; see on_ranks.py."""

import logging

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD
METHODS = (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e5))


class Square:
    """Unit square or cube; its bottom (tag 3) may come into contact, its top (tag 4) is fixed."""

    def __init__(self, dim=2, n=4):
        create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
        kind = mesh.CellType.quadrilateral if dim == 2 else mesh.CellType.hexahedron
        self.mesh = create(COMM, *[n] * dim, kind)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (dim,)))
        parts = [
            mesh.locate_entities_boundary(self.mesh, dim - 1, lambda x, v=v: np.isclose(x[dim - 1], v)) for v in (0, 1)
        ]
        facets = np.concatenate(parts)
        order = np.argsort(facets)
        values = np.repeat(np.array([3, 4], dtype=np.int32), [len(p) for p in parts])
        self.tags = mesh.meshtags(self.mesh, dim - 1, facets[order], values[order])
        top = fem.locate_dofs_topological(self.V, dim - 1, self.tags.find(4))
        self.bc = fem.dirichletbc(np.zeros(dim), top, self.V)
        self.law = di.LinearElastic(1e3, 0.3, 1.0, "3d" if dim == 3 else "plane_strain")

    def problem(self, obstacle, method, slave=3, **options):
        pair = di.ContactPair(self.tags, slave, obstacle, **options)
        return di.StaticProblem(fem.Function(self.V), self.law, bcs=[self.bc], contact=[method(pair)])


def message(make):
    """Text of the ValueError, the same on all ranks; empty without."""
    try:
        make()
        text = ""
    except ValueError as e:
        text = str(e)
    assert all(t == text for t in COMM.allgather(text))
    return text


def check_wrong_side():
    """An obstacle with the wrong orientation is refused, and the error says what to change; others are accepted."""
    for dim in (2, 3):
        body = Square(dim)
        up, centre = np.eye(dim)[-1], np.full(dim, 0.5)
        for method in METHODS:
            for height in (-0.05, 0.0, 0.1):  # open, touching, penetrating
                plane = di.RigidPlane(height * up, -up)
                assert "must point out of the obstacle" in message(lambda: body.problem(plane, method))
                assert message(lambda: body.problem(di.RigidPlane(height * up, up), method)) == ""
            # The bottom of the body is near the top of a ball; as a hole the surface would face away from the slave.
            position = centre - 2.55 * up
            assert message(lambda: body.problem(di.RigidSphere(position, 2.05), method)) == ""
            assert "change the sign of the radius -2.05" in message(
                lambda: body.problem(di.RigidSphere(position, -2.05), method)
            )
            # The body is inside a wide bore.
            position = centre + 1.48 * up
            axis = (0, 0, 1) if dim == 2 else (0, 1, 0)
            assert message(lambda: body.problem(di.RigidCylinder(position, -2.0, axis), method)) == ""
            assert "if the body is inside it" in message(
                lambda: body.problem(di.RigidCylinder(position, 2.0, axis), method)
            )
        # A plane with the right normal that lies inside the body, as after a mistake in the units.
        assert "more than half of the thinner body (1.000e+00)" in message(
            lambda: body.problem(di.RigidPlane(0.6 * up, up), METHODS[0])
        )


def check_shared_nodes():
    """A node of both surfaces is found even if a rank has facets of neither; all ranks raise the same error."""
    domain = mesh.create_unit_square(COMM, 3, 3, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    parts = [mesh.locate_entities_boundary(domain, 1, lambda x, a=a: np.isclose(x[a], 0.0)) for a in (0, 1)]
    facets = np.concatenate(parts)
    order = np.argsort(facets)
    values = np.repeat(np.array([3, 4], dtype=np.int32), [len(p) for p in parts])
    pair = di.ContactPair(mesh.meshtags(domain, 1, facets[order], values[order]), 3, 4)
    assert "share 1 nodes, the first at [[0.0, 0.0]]" in message(lambda: pair.surfaces(V))


def check_deep_penetration():
    """A block deep inside the other one is refused; an overlap like that of a press fit is accepted."""
    for method in METHODS:
        for overlap, words in ((0.02, ""), (0.3, "more than half of the thinner body (5.000e-01)")):
            found = message(lambda: overlapping_blocks(overlap, method, search_distance=0.4))
            assert words in found and bool(words) == bool(found), found


def overlapping_blocks(overlap, method, down=0.0, **options):
    """Problem of two overlapping blocks; the bottom is fixed, the top is displaced downwards."""
    made = meshes.make(
        "two_blocks", COMM, lower=(1.4, 0.5), upper=(1.0, 0.5), lower_cells=(7, 4), upper_cells=(6, 4), gap=-overlap
    )  # fmt: skip
    domain, tags = made.mesh, made.tags
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    ends = [fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags[n])) for n in ("bottom", "top")]
    bcs = [fem.dirichletbc(np.array([0.0, y]), end, V) for end, y in zip(ends, (0.0, down))]
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], **options)
    law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
    return di.StaticProblem(fem.Function(V), law, bcs=bcs, contact=[method(pair)])


class Lines(logging.Handler):
    """Keeps the lines that are written to the log."""

    def __init__(self):
        super().__init__()
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


def check_reported_and_removed():
    """The overlap is reported. If it stays it causes forces; if it is removed, bodies at rest stay at rest."""
    overlap = 0.01
    rigid = Square()
    cases = [lambda m, **o: rigid.problem(di.RigidPlane((0, overlap), (0, 1)), m, **o)]
    cases.append(lambda m, **o: overlapping_blocks(overlap, m, **o))
    for make in cases:
        for method in METHODS:
            log = logging.getLogger("dolfinx_impact")
            log.addHandler(lines := Lines())
            forces = []
            for removed in (False, True):
                problem = make(method, remove_penetration=removed)
                contact = problem.contact[0]
                number = COMM.allreduce(len(contact.points), MPI.SUM)
                assert contact.initial.num_points == number
                assert abs(contact.initial_penetration - overlap) < 1e-14
                assert abs(contact.initial.where[1] - contact.points[:, 1].mean() if len(contact.points) else 0) < 0.02
                problem.solve()
                forces.append(contact.force[1])
                if removed:
                    assert np.all(np.abs(problem.u.x.array) < 1e-13) and np.all(np.abs(contact.gap) < 1e-13)
            log.removeHandler(lines)
            assert forces[0] > 1.0 and abs(forces[1]) < 1e-9, forces
            text = [line for line in lines.lines if "penetrate before anything is loaded" in line]
            assert len(text) == (2 if COMM.rank == 0 else 0)
            if COMM.rank == 0:
                assert f"{number} points penetrate" in text[0] and "1.000e-02 at (" in text[0]
                assert "removed" in text[1] and "removed" not in text[0]


def check_removed_then_pressed():
    """Bodies whose overlap was removed respond to further loads like bodies that just touch."""
    for method in METHODS:
        forces = []
        for overlap in (0.0, 1e-6):
            problem = overlapping_blocks(overlap, method, down=-0.01, remove_penetration=True)
            problem.solve()
            forces.append(problem.contact[0].force)
        change = np.abs(forces[1] - forces[0]).max() / np.abs(forces[0]).max()
        # With the overlap the force would change by 1e-6 of 0.01. The rest is due to the different geometry.
        assert change < 1e-5, change


def check_first_touch():
    """A round body that touches at one node under a force: the results on several ranks equal those on one."""
    results = []
    for comm in (COMM, MPI.COMM_SELF):
        m = meshes.make("cylinder_on_half_plane", comm, cell="triangle", radius=10.0, a=1.0, h=0.25, width=10.0,
                        height=10.0, coarse=4.0)  # fmt: skip
        V = fem.functionspace(m.mesh, ("Lagrange", 1, (2,)))
        supports = (("bottom", 0), ("bottom", 1), ("symmetry_x", 0))
        dofs = [fem.locate_dofs_topological(V.sub(axis), 1, m.facet_tags.find(m.tags[name])) for name, axis in supports]
        bcs = [fem.dirichletbc(0.0, d, V.sub(axis)) for d, (_, axis) in zip(dofs, supports)]
        load = di.Traction(m.facet_tags, m.tags["top"], (0.0, -10.0))
        pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"])
        law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
        problem = di.StaticProblem(fem.Function(V), law, bcs=bcs, loads=[load], contact=[di.Penalty(pair, 1e4)])
        problem.solve()
        contact = problem.contact[0]
        results.append([*contact.force, contact.area, comm.allreduce(np.max(contact.pressure, initial=0.0), MPI.MAX)])
    here, alone = np.array(results)
    assert abs(alone[1] - 100.0) < 1e-6 and alone[2] > 1.0
    # The same equations, summed and solved in another order; Newton's method ends at 1e-10 of the force.
    assert np.abs(here - alone).max() < 1e-8 * np.abs(alone).max(), (here, alone)
