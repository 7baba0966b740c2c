# SPDX-License-Identifier: MIT
"""Check of parameters that change in time: a constant ramped in an implicit run, second order in the step."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.implicit.newmark_problem import NewmarkProblem
from .assembled import AssembledForm, quick_form
from .fields import fields_of
from .findings import Curve, Picture
from dolfinx_impact.own_forms.own_form import made
from .patch import boundary_dofs
from .subject import Subject

TOLERANCE, REASON = 0.2, "order of differences of three runs, 20 to 80 steps, against 2"
STEPS = (20, 40, 80)
RAMP = 0.5  # by which a parameter grows in the run, of its own size [1]
END = 2.0  # of the run, whose density makes the stiffness over the mass of the order of one [T]


def parameters(subject: Subject) -> None:
    """Do constants act when they are changed, at the time for which they are set?

    Args:
        subject: the form.
    """
    check = "parameters"
    if not subject.own.parameters:
        subject.leave_out(check, "no parameters are named: give parameters={'name': constant}")
        return
    if not isinstance(subject.assembled, AssembledForm):
        subject.leave_out(check, "a material with internal variables")
        return
    idle = []
    for name, constant in subject.own.parameters.items():
        before = np.array(constant.value)
        constant.value = before * (1 + RAMP) + (before == 0.0)
        change = subject.size(subject.assembled.vector(subject.state) - subject.forces) + _dead(
            subject, constant, before
        )
        constant.value = before
        if change <= 1e-12:
            idle.append(name)
    if idle:
        subject.add(
            check, np.inf, TOLERANCE, REASON, "",
            f"a change of {', '.join(idle)} changes nothing: the form does not contain the constant. A number that was "
            "read when the form was written (float(c), c.value) stays as it was",
        )  # fmt: skip
        return
    if subject.displacement is None or len(subject.fields) > 1 or subject.own.grounded:
        subject.leave_out(check, "constants act; a run with them needs an unknown that is a displacement alone")
        return
    _run(subject)


def _dead(subject: Subject, constant: fem.Constant, before: FloatArray) -> float:
    """Change of the dead loads by the present value of a constant, relative to their size."""
    form = subject.assembled
    assert isinstance(form, AssembledForm)
    if form.dead is None:
        return 0.0
    compiled = quick_form(form.dead)
    after = np.array(fem.assemble_vector(compiled).array)
    now, constant.value = np.array(constant.value), before
    change = after - fem.assemble_vector(compiled).array
    constant.value = now
    return float(np.abs(change).max() / max(np.abs(after).max(), 1e-300))


def _run(subject: Subject) -> None:
    check = "parameters"
    name = next(iter(subject.own.parameters))
    try:
        ends = [_end(subject, name, n) for n in STEPS]
    except (RuntimeError, ValueError) as e:
        subject.add(check, np.inf, TOLERANCE, REASON, "", f"the run with {name} ramped fails: {e}")
        return
    coarse, fine = np.linalg.norm(ends[0] - ends[1]), np.linalg.norm(ends[1] - ends[2])
    order = float(np.log2(coarse / fine)) if fine > 0.0 else np.inf
    size = np.linalg.norm(ends[2])
    subject.picture(
        Picture(f"{name} ramped in time, implicit run", "number of steps", "change with half the step [1]",
                [Curve(np.array(STEPS[:2], dtype=float), np.array([coarse, fine]) / size, f"order {order:.2f}", -2.0)])
    )  # fmt: skip
    small = fine / size < 1e-10
    subject.add(
        check, 0.0 if small else max(2.0 - order, 0.0), TOLERANCE, REASON,
        f"{', '.join(subject.own.parameters)} act when they change; with {name} ramped in time the displacement "
        f"converges with order {order:.2f} in the step",
        f"with {name} ramped in time the displacement converges with order {order:.2f} in the step in place of 2: its "
        "value acts late, or the form keeps an old one",
    )  # fmt: skip


def _end(subject: Subject, name: str, steps: int) -> FloatArray:
    """Displacement at the end of a run with a parameter ramped; the boundary is held, the inside thrown."""
    own = made(subject.make, subject.name, subject.mesh_of(2))
    V, constant = own.u.function_space, own.parameters[name]
    before = np.array(constant.value)
    # A density by which the block swings once or so in the run.
    density = float(abs(AssembledForm(own).matrix(np.array(own.u.x.array))).max())
    (field,) = fields_of(V)
    held = boundary_dofs(field)
    inner = np.setdiff1d(field.dofs, held)
    velocity = fem.Function(V)
    velocity.x.array[inner] = 0.1 * own.strain * np.cos(np.arange(len(inner)))
    clamp = fem.dirichletbc(np.zeros(subject.gdim), np.unique(held // subject.gdim).astype(np.int32), V)
    problem = NewmarkProblem(
        own.u, residual=own.residual, density=density, velocity=velocity, bcs=[clamp], hypothesis=own.hypothesis
    )

    def ramp(_: NewmarkProblem, time: float) -> None:
        constant.value = before + RAMP * (before + (before == 0.0)) * time / END

    problem.advance(END, dt=END / steps, update=ramp, progress=False, rtol=1e-12)
    return np.array(own.u.x.array)
