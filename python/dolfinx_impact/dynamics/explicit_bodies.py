# SPDX-License-Identifier: MIT
"""Bodies of an explicit problem: forms of their forces and stiffness, masses, frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem, la
from dolfinx.mesh import MeshTags
from ufl.algorithms import expand_derivatives

from .. import _cpp
from ..added_mass import added_masses
from ..assembly.nodal_mean import NodalMean, StrainParts
from ..assembly import lumped_mass as lumps
from ..assembly import operators
from ..assembly.body_forms import body_forms, stiffness_damping
from ..assembly.curvature import is_displacement
from ..assembly.inelastic_part import InelasticParts
from ..assembly.measures import check_measures
from ..assembly.quadrature_degree import warn_of_degree
from ..assembly.residual import check_hypothesis, differentiable, split
from ..common.arguments import number
from ..common.described import Described
from ..common.types import BoolArray, FloatArray
from ..forms import viscosity
from ..forms.quadrature import with_rules
from ..foundation import dashpot_form, spring_form
from ..loads import Load
from ..materials import Material, MaterialMap, Rayleigh, _Material
from .stable_step import Frequencies

KINDS = _cpp.integrators.WorkKind


class ExplicitBodies(Described):
    """Forces of the bodies and of foundations, with damping and viscosity; mass and frequencies.

    Args:
        u: displacement function.
        velocity: velocity at the start, which a residual may contain [L/T].
        given: material, or None with `residual`.
        residual: residual of the user's own, or None.
        tangent: its derivative; None: UFL finds it.
        own: bodies of a residual of one's own; None with a material.
        hypothesis: of a residual of one's own.
        loads: loads; foundations and added masses count here.
        scheme: scheme of the integrator.
        lumping: lumping scheme.
        mixed: whether element forces of the material are computed in float.

    Attributes:
        bodies: material, or bodies of a residual.
        hypothesis: hypothesis in use.
        parts: inelastic parts; None without.
        linear: whether the internal force is linear in the displacement.
        resists: whether the residual contains the velocity.
        frequencies: highest frequencies of the cells.
        internal: internal force.
        terms: all force terms, the internal force first; those that `add` appends.
        mass: lumped mass per degree of freedom [M].
        added_mass: mass that mass scaling has added, of all ranks [M].
        motion_velocity: function of the velocity at the present time [L/T].

    Raises:
        ValueError: what does not fit; on all ranks.
    """

    mass: la.Vector
    added_mass: float

    def __init__(
        self,
        u: fem.Function,
        velocity: fem.Function,
        given: _Material | MaterialMap | None,
        residual: ufl.Form | None,
        tangent: ufl.Form | None,
        own: Any,
        hypothesis: str | None,
        loads: Sequence[Load],
        scheme: str,
        lumping: str,
        mixed: bool = False,
    ) -> None:
        V, mesh = u.function_space, u.function_space.mesh
        self.u, self.loads, self._lumping, self._scheme = u, loads, lumping, scheme
        self._test, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        resisting = damping_tangent = self._laws = None
        self.parts: InelasticParts | None = None
        tags: MeshTags | None = None
        nodal: Sequence[StrainParts] = ()
        self.material = given
        if residual is None:
            assert given is not None  # the caller has checked it
            hypothesis = given.hypothesis_on(mesh)
            forms = body_forms(u, given)
            internal, bounding, self.linear = forms.internal, forms.stiffness, forms.linear
            self._laws, self.parts, nodal = forms.laws, forms.parts, forms.nodal
            densities, tags = [(t, m.mass_density(mesh)) for t, m in given.parts()], given.cell_tags
        else:
            internal, resisting = split(residual, velocity)
            if tangent is None and any(isinstance(f, NodalMean) for f in residual.coefficients()):
                raise ValueError(
                    "the residual reads averages at the nodes (integration='averaged_pressure' or 'averaged_strain'), "
                    "whose stiffness its derivative lacks: the stable step would be too long. Give the material, or as "
                    "tangent= that of integration='full'"
                )
            self.linear, bounding = False, tangent
            if tangent is None:  # by the rules of the residual: it is the change of this force that bounds the step
                with differentiable():
                    bounding = expand_derivatives(ufl.derivative(with_rules(internal), u, du))
            if resisting is not None:
                if scheme == "classical":
                    raise ValueError(
                        "the residual contains the velocity: scheme 'classical' takes mass-proportional damping only"
                    )
                damping_tangent = expand_derivatives(ufl.derivative(with_rules(resisting), velocity, du))
            check_hypothesis(internal, u, hypothesis, tangent)
            warn_of_degree(residual, u, hypothesis)
            densities = [(None, own.density_constant(mesh))]
        self.bodies: Any = given if residual is None else own
        self.hypothesis, self.resists, self._resisting = hypothesis, resisting is not None, resisting
        springs, dashpots = (make(loads, du, self._test, self.bodies) for make in (spring_form, dashpot_form))
        if dashpots is not None and scheme == "classical":
            raise ValueError(
                "a Foundation has dashpots: scheme 'classical' takes mass-proportional damping only, its matrix must "
                "be diagonal"
            )
        if springs is not None:
            bounding = bounding + springs
            check_measures(bounding)
        if dashpots is not None:
            damping_tangent = dashpots if damping_tangent is None else damping_tangent + dashpots
            check_measures(damping_tangent)
        used = hypothesis or "3d"
        self.frequencies = Frequencies(
            u, bounding, lambda: lumps.cell_masses(V, densities, used, tags, lumping), damping_tangent, velocity
        )
        read = [c for t in (bounding, damping_tangent) if t is not None for c in t.coefficients()]
        deforms = any(c is u for c in read)
        # Of other unknowns than displacements the size of a cell says nothing about how far they may change.
        self.watched = deforms and is_displacement(V) and not self.frequencies.depends_on_jumps
        # The stiffness that bounds the frequencies of inelastic parts is that of their elastic part in the deformed
        # shape: no internal variable changes it but by the deformation, which is watched.
        self.periodic = any(c is velocity for c in read) or (deforms and not self.watched)
        self.internal = operators.SplitForce(internal, u, law=self._laws, mixed=mixed, nodal=nodal)
        self.terms: list[operators.SplitForce] = [self.internal]
        self._kinds: list[_cpp.integrators.WorkKind] = []
        if resisting is None:
            self.motion_velocity = fem.Function(V, name="velocity")
            self.motion_velocity.x.array[:] = velocity.x.array
        else:
            self.motion_velocity = velocity
            self.add(resisting, KINDS.damping)

    def check_signs(self, prescribed: BoolArray) -> None:
        """Refuse a stiffness or damping of the wrong sign; see Frequencies.check_signs. Collective.

        Args:
            prescribed: mask of owned degrees of freedom.
        """
        self.frequencies.check_signs(~prescribed)

    def assemble_mass(self, mass_scaling: float | None) -> None:
        """Set `mass` and `added_mass`. Collective.

        Args:
            mass_scaling: step to which the stable step of cells is raised by added mass; None: none is added [T].
        """
        V = self.u.function_space
        self.added_mass = 0.0
        if mass_scaling is not None:
            self.added_mass = self.frequencies.scale_mass(number("mass_scaling", mass_scaling, 0.0))
        masses = self.frequencies.masses()
        self.mass = lumps.assemble_masses(V, [(np.arange(len(masses), dtype=np.int32), masses)], self._lumping)
        for added in added_masses(self.loads):
            self.mass.array[:] += added.nodal(V, self.hypothesis or "3d")

    def add(self, form: ufl.Form, kind: _cpp.integrators.WorkKind) -> None:
        """Add a force.

        Args:
            form: its virtual work.
            kind: which energy its work counts to.
        """
        self.terms.append(operators.SplitForce(form, self.u, self.motion_velocity))
        self._kinds.append(kind)

    def add_damping(self, damping: Rayleigh, bulk_viscosity: tuple[float, float]) -> None:
        """Add stiffness-proportional damping and bulk viscosity.

        Args:
            damping: Rayleigh damping.
            bulk_viscosity: factors, linear and quadratic [1].

        Raises:
            ValueError: the scheme takes none, or the stiffness is not known; on all ranks.
        """
        u, mesh, material = self.u, self.u.function_space.mesh, self.material
        if damping.beta > 0.0:
            if self._scheme == "classical":
                raise ValueError("scheme 'classical' takes mass-proportional damping only: its matrix must be diagonal")
            if material is None:
                raise ValueError("stiffness-proportional damping needs a material: write it into your own residual")
            beta = fem.Constant(mesh, default_scalar_type(damping.beta))
            self.add(stiffness_damping(u, self.motion_velocity, self._test, material, beta), KINDS.damping)
        if any(bulk_viscosity):
            assert material is not None  # checked with the factors
            linear, quadratic = (fem.Constant(mesh, default_scalar_type(f)) for f in bulk_viscosity)
            form = operators.sum_materials(
                u, material,
                lambda m, dx: viscosity.bulk(
                    u, self.motion_velocity, self._test, m.elastic_law(mesh), m.density_constant(mesh), linear,
                    quadratic, dx,
                ),
            )  # fmt: skip
            self.add(form, KINDS.viscosity)

    def add_foundations(self) -> None:
        """Add springs to the ground, whose energy counts as internal, and dashpots. Two terms for all of them: their
        forms share one set of tags, as those of the stable step do."""
        springs = spring_form(self.loads, self.u, self._test, self.bodies)
        if springs is not None:
            self.add(springs, KINDS.foundation)
        dashpots = dashpot_form(self.loads, self.motion_velocity, self._test, self.bodies)
        if dashpots is not None:
            self.add(dashpots, KINDS.damping)

    def body(self, damping: _cpp.problems.UniformDamping) -> _cpp.problems.ExplicitBody:
        """Make the object of the C++ side.

        Args:
            damping: damping of all cells alike.
        """
        body = _cpp.problems.ExplicitBody(
            self.internal.forces(), self.linear, self.mass.array, self.frequencies._cpp_object, damping, self.watched,
            self.periodic, self.parts is not None,
        )  # fmt: skip
        for term, kind in zip(self.terms[1:], self._kinds):
            body.add_term(term.forces(), kind)
        frequencies = self.frequencies
        damping_matrix = None if frequencies.damping_form is None else partial(assembled, frequencies.damping_form)
        body.set_matrices(partial(assembled, frequencies.tangent), damping_matrix)
        if self.material is not None:
            body.set_elasticity(*self._elasticity(self.material))
        return body

    def _elasticity(self, material: Material) -> tuple[FloatArray, FloatArray]:
        """Modulus of uniaxial strain [F/L^2] and speed of waves [L/T] of each owned cell."""
        mesh = self.u.function_space.mesh
        moduli = np.zeros(mesh.topology.index_map(mesh.topology.dim).size_local)
        speeds = np.zeros_like(moduli)
        for tag, m in material.parts():
            cells = operators.entities_of(mesh, "cell", -1 if tag is None else tag, material.cell_tags)
            moduli[cells], speeds[cells] = m.p_wave_modulus, m.wave_speed
        return moduli, speeds


def assembled(form: ufl.Form) -> _cpp.operators.KernelTangent:
    """A matrix of a bilinear form at the present state, a new one with each call. Collective.

    Args:
        form: UFL form of rank 2.
    """
    tangent = operators.Tangent(form)
    tangent.assemble().destroy()  # the reference of petsc4py, the object keeps its own
    return tangent._cpp_object
