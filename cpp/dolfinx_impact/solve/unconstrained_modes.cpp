// SPDX-License-Identifier: MIT
#include "unconstrained_modes.h"
#include "../common/text.h"
#include "../operators/petsc_check.h"
#include "column_products.h"
#include "dense.h"
#include "rigid_supports.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::RigidBodyModes;

namespace dolfinx_impact::solve
{
namespace
{
constexpr double unresisted = 1e-10; // of |K||r|: below it the forces K r on a rigid motion r are round-off
constexpr double unworked = 1e-10;   // of the largest eigenvalue of the Gram matrix of constraints: no work

/// Combinations of modes, one behind the other.
typedef std::vector<std::vector<double>> Combinations;

/// Combinations of rigid body modes that a tangent does not resist: K r is small against |K||r|. Collective.
Combinations without_resistance(Mat K, const RigidBodyModes& motions, const Combinations& modes)
{
  const int n = int(modes.size());
  Combinations fields, forces;
  std::vector<double> columns;
  for (const std::vector<double>& mode : modes)
  {
    fields.push_back(motions.field(mode));
    columns.insert(columns.end(), fields.back().begin(), fields.back().end());
  }
  const std::vector<double> products = column_products({&K, 1}, n, std::move(columns));
  for (int k = 0; k < n; ++k)
  {
    const double* const start = products.data() + std::size_t(k) * fields[k].size();
    forces.emplace_back(start, start + fields[k].size());
  }
  std::vector<double> work(n * n, 0.0), squares(2 * n, 0.0);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (std::size_t k = 0; k < fields[i].size(); ++k)
        work[i * n + j] += fields[i][k] * forces[j][k] + fields[j][k] * forces[i][k];
  MPI_Allreduce(MPI_IN_PLACE, work.data(), n * n, MPI_DOUBLE, MPI_SUM, motions.comm());
  // Springs resist some combinations of motions, others not.
  const SymmetricEigen turn = symmetric_eigen(std::move(work), n);
  const auto combined = [&](int k, const Combinations& vectors)
  {
    std::vector<double> out(vectors.front().size(), 0.0);
    for (int i = 0; i < n; ++i)
      for (std::size_t m = 0; m < out.size(); ++m)
        out[m] += turn.vectors[k * n + i] * vectors[i][m];
    return out;
  };
  const auto squared = [](const std::vector<double>& v)
  { return std::inner_product(v.begin(), v.end(), v.begin(), 0.0); };
  for (int k = 0; k < n; ++k)
  {
    squares[k] = squared(combined(k, forces));
    squares[n + k] = squared(combined(k, fields));
  }
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), 2 * n, MPI_DOUBLE, MPI_SUM, motions.comm());
  double norm = 0.0;
  check(MatNorm(K, NORM_INFINITY, &norm), "a norm is taken");
  Combinations out;
  for (int k = 0; k < n; ++k)
    if (std::sqrt(squares[k]) < unresisted * norm * std::sqrt(squares[n + k]))
      out.push_back(combined(k, modes));
  return out;
}
} // namespace

std::vector<std::vector<double>> free_modes(const RigidBodyModes& motions, const dolfinx::fem::FunctionSpace<double>& V,
                                            std::span<const std::int8_t> fixed,
                                            std::span<enforcement::StaticContact* const> contacts, bool axisymmetric,
                                            Mat stiffness)
{
  const int num = motions.num_modes();
  std::vector<double> gram = products_of_supports(motions, fixed);
  for (const enforcement::StaticContact* contact : contacts)
  {
    const std::vector<double> products = contact->rigid_body_products(motions);
    std::ranges::transform(gram, products, gram.begin(), std::plus{});
  }
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), int(gram.size()), MPI_DOUBLE, MPI_SUM, motions.comm());
  const SymmetricEigen found = symmetric_eigen(std::move(gram), num);
  Combinations loose;
  for (int k = 0; k < num && found.values[k] < unworked * std::max(found.values.back(), 1.0); ++k)
    loose.emplace_back(found.vectors.begin() + k * num, found.vectors.begin() + (k + 1) * num);
  if (!stiffness || loose.empty())
    return loose;
  // A law of small strains does not resist motions about the reference configuration, others those about the present
  // one.
  const std::size_t known = motions.body().size() * motions.gdim();
  const RigidBodyModes at_rest(V, std::vector<double>(known, 0.0), axisymmetric);
  Combinations present = without_resistance(stiffness, motions, loose);
  Combinations reference = without_resistance(stiffness, at_rest, loose);
  return reference.size() > present.size() ? reference : present;
}

std::vector<std::string> unconstrained_modes(const dolfinx::fem::FunctionSpace<double>& V,
                                             std::span<const std::int8_t> fixed,
                                             std::span<enforcement::StaticContact* const> contacts,
                                             std::span<const double> u, bool axisymmetric, Mat stiffness)
{
  const RigidBodyModes motions(V, u, axisymmetric);
  const auto unconstrained = [&] { return free_modes(motions, V, fixed, contacts, axisymmetric, stiffness); };
  Combinations modes = unconstrained();
  if (!modes.empty())
  {
    bool any = false;
    for (enforcement::StaticContact* contact : contacts)
      any = contact->close_nearest() || any;
    if (any)
      modes = unconstrained();
  }
  std::vector<std::string> sentences;
  const int per_body = motions.per_body(), gdim = motions.gdim();
  for (int b = 0; b < motions.num_bodies() && !modes.empty(); ++b)
  {
    std::string found;
    for (int k = 0; k < per_body; ++k)
    {
      double strength = 0.0;
      for (const std::vector<double>& mode : modes)
        strength += mode[b * per_body + k] * mode[b * per_body + k];
      if (std::sqrt(strength) > 1e-3)
        found += (found.empty() ? "" : ", to ") + motions.names()[k];
    }
    if (found.empty())
      continue;
    sentences.push_back("the body around (" + common::components(motions.centres().subspan(b * gdim, gdim)) + ")" +
                        " is free to " + found);
  }
  return sentences;
}
} // namespace dolfinx_impact::solve
