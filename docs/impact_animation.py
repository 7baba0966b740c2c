# SPDX-License-Identifier: MIT
"""The impact that moves on the start page: `python3 docs/impact_animation.py [FILE]`, default docs/figures/impact.gif.

A ring of rubber is thrown obliquely on a beam that is clamped at both ends: explicit steps, penalty contact with
friction. The ring flattens, the beam gives way, and friction spins the ring while it bounces off.
"""

import io
import sys
from pathlib import Path

import basix.ufl
import matplotlib
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from PIL import Image

import dolfinx_impact as di

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

INNER, OUTER, HALF_LENGTH, HEIGHT = 0.03, 0.05, 0.15, 0.02  # of ring and beam [m]
GAP, VELOCITY = 2e-3, (6.0, -10.0)  # between ring and beam [m], of the ring [m/s]
RING, BEAM = 1, 2  # tags of cells
SLAVE, MASTER = 1, 2  # tags of facets: outside of the ring, upper side of the beam
FRAMES, STEP = 56, 0.5e-3  # number of pictures, time between them [s]
LARGEST = 1.0  # stress at the end of the colour bar [MPa]


def ring_on_beam(around=72, through=6, along=60, up=4):
    """Ring and beam in one mesh of quadrilaterals, on this rank: mesh, tags of cells and of facets."""
    angle = np.arange(around) * 2 * np.pi / around
    radius = np.linspace(INNER, OUTER, through + 1)
    ring = np.stack([np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle)) + OUTER + GAP], axis=2)
    x, y = np.linspace(-HALF_LENGTH, HALF_LENGTH, along + 1), np.linspace(-HEIGHT, 0.0, up + 1)
    beam = np.stack(np.meshgrid(x, y), axis=2)
    cells = []
    for rows, columns, first, width in ((through, around, 0, around), (up, along, ring[..., 0].size, along + 1)):
        i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
        after = (j + 1) % width
        corners = [first + i * width + j, first + i * width + after]
        cells.append(np.stack([*corners, corners[0] + width, corners[1] + width], axis=2).reshape(-1, 4))
    points = np.concatenate([ring.reshape(-1, 2), beam.reshape(-1, 2)])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    domain = mesh.create_mesh(MPI.COMM_SELF, np.concatenate(cells).astype(np.int64), x=points, e=ufl.Mesh(element))
    middles = mesh.compute_midpoints(domain, 2, np.arange(sum(map(len, cells)), dtype=np.int32))
    cell_tags = mesh.meshtags(
        domain, 2, np.arange(len(middles), dtype=np.int32), np.where(middles[:, 1] > 0, RING, BEAM).astype(np.int32)
    )
    centre = np.array([[0.0], [OUTER + GAP]])
    outside = mesh.locate_entities_boundary(
        domain, 1, lambda x: np.isclose(np.linalg.norm(x[:2] - centre, axis=0), OUTER)
    )
    upper = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    facets = np.concatenate([outside, upper])
    values = np.repeat([SLAVE, MASTER], [len(outside), len(upper)]).astype(np.int32)
    order = np.argsort(facets)
    return domain, cell_tags, mesh.meshtags(domain, 1, facets[order], values[order])


def thrown_ring():
    """The problem at its start."""
    domain, cell_tags, facet_tags = ring_on_beam()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V, name="displacement"), fem.Function(V)
    v.interpolate(lambda x: np.outer(VELOCITY, x[1] > 1e-6 * HEIGHT))
    rubber = di.NeoHookean(E=2e6, nu=0.4, density=1100.0, hypothesis="plane_strain")
    foam = di.NeoHookean(E=6e6, nu=0.3, density=900.0, hypothesis="plane_strain")
    ends = fem.locate_dofs_geometrical(V, lambda x: np.isclose(np.abs(x[0]), HALF_LENGTH))
    return di.ExplicitProblem(
        u, di.MaterialMap(cell_tags, {RING: rubber, BEAM: foam}), velocity=v,
        bcs=[fem.dirichletbc(np.zeros(2), ends, V)],
        contact=[di.Penalty(di.ContactPair(facet_tags, SLAVE, MASTER, friction=0.5))],
    )  # fmt: skip


def picture(problem):
    """Stress in the deformed bodies now, as an image."""
    figure, axes = plt.subplots(figsize=(5.6, 3.1), dpi=100, layout="constrained")
    di.DeformedBody(problem.u, problem.von_mises).draw(
        axes, "von Mises stress [MPa]", factor=1e-6, clim=(0.0, LARGEST), lengths=1e3, unit="mm"
    )
    axes.set(xlim=(-155, 155), ylim=(-82, 106))
    axes.set_title(f"{1e3 * problem.time:4.1f} ms", fontsize=10, loc="left")
    file = io.BytesIO()
    figure.savefig(file, format="png")
    plt.close(figure)
    return Image.open(file).convert("RGB")


def frames(numbers=range(FRAMES)):
    """Pictures at the times `numbers` STEP of one run, which ends at the last of all."""
    problem = thrown_ring()
    for frame in range(FRAMES):
        problem.advance(frame * STEP, progress=False)
        if frame in numbers:
            with plt.style.context("default"):  # whatever the process drew before
                image = picture(problem)
            yield image
    assert abs(problem.energy["drift"]) < 0.002, "the picture on the start page must be right"


def palette_of(images):
    """Colours for all pictures, from some of them: an image whose palette they are."""
    width, height = images[0].size
    together = Image.new("RGB", (width, height * len(images)))
    for k, image in enumerate(images):
        together.paste(image, (0, k * height))
    return together.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)


def main():
    target = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "figures" / "impact.gif")
    images = list(frames())
    palette = palette_of(images[:: FRAMES // 5])
    few = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    few[0].save(target, save_all=True, append_images=few[1:], duration=60, loop=0, optimize=True)
    print(f"{target}: {len(few)} frames, {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
