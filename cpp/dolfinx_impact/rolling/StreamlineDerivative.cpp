// SPDX-License-Identifier: MIT
#include "StreamlineDerivative.h"
#include "../common/gather.h"
#include "../operators/CooMatrix.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace dolfinx_impact::rolling
{
namespace
{
using operators::check;
using operators::OwnedMatrix;
using operators::OwnedVector;

/// Scores that differ by less are the same: the streamline runs along the edge between two facets.
constexpr double tie = 1e-6;
/// Distance in reference coordinates at which a node lies on a side.
constexpr double on_side = 1e-12;

/// The inequality normal . xi >= bound of a reference facet.
struct Side
{
  double normal[2];
  double bound;
};

std::span<const Side> sides(surface::FacetShape shape)
{
  static constexpr Side interval[] = {{{1.0, 0.0}, 0.0}, {{-1.0, 0.0}, -1.0}};
  static constexpr Side triangle[] = {{{1.0, 0.0}, 0.0}, {{0.0, 1.0}, 0.0}, {{-1.0, -1.0}, -1.0}};
  static constexpr Side quadrilateral[] = {
      {{1.0, 0.0}, 0.0}, {{-1.0, 0.0}, -1.0}, {{0.0, 1.0}, 0.0}, {{0.0, -1.0}, -1.0}};
  switch (shape)
  {
  case surface::FacetShape::interval:
    return interval;
  case surface::FacetShape::triangle:
    return triangle;
  default:
    return quadrilateral;
  }
}

/// A facet on which the derivative at one of its nodes may be taken.
struct Candidate
{
  std::int32_t node = 0;               ///< of the space
  const std::int32_t* facet = nullptr; ///< nodes of the facet
  int num = 0;                         ///< how many it has
  double score = 1.0;                  ///< positive if the flow comes out of the facet; the largest are chosen
  double time = 0.0; ///< that the material takes from where it enters to the node; zero if it does not come out [T]
  double derivative[surface::FacetElement::max_nodes]{}; ///< coefficients of (Grad u) w at the node [1/T]
  double entry[surface::FacetElement::max_nodes]{};      ///< of the value where the streamline enters
};

/// Components of w in the facet's coordinates at a node, by least squares: w and a flat facet of a round body differ
/// slightly.
std::array<double, 2> along_facet(const surface::Facets& facets, std::size_t f, const double* xi, const double* w)
{
  const int tdim = facets.geometry.tdim(), num = facets.geometry.num_nodes(), g = facets.gdim;
  double d[2 * surface::FacetElement::max_nodes], J[2][3] = {}, right[2] = {}, metric[2][2] = {};
  facets.geometry.derivatives(xi, d);
  const double* X = facets.X_of(f);
  for (int a = 0; a < tdim; ++a)
    for (int k = 0; k < num; ++k)
      for (int c = 0; c < g; ++c)
        J[a][c] += d[a * num + k] * X[k * g + c];
  for (int a = 0; a < tdim; ++a)
    for (int c = 0; c < g; ++c)
    {
      right[a] += J[a][c] * w[c];
      for (int b = 0; b < tdim; ++b)
        metric[a][b] += J[a][c] * J[b][c];
    }
  if (tdim == 1)
    return {right[0] / metric[0][0], 0.0};
  const double det = metric[0][0] * metric[1][1] - metric[0][1] * metric[1][0];
  return {(metric[1][1] * right[0] - metric[0][1] * right[1]) / det,
          (metric[0][0] * right[1] - metric[1][0] * right[0]) / det};
}

/// Candidate of a facet for its node i; false where nothing moves there.
bool make_candidate(const surface::Facets& facets, std::size_t f, int i, std::span<const double> w, Candidate& out)
{
  const surface::FacetElement& element = facets.displacement;
  const int tdim = element.tdim(), num = element.num_nodes();
  const std::array<double, 2> xi = element.node(i);
  out.facet = facets.nodes_of(f);
  out.node = out.facet[i];
  out.num = num;
  const std::array<double, 2> along = along_facet(facets, f, xi.data(), &w[std::size_t(out.node) * facets.gdim]);
  if (along[0] == 0.0 && along[1] == 0.0)
    return false;
  double least = std::numeric_limits<double>::infinity(), total = 0.0, reached = least;
  bool rim = false;
  for (const Side& side : sides(element.shape))
  {
    double distance = -side.bound, rate = 0.0; // of the distance, against the flow
    for (int a = 0; a < tdim; ++a)
    {
      distance += side.normal[a] * xi[a];
      rate -= side.normal[a] * along[a];
    }
    if (distance < on_side)
    {
      rim = true;
      least = std::min(least, rate);
      total += std::abs(rate);
    }
    else if (rate < 0.0)
      reached = std::min(reached, distance / -rate);
  }
  if (rim)
    out.score = least / (total > 0.0 ? total : 1.0);
  out.time = out.score >= -tie && std::isfinite(reached) ? reached : 0.0;
  double d[2 * surface::FacetElement::max_nodes], from[2] = {};
  element.derivatives(xi.data(), d);
  for (int a = 0; a < tdim; ++a)
    from[a] = xi[a] - out.time * along[a];
  for (int k = 0; k < num; ++k)
    for (int a = 0; a < tdim; ++a)
      out.derivative[k] += along[a] * d[a * num + k];
  surface::FacetElement corners = element; // values where the material enters are those of the corners' functions
  corners.degree = 1;
  corners.values(from, out.entry);
  return true;
}

/// Weight of each candidate in the mean over the best facets of its node, over all ranks. Collective.
std::vector<double> shares(MPI_Comm comm, const std::vector<std::int64_t>& at, const std::vector<double>& scores)
{
  const std::vector<std::int64_t> nodes = common::gather(comm, at);
  const std::vector<double> values = common::gather(comm, scores);
  struct Best
  {
    double score = -std::numeric_limits<double>::infinity();
    int count = 0;
  };
  std::map<std::int64_t, Best> best;
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    double& score = best[nodes[k]].score;
    score = std::max(score, values[k]);
  }
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    Best& b = best[nodes[k]];
    b.count += values[k] >= b.score - tie;
  }
  std::vector<double> out(at.size(), 0.0);
  for (std::size_t k = 0; k < at.size(); ++k)
    if (const Best& b = best[at[k]]; scores[k] >= b.score - tie)
      out[k] = 1.0 / b.count;
  return out;
}

/// Derivative of the parabola through a node, the point where its streamline enters the facet, and one more facet
/// upstream: d1 + (d1 - d2) t1/(t1 + t2), from the slopes d and times t over both. Collective.
/// @param[in] slope over the facets upstream of the nodes [1/T]
/// @param[in] entry from nodal values to those where the streamlines enter these facets [1]
/// @param[in] time diagonal matrix of the times on these facets [T]
OwnedMatrix through_three_points(OwnedMatrix slope, const OwnedMatrix& entry, const OwnedMatrix& time)
{
  Mat product = nullptr;
  check(MatMatMult(entry.get(), slope.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product), "matrices are multiplied");
  const OwnedMatrix before(product);
  Vec made[3] = {};
  check(MatCreateVecs(time.get(), &made[0], &made[1]), "vectors are made");
  check(VecDuplicate(made[0], &made[2]), "vectors are made");
  const OwnedVector t1(made[0]), t2(made[1]), factor(made[2]);
  check(MatGetDiagonal(time.get(), t1.get()), "a diagonal is read");
  check(MatMult(entry.get(), t1.get(), t2.get()), "a matrix is multiplied");
  {
    operators::Entries first(t1.get()), second(t2.get()), part(factor.get());
    for (std::size_t i = 0; i < part.size(); ++i)
      part[i] = first[i] > 0.0 && second[i] > 0.0 ? first[i] / (first[i] + second[i]) : 0.0;
  }
  check(MatDiagonalScale(before.get(), factor.get(), nullptr), "a matrix is scaled");
  check(VecShift(factor.get(), 1.0), "a vector is shifted");
  check(MatDiagonalScale(slope.get(), factor.get(), nullptr), "a matrix is scaled");
  check(MatAXPY(slope.get(), -1.0, before.get(), DIFFERENT_NONZERO_PATTERN), "matrices are added");
  return slope;
}
} // namespace

operators::OwnedMatrix nodal_matrix(const surface::FunctionSpace& V, std::span<const std::int64_t> rows,
                                    std::span<const std::int64_t> columns, std::vector<double> values)
{
  const PetscInt owned = V.dofmap()->index_map->size_local();
  operators::CooMatrix matrix;
  matrix.assign(V.mesh()->comm(), owned, owned, 1,
                {{rows.begin(), rows.end()}, {columns.begin(), columns.end()}, std::move(values)});
  check(PetscObjectReference(PetscObject(matrix.matrix())), "a matrix is kept");
  return OwnedMatrix(matrix.matrix());
}

StreamlineDerivative::StreamlineDerivative(std::shared_ptr<const surface::FunctionSpace> V,
                                           std::vector<const surface::Facets*> surfaces)
    : _V(std::move(V)), _surfaces(std::move(surfaces))
{
}

operators::OwnedMatrix StreamlineDerivative::matrix(std::span<const double> w) const
{
  std::vector<Candidate> found;
  for (const surface::Facets* facets : _surfaces)
    for (int i = 0; i < facets->displacement.num_nodes(); ++i)
      for (std::size_t f = 0; f < facets->size(); ++f)
        if (Candidate c; make_candidate(*facets, f, i, w, c))
          found.push_back(c);
  const dolfinx::common::IndexMap& map = *_V->dofmap()->index_map;
  const auto global = [&map](std::span<const std::int32_t> local)
  {
    std::vector<std::int64_t> out(local.size());
    map.local_to_global(local, out);
    return out;
  };
  std::vector<std::int32_t> nodes(found.size());
  std::vector<double> scores(found.size());
  for (std::size_t k = 0; k < found.size(); ++k)
  {
    nodes[k] = found[k].node;
    scores[k] = found[k].score;
  }
  const std::vector<std::int64_t> at = global(nodes);
  const std::vector<double> share = shares(_V->mesh()->comm(), at, scores);
  std::vector<std::int64_t> rows, columns;
  std::vector<double> slopes, entries, times;
  for (std::size_t k = 0; k < found.size(); ++k)
  {
    const Candidate& c = found[k];
    times.push_back(share[k] * c.time);
    if (share[k] == 0.0)
      continue;
    const std::vector<std::int64_t> facet = global({c.facet, std::size_t(c.num)});
    for (int m = 0; m < c.num; ++m)
    {
      rows.push_back(at[k]);
      columns.push_back(facet[m]);
      slopes.push_back(share[k] * c.derivative[m]);
      entries.push_back(share[k] * c.entry[m]);
    }
  }
  OwnedMatrix slope = nodal_matrix(*_V, rows, columns, std::move(slopes));
  if (_V->element()->basix_element().degree() > 1)
    return slope;
  const OwnedMatrix entry = nodal_matrix(*_V, rows, columns, std::move(entries));
  const OwnedMatrix time = nodal_matrix(*_V, at, at, std::move(times));
  return through_three_points(std::move(slope), entry, time);
}
} // namespace dolfinx_impact::rolling
