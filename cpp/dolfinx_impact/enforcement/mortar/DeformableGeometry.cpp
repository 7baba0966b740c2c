// SPDX-License-Identifier: MIT
#include "DeformableGeometry.h"
#include "prescribed_components.h"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_set>

namespace dolfinx_impact::enforcement
{
DeformableGeometry::DeformableGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                                       surface::Facets master, const MortarOptions& options,
                                       std::vector<std::int8_t> prescribed)
    : MortarGeometry(std::move(V), std::move(slave), options, std::move(prescribed)), _master(std::move(master))
{
  int any = std::any_of(fixed().begin(), fixed().end(), [](std::int8_t f) { return f; });
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm());
  _any_fixed = any;
  _search = std::make_shared<search::PairSearch>(shared_space(), this->slave(), _master, options.search_distance);
  const FacetRule rule = FacetRule::of_segments(this->slave(), _master, options.quadrature_degree);
  for (auto& integrals : _integrals)
    integrals = std::make_unique<gap::MortarIntegrals>(shared_space(), _search, multiplier_nodes(), rule.view(),
                                                       options.basis, options.axisymmetric);
}

void DeformableGeometry::update_cover(std::span<const double> u)
{
  move(u);
  integrals().update_cover(u, increment.start);
  SlaveNodes& n = now();
  n.around = integrals().around;
  n.area = integrals().area();
  n.aside = integrals().aside();
}

void DeformableGeometry::integrate(std::span<const std::int8_t> carriers)
{
  integrals().integrate(carriers);
  SlaveNodes& n = now();
  n.participates.assign(carriers.begin(), carriers.end());
  n.own_weight = integrals().weight;
  n.own_cover = integrals().cover;
  // Prescribed components along which the master is prescribed to move as the node does: at one of the nodes it faces
  // that lies on one plane with it, or at all of them.
  n.own_locked = fixed();
  if (!_any_fixed)
    return;
  std::vector<double> x(rest());
  for (std::size_t k = 0; k < x.size(); ++k)
    x[k] += n.u[k];
  n.own_locked = locked_components({gdim(), prescribed(), increment.driven, tolerance()}, integrals(), x, size());
}

void DeformableGeometry::update_own_gap(std::span<const std::int8_t> locked, const std::vector<double>* sums)
{
  if (sums)
    integrals().set_sums(*sums);
  integrals().update_gap(locked, symmetry);
  SlaveNodes& n = now();
  n.normal = integrals().normal;
  n.weighted_gap = integrals().weighted_gap;
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (n.participates[i])
      n.weighted_gap[i] += offset[i] * n.own_cover[i];
}

std::vector<double> DeformableGeometry::weighted_jump(std::span<const double> moved) const
{
  return integrals().weighted_jump(moved);
}

gap::MasterRows DeformableGeometry::weighted_rows(std::span<const std::int32_t> rows,
                                                  std::span<const double> weights) const
{
  return integrals().master_rows(rows, weights);
}

std::vector<double> DeformableGeometry::over_master(std::span<const double> values) const
{
  return integrals().over_master(values, 1);
}

Mat DeformableGeometry::tangent(std::span<const double> multiplier, std::span<const double> traction,
                                std::span<const std::int8_t> active)
{
  return integrals().tangent(multiplier, traction, active);
}

std::vector<double> DeformableGeometry::forces(std::span<const double> traction) const
{
  return integrals().contact_forces(traction);
}

std::vector<double> DeformableGeometry::edge_angles() const
{
  // From the sum of unit normals over their number.
  const std::size_t n = slave().displacement.num_nodes(), g = gdim();
  const std::unordered_set<std::int64_t> aside(now().aside.begin(), now().aside.end());
  std::vector<double> counting(slave().nodes.size(), 0.0), out(num_nodes(), 0.0);
  for (std::size_t f = 0; f < slave().size(); ++f)
    std::fill_n(&counting[f * n], n, aside.contains(slave().id[f]) ? 0.0 : 1.0);
  counting = summed_at_nodes(std::move(counting));
  const std::vector<double> sums = normal_sums();
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (counting[i] > 0.0)
    {
      double squared = 0.0;
      for (std::size_t c = 0; c < g; ++c)
        squared += sums[i * g + c] * sums[i * g + c];
      out[i] = 2.0 * std::acos(std::clamp(std::sqrt(squared) / counting[i], 0.0, 1.0)) * 180.0 / std::numbers::pi;
    }
  return out;
}

void DeformableGeometry::set_least_cover(double part)
{
  for (auto& integrals : _integrals)
    integrals->least_cover = part;
}

void DeformableGeometry::forget()
{
  _search->forget();
  MortarGeometry::forget();
}
} // namespace dolfinx_impact::enforcement
