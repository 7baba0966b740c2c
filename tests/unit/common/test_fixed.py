# SPDX-License-Identifier: MIT
"""What problems read when they are made cannot be changed afterwards: all attributes of all classes, but those that
are documented to be followed. The checks on ranks are in fixed_checks.py."""

import contextlib
import copy
import pickle

import fixed_checks
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di
from dolfinx_impact.common.fixed import Fixed, read_only
from dolfinx_impact.common.unique import Unique

test_one_rank, test_several_ranks = rank_tests(fixed_checks)

# What may be set, with a value: obstacles that move between solves, rolling at another speed.
FOLLOWED = {
    **{(kind, "displacement"): (0.0, 0.1) for kind in ("RigidPlane", "RigidSphere", "RigidCylinder", "RigidSurface")},
    **{(kind, "motion"): None for kind in ("RigidPlane", "RigidSphere", "RigidCylinder", "RigidSurface")},
    **{(kind, "velocity"): (0.1, 0.0) for kind in ("RigidPlane", "RigidSphere", "RigidCylinder", "RigidSurface")},
    **{(kind, "angle"): (0.0, 0.0, 0.1) for kind in ("RigidPlane", "RigidSphere", "RigidCylinder", "RigidSurface")},
    **{(kind, "pivot"): (0.1, 0.0, 0.0) for kind in ("RigidPlane", "RigidSphere", "RigidCylinder", "RigidSurface")},
    ("RigidBody", "external_force"): (0.0, 0.0, 1.0),
    ("RigidBody", "external_torque"): (0.0, 0.0, 1.0),
    ("Spin", "omega"): 2.0,
    ("Translation", "velocity"): (0.1, 0.0),
}


# Made for every call: the rate of motions is that of their omega or velocity.
MADE_ANEW = ("rate", "adjustment", "external_force", "external_torque")


class OwnLaw(di.InelasticMaterial):
    """A law with an attribute of its own, set after those of its base."""

    history = {"flow": ()}

    def __init__(self, rate):
        super().__init__(1.0, 0.3, 1.0)
        self.rate = rate


@pytest.fixture(scope="module")
def described():
    """One object of each class that a problem is described with."""
    square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    top = mesh.locate_entities_boundary(square, 1, lambda x: np.isclose(x[1], 1.0))
    tags = mesh.meshtags(square, 1, np.sort(top), np.full(len(top), 1, dtype=np.int32))
    cells = mesh.meshtags(square, 2, np.arange(8, dtype=np.int32), np.full(8, 1, dtype=np.int32))
    law = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    pair = di.ContactPair(tags, 1, 2)
    fixed = fem.dirichletbc(np.zeros(2), np.array([0], dtype=np.int32), V)
    plastic = di.J2Plasticity(1.0, 0.3, 1.0, yield_stress=0.1, kinematic=di.ArmstrongFrederick(1.0))
    return [
        law, di.NeoHookean(1.0, 0.3), di.StVenantKirchhoff(1.0, 0.3), di.MaterialMap(cells, {1: law}), di.Rayleigh(1.0),
        plastic, OwnLaw(2.0), di.Voce(1.0, 2.0), di.Table([0, 1], [1, 2]), di.ArmstrongFrederick(1.0),
        di.BodyForce((0, -1)), di.BodyForce(ufl.SpatialCoordinate(square)), di.Traction(tags, 1, [0, 1]),
        di.FollowerPressure(tags, 1, 2.0), di.Foundation(tags, 1, 3.0, 0.1), di.AddedMass(tags, 1, 2.0),
        di.PrescribedMotion(fixed, lambda t: t), pair, di.Penalty(pair), di.Lagrange(pair), di.Kinematic(pair),
        di.RigidPlane((0, 0), (0, 1)), di.RigidSphere((0, 0), 1), di.RigidCylinder((0, 0), 1),
        di.RigidSurface.from_function(lambda x: 0.1 * x**2, (-1, 1), (0, 0), (0, 1)),
        di.Spin((0, 0), (0, 0, 1), 1.0), di.Translation((1.0, 0.0)), di.AmplitudeTable([0, 1], [0, 1]), di.Tie(pair),
        di.GeneralContact(tags), di.RigidBody(di.RigidSphere((0, 0), 1), mass=1.0, inertia=1.0),
        di.InterfaceLaw(pressure=lambda gap: -gap), di.FrictionLaw(lambda pressure: 0.1 + 0 * pressure),
    ]  # fmt: skip


def public(thing):
    """Attributes and properties that have a value; methods left out."""
    properties = [n for n in dir(type(thing)) if isinstance(getattr(type(thing), n), property)]
    names = [n for n in {*vars(thing), *properties} if not n.startswith("_")]
    values = {}
    for name in sorted(names):
        with contextlib.suppress(AttributeError, RuntimeError, TypeError, ValueError):  # what this object has none of
            values[name] = getattr(thing, name)
    return values


def test_the_table_is_whole(described):
    """Every class that a user can describe a problem with has its object here."""
    problems = {"StaticProblem", "ExplicitProblem", "NewmarkProblem", "RollingProblem"}
    no_state = {
        "ContactStatus",
        "InelasticMaterial",
        "InterfaceUpdate",
        "MaterialFlow",
        "MaterialUpdate",
        "PointValues",
    }
    operators = {"DeformedBody", "Energy", "InternalForce", "PartitionedMesh", "Tangent", "Units"}  # and results
    classes = {name for name in di.__all__ if isinstance(getattr(di, name), type)}
    assert {type(thing).__name__ for thing in described} - {"OwnLaw"} == classes - problems - no_state - operators


def test_no_other_attribute_can_be_set(described):
    changeable = {}
    for thing in described:
        kind = type(thing).__name__
        for name, value in public(thing).items():
            if (kind, name) in FOLLOWED:
                setattr(thing, name, FOLLOWED[kind, name])
                changeable[kind, name] = FOLLOWED[kind, name]
                continue
            with pytest.raises(AttributeError, match=f"{name} of an? {kind} cannot be changed|no setter"):
                setattr(thing, name, value)
            with pytest.raises(AttributeError):
                delattr(thing, name)
            if name not in MADE_ANEW:
                assert getattr(thing, name) is value or np.all(getattr(thing, name) == value)
    assert changeable == FOLLOWED


def test_a_word_that_is_none_of_the_attributes(described):
    for thing in described:
        with pytest.raises(AttributeError, match="has no attribute 'frictoin': it has "):
            thing.frictoin = 0.3


def test_what_they_hold_cannot_be_changed_in_place(described):
    for thing in described:
        for name, value in public(thing).items():
            if isinstance(value, np.ndarray) and name not in MADE_ANEW:
                with pytest.raises(ValueError, match="read-only"):
                    value[...] = 0.0
    by_tag = next(thing for thing in described if isinstance(thing, di.MaterialMap))
    with pytest.raises(TypeError):
        by_tag.materials[1] = by_tag.materials[1]
    times = np.array([0.0, 1.0])
    load = di.BodyForce(times)
    times[:] = 5.0
    assert np.array_equal(load.vector, (0.0, 1.0))


def test_a_copy_is_fixed_as_well(described):
    twin = copy.copy(described[0])
    with pytest.raises(AttributeError, match="E of a LinearElastic cannot be changed"):
        twin.E = 2.0


def test_where_a_value_can_be_set_the_error_says_so(described):
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    u = fem.Function(fem.functionspace(square, ("Lagrange", 1, (2,))))
    load = di.BodyForce((0, -1))
    with pytest.raises(AttributeError, match="no constant before a problem"):
        load.constant
    di.StaticProblem(u, described[0], loads=[load])
    with pytest.raises(AttributeError, match=r"Make another BodyForce, or set `constant.value`"):
        load.constant = (0, -2)
    load.constant.value = (0, -2)


@pytest.mark.parametrize("kind", [di.StaticProblem, di.ExplicitProblem, di.NewmarkProblem])
def test_parts_of_problems_cannot_be_replaced(described, kind):
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    velocity = {} if kind is di.StaticProblem else {"velocity": fem.Function(V)}
    problem = kind(fem.Function(V), described[0], loads=[di.BodyForce((0, -1))], **velocity)
    for name in ("u", "material", "loads", "contact", *(() if kind is di.StaticProblem else ("velocity", "damping"))):
        with pytest.raises(AttributeError, match=f"{name} of an? {kind.__name__} cannot be changed"):
            setattr(problem, name, getattr(problem, name))
    for name in ("loads", "contact"):
        assert isinstance(getattr(problem, name), tuple)
    problem.note = "a user's own"
    assert problem.note == "a user's own"
    del problem.note


class Base(Fixed):
    """Its attribute is set by an `__init__` that those of derived classes call."""

    def __init__(self, size):
        self.size = size


class Derived(Base):
    def __init__(self, size):
        super().__init__(size)
        self.more = 2 * size  # still being made
        self._own = 0

    @property
    def turned(self):
        return self._own

    @turned.setter
    def turned(self, value):
        self._own = value


def test_an_object_is_made_when_its_own_class_has_made_it():
    thing = Derived(3)
    for name in ("size", "more"):
        with pytest.raises(AttributeError, match=f"{name} of a Derived cannot be changed"):
            setattr(thing, name, 0)
    with pytest.raises(AttributeError, match="has no attribute 'less': it has more, size, turned"):
        thing.less = 1
    thing.turned = 5
    twin = thing._copy(size=4)
    assert (twin.size, twin.more, twin.turned, thing.size) == (4, 6, 5, 3)
    with pytest.raises(AttributeError):
        del twin.size
    assert read_only([1, 2]) == (1, 2) and read_only("text") == "text"


class OneOfAKind(Unique):
    def __init__(self):
        self.part = 1


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_what_shares_state_is_not_copied(copied):
    thing = OneOfAKind()
    for notes in ("a user's own", "may be added, changed"):
        thing.notes = notes
    assert thing.notes == "may be added, changed"
    del thing.notes  # and removed
    with pytest.raises(AttributeError):
        del thing.part
    with pytest.raises(AttributeError, match="part of an OneOfAKind cannot be changed: it was made with it"):
        thing.part = 2
    with pytest.raises(TypeError, match="an? OneOfAKind cannot be (copied|pickled): it shares its state"):
        copied(thing)
