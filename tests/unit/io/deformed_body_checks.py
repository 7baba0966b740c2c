# SPDX-License-Identifier: MIT
"""Pictures of fields on deformed bodies. See on_ranks.py."""

import re

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from matplotlib.collections import PolyCollection
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.io import plots

COMM = MPI.COMM_WORLD
STRETCH = np.array([0.2, -0.1, 0.3])


def body(cell, degree=1):
    """A unit square or cube, stretched."""
    plane, kind = cell in ("triangle", "quadrilateral"), getattr(mesh.CellType, cell)
    domain = mesh.create_unit_square(COMM, 3, 2, kind) if plane else mesh.create_unit_cube(COMM, 2, 2, 1, kind)
    gdim = domain.geometry.dim
    u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (gdim,))), name="u")
    u.interpolate(lambda x: STRETCH[:gdim, None] * x[:gdim])
    return u


def field_of(u, kind):
    """A field in each of the ways that one can be given, from 0 to 2 but for the constant in each cell."""
    domain = u.function_space.mesh
    x = ufl.SpatialCoordinate(domain)
    zero = fem.Function(fem.functionspace(domain, ("Lagrange", 1)))
    spaces = {"vertices": ("Lagrange", 1), "degree of u": ("Lagrange", u.function_space.element.basix_element.degree)}
    if kind == "expression":
        return 2 * x[0] + zero
    if kind == "constant in cells":
        f = fem.Function(fem.functionspace(domain, ("DG", 0)))
        f.interpolate(lambda x: 2 * x[0])
        return f
    f = fem.Function(fem.functionspace(domain, spaces[kind]))
    f.interpolate(lambda x: 2 * x[0])
    return f


def area(polygons):
    """Sum of the areas of polygons."""
    x, y = np.moveaxis(np.asarray(polygons), -1, 0)
    return 0.5 * np.sum(np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)))


def check_plane_bodies():
    """Cells, values and axes of every kind of cell, degree and field."""
    cases = [("triangle", 1, "vertices"), ("quadrilateral", 1, "constant in cells"), ("triangle", 2, "degree of u")]
    cases += [("quadrilateral", 2, "expression"), ("quadrilateral", 2, "vertices")]
    for cell, degree, kind in cases:
        u = body(cell, degree)
        picture = di.DeformedBody(u, field_of(u, kind), scale=2.0)
        low, high = (1 / 3, 5 / 3) if kind == "constant in cells" else (0.0, 2.0)
        assert picture.limits == (pytest.approx(low, abs=0.12), pytest.approx(high, abs=0.12))
        if COMM.rank > 0:
            continue
        figure, axes = plots.pyplot().subplots()
        mappable = picture.draw(axes, "value [-]", factor=10.0, lengths=100.0, unit="cm")
        polygons = [c for c in axes.collections if isinstance(c, PolyCollection) and c.get_paths()][-1].get_paths()
        outlines = np.array([p.vertices[:-1] for p in polygons])
        assert area(outlines) == pytest.approx(1.4 * 0.8 * 1e4, rel=1e-12)  # of the body, stretched twice as much
        assert axes.get_xlim()[1] >= 140.0 and axes.get_xlabel() == "x [cm]"
        assert (mappable.norm.vmin, mappable.norm.vmax) == tuple(10.0 * limit for limit in picture.limits)
        assert [a.get_ylabel() for a in figure.axes if a is not axes] == ["value [-]"]
        plots.pyplot().close(figure)


def check_bodies_in_space():
    """The grid that PyVista draws; and a picture of one."""
    for cell, degree, kind in (("hexahedron", 1, "constant in cells"), ("tetrahedron", 2, "vertices")):
        u = body(cell, degree)
        picture = di.DeformedBody(u, field_of(u, kind))
        if COMM.rank == 0:
            grid = picture._grid(3.0)
            assert grid.bounds == pytest.approx([0, 1.2, 0, 0.9, 0, 1.3])
            values = grid.cell_data["value"] if kind == "constant in cells" else grid.point_data["value"]
            assert values.max() == pytest.approx(3.0 * picture.limits[1])
    with shared_folder() as path:
        picture.save(path / "body.png", "value [-]", title="a body", size=(300, 200))
        if COMM.rank == 0:
            image = plots.pyplot().imread(path / "body.png")
            assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 50  # more than axes and a bar


def check_fields_of_problems():
    """Von Mises' stress at the quadrature points, and the length of the displacement."""
    u = body("quadrilateral")
    problem = di.StaticProblem(u, di.LinearElastic(1.0, 0.0, hypothesis="plane_strain"))
    a, b = STRETCH[:2]  # strains, and with Poisson's ratio 0 stresses
    mises = np.sqrt(a**2 - a * b + b**2)
    assert di.DeformedBody(u, problem.von_mises).limits == pytest.approx((mises, mises), rel=1e-12)
    assert di.DeformedBody(u).limits == pytest.approx((0.0, np.hypot(a, b)), rel=1e-12)


def check_what_is_refused():
    u, other = body("triangle"), body("triangle")
    scalar = fem.Function(fem.functionspace(u.function_space.mesh, ("Lagrange", 1)))
    cubic = fem.Function(fem.functionspace(u.function_space.mesh, ("Lagrange", 3)))
    problem = di.StaticProblem(u, di.LinearElastic(1.0, 0.0, hypothesis="plane_strain"))
    for given, kind, words in (
        ((3.0,), TypeError, "u must be a Function of dolfinx.fem, found float"),
        ((scalar,), ValueError, "u must be a displacement"),
        ((body("triangle", 3),), ValueError, "degree 3: interpolate it"),
        ((u, 3.0), TypeError, "field must be a function, problem.von_mises or a UFL expression, found float"),
        ((u, ufl.grad(u)), ValueError, r"field has the shape \(2, 2\): give a number"),
        ((u, problem.stress), ValueError, "stress has 4 components"),
        ((u, other), ValueError, "field is on another mesh than u"),
        ((u, cubic), ValueError, "field is of degree 3.*give others as expressions"),
    ):
        with pytest.raises(kind, match=re.compile(words, re.DOTALL)):
            di.DeformedBody(*given)
