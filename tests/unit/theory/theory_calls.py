# SPDX-License-Identifier: MIT
"""One good call of every function of dolfinx_impact.theory, with the dimensions of what goes in and comes out.

A dimension is a pair (exponent of force, exponent of length); in these functions time enters by speeds and densities
only, so it takes the same unit throughout.
"""

import math

import numpy as np

from dolfinx_impact import theory

ONE, LENGTH, FORCE, LINE, STRESS = (0, 0), (0, 1), (1, 0), (1, -1), (1, -2)
DENSITY, SPEED, MASS, TIME = (1, -4), (0, 1), (1, -1), (0, 0)  # force times time^2 per length^4, and so on
PAIR = {"E1": (207e3, STRESS), "nu1": (0.3, ONE), "E2": (70e3, STRESS), "nu2": (0.2, ONE)}
ROUND = {"R1": (50.0, LENGTH), "R2": (-80.0, LENGTH), **PAIR}
VESSEL = {
    **{"inner_radius": (100.0, LENGTH), "outer_radius": (200.0, LENGTH)},
    **{"E": (210e3, STRESS), "nu": (0.3, ONE), "yield_stress": (240.0, STRESS)},
}
PRESSURES = {
    **{"pressure": STRESS, "front": LENGTH, "first_yield": STRESS, "limit": STRESS},
    **{"inner_displacement": LENGTH, "outer_displacement": LENGTH},
}

# name: (arguments with dimensions, attributes with dimensions, {field of position: dimension})
CALLS = {
    "hertz_line": (
        {"load_per_length": (300.0, LINE), **ROUND},
        {"half_width": LENGTH, "peak_pressure": STRESS, "radius": LENGTH},
        {"pressure": STRESS, "gap": LENGTH, "displacement": LENGTH},
    ),
    "hertz_point": (
        {"load": (300.0, FORCE), **ROUND},
        {"a": LENGTH, "b": LENGTH, "approach": LENGTH, "peak_pressure": STRESS, "stiffness": LINE},
        {"pressure": STRESS, "gap": LENGTH, "displacement": LENGTH},
    ),
    "hertz_elliptic": (
        {
            "load": (300.0, FORCE),
            **{"R1x": (50.0, LENGTH), "R1y": (30.0, LENGTH), "R2x": (-80.0, LENGTH), "R2y": (np.inf, LENGTH)},
            **PAIR,
            "angle": (0.3, ONE),
        },
        {"a": LENGTH, "b": LENGTH, "approach": LENGTH, "peak_pressure": STRESS, "stiffness": LINE, "rotation": ONE},
        {},
    ),
    "relative_curvature": (
        {"R1x": (50.0, LENGTH), "R1y": (30.0, LENGTH), "R2x": (-80.0, LENGTH), "R2y": (np.inf, LENGTH)},
        {"A": (0, -1), "B": (0, -1), "Rx": LENGTH, "Ry": LENGTH},
        {},
    ),
    "winkler": (
        {
            **{"approach": (0.1, LENGTH), "Rx": (460.0, LENGTH), "Ry": (300.0, LENGTH)},
            **{"modulus": (1e5, STRESS), "depth": (10.0, LENGTH)},
        },
        {"a": LENGTH, "b": LENGTH, "load": FORCE, "peak_pressure": STRESS, "stiffness": LINE},
        {"pressure": STRESS, "displacement": LENGTH},
    ),
    "flat_punch": (
        {
            **{"load_per_length": (300.0, LINE), "half_width": (5.0, LENGTH), "nu": (0.3, ONE)},
            **{"condition": ("bonded", None), "tangential_load_per_length": (50.0, LINE)},
        },
        {"eta": ONE},
        {"pressure": STRESS, "shear": STRESS},
    ),
    "circular_punch": (
        {"approach": (0.01, LENGTH), "radius": (5.0, LENGTH), "E": (207e3, STRESS), "nu": (0.3, ONE)},
        {"load": FORCE, "stiffness": LINE},
        {"pressure": STRESS, "displacement": LENGTH},
    ),
    "wedge": (
        {"half_angle": (1.5, ONE), **PAIR, "load_per_length": (300.0, LINE)},
        {"half_width": LENGTH},
        {"pressure": STRESS},
    ),
    "cone": (
        {"half_angle": (1.5, ONE), **PAIR, "load": (300.0, FORCE)},
        {"a": LENGTH, "approach": LENGTH, "stiffness": LINE},
        {"pressure": STRESS},
    ),
    "dundurs": (dict(PAIR), {"alpha": ONE, "beta": ONE}, {}),
    "bonded_indentation": (
        {"load_per_length": (300.0, LINE), **ROUND},
        {"half_width": LENGTH, "beta": ONE, "peak_shear": STRESS},
        {"pressure": STRESS, "shear": STRESS},
    ),
    "cattaneo_mindlin": (
        {"load": (300.0, FORCE), "tangential_load": (50.0, FORCE), "friction": (0.3, ONE), **ROUND},
        {"stick_radius": LENGTH, "shift": LENGTH, "first_dissipation": (1, 1), "cycle_dissipation": (1, 1)},
        {"traction": STRESS},
    ),
    "cattaneo_mindlin_line": (
        {
            "load_per_length": (300.0, LINE),
            "tangential_load_per_length": (50.0, LINE),
            "friction": (0.3, ONE),
            **ROUND,
        },
        {"stick_half_width": LENGTH},
        {"traction": STRESS},
    ),
    "carter": (
        {"load_per_length": (300.0, LINE), "friction": (0.3, ONE), **ROUND, "tangential_load_per_length": (50.0, LINE)},
        {"stick_half_width": LENGTH, "creep": ONE},
        {"traction": STRESS},
    ),
    "bar_impact": (
        {
            **{"velocity": (5.0, SPEED), "length": (100.0, LENGTH), "density": (8e-9, DENSITY)},
            **{"E": (207e3, STRESS), "density2": (3e-9, DENSITY), "E2": (70e3, STRESS)},
        },
        {
            "stress": STRESS,
            "wave_speed": SPEED,
            "interface_velocity": SPEED,
            "release_time": TIME,
            "shortening": LENGTH,
        },
        {},
    ),
    "yield_velocity": (
        {"yield_stress": (780.0, STRESS), "density": (8e-9, DENSITY), "E": (207e3, STRESS), "nu": (0.3, ONE)},
        {"bar": SPEED, "uniaxial_strain": SPEED, "hugoniot": STRESS, "sphere": SPEED, "sphere_mises": SPEED},
        {},
    ),
    "hertz_impact": (
        {"velocity": (5.0, SPEED), "mass1": (2e-3, MASS), "mass2": (np.inf, MASS), **ROUND},
        {"duration": TIME, "peak_force": FORCE, "max_approach": LENGTH, "max_radius": LENGTH, "peak_pressure": STRESS},
        {},
    ),
    "press_fit": (
        {"interference": (0.05, LENGTH), "radius": (50.0, LENGTH), "outer_radius": (100.0, LENGTH), **PAIR},
        {"pressure": STRESS},
        {"radial_stress": STRESS},
    ),
    "bar_pull": (
        {
            **{"force": (1e3, FORCE), "normal_load_per_length": (10.0, LINE), "friction": (0.3, ONE)},
            **{"E": (207e3, STRESS), "area": (100.0, (0, 2))},
        },
        {"slip_length": LENGTH, "end_displacement": LENGTH, "residual_displacement": LENGTH},
        {"displacement": LENGTH, "tension": FORCE},
    ),
    "plastic_sphere": (
        {**VESSEL, "front": (150.0, LENGTH)},
        PRESSURES,
        {},
    ),
    "plastic_cylinder": (
        {**VESSEL, "front": (120.0, LENGTH)},
        PRESSURES,
        {},
    ),
    "line_shakedown": (
        {"yield_stress": (780.0, STRESS), "nu": (0.3, ONE)},
        {"first_yield": STRESS, "depth": ONE, "shakedown": STRESS, "shear_yield_stress": STRESS},
        {},
    ),
    "plastic_cycle": (
        {
            **{"plastic_amplitude": (0.01, ONE), "E": (207e3, STRESS), "yield_stress": (400.0, STRESS)},
            **{"kinematic": (4e4, STRESS), "recall": (90.0, ONE)},
        },
        {"stress_amplitude": STRESS, "strain_amplitude": ONE, "back_stress_amplitude": STRESS, "work": STRESS},
        {},
    ),
    "plastic_bar_impact": (
        {
            **{"velocity": (4e4, SPEED), "density": (7.8e-9, DENSITY), "E": (207e3, STRESS)},
            **{"yield_stress": (780.0, STRESS), "tangent_modulus": (20.7e3, STRESS)},
        },
        {
            **{"stress": STRESS, "strain": ONE, "plastic_strain": ONE, "precursor": STRESS},
            **{"wave_speed": SPEED, "plastic_speed": SPEED, "yield_velocity": SPEED},
        },
        {},
    ),
    # Not results but numbers:
    "prandtl_pressure": ({"yield_stress": (780.0, STRESS)}, STRESS, {}),
    "effective_modulus": (dict(PAIR), STRESS, {}),
    "bentall_johnson": ({"load_per_length": (300.0, LINE), **ROUND}, ONE, {}),
    "impact_stress": ({"density": (8e-9, DENSITY), "c": (5e6, SPEED), "v": (5e3, SPEED)}, STRESS, {}),
}


def call(name, **changes):
    """The good call, with some arguments changed."""
    arguments = {key: value for key, (value, _) in CALLS[name][0].items()}
    return getattr(theory, name)(**{**arguments, **changes})


def in_units(value, dimension, force, length):
    """A value in a system whose units of force and length are 1/force and 1/length of the former ones."""
    if dimension is None or not math.isfinite(value):
        return value
    return value * force ** dimension[0] * length ** dimension[1]
