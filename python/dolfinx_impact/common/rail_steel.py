# SPDX-License-Identifier: MIT
"""Steel of wheels and rails: the values that all commands begin with.

Young's modulus and Poisson's ratio as in Chen and Kuang (2002), whose end posts the rail joint has, too; the density is
that of data sheets of rail steel. 210 GPa is as common in the literature; all forces here change by less than 1 %.
"""

E = 207e9  # Young's modulus [Pa]
NU = 0.3  # Poisson's ratio [1]
DENSITY = 7800.0  # [kg/m^3]
