# SPDX-License-Identifier: MIT
"""Checks of the arguments of a rolling problem, on one rank, for use under a guard (common/collective.py)."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx.mesh import Mesh

from ..common import arguments
from ..contact.general import GeneralContact
from ..contact.mortar.lagrange import Lagrange
from ..contact.mortar.tie import Tie
from ..inelastic import InelasticMaterial
from ..materials import AVERAGED, REDUCED
from ..plasticity import J2Plasticity
from .motions import Spin, Translation


def check(mesh: Mesh, material: Any, cell_tags: Any, motions: Any, contact: Any) -> None:
    """Check what a rolling problem asks beyond a static one.

    Args:
        mesh: mesh of the displacement.
        material: material or MaterialMap, checked.
        cell_tags: tags of the bodies.
        motions: motion by tag.
        contact: contacts, checked.

    Raises:
        TypeError: an argument is of the wrong type.
        ValueError: axisymmetric or massless materials, motions that do not fit, internal variables of bodies that
            stand or have friction, tensors of a law of one's own in bodies that spin, or friction by penalty, ties.
    """
    arguments.tags("RollingProblem", cell_tags, mesh, mesh.topology.dim)
    if not isinstance(motions, dict):
        raise TypeError(f"motions must be a dict, tag -> Spin or Translation, found {type(motions).__name__}")
    if not motions:
        raise ValueError("motions is empty: give every cell tag a Spin or a Translation")
    for tag, motion in motions.items():
        if isinstance(tag, bool) or not isinstance(tag, (int, np.integer)):
            raise TypeError(f"a tag of motions must be an integer, found {tag!r:.60}")
        if not isinstance(motion, (Spin, Translation)):
            raise TypeError(f"the motion of tag {tag} must be a Spin or a Translation, found {type(motion).__name__}")
        motion.check(mesh)
    if material.hypothesis_on(mesh) == "axisymmetric":
        raise ValueError("hypothesis 'axisymmetric': a body that spins about z is not axisymmetric in the (r, z) plane")
    if material.integration == REDUCED:
        raise ValueError(
            "integration='reduced' is not for rolling problems: the inertia of the flow through the mesh knows nothing "
            "of hourglass modes, and would drive them. Take integration='full'"
        )
    for tag, m in material.parts():
        if m.integration in AVERAGED:
            raise ValueError(
                f"integration={m.integration!r} is not for rolling problems: nobody has compared it with other cells "
                "there. Take integration='full', on hexahedra or cells of degree 2"
            )
        m.mass_density(mesh)
        if isinstance(m, InelasticMaterial):
            _check_flowing(m, cell_tags, motions, None if tag is None else material.cell_tags.find(tag))
    for c in contact:
        if isinstance(c, Tie):
            raise ValueError(
                f"{c.pair.name} is a Tie: the bodies of a rolling problem flow through their meshes, and tied surfaces "
                "would have to flow alike; mesh the two parts together"
            )
        if isinstance(c, GeneralContact):
            raise ValueError(
                f"{c.pair.name} is a GeneralContact: in steady rolling it is known which surfaces touch, name them in "
                "pairs"
            )
        c.pair.refuse_rigid_body("steady rolling")
        c.pair.refuse_angle("steady rolling does not turn a rigid master: give its surface a velocity")
    if any(c.pair.has_friction for c in contact):
        if any(isinstance(m, InelasticMaterial) for _, m in material.parts()):
            raise ValueError("friction together with internal variables that flow with the material comes later")
        for c in contact:
            if not isinstance(c, Lagrange):
                raise ValueError(
                    f"{c.pair.name} is enforced by {type(c).__name__}: steady rolling with friction needs Lagrange "
                    "contacts"
                )
            if c.basis != "dual":
                raise ValueError(f"{c.pair.name} has the basis {c.basis!r}: steady rolling with friction needs 'dual'")


def _check_flowing(m: InelasticMaterial, cell_tags: Any, motions: Any, cells: Any) -> None:
    """Raise ValueError if cells of a material with internal variables do not move, or spin with variables of which it
    is not known how they turn."""
    for tag, motion in motions.items():
        here = cell_tags.find(tag)
        if not len(here if cells is None else np.intersect1d(here, cells)):
            continue
        vectors = [name for name, shape in m.history.items() if shape and not isinstance(m, J2Plasticity)]
        if isinstance(motion, Spin) and vectors:
            raise ValueError(
                f"{type(m).__name__} has the internal variables {vectors}, of which a RollingProblem does not know how "
                f"they turn with the body of tag {tag}, which spins: take J2Plasticity, or numbers alone"
            )
        if not np.any(motion.rate):
            raise ValueError(f"{type(m).__name__} has internal variables: the body of tag {tag} must move")


def turns(count: Any, closes: bool) -> int | None:
    """Check a number of turns.

    Args:
        count: number of turns, or None.
        closes: is there a ring with internal variables?

    Returns:
        The number.

    Raises:
        TypeError: not an integer.
        ValueError: not positive, or nothing that turns has internal variables.
    """
    if count is None:
        return None
    number = arguments.integer("turns", count, 1)
    if not closes:
        raise ValueError("turns is for a whole ring with internal variables, and there is none")
    return number


def solver(
    steps: Any,
    rtol: Any,
    atol: Any,
    max_iterations: Any,
    cut_backs: Any,
    torque: Any,
    rubs: bool,
    spin: Spin | None,
) -> dict[str, Any]:
    """Check what RollingProblem.solve is called with.

    Args:
        steps: number of steps.
        rtol: relative tolerance.
        atol: absolute tolerance.
        max_iterations: number of iterations.
        cut_backs: number of cut-backs, or None.
        torque: wanted torque, or None.
        rubs: has a contact friction?
        spin: first of the motions that is a Spin, or None.

    Returns:
        The arguments by name, for comparison between ranks.

    Raises:
        TypeError: an argument is not a number.
        ValueError: an argument is out of bounds, or the torque cannot be controlled.
    """
    given = {
        "steps": arguments.integer("steps", steps, 1),
        "max_iterations": arguments.integer("max_iterations", max_iterations, 1),
        "cut_backs": None if cut_backs is None else arguments.integer("cut_backs", cut_backs, 0),
        "rtol": arguments.tolerance("rtol", rtol),
        "atol": arguments.tolerance("atol", atol),
        "torque": None if torque is None else arguments.number("torque", torque, unit=" [F L]"),
    }
    if torque is not None and spin is None:
        raise ValueError("no body has a Spin: there is no torque to control")
    if torque is not None and not rubs:
        raise ValueError("no contact has friction: the torque is zero at any spin")
    if torque is not None and spin is not None and spin.omega == 0.0:
        raise ValueError(
            "omega is zero, which tells no direction of rolling: give a first value near the one looked for"
        )
    return given
