// SPDX-License-Identifier: MIT
#include "RigidGeometry.h"
#include "prescribed_components.h"
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
const gap::Rigid& checked(const std::shared_ptr<const gap::Rigid>& obstacle, const surface::Facets& slave,
                          gap::Multipliers basis)
{
  if (!obstacle || obstacle->gdim != slave.gdim)
    throw std::invalid_argument("the rigid master has another dimension than the slave");
  if (basis != gap::Multipliers::dual)
    throw std::invalid_argument("against a rigid obstacle multipliers are nodal: the basis is the dual one");
  return *obstacle;
}

gap::FacingShares shares(const std::shared_ptr<const surface::FunctionSpace>& V, const surface::Facets& slave,
                         const gap::MultiplierNodes& nodes, const MortarOptions& options)
{
  const FacetRule rule(slave.displacement.shape, 2 * slave.displacement.degree + 2);
  return {V, slave, nodes, rule.view(), options.basis, options.axisymmetric};
}
} // namespace

RigidGeometry::RigidGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                             std::shared_ptr<const gap::Rigid> obstacle, const MortarOptions& options,
                             std::vector<std::int8_t> prescribed)
    : MortarGeometry(std::move(V), std::move(slave), options, std::move(prescribed)), _given(std::move(obstacle)),
      _obstacle(checked(_given, this->slave(), options.basis)),
      _shares(shares(shared_space(), this->slave(), multiplier_nodes(), options))
{
}

void RigidGeometry::update_cover(std::span<const double> u)
{
  move(u);
  _obstacle.displacement = increment.displacement;
  _obstacle.rotation = increment.rotation;
  SlaveNodes& n = now();
  n.around = n.area = _shares.evaluate(slave(), _obstacle);
  n.aside = _shares.aside();
  const std::size_t g = gdim();
  n.distance.resize(num_nodes());
  n.normal.resize(num_nodes() * g);
  n.hessian.resize(num_nodes() * g * g);
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    const gap::RigidPoint p = gap::evaluate(_obstacle, std::span(&n.points[i * g], g));
    n.distance[i] = p.gap;
    std::copy_n(p.normal, g, &n.normal[i * g]);
    for (std::size_t a = 0; a < g; ++a)
      std::copy_n(&p.hessian[3 * a], g, &n.hessian[(i * g + a) * g]);
  }
}

void RigidGeometry::integrate(std::span<const std::int8_t> carriers)
{
  SlaveNodes& n = now();
  n.participates.assign(carriers.begin(), carriers.end());
  n.own_weight = n.own_cover = n.around;
  std::array<double, 3> motion = increment.displacement;
  for (int c = 0; c < 3; ++c)
    motion[c] -= increment.start_displacement[c];
  if (turns()) // components that turning moves differ from node to node: no node is locked along them
  {
    const gap::Matrix3 turn = gap::turn_between(increment.rotation, increment.start_rotation);
    for (int c = 0; c < 3; ++c)
      if (std::any_of(&turn[3 * c], &turn[3 * c] + 3, [](double value) { return value != 0.0; }))
        motion[c] = std::numeric_limits<double>::infinity();
  }
  n.own_locked = locked_components({gdim(), prescribed(), increment.driven, tolerance()}, nodes(), motion);
}

void RigidGeometry::update_own_gap(std::span<const std::int8_t>, const std::vector<double>*)
{
  SlaveNodes& n = now();
  n.weighted_gap.resize(num_nodes());
  for (std::size_t i = 0; i < num_nodes(); ++i)
    n.weighted_gap[i] = n.own_cover[i] * (n.distance[i] + offset[i]);
}

std::vector<double> RigidGeometry::weighted_jump(std::span<const double> moved) const
{
  const std::size_t g = gdim();
  std::vector<double> out(num_nodes() * g);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    for (std::size_t c = 0; c < g; ++c)
      out[i * g + c] = now().own_cover[i] * moved[std::size_t(nodes()[i]) * g + c];
  return out;
}

gap::MasterRows RigidGeometry::weighted_rows(std::span<const std::int32_t> rows, std::span<const double>) const
{
  return {std::vector<std::int64_t>(rows.size() + 1, 0), {}, {}};
}

std::vector<double> RigidGeometry::over_master(std::span<const double>) const
{
  return std::vector<double>(num_nodes(), 0.0);
}

Mat RigidGeometry::tangent(std::span<const double> multiplier, std::span<const double>,
                           std::span<const std::int8_t> active)
{
  // The normal turns where a node slides over a curved obstacle: - D lambda dn/dx.
  const std::size_t g = gdim();
  if (multiplier.size() != num_nodes() || active.size() != num_nodes())
    throw std::invalid_argument("multiplier and active are arrays of all nodes that may carry a multiplier");
  std::vector<std::int32_t> turning;
  std::vector<double> blocks;
  int any = 0;
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    if (!active[i] || multiplier[i] == 0.0)
      continue;
    turning.push_back(nodes()[i]);
    for (std::size_t k = 0; k < g * g; ++k)
    {
      blocks.push_back(-(now().own_weight[i] * multiplier[i]) * now().hessian[i * g * g + k]);
      any |= blocks.back() != 0.0;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm());
  if (!any)
    return nullptr;
  gap::assign_springs(*map(), gdim(), turning, {}, blocks, _turning);
  return _turning.matrix();
}

std::vector<double> RigidGeometry::forces(std::span<const double> traction) const
{
  const std::size_t g = gdim();
  if (traction.size() != num_nodes() * g)
    throw std::invalid_argument("a traction at every node that may carry a multiplier is needed");
  std::vector<double> out(std::size_t(map()->size_local()) * g, 0.0);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    for (std::size_t c = 0; c < g; ++c)
      out[std::size_t(nodes()[i]) * g + c] = now().own_weight[i] * traction[i * g + c];
  return out;
}
} // namespace dolfinx_impact::enforcement
