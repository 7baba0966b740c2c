# SPDX-License-Identifier: MIT
"""Mesh of a quarter of a shaft in a ring that is too small for it; not one of the package's recipes."""

import math

import numpy as np
from mpi4py import MPI

from dolfinx_impact import compat
from dolfinx_impact.meshes import NAMES, RecipeMesh
from dolfinx_impact.meshes.gmsh_model import generate, session
from dolfinx_impact.meshes.layout import Layout, at


def _on_circle(radius):
    return lambda x: x * (radius / np.linalg.norm(x, axis=1))[:, None]


def shaft_in_ring(radius, outer, overlap, num_shaft, num_ring, degree):
    """Shaft (slave) of `radius` + `overlap` in a ring (master) from `radius` to `outer`; num_...: cells along the
    quarter; symmetry planes symmetry_x (x = 0) and bottom (y = 0)."""
    layout = Layout(2, outer)
    master, slave = layout.body("master_body"), layout.body("slave_body")
    r, s = radius + overlap, math.sqrt(0.5)
    h = math.pi / 2 * radius / num_shaft
    places = {"o": (0, 0), "a": (r / 2, 0), "m": (0.4 * r, 0.4 * r), "e": (0, r / 2), "A": (r, 0), "B": (s * r, s * r)}
    p = {name: slave.point(x, h) for name, x in {**places, "C": (0, r)}.items()}
    for corners in ("oame", "aABm", "mBCe"):
        slave.block(*(p[k] for k in corners))
    b, c = radius, outer
    h = math.pi / 2 * radius / num_ring
    inner = {"A": (b, 0), "B": (s * b, s * b), "C": (0, b)}
    q = {name: master.point(x, h) for name, x in inner.items()}
    q |= {name: master.point(x, 2 * h) for name, x in {"D": (c, 0), "E": (s * c, s * c), "F": (0, c)}.items()}
    for corners in ("ADEB", "BEFC"):
        master.block(*(q[k] for k in corners))
    for i, j in ("AB", "BC"):
        for body, points, name in ((slave, p, "slave_surface"), (master, q, "master_surface")):
            body.arc(points[i], points[j], (0, 0))
            body.facet(name, points[i], points[j])
    for i, j in ("DE", "EF"):
        master.arc(q[i], q[j], (0, 0))
    for body in (master, slave):
        body.tag("symmetry_x", at(0, 0.0))
        body.tag("bottom", at(1, 0.0))
    layout.snap |= {"slave_surface": _on_circle(r), "master_surface": _on_circle(b)}
    with session("shaft_in_ring") as model:
        generate(layout, "quadrilateral", degree)
        domain, cells, facets = compat.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=2)
    return RecipeMesh("shaft_in_ring", domain, cells, facets, {}, NAMES)
