// SPDX-License-Identifier: MIT
// Rigid surfaces z = h(a): closest points, normals and their derivatives against closed forms of a parabola.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/gap/HeightField.h>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact::gap;

namespace
{
constexpr std::array<std::array<double, 3>, 3> upwards{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};

/// z = k a^2 over -1 <= a <= 1, which cubic splines have exactly: their coefficients are k (t^2 - spacing^2/3) at the
/// places t of the splines. In space h does not depend on the second coordinate.
HeightField parabola(double k, int gdim, int cells = 8)
{
  const double spacing = 2.0 / cells;
  std::vector<double> coefficients;
  for (int i = 0; i < cells + 3; ++i)
  {
    const double t = -1.0 + (i - 1) * spacing;
    coefficients.insert(coefficients.end(), gdim == 2 ? 1 : cells + 3, k * (t * t - spacing * spacing / 3));
  }
  return HeightField(gdim, {}, upwards, {{-1.0, -1.0}, {spacing, spacing}, {cells, cells}}, coefficients);
}
} // namespace

TEST_CASE("gaps above a parabola, within the centres of curvature")
{
  const double k = 0.8, curvature = 2 * k;
  for (const int gdim : {2, 3})
  {
    const HeightField field = parabola(k, gdim);
    CHECK(field.gdim() == gdim);
    CHECK(field.largest_coordinate() >= 1.0);
    for (const double distance : {-0.3, 0.0, 0.2, 0.5}) // 1/curvature is 0.625
    {
      double x[3] = {0.0, 0.0, 0.0};
      x[gdim - 1] = distance;
      const RigidPoint at = field.closest({x, std::size_t(gdim)});
      CHECK(at.gap == Approx(distance).margin(1e-12));
      CHECK(at.normal[gdim - 1] == Approx(1.0));
      // The normal turns towards the axis: the surface is hollow, seen from outside.
      CHECK(at.hessian[0] == Approx(-curvature / (1.0 - curvature * distance)).epsilon(1e-9));
      if (gdim == 3)
        CHECK(at.hessian[4] == Approx(0.0).margin(1e-9));
    }
    // Beside the axis: a point at the distance d along the normal of (a, k a^2).
    const double a = 0.4, slope = 2 * k * a, length = std::hypot(slope, 1.0), d = 0.15;
    double x[3] = {a - d * slope / length, 0.1, 0.1};
    x[gdim - 1] = k * a * a + d / length;
    const RigidPoint at = field.closest({x, std::size_t(gdim)});
    CHECK(at.gap == Approx(d).epsilon(1e-10));
    CHECK(at.normal[0] == Approx(-slope / length).epsilon(1e-10));
    CHECK(at.normal[gdim - 1] == Approx(1.0 / length).epsilon(1e-10));
  }
}

TEST_CASE("a height field goes on straight beyond its grid")
{
  const double k = 0.8, slope = 2 * k, length = std::hypot(slope, 1.0);
  const HeightField field = parabola(k, 2);
  // On the tangent at a = 1, one further, and 0.25 off it.
  const double x[2] = {2.0 - 0.25 * slope / length, k + slope + 0.25 / length};
  const RigidPoint at = field.closest(x);
  CHECK(at.gap == Approx(0.25).epsilon(1e-10));
  CHECK(at.hessian[0] == Approx(0.0).margin(1e-12));
}

TEST_CASE("height fields of sizes that do not fit are refused")
{
  CHECK_THROWS_AS(HeightField(2, {}, upwards, {{0.0, 0.0}, {1.0, 1.0}, {4, 1}}, std::vector<double>(6)),
                  std::invalid_argument);
  CHECK_THROWS_AS(HeightField(2, {}, upwards, {{0.0, 0.0}, {0.0, 1.0}, {4, 1}}, std::vector<double>(7)),
                  std::invalid_argument);
}
