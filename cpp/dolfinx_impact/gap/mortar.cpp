// SPDX-License-Identifier: MIT
#include "mortar.h"
#include "../common/vectors.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::gap
{
using surface::FacetElement;
using surface::FacetPoint;
using surface::Facets;
constexpr int N = FacetElement::max_nodes;

namespace
{
/// Points of one slave facet: [first, last).
struct Range
{
  std::size_t first, last;
};

/// Points of the facet that point `first` belongs to.
Range points_of_facet(const Segments& segments, std::size_t first)
{
  std::size_t last = first;
  while (last < segments.weight.size() && segments.slave[last] == segments.slave[first])
    ++last;
  return {first, last};
}

/// Present position of a point of a facet [L].
std::array<double, 3> position(const Facets& facets, std::size_t f, const double* xi)
{
  double phi[N];
  facets.geometry.values(xi, phi);
  const double* x = facets.x_of(f);
  std::array<double, 3> out{};
  for (int i = 0; i < facets.geometry.num_nodes(); ++i)
    for (int c = 0; c < facets.gdim; ++c)
      out[c] += phi[i] * x[i * facets.gdim + c];
  return out;
}

/// d_i = integral of phi_i, M_ij = integral of phi_i phi_j.
void integrate(const FacetElement& element, const Segments& segments, Range points, double* d, double M[N][N])
{
  const int n = element.num_nodes();
  double phi[N];
  for (std::size_t q = points.first; q < points.last; ++q)
  {
    element.values(&segments.xi_slave[2 * q], phi);
    for (int i = 0; i < n; ++i)
    {
      d[i] += segments.weight[q] * phi[i];
      for (int j = 0; j < n; ++j)
        M[i][j] += segments.weight[q] * phi[i] * phi[j];
    }
  }
}

/// Hat functions of the corners in terms of the shape functions: their values at the nodes.
void hats(const FacetElement& element, double A[N][N])
{
  const FacetElement corners{element.shape, 1};
  double values[N];
  for (int j = 0; j < element.num_nodes(); ++j)
  {
    corners.values(element.node(j).data(), values);
    for (int i = 0; i < corners.num_nodes(); ++i)
      A[i][j] = values[i];
  }
}

/// Solves M^T-systems of one facet: A = D M^-1 by Gauss elimination with row pivoting. M is symmetric positive
/// definite and destroyed.
void dual_coefficients(int n, double M[N][N], const double* d, double A[N][N])
{
  double inverse[N][N];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      inverse[i][j] = i == j ? 1.0 : 0.0;
  double largest = 0.0;
  for (int i = 0; i < n; ++i)
    largest = std::max(largest, M[i][i]);
  for (int k = 0; k < n; ++k)
  {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(M[i][k]) > std::abs(M[pivot][k]))
        pivot = i;
    if (!(std::abs(M[pivot][k]) > 1e-300 * largest))
      throw std::runtime_error("the mortar integrals of a slave facet are singular");
    for (int j = 0; j < n; ++j)
    {
      std::swap(M[k][j], M[pivot][j]);
      std::swap(inverse[k][j], inverse[pivot][j]);
    }
    const double scale = 1.0 / M[k][k];
    for (int j = 0; j < n; ++j)
    {
      M[k][j] *= scale;
      inverse[k][j] *= scale;
    }
    for (int i = 0; i < n; ++i)
      if (i != k)
      {
        const double factor = M[i][k];
        for (int j = 0; j < n; ++j)
        {
          M[i][j] -= factor * M[k][j];
          inverse[i][j] -= factor * inverse[k][j];
        }
      }
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      A[i][j] = d[i] * inverse[i][j];
}
} // namespace

std::vector<double> cover(const Facets& slave, const Segments& segments, Multipliers basis, double least)
{
  const FacetElement element = slave.displacement;
  const int n = element.num_nodes();
  std::vector<double> out(slave.size() * n, 0.0);
  double corners[N][N] = {};
  hats(element, corners);
  for (std::size_t first = 0; first < segments.weight.size();)
  {
    const Range points = points_of_facet(segments, first);
    const std::int32_t s = segments.slave[first];
    first = points.last;
    if (segments.covered[s] < least)
      continue;
    double mass[N][N] = {}, d[N] = {};
    integrate(element, segments, points, d, mass);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        out[s * n + i] += (basis == Multipliers::linear ? corners[i][j] : i == j ? 1.0 : 0.0) * d[j];
  }
  return out;
}

Mortar mortar(const Facets& slave, const Facets& master, const Segments& segments, Multipliers basis,
              std::span<const std::int8_t> carries, double least)
{
  const FacetElement es = slave.displacement, em = master.displacement;
  const int n = es.num_nodes(), gdim = slave.gdim;
  Mortar out;
  out.psi.assign(segments.weight.size() * n, 0.0);
  out.gamma.assign(slave.size() * n * gdim, 0.0);
  double phi[N];
  for (std::size_t first = 0; first < segments.weight.size();)
  {
    const auto [begin, last] = points_of_facet(segments, first);
    const std::int32_t s = segments.slave[first];
    const std::int32_t* nodes = slave.nodes_of(s);
    const int num_kept = int(std::count_if(nodes, nodes + n, [&](auto node) { return carries[node] != 0; }));
    if (segments.covered[s] < least || num_kept == 0)
    {
      first = last;
      continue;
    }
    double mass[N][N] = {}, A[N][N] = {}, d[N] = {};
    integrate(es, segments, {begin, last}, d, mass);
    double D[N][N] = {};
    if (basis == Multipliers::dual)
    {
      for (int i = 0; i < n; ++i)
        D[i][i] = d[i];
      dual_coefficients(n, mass, d, A);
    }
    else
    {
      if (basis == Multipliers::linear)
        hats(es, A);
      else
        for (int i = 0; i < n; ++i)
          A[i][i] = 1.0;
      for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
          for (int j = 0; j < n; ++j)
            D[i][j] += A[i][k] * mass[k][j];
    }
    // Rows of nodes without multiplier go in equal parts to the others.
    for (int i = 0; i < n; ++i)
      if (carries[nodes[i]] == 0)
        for (int k = 0; k < n; ++k)
          for (int j = 0; j < n && carries[nodes[k]] != 0; ++j)
          {
            A[k][j] += A[i][j] / num_kept;
            D[k][j] += D[i][j] / num_kept;
          }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (carries[nodes[i]] == 0)
          A[i][j] = 0.0;
        else if (D[i][j] != 0.0)
          out.D.add(nodes[i], nodes[j], D[i][j]);
    // Entries of one master facet are summed before they are stored.
    for (std::size_t q = first; q < last;)
    {
      const std::int32_t m = segments.master[q];
      double Me[N][N] = {};
      for (; q < last && segments.master[q] == m; ++q)
      {
        es.values(&segments.xi_slave[2 * q], phi);
        double* psi = &out.psi[q * n];
        for (int i = 0; i < n; ++i)
        {
          psi[i] = 0.0;
          for (int j = 0; j < n; ++j)
            psi[i] += A[i][j] * phi[j];
          psi[i] *= segments.weight[q];
        }
        if (m < 0)
          continue;
        const std::array<double, 3> here = position(slave, s, &segments.xi_slave[2 * q]);
        const std::array<double, 3> there = position(master, m, &segments.xi_master[2 * q]);
        double phi_m[N];
        em.values(&segments.xi_master[2 * q], phi_m);
        for (int i = 0; i < n; ++i)
        {
          for (int l = 0; l < em.num_nodes(); ++l)
            Me[i][l] += psi[i] * phi_m[l];
          for (int c = 0; c < gdim; ++c)
            out.gamma[(s * n + i) * gdim + c] += psi[i] * (here[c] - there[c]);
        }
      }
      for (int i = 0; i < n && m >= 0; ++i)
        if (carries[nodes[i]] != 0)
          for (int l = 0; l < em.num_nodes(); ++l)
            out.M.add(nodes[i], master.nodes_of(m)[l], Me[i][l]);
    }
    first = last;
  }
  return out;
}

void add_normals(const Facets& slave, std::span<double> normals, std::span<const std::int8_t> counts)
{
  const int n = slave.displacement.num_nodes(), gdim = slave.gdim;
  for (std::size_t f = 0; f < slave.size(); ++f)
    for (int i = 0; i < n; ++i)
    {
      if (!counts.empty() && !counts[f * n + i])
        continue;
      const auto xi = slave.displacement.node(i);
      const FacetPoint p = surface::evaluate(slave, f, slave.x_of(f), xi.data());
      for (int c = 0; c < gdim; ++c)
        normals[slave.nodes_of(f)[i] * gdim + c] -= p.normal[c];
    }
}

Entries sliding_tangent(const Facets& slave, const Facets& master, const Segments& segments, const Mortar& mortar,
                        std::span<const double> z)
{
  const FacetElement es = slave.displacement, em = master.displacement;
  const int n = es.num_nodes(), nm = em.num_nodes(), dim = es.tdim(), gdim = dim + 1;
  Entries out;
  // Rows: the master facet's components; columns: the slave's, then the master's. One block per pair of facets.
  const int num_rows = nm * gdim, num_columns = (n + nm) * gdim;
  double block[3 * N][6 * N] = {};
  bool filled = false;
  for (std::size_t q = 0; q < segments.weight.size(); ++q)
  {
    const std::int32_t s = segments.slave[q], m = segments.master[q];
    if (m < 0)
      continue;
    const std::int32_t *ns = slave.nodes_of(s), *nn = master.nodes_of(m);
    const bool last = q + 1 == segments.weight.size() || segments.slave[q + 1] != s || segments.master[q + 1] != m;
    auto store = [=, &block, &filled, &out]
    {
      for (int i = 0; i < num_rows; ++i)
        for (int j = 0; j < num_columns; ++j)
        {
          const int k = j / gdim;
          out.add(nn[i / gdim] * gdim + i % gdim, (k < n ? ns[k] : nn[k - n]) * gdim + j % gdim, block[i][j]);
          block[i][j] = 0.0;
        }
      filled = false;
    };
    double traction[3] = {0.0, 0.0, 0.0}, size = 0.0;
    for (int i = 0; i < n; ++i)
      for (int c = 0; c < gdim; ++c)
      {
        traction[c] += mortar.psi[q * n + i] * z[ns[i] * gdim + c];
        size += std::abs(traction[c]);
      }
    if (size == 0.0)
    {
      if (last && filled)
        store();
      continue;
    }
    const FacetPoint pm = surface::evaluate(master, m, master.x_of(m), &segments.xi_master[2 * q]);
    // d xi = rows of the inverse of [a_1 a_2 nu] times (dx_s - dx_m): projection along nu.
    const double* nu = &segments.direction[3 * q];
    double rows[2][3];
    if (dim == 1)
    {
      const double det = pm.tangents[0][0] * nu[1] - pm.tangents[0][1] * nu[0];
      rows[0][0] = nu[1] / det;
      rows[0][1] = -nu[0] / det;
    }
    else
    {
      const double *a = pm.tangents[0], *b = pm.tangents[1];
      double across_b[3], across_a[3];
      dolfinx_impact::cross(b, nu, across_b);
      dolfinx_impact::cross(nu, a, across_a);
      const double det = dolfinx_impact::dot(a, across_b, 3);
      for (int c = 0; c < 3; ++c)
      {
        rows[0][c] = across_b[c] / det;
        rows[1][c] = across_a[c] / det;
      }
    }
    double phi_s[N], phi_m[N], dphi[2 * N];
    es.values(&segments.xi_slave[2 * q], phi_s);
    em.values(&segments.xi_master[2 * q], phi_m);
    em.derivatives(&segments.xi_master[2 * q], dphi);
    for (int l = 0; l < nm; ++l)
    {
      double along[3] = {0.0, 0.0, 0.0};
      for (int alpha = 0; alpha < dim; ++alpha)
        for (int e = 0; e < gdim; ++e)
          along[e] += dphi[alpha * nm + l] * rows[alpha][e];
      for (int c = 0; c < gdim; ++c)
        for (int e = 0; e < gdim; ++e)
        {
          const double v = traction[c] * along[e];
          for (int k = 0; k < n; ++k)
            block[l * gdim + c][k * gdim + e] += v * phi_s[k];
          for (int k = 0; k < nm; ++k)
            block[l * gdim + c][(n + k) * gdim + e] -= v * phi_m[k];
        }
    }
    filled = true;
    if (last)
      store();
  }
  return out;
}

Entries turning_tangent(const Facets& slave, std::span<const double> sums, std::span<const double> force,
                        std::span<const std::int8_t> counts)
{
  const FacetElement element = slave.displacement;
  const int n = element.num_nodes(), gdim = slave.gdim, dim = gdim - 1;
  Entries out;
  for (std::size_t f = 0; f < slave.size(); ++f)
    for (int i = 0; i < n; ++i)
    {
      const std::int32_t node = slave.nodes_of(f)[i];
      if (force[node] == 0.0 || (!counts.empty() && !counts[f * n + i]))
        continue;
      const auto xi = element.node(i);
      const FacetPoint p = surface::evaluate(slave, f, slave.x_of(f), xi.data());
      double dphi[2 * N], m[2][2] = {{1.0, 0.0}, {0.0, 1.0}}, length = 0.0, mean[3] = {0.0, 0.0, 0.0};
      element.derivatives(xi.data(), dphi);
      for (int c = 0; c < gdim; ++c)
        length += sums[node * gdim + c] * sums[node * gdim + c];
      length = std::sqrt(length);
      for (int c = 0; c < gdim; ++c)
        mean[c] = sums[node * gdim + c] / length;
      for (int a = 0; a < dim; ++a)
        for (int b = 0; b < dim; ++b)
        {
          m[a][b] = 0.0;
          for (int c = 0; c < gdim; ++c)
            m[a][b] += p.tangents[a][c] * p.tangents[b][c];
        }
      double inverse[2][2] = {{1.0 / m[0][0], 0.0}, {0.0, 0.0}};
      if (dim == 2)
      {
        const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        inverse[0][0] = m[1][1] / det;
        inverse[1][1] = m[0][0] / det;
        inverse[0][1] = inverse[1][0] = -m[0][1] / det;
      }
      // The facet's normal turns by d nu = -a^alpha (nu . d a_alpha); n = -sum/|sum|, minus the force gives a plus.
      for (int k = 0; k < n; ++k)
        for (int c = 0; c < gdim; ++c)
          for (int e = 0; e < gdim; ++e)
          {
            double v = 0.0;
            for (int r = 0; r < gdim; ++r)
              for (int a = 0; a < dim; ++a)
                for (int b = 0; b < dim; ++b)
                  v += ((c == r ? 1.0 : 0.0) - mean[c] * mean[r]) * p.tangents[b][r] * inverse[b][a] * dphi[a * n + k] *
                       p.normal[e];
            out.add(node * gdim + c, slave.nodes_of(f)[k] * gdim + e, -force[node] * v / length);
          }
    }
  return out;
}
} // namespace dolfinx_impact::gap
