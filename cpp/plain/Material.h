// SPDX-License-Identifier: MIT
#pragma once
#include <string>

namespace impact_plain
{
/// Parameters of an isotropic solid.
struct Material
{
  std::string law = "linear_elastic"; ///< "linear_elastic", "st_venant_kirchhoff", "neo_hookean"
  std::string hypothesis = "3d";      ///< "3d", "plane_strain", "plane_stress", "axisymmetric" (x is the radius)
  double E = 0.0;                     ///< Young's modulus [F/L^2]
  double nu = 0.0;                    ///< Poisson's ratio [1]
  double density = 0.0;               ///< [M/L^3]
};
} // namespace impact_plain
