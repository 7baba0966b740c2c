# SPDX-License-Identifier: MIT
"""A body on a mesh recipe with supports, loads and one contact, and the checks every result of contact must pass."""

import math

import numpy as np
from dolfinx import default_scalar_type, fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

METHODS = ("Lagrange", "Penalty")


def enforce(method, pair, **options):
    """A contact by the method's name; penalties are augmented where the answer must not depend on them."""
    return getattr(di, method)(pair, **options)


class Model:
    """Mesh, displacement space and the pieces of a StaticProblem.

    Args:
        recipe: name of a mesh recipe, or a RecipeMesh. law: material, or dict of body name -> material.
        degree: of displacements and geometry. parameters: of the recipe.
    """

    def __init__(self, recipe, law, degree=1, **parameters):
        if isinstance(recipe, str):
            recipe = meshes.make(recipe, MPI.COMM_SELF, degree=degree, **parameters)
        self.mesh, self.facets, self.cells, self.tags = recipe.mesh, recipe.facet_tags, recipe.cell_tags, recipe.tags
        self.gdim = self.mesh.geometry.dim
        if isinstance(law, dict):
            law = di.MaterialMap(recipe.cell_tags, {self.tags[name]: m for name, m in law.items()})
        self.law = law
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (self.gdim,)))
        self.u = fem.Function(self.V, name="u")
        self.bcs, self.loads = [], []

    def dofs(self, name, component):
        return fem.locate_dofs_topological(self.V.sub(component), self.gdim - 1, self.facets.find(self.tags[name]))

    def hold(self, name, *components, value=0.0):
        """Prescribe components of the displacement on a surface; returns the constant, to be changed between solves."""
        constant = fem.Constant(self.mesh, default_scalar_type(value))
        for c in components or range(self.gdim):
            self.bcs.append(fem.dirichletbc(constant, self.dofs(name, c), self.V.sub(c)))
        return constant

    def hold_node(self, point, component):
        """Prescribe zero for one component of one node."""
        dofs = fem.locate_dofs_geometrical(
            (self.V.sub(component), self.V.sub(component).collapse()[0]),
            lambda x: np.linalg.norm(x[: self.gdim].T - np.asarray(point), axis=1) < 1e-9,
        )
        assert len(dofs[0]) == 1
        zero = fem.Function(self.V.sub(component).collapse()[0])
        self.bcs.append(fem.dirichletbc(zero, dofs, self.V.sub(component)))

    def pull(self, name, vector):
        """Traction on a surface."""
        self.loads.append(di.Traction(self.facets, self.tags[name], vector))
        return self.loads[-1]

    def pair(self, slave="slave_surface", master="master_surface", **options):
        """Contact pair of two surfaces by name; the master may be an obstacle."""
        master = self.tags[master] if isinstance(master, str) else master
        return di.ContactPair(self.facets, slave=self.tags[slave], master=master, **options)

    def problem(self, *contacts):
        return di.StaticProblem(self.u, self.law, bcs=self.bcs, loads=self.loads, contact=list(contacts))

    def at(self, point):
        """Displacement of the node at a point of the reference configuration."""
        x = self.V.tabulate_dof_coordinates()[:, : self.gdim]
        distance = np.linalg.norm(x - np.asarray(point), axis=1)
        assert distance.min() < 1e-9 * np.ptp(x)
        return self.u.x.array.reshape(-1, self.gdim)[np.argmin(distance)]

    def support(self, problem, name):
        """Total force of the supports on a surface."""
        r = problem.reactions().x.array
        return np.array([r[self.dofs(name, c)].sum() for c in range(self.gdim)])

    def places(self, contact):
        """Where contact points are in the reference configuration; nodes (Lagrange) or quadrature points (penalty).

        Small strain closed forms are functions of these."""
        if hasattr(contact, "nodes"):
            return self.V.tabulate_dof_coordinates()[contact.nodes, : self.gdim]
        return contact.points


def plane_approach(load, stiffness, depth, half_width):
    """Roughly how far a body of plane-strain modulus `stiffness` gives way under a line load: sets the displacements
    only, the loads are read from the result."""
    return load / (math.pi * stiffness) * (2 * math.log(2 * depth / half_width) - 1)


def tangential(contact):
    """Friction traction on the slave: traction less its normal part."""
    t, n = contact.traction, contact.normal
    return t - np.einsum("na,na->n", t, n)[:, None] * n


def assert_coulomb(contact, slipped=None):
    """|t| <= friction p everywhere, equal where it slips, nothing where it is open; forces of the two bodies opposite.

    Args:
        slipped: growth of `contact.slip` in the last solve, (n, gdim): against the traction where it slips, else zero.
    """
    p, t, status, friction = contact.pressure, tangential(contact), contact.status, contact.pair.friction
    size, top = np.linalg.norm(t, axis=1), p.max()
    slips, opened = status == di.ContactStatus.slip, status == di.ContactStatus.open
    # Newton's method ends at 1e-10 of the largest force; the law itself holds to round-off.
    assert np.all(p >= 0)
    assert np.all(size <= friction * p + 1e-10 * top)
    np.testing.assert_allclose(size[slips], friction * p[slips], rtol=0, atol=1e-10 * top)
    assert np.all(p[opened] == 0) and np.all(size[opened] == 0)
    if slipped is not None:
        length = np.linalg.norm(slipped, axis=1)
        # Displacements are known to about 1e-8 of what moved, where the residual is known to 1e-10 of the forces.
        still = 1e-8 * length.max() + 1e-12 * np.ptp(contact.points)
        along = np.einsum("na,na->n", slipped, t)
        np.testing.assert_allclose(along[slips], -(length * size)[slips], rtol=0, atol=still * top)
        assert length[status == di.ContactStatus.stick].max(initial=0.0) <= still
    if not contact.pair.rigid:
        f = contact.contact_forces().reshape(-1, t.shape[1])
        assert np.abs(f.sum(axis=0)).max() <= 1e-10 * np.abs(f).sum()
