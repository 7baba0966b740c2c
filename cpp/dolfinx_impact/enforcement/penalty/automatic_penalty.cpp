// SPDX-License-Identifier: MIT
#include "automatic_penalty.h"
#include "../../common/text.h"
#include "../../operators/nodal_sums.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <petscvec.h>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Automatic penalty over the stiffness per area.
constexpr double factor = 10.0;
/// Largest ratio of a given penalty to the automatic one. Of the sixteen digits of an entry of the matrix, a larger one
/// leaves fewer than six for the bodies' stiffness, of which a residual needs four.
constexpr double largest = 1e10;

/// Mean of the absolute diagonal entries of each node, owned and ghosts [F/L]. Collective.
std::vector<double> nodal_stiffness(Mat K, const surface::FunctionSpace& V, int gdim)
{
  const auto map = V.dofmap()->index_map;
  std::vector<double> out(map->size_local() + map->num_ghosts(), 0.0);
  Vec diagonal = nullptr;
  operators::check(MatCreateVecs(K, nullptr, &diagonal), "MatCreateVecs");
  operators::check(MatGetDiagonal(K, diagonal), "MatGetDiagonal");
  const PetscScalar* values = nullptr;
  VecGetArrayRead(diagonal, &values);
  for (std::int32_t node = 0; node < map->size_local(); ++node)
  {
    for (int c = 0; c < gdim; ++c)
      out[node] += std::abs(values[std::size_t(node) * gdim + c]);
    out[node] /= gdim;
  }
  VecRestoreArrayRead(diagonal, &values);
  VecDestroy(&diagonal);
  return operators::from_owners(map, std::move(out), 1);
}

/// Largest mean stiffness of a facet's nodes per area of the facet, times the surface's nodes per facet [F/L^3].
/// Collective.
double per_area(const surface::FunctionSpace& V, const std::vector<double>& stiffness, const surface::Facets& facets,
                const surface::QuadratureRule& rule, bool axisymmetric)
{
  const auto map = V.dofmap()->index_map;
  const MPI_Comm comm = V.mesh()->comm();
  std::vector<double> marks(stiffness.size(), 0.0);
  for (std::int32_t node : facets.nodes)
    marks[node] = 1.0;
  marks = operators::sum_over_ranks(map, std::move(marks), 1);
  std::array<std::int64_t, 2> counts{
      std::count_if(marks.begin(), marks.begin() + map->size_local(), [](double mark) { return mark != 0.0; }),
      std::int64_t(facets.size())};
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), 2, MPI_INT64_T, MPI_SUM, comm);
  const gap::Points points = gap::make_points(facets, rule.points, rule.weights, axisymmetric);
  const int n = facets.displacement.num_nodes();
  double most = 0.0;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    double area = 0.0, mean = 0.0;
    for (int q = 0; q < points.per_facet; ++q)
      area += points.weight[f * points.per_facet + q];
    for (int i = 0; i < n; ++i)
      mean += stiffness[facets.nodes_of(f)[i]] / n;
    most = std::max(most, mean / area);
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  return most * double(counts[0]) / double(counts[1]);
}
} // namespace

double automatic_penalty(Mat K, const surface::FunctionSpace& V, const surface::Facets& slave,
                         const surface::Facets* master, const surface::QuadratureRule& rule, bool axisymmetric)
{
  const std::vector<double> stiffness = nodal_stiffness(K, V, slave.gdim);
  double least = std::numeric_limits<double>::infinity();
  for (const surface::Facets* facets : {&slave, master})
    if (facets)
      least = std::min(least, per_area(V, stiffness, *facets, rule, axisymmetric));
  return factor * least;
}

void check_penalty(const std::string& name, double given, double automatic)
{
  using common::text;
  if (given > largest * automatic)
    throw std::invalid_argument(name + ": penalty is " + text("%g", given) + ", " + text("%.1g", given / automatic) +
                                " times what material and mesh ask for (" + text("%.3e", automatic) +
                                "): nothing is left of the bodies' stiffness in the sum; use penalty='auto' or some "
                                "thousand times that, or multipliers (Lagrange)");
}
} // namespace dolfinx_impact::enforcement
