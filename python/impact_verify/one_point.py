# SPDX-License-Identifier: MIT
"""Cells with one point and hourglass control against their counterpart in the hand-written solver, impact_reference's
one_point.py: elements on random distorted cells, and a free motion of a distorted block, also one that flows."""

from __future__ import annotations

import impact_reference as ref
import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact.assembly import operators
from dolfinx_impact.assembly.jit import compile_form
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.forms import registry
from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.plasticity import J2Plasticity
from . import catalogue, element, matched_body, nodes
from .operator import LAWS
from .report import Report
from .scenarios.explicit_runs import FLOAT_STEPS, IN_FLOAT

# Cell, hypothesis, laws.
ELEMENTS = (
    ("hexahedron", "3d", ("linear_elastic", "neo_hookean")),
    ("quadrilateral", "plane_strain", ("linear_elastic", "st_venant_kirchhoff", "neo_hookean")),
    ("quadrilateral", "plane_stress", ("linear_elastic", "neo_hookean")),
)
KINDS = ("force", "tangent", "energy", "hourglass_energy")
NUM_CELLS = 30
NUM_STEPS = 100
GROWTH = 1e-9
RUN_REASON = "round-off of 100 steps"
# Laws with internal variables: cell, hypothesis, whether strains are finite.
FLOWING = (
    ("hexahedron", "3d", False),
    ("hexahedron", "3d", True),
    ("quadrilateral", "plane_strain", True),
    ("quadrilateral", "plane_stress", True),
)
FLOW_STEPS = 40
FLOW_REASON = "round-off of 40 steps, in which yielding begins at the same step"
SLOPE, YIELD = 0.05, 0.01  # of yield stress over plastic strain, and yield stress [F/L^2]


def run_elements(report: Report) -> None:
    """Add the rows of element tensors.

    Args:
        report: report to add to.
    """
    for cell, hypothesis, laws in ELEMENTS:
        for law in laws if report.wants(cell, 1) else ():
            for kind, (worst, where) in element_differences(law, cell, hypothesis).items():
                name = f"{law}.reduced.{kind}"
                report.add("element", name, cell, 1, 1, hypothesis, worst, element.TOLERANCE, element.REASON,
                           "element tensor", where)  # fmt: skip


def element_differences(law: str, cell: str, hypothesis: str) -> dict[str, tuple[float, str]]:
    """Largest differences of element tensors over random cells.

    Args:
        law: name of the law.
        cell: cell.
        hypothesis: hypothesis of the material.

    Returns:
        By kind of the form, the difference relative to the largest entry of the cell's tensor [1], and a text with the
        worst entry.
    """
    rng, dim = np.random.default_rng([2026, *map(ord, law + cell + hypothesis)]), registry.CELLS[cell]
    order, geometry = nodes.dofs(cell, 1, dim), nodes.permutation(cell, 1)
    values = catalogue.parameters(rng, law, dim)
    material = ref.Material(float(values["E"]), float(values["nu"]), 1.0, hypothesis, law)
    cells = [nodes.random_cell(rng, cell, 1, hypothesis) for _ in range(NUM_CELLS)]
    fields = [0.08 * np.ptp(x, axis=0).min() * rng.uniform(-1, 1, len(order)) for x in cells]
    expected = [
        ref.element_one_point(cell, nodes.to_theirs(x, geometry), material, nodes.to_theirs(u, order))
        for x, u in zip(cells, fields)
    ]
    found = {}
    for kind in KINDS:
        built = registry.build(f"{law}.reduced.{kind}", cell, 1, 1, hypothesis)
        compiled = compile_form(built.form, built.names, MPI.COMM_SELF)
        (kernel,) = compiled.kernels
        w, c = zip(*(element.pack(kernel, compiled, built.names, values, {"u": u}) for u in fields))
        worst, where = 0.0, ""
        for lanes in kernel.widths:
            got = element.tabulate(kernel, cells, w, c[0], 0, lanes)
            for row, their in enumerate(expected):
                a: FloatArray = got[row]
                tensor = _tensor(their, kind)
                for _ in range(kernel.rank):
                    tensor = np.moveaxis(tensor, 0, -1)[..., order]
                b = np.ravel(tensor)
                error: FloatArray = np.abs(a - b) / max(np.max(np.abs(b)), 1e-300)
                k = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
                if not error[k] <= worst:
                    worst = float(error[k])
                    where = element.entry(k, kernel.shape, dim, kernel.rank, lanes, None, a[k], b[k])
        found[kind] = worst, where
    return found


def _tensor(forces: ref.OnePointForces, kind: str) -> FloatArray:
    if kind == "energy":
        return np.array([forces.energy])
    if kind == "hourglass_energy":
        return np.array([forces.hourglass])
    return forces.force if kind == "force" else forces.tangent


def run_motion(report: Report) -> None:
    """Add the rows of a free motion.

    Args:
        report: report to add to.
    """
    for cell, hypothesis, laws in ELEMENTS[:2]:
        for law in laws if report.wants(cell, 1) else ():
            rows = motion_differences(law, cell, hypothesis)
            for name, worst in rows.items():
                report.add("history", f"{law}.reduced", cell, 1, 1, hypothesis, worst, GROWTH, RUN_REASON, name)
            if cell == "hexahedron":
                in_float = IN_FLOAT[law]
                for name, worst in motion_differences(law, cell, hypothesis, "mixed", FLOAT_STEPS).items():
                    report.add("history", f"{law}.reduced", cell, 1, 1, hypothesis, worst, in_float.tolerance,
                               in_float.reason, f"mixed precision, {name}")  # fmt: skip


def run_flow(report: Report) -> None:
    """Add the rows of a free motion in which cells and their hourglass modes flow.

    Args:
        report: report to add to.
    """
    for cell, hypothesis, finite in FLOWING:
        if report.wants(cell, 1):
            for name, worst in flow_differences(cell, hypothesis, finite).items():
                law = f"j2.{'finite' if finite else 'small'}.linear.reduced"
                report.add("history", law, cell, 1, 1, hypothesis, worst, GROWTH, FLOW_REASON, name)


def flow_differences(cell: str, hypothesis: str, finite: bool) -> dict[str, float]:
    """Differences of the free motion of a distorted block with linear hardening, whose modes flow.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        finite: whether strains are finite.

    Returns:
        Difference relative to the largest value, by quantity [1].
    """
    domain = distorted_block.block(cell, 2)
    material = J2Plasticity(
        2.0, 0.3, 1.5, YIELD, SLOPE, finite_strain=finite, hypothesis=hypothesis, integration="reduced"
    )
    body = matched_body.Body(domain, 1, material)
    u, velocity, dim = fem.Function(body.V), fem.Function(body.V), body.gdim
    velocity.interpolate(lambda x: 0.08 * np.array([np.cos(3 * x[i] + 2 * x[(i + 1) % dim]) for i in range(dim)]))
    start = velocity.x.array.copy()
    problem = ExplicitProblem(u, material, velocity=velocity)
    dt = 0.4 * problem.stable_step()
    problem.advance(FLOW_STEPS * dt, dt=dt, progress=False)
    model = body.model
    run = ref.run_one_point_plastic(
        model.points, model.cells, cell, body.their_material, ref.J2Parameters(2.0, 0.3, YIELD, SLOPE), SLOPE,
        "simo" if finite else "small", body.to_theirs(start).reshape(-1, dim), dt, problem.step,
    )  # fmt: skip
    ours = body.to_theirs(u.x.array).reshape(-1, dim)
    strain = problem.history["plastic_strain"].values.max()
    return {
        "displacement": float(np.max(np.abs(ours - run.displacement))) / float(np.max(np.abs(run.displacement))),
        "plastic strain": abs(float(strain) / float(run.plastic_strain.max()) - 1.0),
        "elastic energy": abs(problem.energy["internal"] / run.internal - 1.0),
        "hourglass energy": abs(problem.energy["hourglass"] / run.hourglass - 1.0),
    }


def motion_differences(
    law: str, cell: str, hypothesis: str, precision: str = "double", steps: int = NUM_STEPS
) -> dict[str, float]:
    """Differences of the free motion of a distorted block: displacement, strain and hourglass energy at the end.

    Args:
        law: name of the law.
        cell: cell.
        hypothesis: hypothesis of the material.
        precision: of the element forces on our side.
        steps: number of steps [1].

    Returns:
        Difference relative to the largest value, by quantity [1].
    """
    domain = distorted_block.block(cell, 3)
    material = LAWS[law](2.0, 0.3, 1.5, hypothesis, "reduced")
    body = matched_body.Body(domain, 1, material, law)
    u, velocity, dim = fem.Function(body.V), fem.Function(body.V), body.gdim
    velocity.interpolate(lambda x: 0.03 * np.array([np.cos(3 * x[i] + 2 * x[(i + 1) % dim]) for i in range(dim)]))
    start = velocity.x.array.copy()
    problem = ExplicitProblem(u, material, velocity=velocity, precision=precision)
    dt = 0.5 * problem.stable_step()
    problem.advance(steps * dt, dt=dt, progress=False)
    model = body.model
    run = ref.run_one_point(
        model.points, model.cells, cell, body.their_material, body.to_theirs(start).reshape(-1, dim), dt, problem.step
    )
    ours = body.to_theirs(u.x.array).reshape(-1, dim)
    size = float(np.max(np.abs(run.displacement)))
    strain_energy = operators.Energy(operators.strain_energy_form(u, material)).value()
    return {
        "displacement": float(np.max(np.abs(ours - run.displacement))) / size,
        "strain energy": abs(strain_energy / run.internal - 1.0),
        "hourglass energy": abs(problem.energy["hourglass"] / run.hourglass - 1.0),
    }
