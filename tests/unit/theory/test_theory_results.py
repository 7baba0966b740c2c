# SPDX-License-Identifier: MIT
"""What all functions of the theory have in common: units, refusals, frozen results, pictures."""

import dataclasses
import inspect

import numpy as np
import pytest
from theory_calls import CALLS, call, in_units

from dolfinx_impact import theory

RESULTS = [name for name, (_, attributes, _) in CALLS.items() if isinstance(attributes, dict)]
QUADRATURES = {"half_space_displacement", "half_plane_displacement"}  # tested apart, and `profile`


def arguments():
    for name, (given, _, _) in CALLS.items():
        for argument, (value, dimension) in given.items():
            if dimension is not None:
                yield pytest.param(name, argument, value, id=f"{name}-{argument}")


def test_every_function_is_in_the_table():
    functions = {n for n in theory.__all__ if inspect.isfunction(getattr(theory, n))}
    assert functions == set(CALLS) | QUADRATURES | {"profile"}
    for name in theory.__all__:
        assert "[" in inspect.getdoc(getattr(theory, name)), f"{name} states no units"


AXES = {"[L]": (0, 1), "[F/L²]": (1, -2), "[F]": (1, 0), "[T]": (0, 0), "[L/T]": (0, 1), "[1]": (0, 0)}


def assert_same_picture(before, after, force, length):
    """Curves scale as the units in the labels of their axes say."""
    scales = [in_units(1.0, AXES[label[label.rindex("[") :]], force, length) for label in before[:2]]
    assert before[:2] == after[:2] and len(before[2]) == len(after[2]) > 0
    for old, new in zip(before[2], after[2]):
        for scale, x, y in zip(scales, old[1:], new[1:]):
            # Edges of contact: a root there makes 1e-8 of round-off, and infinite slopes.
            assert np.asarray(y) == pytest.approx(scale * np.asarray(x), rel=1e-6, abs=1e-6 * np.max(np.abs(y)))


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("force, length", [(1e3, 1.0), (1.0, 1e-3), (0.2248, 1 / 25.4)])
def test_any_consistent_units(name, force, length):
    """The same problem in other units gives the same answer in other units: no hidden constant has a dimension."""
    given, attributes, fields = CALLS[name]
    before = call(name)
    after = call(name, **{key: in_units(value, dim, force, length) for key, (value, dim) in given.items()})
    same = dict(rel=1e-11)  # round-off; a search for the yield point of the sphere
    if not isinstance(attributes, dict):
        assert after == pytest.approx(in_units(before, attributes, force, length), **same)
        return
    for attribute, dimension in attributes.items():
        expected = in_units(getattr(before, attribute), dimension, force, length)
        assert getattr(after, attribute) == pytest.approx(expected, **same), attribute
    assert_same_picture(before._figure(), after._figure(), force, length)
    for field, dimension in fields.items():
        where = np.array([0.3, 1.7, 60.0])  # somewhere inside and outside, as the case may be
        expected = [in_units(v, dimension, force, length) for v in getattr(before, field)(where)]
        found = getattr(after, field)(where * length)
        # Gaps and far displacements are differences of large numbers.
        assert found == pytest.approx(np.array(expected), rel=1e-9, abs=1e-12 * abs(found).max(), nan_ok=True), field


@pytest.mark.parametrize("name, argument, value", arguments())
def test_wrong_kinds_and_values(name, argument, value):
    for wrong in ("1.0", [1.0, 2.0], 1j, True, {}):
        with pytest.raises(TypeError):
            call(name, **{argument: wrong})
    with pytest.raises(ValueError, match="finite"):
        call(name, **{argument: float("nan")})
    if not argument.startswith(("R", "E", "mass", "outer")):
        with pytest.raises(ValueError, match="finite"):
            call(name, **{argument: float("inf")})
    if argument.startswith("nu"):
        for outside in (-1.0, 0.51, 3.0):
            with pytest.raises(ValueError, match="nu"):
                call(name, **{argument: outside})
    elif argument.startswith("R") and name != "winkler":
        with pytest.raises(ValueError, match="zero"):
            call(name, **{argument: 0.0})
        with pytest.raises(ValueError, match="convex"):
            call(name, **{argument: -1e-3})
    elif argument not in ("angle", "tangential_load_per_length"):
        with pytest.raises(ValueError, match="below|greater"):
            call(name, **{argument: -1.0})
    if argument == "tangential_load_per_length" and name != "flat_punch":
        with pytest.raises(ValueError, match="below"):
            call(name, **{argument: -1.0})


def test_two_rigid_bodies_and_words():
    with pytest.raises(ValueError, match="rigid"):
        theory.hertz_line(1.0, 1.0, 1.0, np.inf, 0.3, np.inf, 0.3)
    with pytest.raises(ValueError, match="glued"):
        theory.flat_punch(1.0, 1.0, 0.3, "glued")
    with pytest.raises(TypeError, match="one of"):
        theory.circular_punch(1.0, 1.0, 1.0, 0.3, 3)
    with pytest.raises(ValueError, match="needs Poisson"):
        theory.flat_punch(1.0, 1.0, condition="bonded")
    with pytest.raises(ValueError, match="sliding"):
        theory.flat_punch(1.0, 1.0, friction=0.2)
    with pytest.raises(ValueError, match="bonded"):
        theory.flat_punch(1.0, 1.0, tangential_load_per_length=0.2)
    with pytest.raises(ValueError, match="bodies are 1 and 2"):
        theory.profile(0.0, 0.0, 1.0, 1.0, body=0)


@pytest.mark.parametrize("name", RESULTS)
def test_results_are_frozen(name):
    result = call(name)
    assert type(result).__name__ in theory.__all__
    field = dataclasses.fields(result)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(result, field, 0.0)
    # Numbers are plain floats: they print and serialise as such.
    kinds = {type(getattr(result, f.name)) for f in dataclasses.fields(result)}
    assert np.float64 not in kinds, result


@pytest.mark.parametrize("name", [n for n in RESULTS if CALLS[n][2]])
def test_fields_take_scalars_and_arrays_and_refuse_words(name):
    result = call(name)
    for field in CALLS[name][2]:
        function = getattr(result, field)
        grid = function(np.full((2, 3), 0.1))
        assert np.shape(grid) == (2, 3) and np.all(grid == function(0.1)) and np.ndim(function(0.1)) == 0
        assert np.array_equal(function([0, 1]), function(np.array([0.0, 1.0])))
        for wrong in ("here", None, [1j]):
            with pytest.raises(TypeError, match="coordinates"):
                function(wrong)


VARIANTS = {
    "winkler": {"Rx": np.inf},
    "flat_punch": {"condition": "frictionless", "tangential_load_per_length": 0.0},
    "circular_punch": {"condition": "bonded"},
    "cattaneo_mindlin": {"tangential_load": 90.0},
    "bar_impact": {"density2": None, "E2": None},
    "plastic_sphere": {"front": None, "pressure": 100.0},
    "plastic_cycle": {"recall": 0.0},
    "plastic_bar_impact": {"velocity": 1e4},
    "relative_curvature": {"R1x": np.inf, "R2x": np.inf},
}


@pytest.mark.parametrize("name, changes", [(n, {}) for n in RESULTS] + list(VARIANTS.items()))
def test_pictures(name, changes):
    """Axes with labels that carry units, curves with finite points; axes that are given are used."""
    import matplotlib.pyplot as plt

    before = dict(plt.rcParams)
    figure, ax = plt.subplots()
    assert call(name, **changes).plot(ax) is ax
    assert "[" in ax.get_xlabel() and "[" in ax.get_ylabel()
    assert ax.lines
    for line in ax.lines:
        x, y = line.get_data()
        assert np.all(np.isfinite(x)) and np.all(np.isfinite(y)) and np.ptp(np.append(x, 0)) > 0
    own = call(name, **changes).plot()
    assert own is not ax and len(own.lines) == len(ax.lines)
    assert dict(plt.rcParams) == before, "a picture leaves the caller's style as it is"
    plt.close(figure)
    plt.close(own.figure)
