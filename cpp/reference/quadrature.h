// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"

namespace impact_reference
{
/// Points (num_points, tdim) and weights (num_points) on a reference cell; the weights sum to its volume.
struct Rule
{
  Matrix points;
  Vector weights;
};

/// Rule by name.
///   "table:D"         exact to degree D: typed tables on simplices (all points inside, all weights positive; D up to 8
///                     on triangles, 6 on tetrahedra), Gauss-Legendre by Newton's method on tensor cells
///   "gauss_jacobi:D"  m = (D + 2) / 2 points per direction: collapsed Gauss-Jacobi product on simplices (Hughes ch. 3;
///                     Karniadakis & Sherwin ch. 4), Gauss-Legendre on tensor cells, both by Golub & Welsch 1969
/// @throws std::invalid_argument for an unknown name or a degree the tables do not reach
Rule quadrature(CellType cell, const std::string& rule);

/// Highest degree of the typed tables; unlimited on tensor cells.
int table_limit(CellType cell);

/// Typed simplex rule exact to `degree`.
Rule simplex_table(CellType cell, int degree);

/// Nodes and weights of the m-point Gauss rule for the weight (1 - x)^alpha on [-1, 1], by Golub & Welsch.
std::array<Vector, 2> gauss_jacobi(int m, int alpha);

/// What an integral is for: decides the degree that integrates it exactly.
enum class Purpose
{
  stiffness,
  finite_strain,
  mass,
  load,
  facet
};

/// Name of the default rule. On affine cells with straight sides (parallelograms, parallelepipeds) every integral of a
/// linear problem is exact, save the hoop terms N N / r of an axisymmetric stiffness; masses, loads and dead or
/// follower facet forces are exact on distorted and curved cells too (flat facets for dead tractions). Tensor stiffness
/// takes the usual (p + 1)-point Gauss rule.
/// @param degree, geometry_degree 1 or 2
/// @param purpose what is integrated; for Purpose::facet the cell is the facet's
std::string default_rule(Purpose purpose, CellType cell, int degree, int geometry_degree, bool axisymmetric);

/// Purpose of a name: "stiffness", "finite_strain", "mass", "load", "facet".
Purpose purpose(const std::string& name);
} // namespace impact_reference
