# SPDX-License-Identifier: MIT
"""Parameters of elasto-plastic materials: bounds and messages."""

import numpy as np
import pytest

import dolfinx_impact as di

Y = 780e6
STEEL = {"E": 207e9, "nu": 0.3, "density": 7800.0, "yield_stress": Y}
NAN = float("nan")


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ({"yield_stress": 0.0}, ValueError, "yield_stress is 0.0.*greater than 0"),
        ({"yield_stress": -Y}, ValueError, "yield_stress is -.*greater than 0"),
        ({"yield_stress": NAN}, ValueError, "yield_stress is nan"),
        ({"yield_stress": None}, ValueError, "needs a yield_stress"),
        ({"yield_stress": "780 MPa"}, TypeError, "yield_stress must be a number"),
        ({"nu": 0.5}, ValueError, "0.5.*incompressible"),
        ({"hardening": -240e9}, ValueError, "falls with the slope -2.4.*above -3 mu.*snaps back"),
        ({"hardening": di.Table([0, 1e-3], [Y, 0.5 * Y])}, ValueError, "falls with the slope -3.9.*above -3 mu"),
        ({"hardening": "linear"}, TypeError, "hardening must be a number"),
        ({"hardening": di.Voce(0.5 * Y, 1e3)}, ValueError, "falls with the slope -3.9.*above -3 mu"),
        ({"hardening": di.Voce(2 * Y, 1.0, -240e9)}, ValueError, "falls with the slope -2.4.*above -3 mu"),
        ({"hardening": di.Table([0, 1], [2 * Y, 3 * Y])}, ValueError, "the table begins at.*leave one out"),
        ({"kinematic": -1e9}, ValueError, "modulus is -1.*greater than 0"),
        ({"kinematic": "Prager"}, TypeError, "modulus must be a number"),
        ({"average": "always"}, ValueError, "average is 'always'.*True, False, 'linear' or 'auto'"),
        ({"hypothesis": "plain_strain"}, ValueError, "plain_strain.*plane_strain"),
    ],
    ids=str,
)
def test_bad_steel(arguments, error, words):
    with pytest.raises(error, match=words):
        di.J2Plasticity(**{**STEEL, **arguments})


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ((0.0, 10.0), ValueError, "saturation is 0.0"),
        ((Y, 0.0), ValueError, "rate is 0.0"),
        ((Y, 10.0, NAN), ValueError, "modulus is nan"),
        ((Y, "fast"), TypeError, "rate must be a number"),
    ],
)
def test_bad_voce(arguments, error, words):
    with pytest.raises(error, match=words):
        di.Voce(*arguments)


@pytest.mark.parametrize(
    "strains, stresses, error, words",
    [
        ([0.0], [Y], ValueError, "as many stresses as strains, two or more; found 1 and 1"),
        ([0.0, 0.1], [Y, Y, Y], ValueError, "found 3 and 2"),
        ([0.01, 0.1], [Y, Y], ValueError, "must ascend from 0"),
        ([0.0, 0.1, 0.1], [Y, Y, Y], ValueError, "must ascend from 0"),
        ([0.0, 0.2, 0.1], [2 * Y, Y, Y], ValueError, "must ascend from 0"),
        ([0.0, 0.1], [0.0, Y], ValueError, "must be positive"),
        ([0.0, 0.1], [Y, 0.0], ValueError, "must be positive"),
        ([0.0, NAN], [Y, Y], ValueError, "strains must be one row of finite numbers"),
        ([[0.0, 0.1]], [Y, Y], ValueError, "strains must be one row"),
        ("low", [Y, Y], TypeError, "strains must be a sequence of numbers"),
        ([0.0, 0.1], None, (TypeError, ValueError), "stresses must be"),
    ],
)
def test_bad_table(strains, stresses, error, words):
    with pytest.raises(error, match=words):
        di.Table(strains, stresses)


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ((0.0,), ValueError, "modulus is 0.0"),
        ((1e9, -1.0), ValueError, "recovery is -1.0.*not be negative"),
        ((1e9, NAN), ValueError, "recovery is nan"),
        (("1e9",), TypeError, "modulus must be a number"),
    ],
)
def test_bad_kinematic_hardening(arguments, error, words):
    with pytest.raises(error, match=words):
        di.ArmstrongFrederick(*arguments)


def test_good_parameters():
    """A table brings its yield stress; all parameters show in the text that checkpoints compare."""
    steel = di.J2Plasticity(207e9, 0.3, hardening=di.Table([0.0, 0.1], [Y, 2 * Y]))
    assert steel.yield_stress == Y and "Table([0.0, 0.1]" in repr(steel)
    texts = [
        repr(di.J2Plasticity(**STEEL, **more))
        for more in (
            {}, {"hardening": 1e9}, {"hardening": di.Voce(2 * Y, 10.0)}, {"kinematic": 1e9}, {"finite_strain": True},
            {"kinematic": di.ArmstrongFrederick(1e9, 3.0)}, {"average": False}, {"hypothesis": "plane_strain"},
            {"finite_strain": True, "kinematic": 1e9}, {"hardening": -1e9},
            {"finite_strain": True, "hypothesis": "plane_stress"},
        )  # fmt: skip
    ]
    assert len(set(texts)) == len(texts)


@pytest.mark.parametrize(
    "hardening, slope",
    [
        (1e9, 0.0),
        (0.0, 0.0),
        (-1e9, -1e9),
        (di.Voce(2 * Y, 10.0), 0.0),
        (di.Voce(2 * Y, 10.0, -1e8), -1e8),
        (di.Voce(0.5 * Y, 10.0, 1e8), 1e8 - 5 * Y),
        (di.Table([0.0, 0.1, 0.2], [Y, 2 * Y, 2 * Y]), 0.0),
        (di.Table([0.0, 0.1, 0.2], [Y, 2 * Y, Y]), -10 * Y),
    ],
    ids=str,
)
def test_steepest_softening(hardening, slope):
    found = di.J2Plasticity(**STEEL, hardening=hardening).steepest_softening
    assert found == pytest.approx(slope, rel=1e-12)


def test_stress_without_history_is_refused():
    from dolfinx import fem, mesh
    from mpi4py import MPI

    domain = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (3,))))
    with pytest.raises(TypeError, match="internal variables.*problem.history"):
        di.J2Plasticity(**STEEL).stress(u)
    assert np.isfinite(di.J2Plasticity(**STEEL).wave_speed)
