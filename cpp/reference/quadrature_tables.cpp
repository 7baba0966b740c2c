// SPDX-License-Identifier: MIT
#include "quadrature.h"
#include <algorithm>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// An orbit is one barycentric point, all its distinct permutations, and their common weight (weights sum to 1).
struct Orbit
{
  std::vector<double> barycentric;
  double weight;
};

std::vector<double> triangle(double a)
{
  return {a, a, 1 - 2 * a};
}
std::vector<double> triangle(double a, double b)
{
  return {a, b, 1 - a - b};
}
std::vector<double> vertex_orbit(double a)
{
  return {a, a, a, 1 - 3 * a};
}
std::vector<double> edge_orbit(double a)
{
  return {a, a, 0.5 - a, 0.5 - a};
}
std::vector<double> face_orbit(double a, double b)
{
  return {a, a, b, 1 - 2 * a - b};
}

// Strang & Fix 1973 (degree 2), Dunavant 1985 (4, 6, 8), Radon 1948 (5).
std::vector<Orbit> triangle_orbits(int degree)
{
  constexpr double third = 1.0 / 3.0;
  if (degree <= 1)
    return {{{third, third, third}, 1.0}};
  if (degree == 2)
    return {{triangle(1.0 / 6.0), third}};
  if (degree <= 4)
    return {{triangle(0.44594849091596488632), 0.22338158967801146570},
            {triangle(0.09157621350977074346), 0.10995174365532186764}};
  if (degree == 5)
    return {{{third, third, third}, 0.225},
            {triangle(0.10128650732345633880), 0.12593918054482715260},
            {triangle(0.47014206410511508977), 0.13239415278850618074}};
  if (degree == 6)
    return {{triangle(0.24928674517091042129), 0.11678627572637936603},
            {triangle(0.06308901449150222834), 0.05084490637020681692},
            {triangle(0.05314504984481694735, 0.31035245103378440542), 0.08285107561837357519}};
  return {{{third, third, third}, 0.14431560767778716825},
          {triangle(0.45929258829272315603), 0.09509163426728462479},
          {triangle(0.17056930775176020662), 0.10321737053471825028},
          {triangle(0.05054722831703097546), 0.03245849762319808031},
          {triangle(0.00839477740995760534, 0.26311282963463811342), 0.02723031417443499427}};
}

// Hammer & Stroud 1956 (degree 2), Walkington 2000 (5), Keast 1986 (6).
std::vector<Orbit> tetrahedron_orbits(int degree)
{
  if (degree <= 1)
    return {{{0.25, 0.25, 0.25, 0.25}, 1.0}};
  if (degree == 2)
    return {{vertex_orbit(0.13819660112501051518), 0.25}};
  if (degree <= 5)
    return {{vertex_orbit(0.31088591926330060980), 0.11268792571801585080},
            {vertex_orbit(0.09273525031089122640), 0.07349304311636194954},
            {edge_orbit(0.04550370412564964949), 0.04254602077708146644}};
  return {{vertex_orbit(0.21460287125915202929), 0.03992275025816749210},
          {vertex_orbit(0.04067395853461135312), 0.01007721105532064295},
          {vertex_orbit(0.32233789014227551034), 0.05535718154365472210},
          {face_orbit(0.06366100187501752530, 0.26967233145831580803), 0.04821428571428571429}};
}
} // namespace

int table_limit(CellType cell)
{
  if (cell == CellType::triangle)
    return 8;
  return cell == CellType::tetrahedron ? 6 : 1000;
}

Rule simplex_table(CellType cell, int degree)
{
  if (degree > table_limit(cell))
    throw std::invalid_argument("the tables for a " + std::string(to_string(cell)) + " reach degree " +
                                std::to_string(table_limit(cell)) + ", not " + std::to_string(degree) +
                                ": use \"gauss_jacobi:" + std::to_string(degree) + "\"");
  const int d = tdim(cell);
  const double volume = d == 2 ? 1.0 / 2.0 : 1.0 / 6.0;
  std::vector<double> points, weights;
  for (Orbit orbit : d == 2 ? triangle_orbits(degree) : tetrahedron_orbits(degree))
  {
    auto& L = orbit.barycentric;
    std::sort(L.begin(), L.end());
    do
    {
      points.insert(points.end(), L.begin() + 1, L.end());
      weights.push_back(volume * orbit.weight);
    } while (std::next_permutation(L.begin(), L.end()));
  }
  return {Eigen::Map<Matrix>(points.data(), weights.size(), d), Eigen::Map<Vector>(weights.data(), weights.size())};
}
} // namespace impact_reference
