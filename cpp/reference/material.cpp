// SPDX-License-Identifier: MIT
#include "material.h"
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
namespace
{
template <typename... T>
[[noreturn]] void invalid(const T&... parts)
{
  std::ostringstream text;
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}
} // namespace

Hypothesis hypothesis(const std::string& name)
{
  if (name == "3d")
    return Hypothesis::solid;
  if (name == "plane_strain")
    return Hypothesis::plane_strain;
  if (name == "plane_stress")
    return Hypothesis::plane_stress;
  if (name == "axisymmetric")
    return Hypothesis::axisymmetric;
  invalid("unknown hypothesis '", name, "': use 3d, plane_strain, plane_stress or axisymmetric");
}

void check(const Material& m, bool needs_density)
{
  if (m.law != "linear_elastic" and m.law != "st_venant_kirchhoff" and m.law != "neo_hookean")
    invalid("unknown law '", m.law, "': use linear_elastic, st_venant_kirchhoff or neo_hookean");
  hypothesis(m.hypothesis);
  if (not std::isfinite(m.E) or m.E <= 0)
    invalid("Young's modulus E is ", m.E, ": it must be positive and finite");
  if (m.nu == 0.5)
    invalid(
        "Poisson's ratio nu is 0.5 (incompressible): a displacement formulation cannot do that, a locking-free mixed "
        "form is needed; use a value below 0.5");
  if (not(m.nu > -1 and m.nu < 0.5))
    invalid("Poisson's ratio nu is ", m.nu, ": it must lie between -1 and 0.5, both excluded");
  if (not std::isfinite(m.density) or m.density < 0)
    invalid("density is ", m.density, ": it must be zero (statics) or positive, and finite");
  if (needs_density and m.density == 0)
    invalid("density is 0, but a mass is asked for: give the material a positive density");
}

std::array<double, 2> lame(const Material& m)
{
  return {m.E * m.nu / ((1 + m.nu) * (1 - 2 * m.nu)), m.E / (2 * (1 + m.nu))};
}

int num_strains(Hypothesis h)
{
  if (h == Hypothesis::solid)
    return 6;
  return h == Hypothesis::axisymmetric ? 4 : 3;
}

Matrix elasticity_matrix(const Material& m)
{
  const double E = m.E, nu = m.nu;
  const double c = E / ((1 + nu) * (1 - 2 * nu)), a = c * (1 - nu), b = c * nu, G = E / (2 * (1 + nu));
  Matrix D;
  switch (hypothesis(m.hypothesis))
  {
  case Hypothesis::solid:
    D.setZero(6, 6);
    D.topLeftCorner(3, 3) << a, b, b, b, a, b, b, b, a;
    D.diagonal().tail(3).setConstant(G);
    break;
  case Hypothesis::plane_strain:
    D.resize(3, 3);
    D << a, b, 0, b, a, 0, 0, 0, G;
    break;
  case Hypothesis::plane_stress:
  {
    const double s = E / (1 - nu * nu);
    D.resize(3, 3);
    D << s, s * nu, 0, s * nu, s, 0, 0, 0, G;
    break;
  }
  case Hypothesis::axisymmetric:
    D.setZero(4, 4);
    D.topLeftCorner(3, 3) << a, b, b, b, a, b, b, b, a;
    D(3, 3) = G;
    break;
  }
  return D;
}
} // namespace impact_reference
