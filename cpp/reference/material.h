// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"
#include "plain/Material.h"

namespace impact_reference
{
using impact_plain::Material;

/// Kinematic hypothesis. Plane problems have thickness 1; axisymmetric ones have x = r, y = z and are integrated over
/// the full circumference (weight 2 pi r), so their forces and masses are totals.
enum class Hypothesis
{
  solid,
  plane_strain,
  plane_stress,
  axisymmetric
};

/// Hypothesis of a name: "3d", "plane_strain", "plane_stress", "axisymmetric".
/// @throws std::invalid_argument for an unknown name
Hypothesis hypothesis(const std::string& name);

/// Checks every number and name of a material.
/// @param needs_density true where a mass is asked for: density must then be positive
/// @throws std::invalid_argument naming the value and the remedy
void check(const Material& material, bool needs_density = false);

/// Lame's constants {lambda, mu} [F/L^2].
std::array<double, 2> lame(const Material& material);

/// Number of strain components: 3d 6 (xx yy zz xy yz xz), plane 3 (xx yy xy), axisymmetric 4 (rr zz tt rz); shears are
/// engineering shears.
int num_strains(Hypothesis hypothesis);

/// Elasticity matrix D, sigma = D eps, seed (3.19) (Zienkiewicz & Taylor vol. 1 ch. 2, 4, 5; Cook et al. ch. 3)
/// [F/L^2].
Matrix elasticity_matrix(const Material& material);

/// Answer of a finite-strain law.
struct Stress
{
  Vector S;      ///< 2nd Piola-Kirchhoff stress, components as the strains [F/L^2]
  Matrix C;      ///< dS/dE for engineering shear strains [F/L^2]
  double energy; ///< per reference volume [F/L^2]
};

/// 2nd Piola-Kirchhoff stress, tangent and energy of St Venant-Kirchhoff or neo-Hookean material (Bonet & Wood ch. 5,
/// 6). Plane stress: E33 from S33 = 0, closed form for the former, Newton's method for the latter, tangent condensed.
/// @param F deformation gradient, 3 x 3; F33 is not read in plane stress
/// @throws std::domain_error if det F <= 0 and the energy needs its logarithm
Stress second_piola(const Material& material, const Eigen::Matrix3d& F);

/// Stress of a linear elastic material in the same form, for the small strain of F.
Stress small_strain(const Material& material, const Eigen::Matrix3d& F);
} // namespace impact_reference
