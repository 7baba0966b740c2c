# SPDX-License-Identifier: MIT
"""Materials with checked parameters; their physics is in forms/materials.py."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem import Constant
from dolfinx.mesh import Mesh, MeshTags
from ufl.algorithms import extract_arguments, extract_coefficients

from .common import arguments
from .common.arguments import number
from .common.collective import comm_of, guard
from .common.fixed import Fixed
from .forms import materials as laws


FULL, REDUCED, AVERAGED_PRESSURE, AVERAGED_STRAIN = "full", "reduced", "averaged_pressure", "averaged_strain"
AVERAGED = (AVERAGED_PRESSURE, AVERAGED_STRAIN)  # at the nodes
INTEGRATIONS = (FULL, REDUCED, *AVERAGED)
NOT_AXISYMMETRIC = (
    "integration='reduced' is not for axisymmetric bodies: the hoop strain u/r is no part of the mean gradient. Take "
    "integration='full'"
)


def mesh_of(u: Any) -> Mesh:
    """Mesh of a displacement.

    Args:
        u: displacement function, or UFL expression of functions or arguments.

    Raises:
        TypeError: there is neither a function nor an argument in `u`.
    """
    if isinstance(u, fem.Function):
        return u.function_space.mesh
    if isinstance(u, ufl.core.expr.Expr):
        spaces = [f.function_space for f in extract_coefficients(u) if isinstance(f, fem.Function)]
        spaces += [v.ufl_function_space() for v in extract_arguments(u)]
        if spaces:
            return spaces[0].mesh
    raise TypeError(f"a displacement is a Function, or a UFL expression of one; found {type(u).__name__} {u!s:.60}")


def _number_of(mesh: Mesh) -> int:
    """Number by which constants of a mesh are kept."""
    return mesh.ufl_id() if hasattr(mesh, "ufl_id") else id(mesh)


class _Material(Fixed):
    """Isotropic solid.

    Args:
        E: Young's modulus, positive [F/L^2].
        nu: Poisson's ratio, between -1 and 0.5, both excluded [1].
        density: None where no mass is asked for; zero, of a body without weight, in static problems only [M/L^3].
        hypothesis: "3d" (default on 3D meshes), "plane_strain", "plane_stress", "axisymmetric" (x is the radius).
        integration: "full"; "reduced", one point and hourglass control, on quadrilaterals and hexahedra of degree 1
            (docs/one_point.md); "averaged_pressure", the mean stress by averages at the nodes, for tetrahedra and
            triangles of degree 1 that do not lock; or "averaged_strain", a share of the whole stress by averages, for
            such cells that bend (docs/averaged_pressure.md).

    Raises:
        ValueError: a value outside its range; the message says which and what to do.
        TypeError: a value that is not a number.
    """

    law_class: type[laws.Law]

    def __init__(
        self,
        E: float,
        nu: float,
        density: float | None = None,
        hypothesis: str | None = None,
        integration: str = FULL,
    ) -> None:
        self.E = number("Young's modulus E", E, 0.0, " [F/L^2]")
        self.nu = number("Poisson's ratio nu", nu)
        if self.nu == 0.5:
            raise ValueError(
                "Poisson's ratio nu is 0.5: an incompressible solid has no finite Lame constant. Use 0.499, or a mixed "
                "form of your own"
            )
        if not -1.0 < self.nu < 0.5:
            raise ValueError(f"Poisson's ratio nu is {self.nu}: it must lie between -1 and 0.5")
        self.density = None if density is None else number("density", density, unit=" [M/L^3]")
        if self.density is not None and self.density < 0.0:
            raise ValueError(f"density is {self.density}: it must not be negative [M/L^3]")
        if hypothesis is not None and hypothesis not in laws.HYPOTHESES:
            raise ValueError(f"hypothesis {hypothesis!r} is unknown: use one of {', '.join(laws.HYPOTHESES)}")
        self._check_integration(integration, hypothesis)
        self.hypothesis = hypothesis
        self.integration = integration
        self.cell_tags = None
        self._constants: dict[tuple[int, str], Constant] = {}

    def _check_integration(self, integration: str, hypothesis: str | None) -> None:
        if integration not in INTEGRATIONS:
            raise ValueError(f"integration {integration!r} is unknown: use one of {', '.join(INTEGRATIONS)}")
        if integration == REDUCED and hypothesis == "axisymmetric":
            raise ValueError(NOT_AXISYMMETRIC)

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}(E={self.E}, nu={self.nu}, density={self.density}, hypothesis={self.hypothesis!r}"
            f"{self._repr_of_integration()})"
        )

    def _repr_of_integration(self) -> str:
        return "" if self.integration == FULL else f", integration={self.integration!r}"

    def hypothesis_on(self, mesh: Mesh) -> str:
        """The hypothesis on a given mesh; "3d" when none was given and the mesh is 3D.

        Raises:
            ValueError: none was given on a 2D mesh, or it does not fit the mesh.
        """
        hypothesis = self.hypothesis
        if hypothesis is None:
            if mesh.geometry.dim != 3:
                raise ValueError(
                    "the mesh is 2D: give the material a hypothesis, plane_strain, plane_stress or axisymmetric"
                )
            hypothesis = "3d"
        laws.check_hypothesis(hypothesis, mesh.geometry.dim)
        return hypothesis

    def parts(self) -> list[tuple[int | None, _Material]]:
        """Pairs (cell tag or None, material)."""
        return [(None, self)]

    def _constant(self, mesh: Mesh, name: str, value: float) -> Constant:
        key = (_number_of(mesh), name)
        if key not in self._constants:
            self._constants[key] = fem.Constant(mesh, default_scalar_type(value))
        return self._constants[key]

    def constants_on(self, mesh: Mesh) -> dict[str, Constant]:
        """Constants that this material's laws have on a mesh so far, by name.

        Args:
            mesh: mesh.
        """
        return {name: c for (of, name), c in self._constants.items() if of == _number_of(mesh)}

    def law(self, mesh: Mesh) -> laws.Law:
        """The law in UFL with parameters as constants of the mesh (forms/materials.py).

        Raises:
            TypeError: the stress is averaged at the nodes, and is no function of a cell's displacement.
        """
        if self.integration in AVERAGED:
            raise TypeError(
                f"the stress of {self!r} needs averages over the cells around nodes: give the material to a problem, "
                "and read `problem.stress`"
            )
        return self._full_law(mesh)

    def _full_law(self, mesh: Mesh) -> laws.Law:
        E, nu = self._constant(mesh, "E", self.E), self._constant(mesh, "nu", self.nu)
        # Averages take the place of the law's own volumetric part, whose kernel is that of full integration.
        integration = REDUCED if self.integration == REDUCED else FULL
        return self.law_class(E, nu, self.hypothesis_on(mesh), integration)

    def elastic_law(self, mesh: Mesh) -> laws.Law:
        """The law, or of materials with internal variables its elastic part.

        Args:
            mesh: mesh.
        """
        return self._full_law(mesh)

    def mass_density(self, mesh: Mesh) -> Constant:
        """Density as a constant of the mesh, for a mass.

        Raises:
            ValueError: the material has none, or zero.
        """
        if self.density == 0.0:
            raise ValueError(f"{self!r} has the density 0: without mass there are no waves, use a StaticProblem")
        return self.density_constant(mesh)

    def density_constant(self, mesh: Mesh) -> Constant:
        """Density as a constant of the mesh.

        Raises:
            ValueError: the material has none.
        """
        if self.density is None:
            raise ValueError(f"{self!r} has no density: a mass was asked for")
        return self._constant(mesh, "density", self.density)

    def stress(self, u: Any) -> Any:
        """Stress of a displacement: Cauchy for small strain, first Piola-Kirchhoff for finite strain [F/L^2].

        Args:
            u: displacement function, or UFL expression of one.

        Returns:
            UFL tensor: 3 x 3 in 3D, plane strain (with the stress across the plane at [2, 2]) and axisymmetric bodies
            (with the hoop stress at [2, 2]); 2 x 2 in plane stress, where the third row is zero.
        """
        return self.law(mesh_of(u)).stress(u)

    def cauchy_stress(self, u: Any) -> Any:
        """Cauchy stress of a displacement [F/L^2].

        Args:
            u: displacement function, or UFL expression of one.

        Returns:
            UFL tensor, 3 x 3 under every hypothesis.
        """
        return self.law(mesh_of(u)).cauchy_stress(u)

    def von_mises(self, u: Any) -> Any:
        """Von Mises' equivalent stress of a displacement, from the Cauchy stress [F/L^2].

        Args:
            u: displacement function, or UFL expression of one.

        Returns:
            UFL scalar.
        """
        return laws.von_mises(self.cauchy_stress(u))

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants (lambda, mu) [F/L^2]."""
        return laws.lame(self.E, self.nu)

    @property
    def p_wave_modulus(self) -> float:
        """Stress over strain in uniaxial strain, lambda + 2 mu; of sheets in plane stress [F/L^2]."""
        lmbda, mu = self.lame
        if self.hypothesis == "plane_stress":
            lmbda = laws.plane_stress_lambda(lmbda, mu)
        return float(lmbda + 2 * mu)

    @property
    def wave_speed(self) -> float:
        """Dilatational wave speed [L/T]: seed (3.80), plane waves in 3D and plane strain; sheets in plane stress."""
        if self.density is None or self.density == 0.0:
            what = "no density" if self.density is None else "the density 0"
            raise ValueError(f"{self!r} has {what}: a wave speed was asked for")
        return float(np.sqrt(self.p_wave_modulus / self.density))


class LinearElastic(_Material):
    __doc__ = "Small-strain elasticity, sigma = lambda tr(eps) I + 2 mu eps. " + str(_Material.__doc__)
    law_class = laws.LinearElastic


class StVenantKirchhoff(_Material):
    __doc__ = "Green's strain and second Piola-Kirchhoff stress in Hooke's law. " + str(_Material.__doc__)
    law_class = laws.StVenantKirchhoff


class NeoHookean(_Material):
    __doc__ = "Compressible neo-Hookean solid (Bonet & Wood 2008, 6.27). " + str(_Material.__doc__)
    law_class = laws.NeoHookean


class MaterialMap(Fixed):
    """Several materials by cell tag.

    Args:
        cell_tags: dolfinx MeshTags over cells; every owned cell must carry one of the tags.
        materials: dict tag -> material, all of one hypothesis.

    Raises:
        ValueError: a tag without material or without cells anywhere, cells without tag, mixed hypotheses; on all ranks.
    """

    def __init__(self, cell_tags: MeshTags, materials: Mapping[int, _Material]) -> None:
        with guard(comm_of(cell_tags), "MaterialMap", materials=materials):
            _check_map(cell_tags, materials)
        self.cell_tags = cell_tags
        self.materials = MappingProxyType({int(t): m for t, m in materials.items()})
        self._cell_numbers: fem.Function | None = None
        topology = cell_tags.topology
        comm, num_owned = topology.comm, topology.index_map(topology.dim).size_local
        owned = cell_tags.indices < num_owned
        here = np.unique(cell_tags.values[owned])
        everywhere = {int(t) for part in comm.allgather(here) for t in part}
        missing = sorted(everywhere - set(self.materials))
        empty = sorted(set(self.materials) - everywhere)
        untagged = sum(comm.allgather(int(num_owned - np.count_nonzero(owned))))
        if missing:
            raise ValueError(
                f"cells carry the tags {missing}, which have no material; there are materials for "
                f"{sorted(self.materials)}"
            )
        if empty:
            raise ValueError(f"no cell carries the tags {empty}; the mesh has {sorted(everywhere)}")
        if untagged:
            raise ValueError(f"{untagged} cells carry no tag: every cell needs a material")

    def __repr__(self) -> str:
        return f"MaterialMap({{{', '.join(f'{tag}: {m!r}' for tag, m in self.parts())}}})"

    def hypothesis_on(self, mesh: Mesh) -> str:
        """The hypothesis of all materials on a given mesh."""
        return next(iter(self.materials.values())).hypothesis_on(mesh)

    def parts(self) -> list[tuple[int, _Material]]:
        """Pairs (cell tag, material)."""
        return sorted(self.materials.items())

    def stress(self, u: Any) -> Any:
        """Stress of a displacement, in each cell that of its material: Cauchy for small strain, first Piola-Kirchhoff
        for finite strain [F/L^2]. Collective.

        Args:
            u: displacement function, or UFL expression of one, on the mesh of the tags.

        Returns:
            UFL tensor, of the shape that the materials have.

        Raises:
            TypeError: a material has internal variables, on which its stress depends.
            ValueError: the tags are of another mesh.
        """
        return self._by_cell(u, lambda material: material.stress(u))

    def cauchy_stress(self, u: Any) -> Any:
        """Cauchy stress of a displacement, in each cell that of its material [F/L^2]. Collective.

        Args:
            u: displacement function, or UFL expression of one, on the mesh of the tags.

        Returns:
            UFL tensor, 3 x 3 under every hypothesis.

        Raises:
            TypeError: a material has internal variables, on which its stress depends.
            ValueError: the tags are of another mesh.
        """
        return self._by_cell(u, lambda material: material.cauchy_stress(u))

    def von_mises(self, u: Any) -> Any:
        """Von Mises' equivalent stress of a displacement, from the Cauchy stress [F/L^2]. Collective.

        Args:
            u: displacement function, or UFL expression of one, on the mesh of the tags.

        Returns:
            UFL scalar.

        Raises:
            TypeError: a material has internal variables, on which its stress depends.
            ValueError: the tags are of another mesh.
        """
        return laws.von_mises(self.cauchy_stress(u))

    def _by_cell(self, u: Any, of: Callable[[_Material], Any]) -> Any:
        """Tensor in UFL that is, in each cell, what a function gives for the material of the cell."""
        number, tensors = self._numbers(mesh_of(u)), [of(material) for _, material in self.parts()]

        def component(i: int, j: int) -> Any:
            chosen = tensors[-1][i, j]
            # The branches are not added up with factors 0 and 1: those of other materials may be no numbers here.
            for k in reversed(range(len(tensors) - 1)):
                chosen = ufl.conditional(ufl.lt(number, k + 0.5), tensors[k][i, j], chosen)
            return chosen

        rows, columns = tensors[0].ufl_shape
        return ufl.as_tensor([[component(i, j) for j in range(columns)] for i in range(rows)])

    def _numbers(self, mesh: Mesh) -> fem.Function:
        """Number in `parts` of the material of each cell."""
        arguments.tags("MaterialMap", self.cell_tags, mesh, mesh.topology.dim)
        if self._cell_numbers is None:
            self._cell_numbers = fem.Function(fem.functionspace(mesh, ("DG", 0)), name="material")
            dofs = self._cell_numbers.function_space.dofmap.list
            for k, (tag, _) in enumerate(self.parts()):
                self._cell_numbers.x.array[dofs[self.cell_tags.find(tag), 0]] = k
            self._cell_numbers.x.scatter_forward()
        return self._cell_numbers

    @property
    def integration(self) -> str:
        """Integration of the materials: of a mixture of full and averaged ones that of the first."""
        return next(iter(self.materials.values())).integration

    @property
    def wave_speed(self) -> float:
        """Largest of the materials' wave speeds [L/T]."""
        return max(m.wave_speed for m in self.materials.values())


Material: TypeAlias = _Material | MaterialMap  # of a body, in annotations


def _check_map(cell_tags: MeshTags, materials: Mapping[int, _Material]) -> None:
    """Arguments of a MaterialMap, on this rank."""
    if not hasattr(cell_tags, "topology") or not hasattr(cell_tags, "indices"):
        raise TypeError(f"cell_tags must be dolfinx MeshTags of cells, found {type(cell_tags).__name__}")
    if not isinstance(materials, dict):
        raise TypeError(f"materials must be a dict, tag -> material, found {type(materials).__name__}")
    if not materials:
        raise ValueError("MaterialMap needs at least one material")
    for tag, m in materials.items():
        if isinstance(tag, bool) or not isinstance(tag, (int, np.integer)):
            raise TypeError(f"a tag must be an integer, found {tag!r}")
        if not isinstance(m, _Material):
            raise TypeError(f"tag {tag}: expected a material, found {type(m).__name__} {m!r:.60}")
    hypotheses = {m.hypothesis for m in materials.values()}
    if len(hypotheses) > 1:
        raise ValueError(f"materials of one body share one hypothesis, found {sorted(map(str, hypotheses))}")
    integrations = sorted({m.integration for m in materials.values()})
    if REDUCED in integrations and len(integrations) > 1:
        raise ValueError(f"materials of one mesh share one integration, found {', '.join(integrations)}")
    tdim = cell_tags.topology.dim
    if cell_tags.dim != tdim:
        raise ValueError(f"materials need tags of cells (dimension {tdim}), found tags of dimension {cell_tags.dim}")


class Rayleigh(Fixed):
    """Rayleigh damping C = alpha M + beta K, seed (3.67).

    Args:
        alpha: mass factor, not negative [1/T].
        beta: stiffness factor, not negative [T].
    """

    def __init__(self, alpha: float = 0.0, beta: float = 0.0) -> None:
        self.alpha = number("Rayleigh factor alpha", alpha)
        self.beta = number("Rayleigh factor beta", beta)
        if self.alpha < 0 or self.beta < 0:
            raise ValueError(
                f"Rayleigh factors alpha={alpha}, beta={beta} must not be negative: they would feed energy in"
            )

    def __repr__(self) -> str:
        return f"Rayleigh(alpha={self.alpha}, beta={self.beta})"
