// SPDX-License-Identifier: MIT
#include "variation.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
using search::ProjectionStatus;
using surface::FacetElement;

/// Free parameters of a point on a master facet: directions[r][alpha]. @returns their number
int free_directions(const gap::Points& points, const surface::Facets& master, std::size_t q, double directions[2][2])
{
  const FacetElement& element = master.geometry;
  if (points.status[q] == ProjectionStatus::vertex)
    return 0;
  if (points.status[q] == ProjectionStatus::edge)
  {
    const int* ends = search::edge_corners(element.shape, points.entity[q]);
    const auto a = element.node(ends[0]), b = element.node(ends[1]);
    directions[0][0] = b[0] - a[0];
    directions[0][1] = b[1] - a[1];
    return 1;
  }
  directions[0][0] = directions[1][1] = 1.0;
  directions[0][1] = directions[1][0] = 0.0;
  return element.tdim();
}

/// Tangents, metric and curvature of the master in the free parameters.
struct Chart
{
  double a[2][3] = {}, metric[2][2] = {}, curvature[2][2] = {};
};

Chart chart(const surface::Facets& master, std::int32_t f, const double* xi, const double* normal, int k,
            const double directions[2][2])
{
  const FacetElement& element = master.geometry;
  const int n = element.num_nodes(), tdim = element.tdim(), gdim = master.gdim;
  double dphi[2 * FacetElement::max_nodes], ddphi[3 * FacetElement::max_nodes];
  element.derivatives(xi, dphi);
  element.second_derivatives(xi, ddphi);
  double tangent[2][3] = {}, bend[2][2] = {};
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < gdim; ++c)
    {
      const double x = master.x_of(f)[i * gdim + c];
      for (int alpha = 0; alpha < tdim; ++alpha)
        tangent[alpha][c] += dphi[alpha * n + i] * x;
      bend[0][0] += ddphi[i] * x * normal[c];
      if (tdim == 2)
      {
        bend[1][1] += ddphi[n + i] * x * normal[c];
        bend[0][1] += ddphi[2 * n + i] * x * normal[c];
      }
    }
  bend[1][0] = bend[0][1];
  Chart out;
  for (int r = 0; r < k; ++r)
    for (int c = 0; c < gdim; ++c)
      for (int alpha = 0; alpha < tdim; ++alpha)
        out.a[r][c] += directions[r][alpha] * tangent[alpha][c];
  for (int r = 0; r < k; ++r)
    for (int s = 0; s < k; ++s)
    {
      for (int c = 0; c < gdim; ++c)
        out.metric[r][s] += out.a[r][c] * out.a[s][c];
      for (int alpha = 0; alpha < tdim; ++alpha)
        for (int beta = 0; beta < tdim; ++beta)
          out.curvature[r][s] += directions[r][alpha] * bend[alpha][beta] * directions[s][beta];
    }
  return out;
}

/// Inverse of a k x k matrix, k = 0, 1, 2.
void invert(int k, const double m[2][2], double out[2][2])
{
  if (k == 1)
    out[0][0] = 1.0 / m[0][0];
  if (k < 2)
    return;
  const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  out[0][0] = m[1][1] / det;
  out[1][1] = m[0][0] / det;
  out[0][1] = -m[0][1] / det;
  out[1][0] = -m[1][0] / det;
}

/// Derivatives of parameters and normal of a point on a deformable master.
void vary_on_facet(const Chart& chart, double gap, const double* n, bool interior, Variation& v)
{
  const int gdim = v.gdim, k = v.k, num = v.num;
  double stiff[2][2] = {}, A[2][2] = {}, inverse[2][2] = {}, dual[2][3] = {};
  for (int r = 0; r < k; ++r)
    for (int s = 0; s < k; ++s)
      stiff[r][s] = chart.metric[r][s] - gap * chart.curvature[r][s];
  invert(k, stiff, A);
  invert(k, chart.metric, inverse);
  for (int r = 0; r < k; ++r)
    for (int s = 0; s < k; ++s)
      for (int c = 0; c < gdim; ++c)
        dual[r][c] += inverse[r][s] * chart.a[s][c];
  // d xi = A (T + g S)
  std::fill_n(v.d_xi, k * num, 0.0);
  for (int r = 0; r < k; ++r)
    for (int s = 0; s < k; ++s)
      for (int c = 0; c < gdim; ++c)
      {
        v.d_xi[r * num + c] += A[r][s] * chart.a[s][c];
        v.d_xi[r * num + (1 + s) * gdim + c] += A[r][s] * gap * n[c];
      }
  // n stays orthogonal to the tangents: n . a_r = 0.
  std::fill_n(v.d_normal, gdim * num, 0.0);
  for (int r = 0; r < k; ++r)
    for (int j = 0; j < num; ++j)
    {
      double turn = j / gdim == 1 + r ? n[j % gdim] : 0.0;
      for (int s = 0; s < k; ++s)
        turn += chart.curvature[r][s] * v.d_xi[s * num + j];
      for (int c = 0; c < gdim; ++c)
        v.d_normal[c * num + j] -= dual[r][c] * turn;
    }
  if (interior)
    return;
  // On edges and at vertices it turns with D in the directions that are left.
  for (int c = 0; c < gdim; ++c)
    for (int d = 0; d < gdim; ++d)
    {
      double left = (c == d ? 1.0 : 0.0) - n[c] * n[d];
      for (int r = 0; r < k; ++r)
        left -= dual[r][c] * chart.a[r][d];
      v.d_normal[c * num + d] += left / gap;
    }
}
} // namespace

int relative_shape(const gap::Points& points, const surface::Facets& slave, const surface::Facets* master,
                   std::size_t q, double* shape)
{
  const int num_slave = slave.displacement.num_nodes();
  slave.displacement.values(points.xi.data() + 2 * q, shape);
  if (!master)
    return num_slave;
  const int num_master = master->displacement.num_nodes();
  master->displacement.values(points.master_xi.data() + 2 * q, shape + num_slave);
  for (int i = 0; i < num_master; ++i)
    shape[num_slave + i] *= -1.0;
  return num_slave + num_master;
}

Variation vary(const gap::Points& points, const surface::Facets& slave, const surface::Facets* master, std::size_t q)
{
  Variation v;
  const int gdim = points.gdim;
  const double* n = points.normal.data() + q * gdim;
  v.gdim = gdim;
  v.num_slave = slave.displacement.num_nodes();
  v.num_master = master ? master->displacement.num_nodes() : 0;
  relative_shape(points, slave, master, q, v.shape[0]);
  double directions[2][2];
  v.k = master ? free_directions(points, *master, q, directions) : 0;
  v.num = (1 + v.k) * gdim;
  std::fill_n(v.d_gap, v.num, 0.0);
  std::copy_n(n, gdim, v.d_gap);
  if (!master)
  {
    std::copy_n(points.hessian.data() + q * gdim * gdim, gdim * gdim, v.d_normal);
    return v;
  }
  const FacetElement& element = master->displacement;
  double dphi[2 * FacetElement::max_nodes];
  element.derivatives(points.master_xi.data() + 2 * q, dphi);
  for (int r = 0; r < v.k; ++r)
  {
    std::fill_n(v.shape[1 + r], v.num_slave, 0.0);
    for (int i = 0; i < v.num_master; ++i)
    {
      v.shape[1 + r][v.num_slave + i] = 0.0;
      for (int alpha = 0; alpha < element.tdim(); ++alpha)
        v.shape[1 + r][v.num_slave + i] += directions[r][alpha] * dphi[alpha * v.num_master + i];
    }
  }
  const Chart c = chart(*master, points.master[q], points.master_xi.data() + 2 * q, n, v.k, directions);
  vary_on_facet(c, points.gap[q], n, points.status[q] == ProjectionStatus::converged, v);
  return v;
}
} // namespace dolfinx_impact::enforcement
