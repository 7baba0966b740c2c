# SPDX-License-Identifier: MIT
"""Bad pairs are refused with a reason; obstacles know their gaps, normals and curvatures."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp


def square(y=0.0, tags=((3, 0.0), (4, 1.0))):
    """Unit square with tagged edges y = value, and its displacement space."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 4, 4, mesh.CellType.quadrilateral)
    parts = [mesh.locate_entities_boundary(domain, 1, lambda x, v=v: np.isclose(x[1], v)) for _, v in tags]
    facets, values = np.concatenate(parts), np.repeat([t for t, _ in tags], [len(p) for p in parts]).astype(np.int32)
    order = np.argsort(facets)
    return fem.functionspace(domain, ("Lagrange", 1, (2,))), mesh.meshtags(domain, 1, facets[order], values[order])


def test_pairs_that_make_no_sense():
    _, tags = square()
    with pytest.raises(ValueError, match="take GeneralContact, which knows self-contact"):
        di.ContactPair(tags, slave=3, master=3)
    with pytest.raises(ValueError, match="friction is -0.1"):
        di.ContactPair(tags, 3, 4, friction=-0.1)
    for bad in (float("nan"), float("inf")):
        with pytest.raises(ValueError, match="finite"):
            di.ContactPair(tags, 3, 4, friction=bad)
    with pytest.raises(TypeError, match="MeshTags"):
        di.ContactPair([3, 4], 3, 4)
    with pytest.raises(TypeError, match="integer"):
        di.ContactPair(tags, "slave", 4)
    ball = di.RigidSphere((0.0, 2.0), 1.0)
    for rigid in (ball, di.RigidBody(ball, mass=1.0)):
        with pytest.raises(TypeError, match="what is rigid is the master, and the deformable surface the slave"):
            di.ContactPair(tags, rigid, 3)
    with pytest.raises(ValueError, match="search_distance"):
        di.ContactPair(tags, 3, 4, search_distance=-1.0)
    for method in (di.Lagrange, di.Penalty):
        with pytest.raises(TypeError, match="ContactPair"):
            method(tags)
    pair = di.ContactPair(tags, 3, 4)
    for bad in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="penalty"):
            di.Penalty(pair, penalty=bad)
    with pytest.raises(TypeError, match="penalty"):
        di.Penalty(pair, penalty="large")


def test_surfaces_that_do_not_fit_the_mesh():
    V, tags = square()
    with pytest.raises(ValueError, match="no facet carries the tag 7"):
        di.ContactPair(tags, 7, 4).surfaces(V)
    V, tags = square(tags=((3, 0.0), (4, 0.5)))
    everywhere = mesh.locate_entities(V.mesh, 1, lambda x: np.isclose(x[1], 0.5))
    inner = mesh.meshtags(V.mesh, 1, np.sort(everywhere), np.full(len(everywhere), 4, dtype=np.int32))
    with pytest.raises(ValueError, match="inside the body"):
        di.ContactPair(inner, 4, di.RigidPlane((0, 0), (0, 1))).surfaces(V)


def test_shared_nodes_are_named():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    bottom = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    left = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], 0.0))
    facets, values = np.concatenate([bottom, left]), np.repeat([3, 4], [2, 2]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, 1, facets[order], values[order])
    with pytest.raises(ValueError, match=r"share 1 nodes, the first at \[\[0\.0, 0\.0\]\]"):
        di.ContactPair(tags, 3, 4).surfaces(V)


def test_obstacles_that_make_no_sense():
    with pytest.raises(ValueError, match="normal is zero"):
        di.RigidPlane((0, 0), (0, 0))
    with pytest.raises(ValueError, match="radius"):
        di.RigidSphere((0, 0, 0), 0.0)
    with pytest.raises(TypeError, match="center"):
        di.RigidSphere("origin", 1.0)
    with pytest.raises(ValueError, match="finite"):
        di.RigidCylinder((0, np.nan), 1.0)
    plane = di.RigidPlane((0, 0, 0), (0, 1, 1))
    with pytest.raises(ValueError, match="third component"):
        plane.obstacle(2)
    with pytest.raises(ValueError, match="two or three components"):
        plane.displacement = (1.0,)


@pytest.mark.parametrize("gdim", (2, 3))
@pytest.mark.parametrize("kind", ("plane", "sphere", "cylinder", "bore"))
def test_gaps_of_obstacles_and_their_derivatives(kind, gdim, rng):
    """First and second derivatives against central differences: step 1e-5, errors of its square and of 1e-16/step."""
    axis = np.array([0.0, 0.0, 1.0]) if gdim == 2 else np.array([0.48, 0.6, 0.64])
    radius = -1.5 if kind == "bore" else 1.5
    obstacle = _cpp.gap.Rigid(
        "cylinder" if kind == "bore" else kind,
        gdim,
        [0.1, 0.2, 0.0 if gdim == 2 else 0.3],
        ([0.6, 0.8, 0.0] if kind == "plane" else axis.tolist()),
        0.0 if kind == "plane" else radius,
    )
    obstacle.displacement = [0.05, -0.02, 0.0]
    x, h = rng.uniform(-1, 1, size=gdim) + 0.7, 1e-5
    gap, normal, hessian = (a[0] for a in obstacle.evaluate(x))
    steps = h * np.eye(gdim)
    up, down = (obstacle.evaluate((x + s * steps).ravel()) for s in (1, -1))
    assert np.isclose(np.linalg.norm(normal), 1.0, rtol=1e-14)
    assert np.allclose((up[0] - down[0]) / (2 * h), normal, atol=1e-9)
    assert np.allclose((up[1] - down[1]) / (2 * h), hessian, atol=1e-9)
    centre = np.array([0.15, 0.18, 0.0 if gdim == 2 else 0.3])[:gdim]
    d = x - centre
    if kind in ("cylinder", "bore") and gdim == 3:
        d = d - axis * (axis @ d)
    distance = np.linalg.norm(d)
    expected = {"plane": d @ np.array([0.6, 0.8, 0.0])[:gdim], "bore": 1.5 - distance}.get(kind, distance - 1.5)
    assert np.isclose(gap, expected, rtol=1e-13)
