# SPDX-License-Identifier: MIT
"""A checkpoint is refused by a problem of which any argument is another one, and the argument is named.

The table has a row for every argument of every public class that a problem in time is made of; a new argument without
a row fails the test.
"""

import functools
import inspect
from types import SimpleNamespace

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

DT = 1e-3
EXPLICIT, IMPLICIT = di.ExplicitProblem, di.NewmarkProblem


class Creeping(di.InelasticMaterial):
    """A law of one's own: elastic, with a history that counts the strain."""

    history = {"largest": ()}

    def __init__(self, *given, viscosity=1.0, **named):
        super().__init__(*given, **named)
        self.viscosity = viscosity

    def respond(self, strain, history, unknown):
        stress = 2.0 * ufl.sym(strain) * self.constant(body().mesh, "viscosity", self.viscosity)
        outputs = {"largest": history["largest"] + ufl.tr(strain)}
        return di.MaterialUpdate(stress, outputs, 0.5 * ufl.inner(stress, strain))


class CreepingOtherwise(Creeping):
    """The same with another stress."""

    def respond(self, strain, history, unknown):
        stress = 2.5 * ufl.sym(strain) * self.constant(body().mesh, "viscosity", self.viscosity)
        outputs = {"largest": history["largest"] + ufl.tr(strain)}
        return di.MaterialUpdate(stress, outputs, 0.5 * ufl.inner(stress, strain))


@functools.cache
def body():
    """Two blocks with a small gap, and tags that lack one facet, or have one cell elsewhere."""
    size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (3, 2), "upper_cells": (2, 2)}
    made = meshes.make("two_blocks", MPI.COMM_SELF, gap=1e-4, **size)
    b = SimpleNamespace(mesh=made.mesh, facets=made.facet_tags, cells=made.cell_tags, **made.tags)
    b.V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))

    def fewer(tag):
        kept = np.ones(len(b.facets.indices), dtype=bool)
        kept[np.flatnonzero(b.facets.values == tag)[0]] = False
        return mesh.meshtags(b.mesh, 1, b.facets.indices[kept], b.facets.values[kept])

    b.fewer_below, b.fewer_above = fewer(b.slave_surface), fewer(b.top)
    values = b.cells.values.copy()
    values[0] = b.slave_body + b.master_body - values[0]
    b.other_cells = mesh.meshtags(b.mesh, 2, b.cells.indices, values)
    b.x = ufl.SpatialCoordinate(b.mesh)
    b.fields = [fem.Function(b.V), fem.Function(b.V)]
    for k, f in enumerate(b.fields):
        f.x.array[:] = k + 1.0
    bottom = fem.locate_dofs_topological(b.V, 1, b.facets.find(b.bottom))
    b.held = [fem.dirichletbc(np.array([0.0, v]), bottom, b.V) for v in (0.01, 0.02)]
    return b


def wavy(amplitude):
    return di.RigidSurface.from_function(lambda x: amplitude * np.sin(x) - 0.1, (-1.0, 3.0), (0.0, 0.5), (0.0, 1.0))


def normals(tilt):
    return lambda x: np.vstack([tilt * np.sin(9.0 * x[0]), np.where(x[1] > 0.50005, -1.0, 1.0)])


class Made:
    """A problem in time, made of BASE with changes: {class: {argument: value}}; some choose its parts."""

    def __init__(self, integrator, chosen, changes):
        self.integrator, self.chosen, self.changes = integrator, chosen, changes

    def of(self, kind, **given):
        """An object of a class with its arguments, changed where that is asked for."""
        return kind(**{**given, **self.changes.get(kind, {})})

    def material(self):
        b, name = body(), self.chosen.get("material", di.LinearElastic)
        solid = {"E": 1e3, "nu": 0.3, "density": 1.0, "hypothesis": "plane_strain"}
        plastic = {**solid, "yield_stress": 5.0}
        if name is di.MaterialMap:
            steel = di.LinearElastic(**solid)
            return self.of(di.MaterialMap, cell_tags=b.cells, materials={b.slave_body: steel, b.master_body: steel})
        if name in (di.Voce, di.Table):
            given = {"saturation": 9.0, "rate": 7.0, "modulus": 20.0}
            if name is di.Table:
                given = {"strains": (0.0, 0.1), "stresses": (5.0, 6.0)}
            return di.J2Plasticity(**plastic, hardening=self.of(name, **given))
        if name is di.ArmstrongFrederick:
            return di.J2Plasticity(**plastic, kinematic=self.of(name, modulus=20.0, recovery=3.0))
        if name is Creeping:
            return self.of(self.changes.get("law", name), **solid)
        return self.of(name, **(plastic if name is di.J2Plasticity else solid))

    def load(self):
        b, name = body(), self.chosen.get("load", di.BodyForce)
        on = {"facet_tags": b.facets, "tag": b.top}
        given = {
            di.BodyForce: {"vector": (0.0, -9.0), "amplitude": lambda t: 1.0 + t},
            di.Traction: {**on, "vector": (0.0, -1.0), "amplitude": lambda t: 1.0 + t},
            di.FollowerPressure: {**on, "pressure": 1.0}, di.Foundation: {**on, "stiffness": 3.0, "damping": 0.1},
            di.AddedMass: {**on, "mass": 0.1},
        }[name]  # fmt: skip
        return self.of(name, **given)

    def master(self):
        b, name = body(), self.chosen.get("master")
        if name is None:
            return b.master_surface
        if name is di.RigidSurface:
            return wavy(self.changes["surface"])
        if name is di.RigidBody:
            return self.of(
                di.RigidBody, surface=di.RigidCylinder((0.7, -9.5), 10.0), mass=50.0, inertia=2e3, centre=(0.7, -9.0),
                velocity=(0.0, 0.1), spin=0.01, force=lambda t: (0.0, 1.0, 0.0), torque=lambda t: (0.0, 0.0, t),
                fixed=("x",),
            )  # fmt: skip
        given = {
            di.RigidPlane: {"point": (0.0, 0.49), "normal": (0.0, 1.0)},
            di.RigidSphere: {"center": (0.7, -9.5), "radius": 10.0},
            di.RigidCylinder: {"center": (0.7, -9.5), "radius": 10.0},
        }[name]  # fmt: skip
        made = self.of(name, **given)
        made.motion, made.displacement = self.changes.get("motion"), self.changes.get("displacement", (0.0, 0.0))
        made.angle = self.changes.get("angle")
        if "pivot" in self.changes:
            made.pivot = self.changes["pivot"]
        return made

    def problem(self):
        b, contact = body(), self.changes.get("contact", self.chosen.get("contact", di.Penalty))
        if self.changes.get("exact"):
            contact = di.Kinematic if self.integrator is EXPLICIT else di.Lagrange
        pair = self.of(
            di.ContactPair, facet_tags=b.facets, slave=b.slave_surface, master=self.master(),
            friction=0.0 if contact is di.Tie else 0.3, search_distance=0.9, smooth=self.changes.get("smooth", False),
        )  # fmt: skip
        u, velocity = fem.Function(b.V), fem.Function(b.V)
        velocity.x.array.reshape(-1, 2)[:, 1] = -0.5
        surfaces = {"pair": pair}
        if contact is di.GeneralContact:
            surfaces = {"facet_tags": b.facets, "tags": (b.slave_surface, b.master_surface, b.top), "friction": 0.3}
        given = {"u": u, "velocity": velocity, "contact": [self.of(contact, **surfaces)]}
        given |= {"bcs": [self.of(di.PrescribedMotion, bc=b.held[0], amplitude=lambda t: t)]}
        if self.chosen.get("residual"):
            one, which = self.changes.get("form", (1.0, 0))
            v, factor = ufl.TestFunction(b.V), fem.Constant(b.mesh, one)
            residual = factor * 1e3 * ufl.inner(ufl.sym(ufl.grad(u)), ufl.grad(v)) * ufl.dx
            given |= {"residual": residual - ufl.inner(b.fields[which], v) * ufl.dx, "density": 1.0}
        else:
            given |= {"material": self.material(), "loads": [self.load()]}
            given["damping"] = self.of(di.Rayleigh, alpha=0.1, beta=1e-5)
        for name, values in self.changes.get("state", {}).items():
            free = np.setdiff1d(np.arange(len(u.x.array)), b.held[0].dof_indices()[0])
            given[name].x.array[free] = values
        return self.of(self.integrator, **given)


def pressed(stiffness, power=lambda gap: -gap):
    """Contact by a law of the interface: changes of the pair and of its method."""

    def pressure(gap, parameters):
        return ufl.max_value(parameters.stiffness * power(gap), 0)

    law = di.InterfaceLaw(pressure, parameters={"stiffness": stiffness}, reach=0.1)
    return {di.ContactPair: {"friction": 0.0}, di.Penalty: {"law": law}}


def rubbed(power):
    """Friction by a law, in a method that takes it: changes of the pair."""
    law = di.FrictionLaw(lambda pressure, parameters: parameters.mu / (1 + pressure) ** power, parameters={"mu": 0.3})
    return {di.ContactPair: {"friction": law}, "exact": True}


STATE = "state: the checkpoint has it"
ELSEWHERE = "in rows of its own class"
NO_MATTER = "does not belong to the problem"
OF_TAGS = {"facet_tags": lambda b: b.fewer_above, "tag": lambda b: b.bottom}
# Other integrations are for other cells: tests/verification/test_one_point.py,
# tests/unit/assembly/averaged_pressure_checks.py.
SOLID = {"E": 1.1e3, "nu": 0.31, "density": 1.1, "hypothesis": "plane_stress", "integration": ELSEWHERE}
UP = {"vector": (0.0, 9.0), "amplitude": lambda t: 1.0 + 2.0 * t}
# Of each class: what the problem is made of besides, and per argument another value, or why there is none.
ROWS = {
    EXPLICIT: ({}, {
        "u": STATE, "material": ELSEWHERE, "residual": ELSEWHERE, "density": ELSEWHERE, "velocity": STATE,
        "bcs": [], "loads": [], "contact": [], "damping": None, "bulk_viscosity": (0.06, 1.2),
        "scheme": ELSEWHERE, "lumping": ELSEWHERE, "mass_scaling": 1e-2, "hypothesis": ELSEWHERE, "tangent": NO_MATTER,
        "precision": ELSEWHERE,  # of 3D bodies: tests/unit/dynamics/test_precision.py
    }),
    IMPLICIT: ({}, {
        "u": STATE, "material": ELSEWHERE, "residual": ELSEWHERE, "density": ELSEWHERE, "velocity": STATE,
        "bcs": [], "loads": [], "contact": [], "beta": 0.3, "gamma": 0.55, "rho_inf": 0.8, "hht": -0.1,
        "damping": None, "lumping": "auto", "impact": "none", "options": NO_MATTER, "prefix": NO_MATTER,
        "hypothesis": ELSEWHERE, "tangent": NO_MATTER, "evaluate": NO_MATTER, "accept": NO_MATTER,
    }),
    di.LinearElastic: ({}, SOLID), di.NeoHookean: ({"material": di.NeoHookean}, SOLID),
    di.StVenantKirchhoff: ({"material": di.StVenantKirchhoff}, SOLID),
    di.InelasticMaterial: ({"material": Creeping}, {name: ELSEWHERE for name in SOLID}),
    Creeping: ({"material": Creeping}, {"given": ELSEWHERE, "named": ELSEWHERE, "viscosity": 2.0}),
    di.J2Plasticity: ({"material": di.J2Plasticity}, {
        **SOLID, "yield_stress": 6.0, "hardening": 1.0, "kinematic": 1.0, "finite_strain": True, "average": False,
    }),
    di.Voce: ({"material": di.Voce}, {"saturation": 10.0, "rate": 8.0, "modulus": 21.0}),
    di.Table: ({"material": di.Table}, {"strains": (0.0, 0.2), "stresses": (5.0, 7.0)}),
    di.ArmstrongFrederick: ({"material": di.ArmstrongFrederick}, {"modulus": 21.0, "recovery": 4.0}),
    di.MaterialMap: ({"material": di.MaterialMap}, {"cell_tags": lambda b: b.other_cells, "materials": ELSEWHERE}),
    di.Rayleigh: ({}, {"alpha": 0.2, "beta": 2e-5}),
    di.BodyForce: ({}, {**UP, "per_mass": False}),
    di.Traction: ({"load": di.Traction}, {**OF_TAGS, **UP}),
    di.FollowerPressure: ({"load": di.FollowerPressure}, {**OF_TAGS, "pressure": 2.0}),
    di.Foundation: ({"load": di.Foundation}, {**OF_TAGS, "stiffness": 4.0, "damping": 0.2}),
    di.AddedMass: ({"load": di.AddedMass}, {**OF_TAGS, "mass": 0.2}),
    di.ContactPair: ({}, {
        "facet_tags": lambda b: b.fewer_below, "slave": lambda b: b.top, "master": lambda b: b.bottom, "friction": 0.2,
        "search_distance": 0.8, "remove_penetration": ELSEWHERE, "name": NO_MATTER, "smooth": True, "crease": 20.0,
        "clearance": 0.03, "offset": 0.02, "adjust": 0.01,
    }),
    di.Lagrange: ({"contact": di.Lagrange}, {"pair": ELSEWHERE, "quadrature_degree": 3, "basis": "standard"}),
    di.Penalty: ({}, {
        "pair": ELSEWHERE, "penalty": 1e4, "tangential": 2e4, "augmented": True, "tolerance": 1e-4,
        "quadrature_degree": 3, "balanced": True, "max_augmentations": 9, "law": ELSEWHERE,
    }),
    di.Kinematic: ({"contact": di.Kinematic}, {"pair": ELSEWHERE, "sweeps": 2}),
    di.Tie: ({"contact": di.Tie}, {
        "pair": ELSEWHERE, "directions": "normal", "partial": True, "quadrature_degree": 3, "basis": "standard",
    }),
    di.GeneralContact: ({"contact": di.GeneralContact}, {
        "facet_tags": lambda b: b.fewer_below, "tags": lambda b: (b.slave_surface, b.master_surface), "friction": 0.2,
        "name": NO_MATTER,
    }),
    di.RigidPlane: ({"master": di.RigidPlane}, {"point": (0.0, 0.48), "normal": (0.01, 1.0)}),
    di.RigidSphere: ({"master": di.RigidSphere}, {"center": (0.8, -9.5), "radius": 9.9}),
    di.RigidCylinder: ({"master": di.RigidCylinder}, {"center": (0.8, -9.5), "radius": 9.9, "axis": (0.0, 0.0, -1.0)}),
    di.RigidBody: ({"master": di.RigidBody}, {
        "surface": di.RigidCylinder((0.7, -9.6), 10.1), "mass": 51.0, "inertia": 2.1e3, "centre": (0.7, -9.1),
        "velocity": (0.0, 0.2), "spin": 0.02, "force": lambda t: (0.0, 1.0 + t, 0.0), "torque": None,
        "fixed": ("y",), "meets": di.RigidPlane((0.0, -30.0), (0.0, 1.0)), "friction": ELSEWHERE,
    }),
    di.PrescribedMotion: ({}, {"bc": lambda b: b.held[1], "amplitude": lambda t: 2.0 * t}),
}  # fmt: skip
WORDS = {"beta": "beta|scheme", "gamma": "scheme", "rho_inf": "scheme", "hht": "scheme", "bcs": "supports|functions of",
         "bc": "supports", "facet_tags": "facet_tags|slave|tag", "cell_tags": "cells", "mass_scaling": "mass",
         "amplitude": "functions of time", "density": "density", "mass": "mass",
         "normal": "master.normal", "clearance": "remove_penetration", "offset": "remove_penetration",
         "adjust": "remove_penetration", "surface": "master", "inertia": "master", "centre": "master",
         "velocity": "master", "spin": "master", "force": "functions of time",
         "torque": "functions of time"}  # fmt: skip
# Further changes, of functions, forms, motions, laws of one's own: (parts, first, then, words).
MORE = {
    "an amplitude that is left out": ({}, {}, {di.BodyForce: {"amplitude": None}}, "loads.0..amplitude"),
    "a constant in the residual": ({"residual": True}, {}, {"form": (2.0, 0)}, "residual.constants"),
    "a function in the residual": ({"residual": True}, {}, {"form": (1.0, 1)}, "residual.function 0"),
    "the density of a residual": (
        {"residual": True}, {}, {EXPLICIT: {"density": 2.0}, IMPLICIT: {"density": 2.0}}, "density",
    ),
    "how masses are lumped": ({}, {}, dict.fromkeys((EXPLICIT, IMPLICIT), {"lumping": "row_sum"}), "lumping"),
    # Damping with stiffness is refused in the scheme "classical".
    "the scheme": (
        {}, {EXPLICIT: {"damping": None}},
        {EXPLICIT: {"damping": None, "scheme": "classical"}, IMPLICIT: {"hht": -0.2}}, "scheme",
    ),
    "the shape of an obstacle": (
        {"master": di.RigidSurface}, {"surface": 0.01}, {"surface": 0.02}, "contact.0..pair.master",
    ),
    "the motion of an obstacle": (
        {"master": di.RigidPlane}, {}, {"motion": lambda t: (0.0, 0.0, 0.0)}, "contact.0..pair.master",
    ),
    "the place of an obstacle": (
        {"master": di.RigidPlane}, {}, {"displacement": (0.0, 0.001)}, "contact.0..pair.master",
    ),
    "the angle of an obstacle": (
        {"master": di.RigidCylinder}, {}, {"angle": lambda t: (0.0, 0.0, t)}, "contact.0..pair.master",
    ),
    "how fast an obstacle turns": (
        {"master": di.RigidCylinder}, {"angle": lambda t: (0.0, 0.0, t)}, {"angle": lambda t: (0.0, 0.0, 2.0 * t)},
        "functions of time",
    ),
    "where an obstacle turns": (
        {"master": di.RigidCylinder}, {"angle": (0.0, 0.0, 0.0)}, {"angle": (0.0, 0.0, 0.0), "pivot": (0.7, -9.4)},
        "contact.0..pair.master",
    ),
    "normals of a smooth surface": ({}, {"smooth": normals(0.0)}, {"smooth": normals(0.3)}, "pair.smooth"),
    "how a law responds": ({"material": Creeping}, {}, {"law": CreepingOtherwise}, "material"),
    "surfaces of a tie": (
        {"contact": di.Tie}, {}, {di.ContactPair: {"search_distance": 0.8}}, "contact.0..pair.search_distance",
    ),
    "a tie instead of a contact": ({}, {}, {"contact": di.Tie}, "contact"),
    "a law of the interface": ({}, pressed(1e3), pressed(1e3, lambda gap: -gap**3), "contact.0..law"),
    "a law of friction": ({}, rubbed(1), rubbed(2), "contact.0..pair.friction"),
    "parameters of a law of the interface": ({}, pressed(1e3), pressed(2e3), "contact.0..law"),
}  # fmt: skip


def expressions():
    """Loads whose value is an expression: another one, another function in it, another constant in it."""
    b = body()
    two = [fem.Constant(b.mesh, v) for v in (1.0, 2.0)]
    for kind, key in ((di.BodyForce, "vector"), (di.Traction, "vector"), (di.Foundation, "stiffness")):
        first = ufl.as_vector([two[0] * b.x[0], b.fields[0][1]])
        for other in (
            ufl.as_vector([two[0] * b.x[1], b.fields[0][1]]), ufl.as_vector([two[0] * b.x[0], b.fields[1][1]]),
            ufl.as_vector([two[1] * b.x[0], b.fields[0][1]]),
        ):  # fmt: skip
            yield kind, key, first, other


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory):
    """Function that makes a checkpoint of a problem after some steps; one file for all rows of the same problem."""
    folder, saved = tmp_path_factory.mktemp("checkpoints"), {}

    def make(integrator, chosen, changes):
        key = integrator, repr(chosen), repr(changes)
        if key not in saved:
            problem, same = (Made(integrator, chosen, changes).problem() for _ in range(2))
            steps = {"dt": DT} if integrator is IMPLICIT else {"dt": DT, "unsafe": True}
            problem.advance(4 * DT, progress=False, **steps)
            saved[key] = folder / f"{len(saved)}.h5"
            problem.save(saved[key])
            same.restore(saved[key])
            assert same.step == problem.step > 0
        return saved[key]

    return make


def takes(integrator, kind, name):
    """Whether problems of an integrator take an argument of a class."""
    only = {
        di.Lagrange: IMPLICIT,
        di.Kinematic: EXPLICIT,
        EXPLICIT: EXPLICIT,
        IMPLICIT: IMPLICIT,
    }
    static = kind is di.Penalty and name in (
        "tangential", "augmented", "quadrature_degree", "tolerance", "max_augmentations",
    )  # fmt: skip
    if static or (kind, name) in ((di.Penalty, "balanced"), (di.RigidBody, "meets")):
        return integrator is (IMPLICIT if static else EXPLICIT)
    return only.get(kind, integrator) is integrator


@pytest.mark.parametrize("kind", ROWS, ids=lambda kind: kind.__name__)
def test_every_argument_has_a_row(kind):
    taken = [p for p in inspect.signature(kind.__init__).parameters if p != "self"]
    assert set(ROWS[kind][1]) == set(taken), f"{kind.__name__}: write a row for its new argument"


def test_every_public_class_has_rows():
    """But what is no part of a problem in time: static and rolling problems, operators, and results; laws of the
    interface, whose rows are in MORE."""
    others = {
        "AmplitudeTable", "ContactStatus", "DeformedBody", "Energy", "FrictionLaw", "InterfaceLaw",
        "InterfaceUpdate", "InternalForce", "MaterialFlow", "MaterialUpdate", "PartitionedMesh", "PointValues",
        "RigidSurface", "RollingProblem", "Spin", "StaticProblem", "Tangent", "Translation", "Units",
    }  # fmt: skip
    classes = {name for name in di.__all__ if isinstance(getattr(di, name), type)}
    assert classes == others | {kind.__name__ for kind in ROWS if kind is not Creeping}


TABLE = [
    pytest.param(integrator, kind, name, id=f"{integrator.__name__[:8]}-{kind.__name__}-{name}")
    for integrator in (EXPLICIT, IMPLICIT)
    for kind, (_, row) in ROWS.items()
    for name, value in row.items()
    if takes(integrator, kind, name) and not (isinstance(value, str) and value in (STATE, ELSEWHERE, NO_MATTER))
]


def repeats(integrator, kind, name):
    """Explicit problems where implicit ones have the row, and what laws have from the class that they share: the row of
    LinearElastic. What is left to `make verify` are kernels of other hypotheses."""
    inherited = kind in (di.NeoHookean, di.StVenantKirchhoff, di.J2Plasticity) and name in (
        "nu",
        "density",
        "hypothesis",
    )
    return inherited or (integrator is EXPLICIT and takes(IMPLICIT, kind, name))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.long_rows(where=repeats)
@pytest.mark.parametrize("integrator, kind, name", TABLE)
def test_another_argument_is_refused(integrator, kind, name, checkpoint):
    chosen, row = ROWS[kind]
    value = row[name]
    if callable(value) and "amplitude" not in name and name != "force":
        value = value(body())
    path = checkpoint(integrator, chosen, {})
    refuse(Made(integrator, chosen, {kind: {name: value}}), path, WORDS.get(name, name))


def refuse(made, path, words):
    problem = made.problem()
    before = problem.u.x.array.copy()
    with pytest.raises(ValueError, match=f"of another problem.*({words})"):
        problem.restore(path)
    np.testing.assert_array_equal(problem.u.x.array, before)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("integrator", (EXPLICIT, IMPLICIT))
@pytest.mark.parametrize("row", MORE)
def test_other_functions_are_refused(row, integrator, checkpoint):
    chosen, first, then, words = MORE[row]
    path = checkpoint(integrator, chosen, first)
    refuse(Made(integrator, chosen, then), path, words)


@pytest.mark.filterwarnings("ignore")
def test_what_explicit_problems_do_not_take(checkpoint):
    then = {di.ContactPair: {"remove_penetration": True}}
    refuse(Made(IMPLICIT, {}, then), checkpoint(IMPLICIT, {}, {}), "remove_penetration")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("integrator", (EXPLICIT, IMPLICIT))
def test_other_expressions_are_refused(integrator, checkpoint):
    for kind, key, first, other in expressions():
        path = checkpoint(integrator, {"load": kind}, {kind: {key: first}})
        refuse(Made(integrator, {"load": kind}, {kind: {key: other}}), path, f"loads.0..{key}")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("integrator", (EXPLICIT, IMPLICIT))
def test_the_state_and_names_may_be_others(integrator, checkpoint):
    """What the checkpoint replaces, and what does not belong to the problem."""
    path = checkpoint(integrator, {}, {})
    changes = {"state": {"u": 1e-6, "velocity": 0.3}, di.ContactPair: {"name": "another"}}
    if integrator is IMPLICIT:
        changes[IMPLICIT] = {"options": {"ksp_rtol": 1e-11}, "prefix": "mine_"}
    problem, same = Made(integrator, {}, changes).problem(), Made(integrator, {}, {}).problem()
    for one in (problem, same):
        one.restore(path)
    np.testing.assert_array_equal(problem.u.x.array, same.u.x.array)
    np.testing.assert_array_equal(problem.velocity.x.array, same.velocity.x.array)
