// SPDX-License-Identifier: MIT
#include "points.h"
#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace dolfinx_impact::gap
{
namespace
{
void check_points(const Points& points, const surface::Facets& slave)
{
  if (points.gdim != slave.gdim || points.size() != points.per_facet * slave.size())
    throw std::invalid_argument("these points belong to another surface");
}
} // namespace

Points make_points(const surface::Facets& slave, std::span<const double> points, std::span<const double> weights,
                   bool axisymmetric)
{
  const int tdim = slave.geometry.tdim(), gdim = slave.gdim;
  if (points.size() != weights.size() * tdim)
    throw std::invalid_argument("a rule has as many weights as points, each with the facet's dimension");
  if (axisymmetric && gdim != 2)
    throw std::invalid_argument("axisymmetric surfaces are curves in the plane");
  Points out;
  out.gdim = gdim;
  out.per_facet = int(weights.size());
  for (std::size_t f = 0; f < slave.size(); ++f)
    for (std::size_t i = 0; i < weights.size(); ++i)
    {
      const double xi[2] = {points[tdim * i], tdim == 2 ? points[tdim * i + 1] : 0.0};
      const surface::FacetPoint p = surface::evaluate(slave, f, slave.X_of(f), xi);
      out.facet.push_back(std::int32_t(f));
      out.xi.insert(out.xi.end(), xi, xi + 2);
      out.weight.push_back(weights[i] * p.jacobian * (axisymmetric ? 2 * std::numbers::pi * p.x[0] : 1.0));
      out.x.insert(out.x.end(), p.x, p.x + gdim);
    }
  const std::size_t num = out.size();
  out.status.assign(num, search::ProjectionStatus::outside);
  out.entity.assign(num, -1);
  out.beside.assign(num, 0);
  out.margin.assign(num, search::keep_margin);
  out.master.assign(num, -1);
  out.master_xi.assign(2 * num, 0.0);
  out.gap.assign(num, std::numeric_limits<double>::infinity());
  out.normal.assign(num * gdim, 0.0);
  return out;
}

namespace
{
/// Positions, and what project(q, position, previous facet) finds there.
void update_each(Points& points, const surface::Facets& slave, bool keep, auto&& project)
{
  check_points(points, slave);
  const int gdim = points.gdim;
  points.hessian.clear();
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    const std::int32_t f = points.facet[q];
    const surface::FacetPoint s = surface::evaluate(slave, f, slave.x_of(f), points.xi.data() + 2 * q);
    const search::Projection p = project(q, s, keep ? points.master[q] : -1);
    std::copy_n(s.x, gdim, points.x.data() + q * gdim);
    points.status[q] = p.status;
    points.entity[q] = p.entity;
    points.beside[q] = p.rim == search::Projection::Rim::beside;
    points.master[q] = p.facet;
    std::copy_n(p.xi, 2, points.master_xi.data() + 2 * q);
    points.gap[q] = p.gap;
    std::copy_n(p.normal, gdim, points.normal.data() + q * gdim);
  }
}
} // namespace

void update(Points& points, const surface::Facets& slave, const search::SurfaceSearch& master, double reach, bool keep)
{
  update_each(points, slave, keep, [&](std::size_t q, const surface::FacetPoint& s, std::int32_t previous)
              { return master.project(s.x, s.normal, reach, previous, points.margin[q]); });
}

void update(Points& points, const surface::Facets& slave, const search::GeneralSearch& master, double reach, bool keep,
            std::span<const double> depth)
{
  update_each(points, slave, keep,
              [&](std::size_t q, const surface::FacetPoint& s, std::int32_t previous)
              {
                return master.project({points.facet[q], points.xi.data() + 2 * q, s.x, s.normal, depth[q]}, reach,
                                      previous, points.margin[q]);
              });
}

void update(Points& points, const surface::Facets& slave, const Rigid& master)
{
  check_points(points, slave);
  const int gdim = points.gdim;
  if (master.gdim != gdim)
    throw std::invalid_argument("the rigid master has another dimension than the slave");
  points.hessian.resize(points.size() * gdim * gdim);
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    const std::int32_t f = points.facet[q];
    const surface::FacetPoint s = surface::evaluate(slave, f, slave.x_of(f), points.xi.data() + 2 * q);
    const RigidPoint p = evaluate(master, s.x);
    std::copy_n(s.x, gdim, points.x.data() + q * gdim);
    points.status[q] = search::ProjectionStatus::converged;
    points.entity[q] = -1;
    points.beside[q] = 0;
    points.master[q] = -1;
    points.gap[q] = p.gap;
    std::copy_n(p.normal, gdim, points.normal.data() + q * gdim);
    for (int a = 0; a < gdim; ++a)
      std::copy_n(p.hessian + 3 * a, gdim, points.hessian.data() + (q * gdim + a) * gdim);
  }
}
} // namespace dolfinx_impact::gap
