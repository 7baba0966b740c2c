// SPDX-License-Identifier: MIT
#include "FrictionlessMortar.h"
#include "../StaticContact.h"
#include <algorithm>
#include <basix/quadrature.h>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{

namespace
{
/// Rounding of coordinates, in sizes of the largest distance that a slave facet has from the origin.
constexpr double round_off = 1e-12;

std::array<std::vector<double>, 2> rule(surface::FacetShape shape, int degree)
{
  const auto cell = shape == surface::FacetShape::interval   ? basix::cell::type::interval
                    : shape == surface::FacetShape::triangle ? basix::cell::type::triangle
                                                             : basix::cell::type::quadrilateral;
  return basix::quadrature::make_quadrature<double>(basix::quadrature::type::Default, cell,
                                                    basix::polyset::type::standard, degree);
}

gap::MortarIntegrals make_integrals(const std::shared_ptr<const surface::FunctionSpace>& V,
                                    const surface::Facets& slave, const surface::Facets& master, bool axisymmetric)
{
  const int p = slave.displacement.degree;
  const bool flat = slave.displacement.shape != surface::FacetShape::quadrilateral && slave.geometry.degree == 1;
  const auto whole = rule(slave.displacement.shape, 2 * p + 2);
  const auto segment =
      rule(slave.gdim == 2 ? surface::FacetShape::interval : surface::FacetShape::triangle, 3 * p + (flat ? 2 : 4));
  const auto dual = gap::Multipliers::dual;
  return {V,
          std::make_shared<search::PairSearch>(V, slave, master),
          gap::multiplier_nodes(*V, slave, {whole[0], whole[1]}, dual, axisymmetric),
          {segment[0], segment[1]},
          dual,
          axisymmetric};
}

double maximum(MPI_Comm comm, double value)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, comm);
  return value;
}
} // namespace

FrictionlessMortar::FrictionlessMortar(const std::shared_ptr<const surface::FunctionSpace>& V,
                                       const surface::Facets& slave, const surface::Facets& master, bool axisymmetric)
    : _comm(V->mesh()->comm()), _gdim(slave.gdim), _integrals(make_integrals(V, slave, master, axisymmetric)),
      _active(_integrals.nodes().nodes.size(), 0), _pressure(_active.size(), 0.0)
{
  double size = 0.0;
  for (double x : slave.X)
    size = std::max(size, std::abs(x));
  _tolerance = round_off * maximum(_comm, size);
}

NodalMultipliers FrictionlessMortar::state() const
{
  return {.gdim = _gdim, .usable = _usable, .active = _active, .gap = _integrals.gap, .multiplier = _pressure};
}

NodalGeometry FrictionlessMortar::geometry() const
{
  return {.nodes = _integrals.nodes().nodes,
          .normal = _integrals.normal,
          .gap = _integrals.gap,
          .slip = {},
          .weight = _integrals.weight,
          .cover = _integrals.cover,
          .fixed = {},
          .ahead = {},
          .frames = _frames};
}

void FrictionlessMortar::update_gap(std::span<const double> u, std::span<const double> start)
{
  _integrals.update(u, start);
  _integrals.update_gap();
  _frames = frames_at(_gdim, _integrals.normal, std::vector<std::int8_t>(_integrals.normal.size(), 0));
  _usable = _integrals.participates;
}

void FrictionlessMortar::update_multipliers(std::span<const double> residual)
{
  const auto& nodes = _integrals.nodes().nodes;
  std::vector<double> force(nodes.size() * _gdim);
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    if (std::size_t(nodes[i] + 1) * _gdim > residual.size())
      throw std::invalid_argument("the residual has an entry for every owned degree of freedom of the space");
    std::copy_n(&residual[nodes[i] * _gdim], _gdim, &force[i * _gdim]);
  }
  std::vector<double> pressure(_pressure.size());
  evaluate_multipliers(state(), geometry(), force, {}, {}, {}, pressure, {});
  _pressure = std::move(pressure);
}

int FrictionlessMortar::update_active_set(bool first)
{
  const double largest =
      maximum(_comm, _pressure.empty() ? 0.0 : *std::max_element(_pressure.begin(), _pressure.end()));
  ActiveSet found = enforcement::update_active_set(state(), first, _tolerance, largest);
  int changes = 0;
  for (std::size_t i = 0; i < _active.size(); ++i)
  {
    changes += found.active[i] != _active[i];
    _pressure[i] = found.active[i] ? _pressure[i] : 0.0;
  }
  _active = std::move(found.active);
  MPI_Allreduce(MPI_IN_PLACE, &changes, 1, MPI_INT, MPI_SUM, _comm);
  return changes;
}

Constraints FrictionlessMortar::constraints() const
{
  const NodalMultipliers now = state();
  return constrain(now, geometry(), std::vector<double>(now.size() * _gdim, 0.0),
                   _integrals.master_rows(constrained_nodes(now)));
}

std::vector<double> FrictionlessMortar::contact_forces() const
{
  std::vector<double> traction(_integrals.normal);
  for (std::size_t i = 0; i < traction.size(); ++i)
    traction[i] *= _pressure[i / _gdim];
  return _integrals.contact_forces(traction);
}
} // namespace dolfinx_impact::enforcement
