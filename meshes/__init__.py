# SPDX-License-Identifier: MIT
"""Parametric gmsh recipes for contact problems.

    from dolfinx_impact import meshes

    meshes.names()                                               # what there is
    m = meshes.make("cylinder_on_half_plane", MPI.COMM_WORLD, radius=0.05, a=6e-3)
    m.mesh, m.cell_tags, m.facet_tags, m.tags["slave_surface"]

Every recipe is a function of keyword parameters (see its docstring for units) that returns a block layout; `make`
meshes it on rank 0 and distributes it. The numbers of the tags are in `tags.py`, the same for all recipes.
"""

import inspect
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from dolfinx_impact import compat
from dolfinx_impact.io import bisection
from . import (
    bars, blocks, hertz, indenters, insulated_joint, rail_joint, rolling_contact, wheel_rail,
)  # fmt: skip
from .layout import require
from .tags import BODIES, FACETS, NAMES, name_of

__all__ = ["BODIES", "FACETS", "NAMES", "RecipeMesh", "layout", "make", "name_of", "names", "recipe", "write"]

_RECIPES = {
    function.__name__: function
    for module in (blocks, hertz, indenters, bars, wheel_rail, rolling_contact, rail_joint, insulated_joint)
    for function in module.RECIPES
}
_CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}


@dataclass
class RecipeMesh:
    """What a recipe gives: mesh, tags, the parameters it was made with, and name -> number of the tags it has."""

    name: str
    mesh: Any
    cell_tags: Any
    facet_tags: Any
    parameters: dict
    tags: dict


def names():
    """Names of all recipes."""
    return tuple(_RECIPES)


def recipe(name):
    """The function behind a name; its signature and docstring are the list of parameters, with units."""
    require(name in _RECIPES, f"no mesh recipe {name!r}; there are: {', '.join(_RECIPES)}")
    return _RECIPES[name]


def layout(name, cell=None, degree=1, **parameters):
    """Block layout of a recipe, its cell name and all its parameters, without meshing it."""
    function = recipe(name)
    known = inspect.signature(function).parameters
    unknown = sorted(set(parameters) - set(known))
    require(not unknown, f"{name} has no parameter {unknown}; it takes cell, degree, {', '.join(known)}")
    plan = function(**parameters)
    cells = plan.made_of or _CELLS[plan.dim]
    cell = cells[0] if cell is None else cell
    require(cell in cells, f"cell = {cell!r}: {name} in {plan.dim}D is made of {' or '.join(cells)}")
    require(degree in (1, 2), f"degree = {degree!r}: the geometry degree is 1 or 2")
    used = {key: parameters.get(key, value.default) for key, value in known.items()}
    return plan, cell, {**used, "cell": cell, "degree": degree}


def make(name, comm=MPI.COMM_WORLD, cell=None, degree=1, partitioner=None, weight=None, **parameters):
    """Mesh the recipe `name` on rank 0 of `comm` and distribute it. Collective.

    `cell`: "quadrilateral" or "triangle", "hexahedron" or "tetrahedron" (default: the first); `degree`: geometry
    degree, 1 or 2; `partitioner`: as in dolfinx.mesh.create_mesh; `weight`: function of the midpoints of cells,
    (n, 3) -> (n), what a cell costs: ranks get equal sums, cut along the coordinates (instead of a partitioner, without
    ghost cells); all other parameters are those of the recipe.
    A bad parameter raises ValueError, a mesh gmsh cannot make RuntimeError, on every rank.
    """
    plan, cell, used = layout(name, cell, degree, **parameters)
    require(weight is None or partitioner is None, "give a weight or a partitioner, not both")

    def distribute(model):
        nonlocal partitioner
        if weight is not None and comm.size > 1:
            x = compat.gmsh_nodes(model) if comm.rank == 0 else np.zeros((0, 3))
            partitioner = bisection.partitioner(x, weight)
        return compat.model_to_mesh(model, comm, 0, gdim=plan.dim, partitioner=partitioner)

    mesh, cell_tags, facet_tags = _on_rank_0(comm, name, plan, cell, degree, distribute)
    mesh.name, cell_tags.name, facet_tags.name = name, "cell_tags", "facet_tags"
    present = [body.name for body in plan.bodies] + sorted(plan.outer_facets(), key=FACETS.get)
    return RecipeMesh(name, mesh, cell_tags, facet_tags, used, {key: NAMES[key] for key in present})


def write(name, path, cell=None, degree=1, binary=False, **parameters):
    """Mesh a recipe in this process and write a gmsh file (format 4.1) with the physical names."""
    import gmsh

    def save(model):
        gmsh.option.setNumber("Mesh.Binary", int(binary))
        gmsh.write(str(path))

    plan, cell, _ = layout(name, cell, degree, **parameters)
    _on_rank_0(MPI.COMM_SELF, name, plan, cell, degree, save)


def _on_rank_0(comm, name, plan, cell, degree, use):
    """Generate on rank 0 and hand the model to `use` on every rank; all ranks fail together."""
    if comm.rank > 0:
        problem = comm.bcast(None, root=0)
        if problem is None:
            return use(None)
        raise RuntimeError(problem)
    from .gmsh_model import generate, session

    with session(name) as model:
        problem = None
        try:
            generate(plan, cell, degree)
        except Exception as error:
            problem = f"recipe {name!r}: gmsh could not make the mesh: {error}"
        comm.bcast(problem, root=0)
        if problem is not None:
            raise RuntimeError(problem)
        return use(model)
