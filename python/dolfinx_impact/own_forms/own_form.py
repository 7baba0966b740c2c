# SPDX-License-Identifier: MIT
"""What a user says about a form of their own, and errors about it at the door."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh

from ..assembly.residual import check_residual
from ..forms.materials import HYPOTHESES
from ..inelastic import InelasticMaterial


@dataclass
class OwnForm:
    """A form of one's own on a mesh, and what is meant by it: the checks expect what is said here.

    Args:
        residual: UFL residual (rank 1): internal minus external forces; None with `material`.
        u: unknown; its value is the state of rest.
        energy: stored energy (rank 0) that the residual should be the derivative of; None: not known.
        tangent: tangent (rank 2) that you program yourself; None: the derivative by UFL.
        material: material with internal variables, in the place of `residual`.
        parameters: constants by name that change while the form is in use.
        conservative: whether the residual should be the derivative of an energy; None: if the unknown is a
            displacement alone.
        grounded: whether springs, or terms in the value of u, tie the body to the ground.
        prestressed: whether internal forces at rest are meant.
        definite: whether the tangent at rest should have no negative direction.
        hypothesis: "axisymmetric" if x[0] is the radius; None or another hypothesis if not.
        displacement: number of the displacement's subspace in a mixed space; None: the first that is a vector.
        rotation: number of the subspace of a micro-rotation (Cosserat) in a mixed space; None: there is none.
        strain: size of the strains at which the form is checked [1].
        stress: Cauchy stress, a UFL tensor of 3 x 3 with that across the plane at [2, 2]; `dolfinx-impact compile`
            writes a kernel of it. It is not checked; None: not known [F/L^2].
    """

    residual: ufl.Form | None
    u: fem.Function
    energy: ufl.Form | None = None
    tangent: ufl.Form | None = None
    material: InelasticMaterial | None = None
    parameters: Mapping[str, fem.Constant] = field(default_factory=dict)
    conservative: bool | None = None
    grounded: bool = False
    prestressed: bool = False
    definite: bool = True
    hypothesis: str | None = None
    displacement: int | None = None
    rotation: int | None = None
    strain: float = 0.05
    stress: Any = None

    def check(self) -> None:
        """Refuse what cannot be checked.

        Raises:
            TypeError: an argument is of the wrong kind.
            ValueError: residual and unknown do not fit, or a value is out of its range.
        """
        if not isinstance(self.u, fem.Function):
            raise TypeError(f"u must be a dolfinx.fem.Function, found {type(self.u).__name__}")
        if (self.residual is None) == (self.material is None):
            raise ValueError("give a residual, or a material with internal variables, and not both")
        if self.residual is not None:
            self._check_residual()
        elif not isinstance(self.material, InelasticMaterial):
            raise TypeError(f"material must be an InelasticMaterial, found {type(self.material).__name__}")
        for name, form, rank in (("energy", self.energy, 0), ("tangent", self.tangent, 2)):
            if form is not None and (not isinstance(form, ufl.Form) or len(form.arguments()) != rank):
                raise ValueError(f"{name} must be a UFL form of rank {rank}, as is written with ufl.dx")
        for name, constant in self.parameters.items():
            if not isinstance(constant, fem.Constant):
                raise TypeError(f"parameter {name!r} must be a dolfinx.fem.Constant, found {type(constant).__name__}")
        if self.hypothesis is not None and self.hypothesis not in HYPOTHESES:
            raise ValueError(f"hypothesis {self.hypothesis!r} is unknown: use one of {', '.join(HYPOTHESES)}")
        if self.stress is not None and getattr(self.stress, "ufl_shape", None) != (3, 3):
            raise ValueError("stress must be a UFL tensor of 3 x 3: under plane hypotheses, too, with zz at [2, 2]")
        if not 0.0 < self.strain < 1.0:
            raise ValueError(f"strain is {self.strain}: the size of the strains at which to check is between 0 and 1")

    def _check_residual(self) -> None:
        V = self.u.function_space
        try:
            check_residual(self.residual, self.u)
        except RuntimeError:  # DOLFINx does not compare elements of mixed spaces
            assert self.residual is not None
            if self.residual.arguments()[0].ufl_element() != V.ufl_element():
                raise ValueError(
                    "the test function of the residual is of another space than u: use "
                    "ufl.TestFunctions(u.function_space)"
                ) from None


# A function of a mesh that writes the form there.
Maker = Callable[[Mesh], OwnForm]


def made(maker: Callable[[Mesh], Any], name: str, mesh: Mesh) -> OwnForm:
    """Call a user's function, and say in one sentence what is wrong if it cannot be used.

    Args:
        maker: the function of a mesh.
        name: its name, for errors.
        mesh: mesh.

    Returns:
        The form on this mesh.

    Raises:
        TypeError: it does not return a form.
        ValueError: it raises, or the form cannot be checked.
    """
    try:
        given = maker(mesh)
    except Exception as e:
        where = f"{name}(mesh of {mesh.topology.cell_name()}s)"
        raise ValueError(
            f"{where} ends with {type(e).__name__}: {e}; --cells (cells=) names the cells it is for"
        ) from e
    if isinstance(given, tuple) and len(given) == 2:
        given = OwnForm(*given)
    if not isinstance(given, OwnForm):
        raise TypeError(
            f"{name}(mesh) returns {type(given).__name__}: return dolfinx_impact.verify.OwnForm(residual, u, ...), or "
            "residual and u"
        )
    try:
        given.check()
    except (TypeError, ValueError) as e:
        raise type(e)(f"{name}: {e}") from e
    if given.u.function_space.mesh is not mesh and given.u.function_space.mesh._cpp_object is not mesh._cpp_object:
        raise ValueError(f"{name}(mesh) must write the form on the mesh that it is given")
    return given
