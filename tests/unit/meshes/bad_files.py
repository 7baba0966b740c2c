# SPDX-License-Identifier: MIT
"""Bad mesh files, written by hand, and the words an error about each must contain."""

from pathlib import Path

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
QUADS = [(3, 1, (1, 2, 3, 4)), (3, 1, (2, 5, 6, 3))]
LINES = [(1, 3, (1, 2)), (1, 3, (2, 5)), (1, 4, (3, 4))]


def msh(path, nodes=SQUARE, elements=(*QUADS, *LINES), names=((2, 1, "body"), (1, 3, "low"), (1, 4, "high"))):
    """Write a gmsh 2.2 file; elements are (type, physical tag, nodes), each tag its own entity."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if names:
        lines += ["$PhysicalNames", f"{len(names)}", *(f'{d} {t} "{n}"' for d, t, n in names), "$EndPhysicalNames"]
    lines += ["$Nodes", f"{len(nodes)}"]
    lines += [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(nodes)] + ["$EndNodes", "$Elements"]
    lines += [f"{len(elements)}"]
    for i, (kind, tag, members) in enumerate(elements):
        lines.append(f"{i + 1} {kind} 2 {tag} {tag + 10} " + " ".join(map(str, members)))
    Path(path).write_text("\n".join([*lines, "$EndElements", ""]))
    return path


def moved(node, x):
    nodes = list(SQUARE)
    nodes[node - 1] = x
    return nodes


NINE = [(x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (0.98, 0), (1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0.5))]
MESHES = {
    "inverted": (
        {"nodes": moved(6, (0.5, 0.5, 0))},
        {},
        ["1 cells of 2", "(gmsh element 2), centre (1.125, 0.375)", '1 ("body")', "folded"],
    ),
    "bow_tie": ({"elements": [QUADS[0], (3, 1, (2, 5, 3, 6))]}, {}, ["folded", "gmsh element 2", "centre (1.5, 0.5)"]),
    "flat": ({"nodes": [(x, 0, 0) for x, _, _ in SQUARE]}, {}, ["2 cells of 2", "zero volume", "det J zero"]),
    "repeated_node": ({"elements": [QUADS[0], (3, 1, (2, 5, 6, 6))]}, {}, ["zero volume", "gmsh element 2"]),
    "folded_inside": ({"nodes": NINE, "elements": [(10, 1, range(1, 10))]}, {}, ["folded", "1 cells of 1"]),
    "no_groups": (
        {"elements": [(3, 0, QUADS[0][2])], "names": ()},
        {},
        ["no physical group of dimension 2", "Physical Surface"],
    ),
    "only_facet_groups": (
        {"elements": [(3, 0, QUADS[0][2]), LINES[0]], "names": ()},
        {},
        ["no physical group of dimension 2", "there are 3 of dimension 1"],
    ),
    "no_cells": ({"elements": LINES}, {}, ["has no triangles", "mesh the surfaces"]),
    "missing_tag": ({}, {"required_facet_tags": (3, 7)}, ["facet tags [7]", '3 ("low"): 2', '4 ("high"): 1']),
    "missing_name": ({}, {"required_facet_tags": ("hub",)}, ["['hub']", '"low"']),
    "missing_cell_tag": ({}, {"required_cell_tags": (2,)}, ["cell tags [2]", '1 ("body"): 2']),
    "not_plane": ({"nodes": moved(6, (2, 1, 0.3))}, {"gdim": 2}, ["gdim = 2, but z goes from 0 to 0.3"]),
    "mixed": ({"elements": [QUADS[0], (2, 1, (2, 5, 6))]}, {}, ["mixed", "Quadrilateral 4", "Triangle 3"]),
    "mixed_groups": (
        {"elements": [QUADS[0], (2, 2, (2, 5, 6))], "names": ()},
        {},
        ["mixed cells", "1 of 'Triangle 3'"],
    ),
    "serendipity": (
        {"nodes": NINE, "elements": [(16, 1, range(1, 9))]},
        {},
        ["Quadrilateral 8", "SecondOrderIncomplete"],
    ),
    "facet_twice": ({"elements": [*QUADS, LINES[0], (1, 4, (1, 2))]}, {}, ["tag a facet once"]),
    "facet_astray": ({"elements": [*QUADS, (1, 3, (1, 6))]}, {}, ['3 ("low")', "only 0 are facets"]),
    "nan": ({"nodes": moved(6, ("nan", 1, 0))}, {}, ["nodes [6]", "nan"]),
    "lost_node": ({"elements": [QUADS[0], (3, 1, (2, 5, 66, 3))]}, {}, ["gmsh cannot read it"]),
}


def write_all(folder, committed_mesh):
    """Write every bad file; name -> (path, keyword arguments of read_mesh, error type, words)."""
    folder, cases = Path(folder), {}
    for name, (contents, arguments, words) in MESHES.items():
        cases[name] = (msh(folder / f"{name}.msh", **contents), arguments, ValueError, words)
    good = Path(committed_mesh).read_bytes()

    def raw(name, data, words, arguments={}):
        (folder / name).write_bytes(data)
        cases[name] = (folder / name, arguments, ValueError, words)

    raw("empty.msh", b"", ["is empty"])
    raw("picture.msh", b"\x89PNG\r\n\x1a\n0000", ["not a gmsh mesh", "instead of $MeshFormat"])
    raw("geometry.msh", good[: good.index(b"$Nodes")], ["no section $Nodes", "mesh the geometry"])
    for share in (0.2, 0.5, 0.8, 0.99):
        raw(f"cut_{share}.msh", good[: int(share * len(good))], ["cut off"])
    lines = good.split(b"\n")
    start, end = lines.index(b"$Elements"), lines.index(b"$EndElements")
    raw("lines_lost.msh", b"\n".join(lines[: start + 3] + lines[end - 3 :]), ["lines_lost.msh"])
    raw("solid_as_plane.msh", good, ["gdim = 2, but the cells are three-dimensional"], {"gdim": 2})
    raw("mesh.stl", b"solid", ["a .msh (gmsh) or an .xdmf"])
    raw("broken.xdmf", b"<Xdmf><Domain>", ["not an XDMF file, or cut off"])
    raw("no_grid.xdmf", b"<Xdmf><Domain/></Xdmf>", ["no grid with cells"])
    cases["missing.msh"] = (folder / "missing.msh", {}, FileNotFoundError, ["no such file", "empty.msh"])
    cases["bad_gdim"] = (folder / "inverted.msh", {"gdim": 5}, ValueError, ["gdim = 5"])
    return cases
