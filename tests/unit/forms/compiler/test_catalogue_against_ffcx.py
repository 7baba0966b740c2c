# SPDX-License-Identifier: MIT
"""Forms of the catalogue that are not compiled ahead of time: generated C++ against FFCx's C, name by name."""

import itertools

import pytest
from kernel_oracle import Oracle, build_many, difference

from dolfinx_impact import _cpp
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.materials import HYPOTHESES

BUILT_IN = {(r.name, r.cell, r.degree, r.geometry_degree, r.hypothesis) for r in registry.TABLE}

# As for the table: different order of summation. The Poisson and momentum residuals and the finite-strain energies add
# terms that cancel, the plane-stress neo-Hookean law repeats that in six Newton steps: up to three digits are lost
# there.
TOLERANCE = 1e-13
CANCELLING = 5e-12


def tolerance(spec):
    finite_strain = spec[0].split(".")[0] in ("neo_hookean", "st_venant_kirchhoff")
    return CANCELLING if finite_strain or spec[0] in ("poisson_residual", "momentum_balance") else TOLERANCE


def allowed():
    """Every combination that the catalogue holds and that is not in the table."""
    found = []
    combinations = itertools.product(registry.NAMES, registry.CELLS, registry.DEGREES, registry.DEGREES, HYPOTHESES)
    for spec in combinations:
        try:
            registry.check(*spec)
            if spec[0] == "nodal_mass":
                registry.build(*spec)
        except ValueError:
            continue
        if spec not in BUILT_IN:
            found.append(spec)
    return found


def cost(spec):
    """Rough size of a kernel, so that the sample takes cheap ones where it may choose."""
    name, cell, degree, geometry_degree, _ = spec
    big = {"triangle": 1, "quadrilateral": 2, "tetrahedron": 2, "hexahedron": 6}[cell]
    return big * degree**2 * geometry_degree * (4 if "tangent" in name else 1)


def sample(specs):
    """Few combinations that hold every name on simplices and on the other cells, every (cell, degree, geometry degree)
    and every (name or law, hypothesis)."""

    def facts(spec):
        name, cell, degree, geometry_degree, hypothesis = spec
        return {
            ("name", name),
            ("kind", cell, degree, geometry_degree),
            (name.split(".")[0], hypothesis),
            (name, "simplex" if cell in ("triangle", "tetrahedron") else "product"),
        }

    open_facts = set().union(*map(facts, specs))
    chosen = []
    while open_facts:
        best = max(specs, key=lambda s: (len(facts(s) & open_facts), -cost(s)))
        chosen.append(best)
        open_facts -= facts(best)
    return chosen


EVERYTHING = allowed()
SAMPLE = sample(EVERYTHING)


def label(spec):
    return "-".join(map(str, spec))


def compare(spec, libraries, rng):
    ffcx_library, (path, names) = libraries[spec]
    shift = 3.0 if spec[4] == "axisymmetric" else 0.0
    for kernel in _cpp.kernels.load(path, names):
        assert difference(kernel, Oracle(ffcx_library), rng, shift=shift) < tolerance(spec)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    return build_many(SAMPLE, tmp_path_factory.mktemp("sample"), with_ours=True)


@pytest.mark.parametrize("spec", SAMPLE, ids=label)
def test_sample_equals_ffcx(spec, libraries, rng):
    compare(spec, libraries, rng)


def test_sample_holds_everything():
    for place, values in enumerate((registry.NAMES, registry.CELLS, registry.DEGREES, registry.DEGREES, HYPOTHESES)):
        assert {s[place] for s in SAMPLE} == set(values)


@pytest.fixture(scope="module")
def all_libraries(tmp_path_factory):
    return build_many(EVERYTHING, tmp_path_factory.mktemp("matrix"), with_ours=True)


@pytest.mark.slow
@pytest.mark.matrix
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("spec", EVERYTHING, ids=label)
def test_whole_matrix_equals_ffcx(spec, all_libraries, rng):
    compare(spec, all_libraries, rng)
