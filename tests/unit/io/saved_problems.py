# SPDX-License-Identifier: MIT
"""Problems whose checkpoints are kept in the folder format_11, as the version that made them wrote them."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes


def rectangles(comm):
    """A block above a longer one, of few cells."""
    size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (4, 2), "upper_cells": (3, 2)}
    return meshes.make("two_blocks", comm, gap=1e-3, **size)


def parts(comm, law):
    """Arguments of a problem without contact, and the contact pair."""
    made = rectangles(comm)
    tags, V = made.tags, fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    nodes = np.unique(V.dofmap.list[made.cell_tags.find(tags["slave_body"])].ravel())
    v.x.array.reshape(-1, 2)[nodes] = (0.5, -0.4)
    v.x.scatter_forward()
    bottom = fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags["bottom"]))
    base = fem.dirichletbc(np.array([0.0, 0.002]), bottom, V)
    given = {
        "u": u, "velocity": v, "damping": di.Rayleigh(0.1, 0.0),
        "bcs": [di.PrescribedMotion(base, (np.array([0.0, 1.0]), np.array([0.0, 1.0])))],
        "loads": [di.BodyForce((0.0, -9.81), amplitude=(np.array([0.0, 1.0]), np.array([0.0, 1.0])))],
        "material": law,
    }  # fmt: skip
    return given, di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=0.3)


def elastic(kind=di.NeoHookean):
    return kind(1e3, 0.3, 1.0, "plane_strain")


def plastic():
    return di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=5.0, hardening=100.0, hypothesis="plane_strain")


def explicit_penalty(comm=MPI.COMM_SELF):
    given, pair = parts(comm, elastic())
    return di.ExplicitProblem(**given, contact=[di.Penalty(pair)])


def explicit_kinematic(comm=MPI.COMM_SELF):
    given, pair = parts(comm, plastic())
    return di.ExplicitProblem(**given, contact=[di.Kinematic(pair)])


def implicit_multipliers(comm=MPI.COMM_SELF):
    given, pair = parts(comm, elastic())
    return di.NewmarkProblem(**given, contact=[di.Lagrange(pair)])


def implicit_penalty(comm=MPI.COMM_SELF):
    given, pair = parts(comm, plastic())
    return di.NewmarkProblem(**given, contact=[di.Penalty(pair, augmented=True, tolerance=1e-6)])


EXPLICIT = (explicit_penalty, explicit_kinematic)
IMPLICIT = (implicit_multipliers, implicit_penalty)


def run_and_save(make, path):
    """Run until bodies are in contact, and save inside of a call of advance if the problem is explicit."""
    problem = make()
    if make in EXPLICIT:

        def keep(p):
            if p.contact[0].dissipated > 0.0 and not path.exists():
                p.save(path)

        problem.advance(120 * problem.stable_step(), callback=keep, progress=False)
    else:
        problem.advance(0.04, 0.002, progress=False)
        problem.save(path)
    assert problem.contact[0].dissipated > 0.0
