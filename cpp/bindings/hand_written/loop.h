// SPDX-License-Identifier: MIT
#pragma once
// The loops, written once for vectors of W numbers. Everything is in an unnamed namespace: each file that includes this
// is compiled for another processor.
#include "CellLoop.h"
#include <immintrin.h>

namespace dolfinx_impact::hand_written
{
namespace
{
constexpr int W = IMPACT_HAND_WRITTEN_WIDTH;
typedef double V __attribute__((vector_size(8 * W)));
#define ALWAYS __attribute__((always_inline)) inline

struct Vector
{
  V c[3];
};
/// c[i] is the derivative with respect to coordinate i.
struct Gradient
{
  Vector c[3];
};

ALWAYS V fused(V a, V b, V c)
{
  return a * b + c;
}

struct Rows
{
  __m256d x, y, z;
};

ALWAYS Rows columns(const double* a, const std::int32_t* nodes)
{
  const __m256d r0 = _mm256_load_pd(a + 4 * std::int64_t(nodes[0])),
                r1 = _mm256_load_pd(a + 4 * std::int64_t(nodes[1]));
  const __m256d r2 = _mm256_load_pd(a + 4 * std::int64_t(nodes[2])),
                r3 = _mm256_load_pd(a + 4 * std::int64_t(nodes[3]));
  const __m256d t0 = _mm256_unpacklo_pd(r0, r1), t1 = _mm256_unpackhi_pd(r0, r1);
  const __m256d t2 = _mm256_unpacklo_pd(r2, r3), t3 = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(t0, t2, 0x20), _mm256_permute2f128_pd(t1, t3, 0x20),
          _mm256_permute2f128_pd(t0, t2, 0x31)};
}

ALWAYS void add_rows(double* r, const std::int32_t* nodes, __m256d x, __m256d y, __m256d z)
{
  const __m256d zero = _mm256_setzero_pd();
  const __m256d t0 = _mm256_unpacklo_pd(x, y), t1 = _mm256_unpackhi_pd(x, y);
  const __m256d t2 = _mm256_unpacklo_pd(z, zero), t3 = _mm256_unpackhi_pd(z, zero);
  const auto add = [r](std::int32_t node, __m256d row)
  {
    double* p = r + 4 * std::int64_t(node);
    _mm256_store_pd(p, _mm256_add_pd(_mm256_load_pd(p), row));
  };
  add(nodes[0], _mm256_permute2f128_pd(t0, t2, 0x20));
  add(nodes[1], _mm256_permute2f128_pd(t1, t3, 0x20));
  add(nodes[2], _mm256_permute2f128_pd(t0, t2, 0x31));
  add(nodes[3], _mm256_permute2f128_pd(t1, t3, 0x31));
}

ALWAYS Vector gather(const double* a, const std::int32_t* nodes)
{
  const Rows first = columns(a, nodes);
#if IMPACT_HAND_WRITTEN_WIDTH == 8
  const Rows second = columns(a, nodes + 4);
  const auto whole = [](__m256d low, __m256d high)
  { return V(_mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1)); };
  return {{whole(first.x, second.x), whole(first.y, second.y), whole(first.z, second.z)}};
#else
  return {{V(first.x), V(first.y), V(first.z)}};
#endif
}

ALWAYS void scatter(double* r, const std::int32_t* nodes, const Vector& f)
{
#if IMPACT_HAND_WRITTEN_WIDTH == 8
  const auto low = [&f](int i) { return _mm512_castpd512_pd256(__m512d(f.c[i])); };
  const auto high = [&f](int i) { return _mm512_extractf64x4_pd(__m512d(f.c[i]), 1); };
  add_rows(r, nodes, low(0), low(1), low(2));
  add_rows(r, nodes + 4, high(0), high(1), high(2));
#else
  add_rows(r, nodes, __m256d(f.c[0]), __m256d(f.c[1]), __m256d(f.c[2]));
#endif
}

ALWAYS Vector operator-(const Vector& a, const Vector& b)
{
  return {{a.c[0] - b.c[0], a.c[1] - b.c[1], a.c[2] - b.c[2]}};
}
ALWAYS Vector operator+(const Vector& a, const Vector& b)
{
  return {{a.c[0] + b.c[0], a.c[1] + b.c[1], a.c[2] + b.c[2]}};
}
ALWAYS Vector operator*(double s, const Vector& a)
{
  return {{s * a.c[0], s * a.c[1], s * a.c[2]}};
}
ALWAYS Vector cross(const Vector& a, const Vector& b)
{
  return {{a.c[1] * b.c[2] - a.c[2] * b.c[1], a.c[2] * b.c[0] - a.c[0] * b.c[2], a.c[0] * b.c[1] - a.c[1] * b.c[0]}};
}
ALWAYS V dot(const Vector& a, const Vector& b)
{
  return fused(a.c[0], b.c[0], fused(a.c[1], b.c[1], a.c[2] * b.c[2]));
}

/// Rows of the cofactors of the Jacobian: derivatives of reference coordinates, times the determinant.
struct Cofactors
{
  Vector c[3];
  V determinant;
};
ALWAYS Cofactors cofactors(const Gradient& x)
{
  Cofactors out{{cross(x.c[1], x.c[2]), cross(x.c[2], x.c[0]), cross(x.c[0], x.c[1])}, {}};
  out.determinant = dot(x.c[0], out.c[0]);
  return out;
}

/// Stress times cofactors times a weight: c[d] is what the test function's derivative with respect to reference
/// coordinate d is multiplied with.
ALWAYS Gradient fluxes(const Elasticity& e, const Gradient& u, const Cofactors& k, double weight)
{
  V h[3][3]; // h[i][j]: derivative of component i with respect to x_j, times the determinant
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      h[i][j] = fused(u.c[0].c[i], k.c[0].c[j], fused(u.c[1].c[i], k.c[1].c[j], u.c[2].c[i] * k.c[2].c[j]));
  const V scale = weight / k.determinant, shear = e.mu * scale;
  const V pressure = (e.lambda * scale) * (h[0][0] + h[1][1] + h[2][2]);
  V s[3][3];
  for (int i = 0; i < 3; ++i)
  {
    s[i][i] = fused(2.0 * shear, h[i][i], pressure);
    for (int j = 0; j < i; ++j)
      s[i][j] = s[j][i] = shear * (h[i][j] + h[j][i]);
  }
  Gradient out;
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < 3; ++i)
      out.c[d].c[i] = fused(s[i][0], k.c[d].c[0], fused(s[i][1], k.c[d].c[1], s[i][2] * k.c[d].c[2]));
  return out;
}

ALWAYS void tetrahedron4(const std::int32_t* nodes, const Elasticity& e, const NodalArrays& a)
{
  const Vector x0 = gather(a.x, nodes), u0 = gather(a.u, nodes);
  Gradient x, u;
  for (int d = 0; d < 3; ++d)
  {
    x.c[d] = gather(a.x, nodes + (d + 1) * W) - x0;
    u.c[d] = gather(a.u, nodes + (d + 1) * W) - u0;
  }
  const Gradient f = fluxes(e, u, cofactors(x), 1.0 / 6.0);
  scatter(a.r, nodes, -1.0 * (f.c[0] + f.c[1] + f.c[2]));
  for (int d = 0; d < 3; ++d)
    scatter(a.r, nodes + (d + 1) * W, f.c[d]);
}

/// Straight sides; four points with barycentric coordinates `far` but for the own one. Derivatives with respect to a
/// barycentric coordinate at the points differ in one term only.
ALWAYS void tetrahedron10(const std::int32_t* nodes, const Elasticity& e, const NodalArrays& a)
{
  // number of the node between two corners, in Basix's order
  constexpr int between[4][4] = {{-1, 9, 8, 7}, {9, -1, 6, 5}, {8, 6, -1, 4}, {7, 5, 4, -1}};
  constexpr double far = 0.1381966011250105, near = 1.0 - 3.0 * far, step = 4.0 * (near - far);
  const Vector x0 = gather(a.x, nodes);
  Gradient x;
  for (int d = 0; d < 3; ++d)
    x.c[d] = gather(a.x, nodes + (d + 1) * W) - x0;
  const Cofactors k = cofactors(x);
  Vector u[10];
  for (int i = 0; i < 10; ++i)
    u[i] = gather(a.u, nodes + i * W);
  Vector mean[4], f[10];
  for (int i = 0; i < 4; ++i)
  {
    Vector sum{};
    for (int j = 0; j < 4; ++j)
      if (j != i)
        sum = sum + u[between[i][j]];
    mean[i] = (4.0 * far - 1.0) * u[i] + (4.0 * far) * sum;
  }
  for (int i = 0; i < 10; ++i)
    f[i] = Vector{};
  Vector total[4]{};
  for (int q = 0; q < 4; ++q)
  {
    const auto derivative = [&](int i) { return mean[i] + step * u[i == q ? i : between[i][q]]; };
    const Vector first = derivative(0);
    Gradient g;
    for (int d = 0; d < 3; ++d)
      g.c[d] = derivative(d + 1) - first;
    const Gradient p = fluxes(e, g, k, 1.0 / 24.0);
    const Vector own[4] = {-1.0 * (p.c[0] + p.c[1] + p.c[2]), p.c[0], p.c[1], p.c[2]};
    for (int i = 0; i < 4; ++i)
    {
      total[i] = total[i] + own[i];
      Vector& node = f[i == q ? i : between[i][q]];
      node = node + step * own[i];
    }
  }
  for (int i = 0; i < 4; ++i)
  {
    f[i] = f[i] + (4.0 * far - 1.0) * total[i];
    for (int j = i + 1; j < 4; ++j)
      f[between[i][j]] = f[between[i][j]] + (4.0 * far) * (total[i] + total[j]);
  }
  for (int i = 0; i < 10; ++i)
    scatter(a.r, nodes + i * W, f[i]);
}

/// Derivatives at 2 x 2 x 2 points by edges, of one component: that along one direction is constant in it. Entry [d][j]
/// is that of direction d at the points j of the two other directions, the earlier of which changes first.
typedef V Edges[3][4];

constexpr double low = 0.21132486540518713, high = 1.0 - low; // Gauss points of [0, 1]

/// Values at two ends of two pairs of edges -> at two points, and again in the other direction. It is its own
/// transpose.
ALWAYS void to_points(V (&a)[4])
{
  const V b0 = high * a[0] + low * a[1], b1 = low * a[0] + high * a[1];
  const V b2 = high * a[2] + low * a[3], b3 = low * a[2] + high * a[3];
  a[0] = high * b0 + low * b2;
  a[1] = high * b1 + low * b3;
  a[2] = low * b0 + high * b2;
  a[3] = low * b1 + high * b3;
}

/// @param[in] n nodal values of a component, node i + 2j + 4k
ALWAYS void derivatives(const V (&n)[8], Edges& e)
{
  for (int j = 0; j < 4; ++j)
  {
    e[0][j] = n[2 * j + 1] - n[2 * j];
    e[1][j] = n[(j & 1) + 4 * (j >> 1) + 2] - n[(j & 1) + 4 * (j >> 1)];
    e[2][j] = n[j + 4] - n[j];
  }
  for (int d = 0; d < 3; ++d)
    to_points(e[d]);
}

/// @param[out] n by component, then by node
ALWAYS void gather_components(const double* values, const std::int32_t* nodes, V (&n)[3][8])
{
  for (int i = 0; i < 8; ++i)
  {
    const Vector p = gather(values, nodes + i * W);
    n[0][i] = p.c[0];
    n[1][i] = p.c[1];
    n[2][i] = p.c[2];
  }
}

ALWAYS void hexahedron8(const std::int32_t* nodes, const Elasticity& e, const NodalArrays& a)
{
  V n[3][8];
  Edges x[3], u[3], f[3];
  gather_components(a.x, nodes, n);
#pragma GCC unroll 1
  for (int c = 0; c < 3; ++c)
    derivatives(n[c], x[c]);
  gather_components(a.u, nodes, n);
#pragma GCC unroll 1
  for (int c = 0; c < 3; ++c)
  {
    derivatives(n[c], u[c]);
    for (int d = 0; d < 3; ++d)
      for (int j = 0; j < 4; ++j)
        f[c][d][j] = V{};
  }
#pragma GCC unroll 1
  for (int k = 0; k < 2; ++k)
#pragma GCC unroll 1
    for (int j = 0; j < 2; ++j)
#pragma GCC unroll 1
      for (int i = 0; i < 2; ++i)
      {
        const int at[3] = {j + 2 * k, i + 2 * k, i + 2 * j};
        Gradient dx, du;
        for (int d = 0; d < 3; ++d)
          for (int c = 0; c < 3; ++c)
          {
            dx.c[d].c[c] = x[c][d][at[d]];
            du.c[d].c[c] = u[c][d][at[d]];
          }
        const Gradient p = fluxes(e, du, cofactors(dx), 0.125);
        for (int d = 0; d < 3; ++d)
          for (int c = 0; c < 3; ++c)
            f[c][d][at[d]] += p.c[d].c[c];
      }
#pragma GCC unroll 1
  for (int c = 0; c < 3; ++c)
  {
    for (int d = 0; d < 3; ++d)
      to_points(f[c][d]);
    for (int j = 0; j < 4; ++j)
    {
      n[c][2 * j] = -f[c][0][j];
      n[c][2 * j + 1] = f[c][0][j];
    }
    for (int j = 0; j < 4; ++j)
    {
      const int first = (j & 1) + 4 * (j >> 1);
      n[c][first] -= f[c][1][j];
      n[c][first + 2] += f[c][1][j];
    }
    for (int j = 0; j < 4; ++j)
    {
      n[c][j] -= f[c][2][j];
      n[c][j + 4] += f[c][2][j];
    }
  }
  for (int i = 0; i < 8; ++i)
    scatter(a.r, nodes + i * W, {{n[0][i], n[1][i], n[2][i]}});
}

/// Derivatives by the reference coordinates at the centre of a hexahedron: those by one coordinate times 4, by the two
/// others times 2, and by all three.
struct CentreDerivatives
{
  Vector first[3], second[3], third;
};

/// Nodes are added and subtracted as they are read, so that half of them need registers.
ALWAYS CentreDerivatives centre_derivatives(const double* values, const std::int32_t* nodes)
{
  Vector sum[2], by_0[2], by_1[2], by_01[2]; // of the four nodes at either end of the last direction
  for (int k = 0; k < 2; ++k)
  {
    const Vector n0 = gather(values, nodes + 4 * k * W), n1 = gather(values, nodes + (4 * k + 1) * W);
    const Vector low_sum = n0 + n1, low_step = n1 - n0;
    const Vector n2 = gather(values, nodes + (4 * k + 2) * W), n3 = gather(values, nodes + (4 * k + 3) * W);
    const Vector high_sum = n2 + n3, high_step = n3 - n2;
    sum[k] = low_sum + high_sum;
    by_0[k] = low_step + high_step;
    by_1[k] = high_sum - low_sum;
    by_01[k] = high_step - low_step;
  }
  return {{by_0[0] + by_0[1], by_1[0] + by_1[1], sum[1] - sum[0]},
          {by_1[1] - by_1[0], by_0[1] - by_0[0], by_01[0] + by_01[1]},
          by_01[1] - by_01[0]};
}

/// The transpose of centre_derivatives, added to the nodes.
ALWAYS void scatter_centre_derivatives(double* r, const std::int32_t* nodes, const CentreDerivatives& f)
{
  for (int k = 0; k < 2; ++k)
  {
    const double side = k == 0 ? -1.0 : 1.0;
    const Vector by_0 = f.first[0] + side * f.second[1], by_1 = f.first[1] + side * f.second[0];
    const Vector sum = side * f.first[2], by_01 = f.second[2] + side * f.third;
    const Vector low = sum - by_1, high = sum + by_1, low_step = by_0 - by_01, high_step = by_0 + by_01;
    scatter(r, nodes + 4 * k * W, low - low_step);
    scatter(r, nodes + (4 * k + 1) * W, low + low_step);
    scatter(r, nodes + (4 * k + 2) * W, high - high_step);
    scatter(r, nodes + (4 * k + 3) * W, high + high_step);
  }
}

/// One point and hourglass control, docs/one_point.md; second[i] and third of what centre_derivatives gives are the
/// modes.
ALWAYS void hexahedron1(const std::int32_t* nodes, const Elasticity& e, const NodalArrays& a)
{
  const CentreDerivatives x = centre_derivatives(a.x, nodes);
  Vector linear[3], bilinear[3]; // factors of first and second derivatives in 192 times the volume times the gradient
  V volume{};                    // times 192
  for (int i = 0; i < 3; ++i)
  {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    linear[i] = 3.0 * cross(x.first[j], x.first[k]) - cross(x.second[j], x.second[k]);
    bilinear[i] = -1.0 * (cross(x.first[j], x.second[k]) + cross(x.second[j], x.first[k]));
    volume = fused(x.first[i].c[0], linear[i].c[0], fused(x.second[i].c[0], bilinear[i].c[0], volume));
  }
  const CentreDerivatives u = centre_derivatives(a.u, nodes);
  V g[3][3]{}; // mean gradient
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        g[c][d] = fused(u.first[i].c[c], linear[i].c[d], fused(u.second[i].c[c], bilinear[i].c[d], g[c][d]));
  const V inverse_volume = 1.0 / volume;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      g[c][d] = g[c][d] * inverse_volume;

  // Amplitudes of the modes along the axes: eight times a . h, of the last mode four times.
  const Vector modes_x[4] = {x.second[0], x.second[1], x.second[2], x.third};
  const Vector modes_u[4] = {u.second[0], u.second[1], u.second[2], u.third};
  V amplitude[4][3];
  for (int m = 0; m < 4; ++m)
  {
    Vector h;
    for (int c = 0; c < 3; ++c)
      h.c[c] = modes_u[m].c[c] - g[c][0] * modes_x[m].c[0] - g[c][1] * modes_x[m].c[1] - g[c][2] * modes_x[m].c[2];
    for (int i = 0; i < 3; ++i)
      amplitude[m][i] = dot(x.first[i], h);
  }

  V s[3][3];
  const V pressure = e.lambda * (g[0][0] + g[1][1] + g[2][2]);
  for (int i = 0; i < 3; ++i)
  {
    s[i][i] = fused(V{} + 2.0 * e.mu, g[i][i], pressure);
    for (int j = 0; j < i; ++j)
      s[i][j] = s[j][i] = e.mu * (g[i][j] + g[j][i]);
  }

  // Forces on the modes, by axes; mode i is that of both other coordinates.
  const double poisson = e.lambda / (2.0 * (e.lambda + e.mu));
  const double plate = 4.0 * e.mu * (e.lambda + e.mu) / (e.lambda + 2.0 * e.mu);
  const double young = 2.0 * e.mu * (1.0 + poisson);
  V inverse[3], force[4][3]; // 1 / (16 |x_i|^2)
  for (int i = 0; i < 3; ++i)
    inverse[i] = 1.0 / dot(x.first[i], x.first[i]);
  for (int k = 0; k < 3; ++k)
  {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const V strain_i = inverse[i] * amplitude[j][i], strain_j = inverse[j] * amplitude[i][j];
    force[j][i] = (plate * 256.0 / 384.0) * inverse[i] * fused(V{} + poisson, strain_j, strain_i);
    force[i][j] = (plate * 256.0 / 384.0) * inverse[j] * fused(V{} + poisson, strain_i, strain_j);
  }
  for (int i = 0; i < 3; ++i)
  {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const V twist_j = amplitude[i][i] + amplitude[j][j], twist_k = amplitude[i][i] + amplitude[k][k];
    force[i][i] = (e.mu * 256.0 / 384.0) * inverse[i] * fused(inverse[j], twist_j, inverse[k] * twist_k);
    force[3][i] = (young * 256.0 / 2304.0) * inverse[i] * inverse[i] * amplitude[3][i];
  }
  Vector on_modes[4];
  for (int m = 0; m < 4; ++m)
  {
    for (int c = 0; c < 3; ++c)
      on_modes[m].c[c] =
          fused(x.first[0].c[c], force[m][0], fused(x.first[1].c[c], force[m][1], x.first[2].c[c] * force[m][2]));
    const Vector half = (m < 3 ? 0.5 : 1.0) * on_modes[m]; // modes_x is twice the mode but for the last one
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        s[c][d] = s[c][d] - half.c[c] * modes_x[m].c[d];
  }

  CentreDerivatives f;
  const V size = (1.0 / 192.0) * volume, half_size = 0.5 * size;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      s[c][d] = (1.0 / 192.0) * s[c][d];
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c)
    {
      const Vector row{{s[c][0], s[c][1], s[c][2]}};
      f.first[i].c[c] = dot(row, linear[i]);
      f.second[i].c[c] = fused(half_size, on_modes[i].c[c], dot(row, bilinear[i]));
    }
  for (int c = 0; c < 3; ++c)
    f.third.c[c] = size * on_modes[3].c[c];
  scatter_centre_derivatives(a.r, nodes, f);
}

template <int N, bool one_point = false>
void add_forces(const CellBatches& cells, const Elasticity& elasticity, const NodalArrays& arrays)
{
  const Elasticity e = elasticity; // copies: stores of doubles might change what is read by reference
  const NodalArrays a = arrays;
  for (std::size_t b = 0; b < cells.num_batches; ++b)
  {
    const std::int32_t* nodes = cells.nodes + b * N * W;
    if constexpr (one_point)
      hexahedron1(nodes, e, a);
    else if constexpr (N == 8)
      hexahedron8(nodes, e, a);
    else if constexpr (N == 4)
      tetrahedron4(nodes, e, a);
    else
      tetrahedron10(nodes, e, a);
  }
}

void update(std::size_t num_nodes, double step, const NodalArrays& a)
{
  const __m256d dt = _mm256_set1_pd(step), zero = _mm256_setzero_pd();
  for (std::size_t i = 0; i < num_nodes; ++i)
  {
    const __m256d push = _mm256_mul_pd(dt, _mm256_broadcast_sd(a.inverse_mass + i));
    const __m256d v = _mm256_fnmadd_pd(push, _mm256_load_pd(a.r + 4 * i), _mm256_load_pd(a.v + 4 * i));
    _mm256_store_pd(a.v + 4 * i, v);
    _mm256_store_pd(a.u + 4 * i, _mm256_fmadd_pd(dt, v, _mm256_load_pd(a.u + 4 * i)));
    _mm256_store_pd(a.r + 4 * i, zero);
  }
}

CellLoop loop(const CellKind& kind)
{
  const int n = kind.num_nodes;
  if (kind.one_point)
    return {n == 8 ? add_forces<8, true> : nullptr, update};
  return {n == 8 ? add_forces<8> : n == 10 ? add_forces<10> : n == 4 ? add_forces<4> : nullptr, update};
}
} // namespace
} // namespace dolfinx_impact::hand_written
