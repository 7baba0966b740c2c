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

/// Largest mean stiffness of a facet's nodes per area of the facet, times the surface's nodes per facet, of each part
/// of a surface; infinite for parts without facets [F/L^3]. Collective.
/// @param[in] part of each facet, below num_parts
std::vector<double> per_area(const surface::FunctionSpace& V, const std::vector<double>& stiffness,
                             const surface::Facets& facets, std::span<const std::int32_t> part, int num_parts,
                             const surface::QuadratureRule& rule, bool axisymmetric)
{
  const auto map = V.dofmap()->index_map;
  const MPI_Comm comm = V.mesh()->comm();
  const int n = facets.displacement.num_nodes();
  // Parts share no nodes: each node belongs to the part of its facets.
  std::vector<double> owner(stiffness.size(), -1.0);
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int i = 0; i < n; ++i)
      owner[facets.nodes_of(f)[i]] = part[f];
  std::vector<double> marks(stiffness.size() * 2, 0.0); // sums of parts, and how many ranks have added to them
  for (std::size_t node = 0; node < owner.size(); ++node)
    if (owner[node] >= 0.0)
    {
      marks[2 * node] = owner[node];
      marks[2 * node + 1] = 1.0;
    }
  marks = operators::sum_over_ranks(map, std::move(marks), 2);
  std::vector<std::int64_t> counts(2 * std::size_t(num_parts), 0);
  for (std::int32_t node = 0; node < map->size_local(); ++node)
    if (marks[2 * std::size_t(node) + 1] > 0.0)
      ++counts[2 * std::size_t(std::lround(marks[2 * std::size_t(node)] / marks[2 * std::size_t(node) + 1]))];
  const gap::Points points = gap::make_points(facets, rule.points, rule.weights, axisymmetric);
  std::vector<double> most(num_parts, 0.0);
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    double area = 0.0, mean = 0.0;
    for (int q = 0; q < points.per_facet; ++q)
      area += points.weight[f * points.per_facet + q];
    for (int i = 0; i < n; ++i)
      mean += stiffness[facets.nodes_of(f)[i]] / n;
    most[part[f]] = std::max(most[part[f]], mean / area);
    ++counts[2 * std::size_t(part[f]) + 1];
  }
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), int(counts.size()), MPI_INT64_T, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), num_parts, MPI_DOUBLE, MPI_MAX, comm);
  for (int p = 0; p < num_parts; ++p)
    most[p] = counts[2 * p + 1] > 0 ? most[p] * double(counts[2 * p]) / double(counts[2 * p + 1])
                                    : std::numeric_limits<double>::infinity();
  return most;
}
} // namespace

double automatic_penalty(Mat K, const surface::FunctionSpace& V, const surface::Facets& slave,
                         const surface::Facets* master, const surface::QuadratureRule& rule, bool axisymmetric)
{
  const std::vector<double> stiffness = nodal_stiffness(K, V, slave.gdim);
  double least = std::numeric_limits<double>::infinity();
  for (const surface::Facets* facets : {&slave, master})
    if (facets)
    {
      const std::vector<std::int32_t> one(facets->size(), 0);
      least = std::min(least, per_area(V, stiffness, *facets, one, 1, rule, axisymmetric)[0]);
    }
  return factor * least;
}

std::vector<double> automatic_penalties(Mat K, const surface::FunctionSpace& V, const surface::Facets& facets,
                                        std::span<const std::int32_t> body, int num_bodies,
                                        const surface::QuadratureRule& rule, bool axisymmetric)
{
  std::vector<double> out =
      per_area(V, nodal_stiffness(K, V, facets.gdim), facets, body, num_bodies, rule, axisymmetric);
  for (double& value : out)
    value *= factor;
  return out;
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
