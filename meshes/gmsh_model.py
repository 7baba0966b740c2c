# SPDX-License-Identifier: MIT
"""From a block layout to a meshed gmsh model with named physical groups; the only file that calls gmsh."""

from collections import Counter
from contextlib import contextmanager

import gmsh
import numpy as np

from .tags import BODIES, FACETS


OPTIONS = {
    "General.Terminal": 0,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.SecondOrderIncomplete": 0,  # 9 and 27 nodes
    "Mesh.RandomSeed": 1,
    "Mesh.OptimizeThreshold": 0.6,  # fewer flat tetrahedra than with gmsh's 0.3
    "Mesh.MshFileVersion": 4.1,
    "Mesh.Binary": 0,
    "Mesh.SaveAll": 0,
}


@contextmanager
def session(name):
    """A gmsh model of our own; an open session of the caller keeps its current model and its options."""
    before = bool(gmsh.isInitialized())
    current = gmsh.model.getCurrent() if before else None
    if not before:
        gmsh.initialize(interruptible=False)
    options = {key: gmsh.option.getNumber(key) for key in OPTIONS}
    for key, value in OPTIONS.items():
        gmsh.option.setNumber(key, value)
    gmsh.model.add(name)
    try:
        yield gmsh.model
    finally:
        gmsh.model.remove()
        for key, value in options.items():
            gmsh.option.setNumber(key, value)
        if not before:
            gmsh.finalize()
        elif current:
            gmsh.model.setCurrent(current)


def generate(layout, cell, degree):
    """Build and mesh the layout in the current gmsh model; `cell` is a DOLFINx cell name, `degree` 1 or 2."""
    dim, structured = layout.dim, cell in ("quadrilateral", "hexahedron")
    simplices_follow = layout.structured and not structured
    geo = gmsh.model.geo

    def as_3d(x):
        return (*x, 0.0) if dim == 2 else tuple(x)

    points = [geo.addPoint(*as_3d(x), s) for x, s in zip(layout.points, layout.sizes)]
    centres = {}

    def centre_of(x):
        key = tuple(np.round(x / layout.tolerance).astype(np.int64))
        if key not in centres:
            centres[key] = geo.addPoint(*as_3d(x))
        return centres[key]

    lines = {}
    for (p, q), (number, first, last) in layout.divisions().items():
        centre = layout.arcs.get(frozenset((p, q)))
        if centre is None:
            line = geo.addLine(points[p], points[q])
        else:
            line = geo.addCircleArc(points[p], centre_of(centre), points[q])
        lines[(p, q)] = line
        if structured or simplices_follow:
            fixed = (p, q) in layout.cells
            ratio = 1.0 if number == 1 or fixed else (last / first) ** (1.0 / (number - 1))
            geo.mesh.setTransfiniteCurve(line, number + 1, "Progression", ratio)

    def loop(corners):
        pairs = zip(corners, corners[1:] + corners[:1])
        return geo.addCurveLoop([lines[(p, q)] if p < q else -lines[(q, p)] for p, q in pairs])

    surfaces = {}

    def surface(corners):
        key = frozenset(corners)
        if key not in surfaces:
            if dim == 2 and signed_area(layout.points, corners) < 0:
                corners = corners[::-1]
            if dim == 2 or is_plane(layout, corners):
                surfaces[key] = geo.addPlaneSurface([loop(corners)])
            else:
                centre = layout.spheres.get(key)
                surfaces[key] = geo.addSurfaceFilling(
                    [loop(corners)], sphereCenterTag=-1 if centre is None else centre_of(centre)
                )
            if structured or simplices_follow:
                geo.mesh.setTransfiniteSurface(surfaces[key], cornerTags=[points[p] for p in corners])
                if structured:
                    geo.mesh.setRecombine(2, surfaces[key])
        return surfaces[key]

    members = {}
    for body in layout.bodies:
        entities = members.setdefault(body.name, [])
        if dim == 3 and not structured and not simplices_follow:
            # Free tetrahedra do without the faces between blocks: one volume inside the body's own skin.
            faces = [face for block in body.blocks for face in layout.faces_of(block)]
            owners = Counter(frozenset(face) for face in faces)
            skin = [surface(tuple(face)) for face in faces if owners[frozenset(face)] == 1]
            entities.append(geo.addVolume([geo.addSurfaceLoop(skin)]))
            continue
        for block in body.blocks:
            faces = [surface(tuple(corners)) for corners in layout.faces_of(block)]
            if dim == 2:
                entities.append(faces[0])
                continue
            entities.append(geo.addVolume([geo.addSurfaceLoop(faces)]))
            if structured or simplices_follow:
                geo.mesh.setTransfiniteVolume(entities[-1], [points[p] for p in block])
    geo.synchronize()
    groups = {}
    for name, entities in members.items():
        groups[name] = gmsh.model.addPhysicalGroup(dim, entities, BODIES[name], name)
    for name, facets in layout.outer_facets().items():
        entities = [surfaces[frozenset(c)] if dim == 3 else lines[(min(c), max(c))] for c in facets]
        groups[name] = gmsh.model.addPhysicalGroup(dim - 1, entities, FACETS[name], name)

    gmsh.model.mesh.generate(dim)
    if simplices_follow and dim == 3:
        match_diagonals(surfaces.values())
    move_bodies(dim, layout, groups, True)
    if degree > 1:
        gmsh.model.mesh.setOrder(degree)
    move_bodies(dim, layout, groups, False)
    for name, function in layout.snap.items():
        if name in groups:
            move(dim - 1, [groups[name]], function)
    check_cells(dim)
    cell_nodes_first(dim)


def check_cells(dim):
    """Raise RuntimeError if a cell is folded; gmsh curves free simplices at a coarse boundary without looking."""
    cells = np.concatenate(gmsh.model.mesh.getElements(dim)[1])
    bounds = [np.array(gmsh.model.mesh.getElementQualities(cells, name)) for name in ("minDetJac", "maxDetJac")]
    folded = np.flatnonzero(bounds[0] * bounds[1] <= 0)
    if len(folded):
        node = gmsh.model.mesh.getElement(cells[folded[0]])[1][0]
        x = ", ".join(f"{v:.4g}" for v in gmsh.model.mesh.getNode(node)[0])
        raise RuntimeError(f"{len(folded)} of {len(cells)} cells are folded, one at ({x}); take smaller cells there")


def cell_nodes_first(dim):
    """Number the nodes of the cells before those of no cell (centres of arcs): DOLFINx aborts otherwise."""
    nodes = gmsh.model.mesh.getNodes()[0]
    used = np.unique(np.concatenate(gmsh.model.mesh.getElements(dim)[2]))
    gmsh.model.mesh.renumberNodes(np.concatenate([used, np.setdiff1d(nodes, used)]), np.arange(1, len(nodes) + 1))


def match_diagonals(surfaces):
    """Turn the diagonals of transfinite surfaces whose triangles are not faces of the structured tetrahedra."""
    for arrangement in ("Right", "Left"):  # which one turns a diagonal is not the same in all versions of gmsh
        tets = np.sort(gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4), axis=1)
        faces = {tuple(face) for skip in range(4) for face in np.delete(tets, skip, axis=1)}
        triangles = {tag: np.sort(gmsh.model.mesh.getElementsByType(2, tag)[1].reshape(-1, 3)) for tag in surfaces}
        wrong = [tag for tag, rows in triangles.items() if any(tuple(row) not in faces for row in rows)]
        if not wrong:
            return
        gmsh.model.mesh.clear()
        for tag in wrong:
            gmsh.model.mesh.setTransfiniteSurface(tag, arrangement)
        gmsh.model.mesh.generate(3)


def move_bodies(dim, layout, groups, straight):
    """Move the nodes of the bodies by their maps. A node that bodies with the same map share moves once."""
    maps = {}
    for body in layout.bodies:
        for function, of_vertices in body.maps:
            if of_vertices == straight:
                maps.setdefault(function, []).append(groups[body.name])
    for function, of in maps.items():
        move(dim, list(dict.fromkeys(of)), function)


def move(dim, groups, function):
    """Move the nodes of physical groups: x -> function(x), arrays of shape (n, 3)."""
    found = [gmsh.model.mesh.getNodesForPhysicalGroup(dim, group) for group in groups]
    nodes, x = (np.concatenate(parts) for parts in zip(*found))
    nodes, unique = np.unique(nodes, return_index=True)
    x = x.reshape(-1, 3)[unique]
    for node, old, new in zip(nodes, x, function(x.copy())):
        if not np.array_equal(old, new):
            gmsh.model.mesh.setNode(node, new, [])


def signed_area(points, corners):
    """Shoelace area of a polygon in 2D."""
    x = np.array([points[p] for p in corners])
    return 0.5 * float(np.sum(x[:, 0] * np.roll(x[:, 1], -1) - np.roll(x[:, 0], -1) * x[:, 1]))


def is_plane(layout, corners):
    """Whether a face in 3D, with the centres of its arcs, lies in one plane."""
    x = [layout.points[p] for p in corners]
    for p, q in zip(corners, corners[1:] + corners[:1]):
        if frozenset((p, q)) in layout.arcs:
            x.append(layout.arcs[frozenset((p, q))])
    x = np.array(x) - x[0]
    values = np.linalg.svd(x, compute_uv=False)
    return values[2] <= 1e-9 * values[0]
