# SPDX-License-Identifier: MIT
"""Check of the tangent at rest: no negative direction, and none without stiffness but the rigid ones."""

from __future__ import annotations

import numpy as np
from ufl.algorithms import expand_derivatives

from dolfinx_impact.common.types import FloatArray
from .assembled import AssembledForm
from .findings import Curve, Picture
from .rigid import _spins, _translations
from .strong import gradient_order
from .subject import Subject

ZERO = 1e-9  # singular value over the largest one: rigid motions have 1e-16, strains of a small mesh 1e-5 and more
REASON = "a count of eigenvalues"


def definiteness(subject: Subject) -> None:
    """Is the tangent at rest positive but for rigid motions?

    Args:
        subject: the form.
    """
    if not subject.own.definite:
        subject.leave_out("definiteness", "definite=False")
        return
    K = subject.scaled(subject.assembled.matrix(subject.rest))
    size = float(np.linalg.norm(K, 2))
    rigid = _motions_without_force(subject, K, size)
    singular = np.linalg.svd(K, compute_uv=False) / size
    zero = int(np.sum(singular <= ZERO))
    if subject.displacement is None and _of_fourth_order(subject):
        rigid = zero  # depends on the form of the boundary's terms: of Laplacians all harmonic functions
    negative, share, constraints = _signs(subject, K, size)
    _draw(subject, singular)
    if negative > 0:
        subject.add(
            "definiteness", negative, 0, REASON, "",
            f"the tangent at rest has {negative} negative directions, down to -{share:.2g} of its largest value: the "
            "body would fly apart by itself. The sign of the residual, or of one of its terms, is wrong; where this is "
            "meant (prestress, several equilibria) say definite=False",
        )  # fmt: skip
        return
    beside = f" but for {rigid} motions that should cause no forces" if rigid else ""
    subject.add(
        "definiteness", abs(zero - rigid), 0, REASON,
        f"the tangent at rest is positive{beside}"
        + (f"; {constraints} constraints make it that of a saddle point" if constraints else ""),
        f"{zero - rigid} directions too many have no stiffness at rest ({rigid} motions should have none): the "
        "quadrature rule is too coarse, a term is missing, or a mixed space is unstable",
    )  # fmt: skip


def _of_fourth_order(subject: Subject) -> bool:
    form = subject.assembled
    return isinstance(form, AssembledForm) and gradient_order(expand_derivatives(form.internal)) > 1


def _signs(subject: Subject, K: FloatArray, size: float) -> tuple[int, float, int]:
    """Number of negative directions, the size of the worst, and number of constraints (multipliers, pressures).

    The fields of a symmetric saddle point are counted together: it has as many negative directions as constraints.
    Of a tangent that is not symmetric the block of each field counts, as the units of fields are not comparable.
    """
    blocks: list[FloatArray] = []
    constraints = 0
    for f in subject.fields:
        block = K[np.ix_(f.dofs, f.dofs)]
        values = np.linalg.eigvalsh(0.5 * (block + block.T)) / size
        if len(subject.fields) > 1 and values[-1] <= ZERO:
            constraints += len(f.dofs)
        else:
            blocks.append(values)
    if np.abs(K - K.T).max() <= ZERO * size:
        every = np.linalg.eigvalsh(0.5 * (K + K.T)) / size
        return max(int(np.sum(every < -ZERO)) - constraints, 0), float(-every[0]), constraints
    alone = np.concatenate(blocks)
    return int(np.sum(alone < -ZERO)), float(-alone.min()), constraints


def _motions_without_force(subject: Subject, K: FloatArray, size: float) -> int:
    """Number of independent motions that should cause no force and do not.

    They are rigid ones, constants of fields that are no displacement, and strains that go with such constants without
    stress (a body that is heated and free expands).
    """
    f, gdim, rigid, straining, constant = subject.displacement, subject.gdim, [], [], []
    if f is not None:
        rigid = [m for _, m in _translations(subject)] + [m for *_, m in _spins(subject)]
        units = [np.outer(np.eye(gdim)[i], np.eye(gdim)[j]) for i in range(gdim) for j in range(gdim)]
        straining = rigid + [subject.of(f, f.nodes @ unit.T) for unit in units]
    for g in subject.fields:
        if g is not f and g is not subject.rotation and g.nodal:
            for component in range(g.num_components):
                values = np.zeros((len(g.nodes), g.num_components))
                values[:, component] = 1.0
                constant.append(subject.of(g, values))
    count = _nullity(subject, K, size, rigid)
    if constant:
        count += _nullity(subject, K, size, straining + constant) - _nullity(subject, K, size, straining)
    return count


def _nullity(subject: Subject, K: FloatArray, size: float, motions: list[FloatArray]) -> int:
    """Dimension of the part of the span of some motions that causes no forces."""
    if not motions:
        return 0
    vectors = np.array(motions) / subject.scales()
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    left, values, _ = np.linalg.svd(vectors.T, full_matrices=False)
    basis = left[:, values > 1e-10 * values[0]]
    return int(np.sum(np.linalg.svd(K @ basis, compute_uv=False) <= ZERO * size))


def _draw(subject: Subject, values: FloatArray) -> None:
    count = np.arange(1.0, len(values) + 1)
    shown = np.maximum(values, 1e-18)
    curves = [Curve(count, shown, "all"), Curve(count, np.full(len(count), ZERO), "counts as zero")]
    title = "Singular values of the tangent at rest"
    subject.picture(Picture(title, "number", "size over the largest [1]", curves, points=True))
