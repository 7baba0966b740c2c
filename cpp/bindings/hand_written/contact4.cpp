// SPDX-License-Identifier: MIT
#include "ContactLoop.h"
#include <immintrin.h>

namespace dolfinx_impact::hand_written
{
namespace
{
typedef double V __attribute__((vector_size(32)));
#define ALWAYS __attribute__((always_inline)) inline

/// Nodes ahead for which the memory is asked.
constexpr std::size_t ahead = 24;

ALWAYS void ask(const double* p)
{
  _mm_prefetch(reinterpret_cast<const char*>(p), _MM_HINT_T0);
  _mm_prefetch(reinterpret_cast<const char*>(p + 2), _MM_HINT_T0);
}

/// Rows become columns.
ALWAYS void transpose(V& a, V& b, V& c, V& d)
{
  const __m256d t0 = _mm256_unpacklo_pd(a, b), t1 = _mm256_unpackhi_pd(a, b);
  const __m256d t2 = _mm256_unpacklo_pd(c, d), t3 = _mm256_unpackhi_pd(c, d);
  a = _mm256_permute2f128_pd(t0, t2, 0x20);
  b = _mm256_permute2f128_pd(t1, t3, 0x20);
  c = _mm256_permute2f128_pd(t0, t2, 0x31);
  d = _mm256_permute2f128_pd(t1, t3, 0x31);
}

ALWAYS V root(V x)
{
  return _mm256_sqrt_pd(x);
}

/// Three numbers, and a zero: the next node's may lie in another page.
ALWAYS V three(const double* p)
{
  return _mm256_maskload_pd(p, _mm256_set_epi64x(0, -1, -1, -1));
}

void move_master(const ContactArrays& a)
{
  for (std::size_t k = 0; k < a.num_masters; ++k)
  {
    if (k + ahead < a.num_masters)
    {
      ask(a.u + 3 * std::int64_t(a.numbers[k + ahead]));
      ask(a.du + 3 * std::int64_t(a.numbers[k + ahead]));
    }
    const std::int64_t node = 3 * std::int64_t(a.numbers[k]);
    *reinterpret_cast<V*>(a.masters[k].x) = three(a.X + 3 * k) + three(a.u + node);
    *reinterpret_cast<V*>(a.masters[k].du) = three(a.du + node);
  }
}

void add_to_master(const ContactArrays& a)
{
  for (std::size_t k = 0; k < a.num_masters; ++k)
  {
    if (k + ahead < a.num_masters)
      ask(a.f + 3 * std::int64_t(a.numbers[k + ahead]));
    for (int c = 0; c < 3; ++c)
    {
      a.f[3 * std::int64_t(a.numbers[k]) + c] += a.sums[4 * k + c];
      a.sums[4 * k + c] = 0.0;
    }
  }
}
} // namespace

void add_contact_forces(const ContactArrays& arrays)
{
  const ContactArrays& a = arrays;
  move_master(a);
  const V zero = {}, one = {1.0, 1.0, 1.0, 1.0};
  for (std::size_t first = 0; first < a.num_slaves; first += 4)
  {
    SlaveNode* const s = a.slaves + first;
    V x[4], d[4], X[4][3], D[4][3], t[4], xi[2];
    for (int l = 0; l < 4; ++l)
    {
      if (first + ahead < a.num_slaves)
      {
        const std::int64_t next = 3 * std::int64_t(s[ahead + l].node);
        ask(a.u + next);
        ask(a.du + next);
        ask(a.f + next);
      }
      if (first + 2 * ahead < a.num_slaves)
      {
        ask(s[2 * ahead + l].X);
        ask(reinterpret_cast<const double*>(s + 2 * ahead + l) + 8);
      }
      const std::int64_t node = 3 * std::int64_t(s[l].node);
      x[l] = three(s[l].X) + three(a.u + node);
      d[l] = three(a.du + node);
      t[l] = three(s[l].tangential);
      xi[0][l] = s[l].xi[0];
      xi[1][l] = s[l].xi[1];
    }
    transpose(x[0], x[1], x[2], x[3]);
    transpose(d[0], d[1], d[2], d[3]);
    transpose(t[0], t[1], t[2], t[3]);
    for (int j = 0; j < 4; ++j)
    {
      V p[4], q[4];
      for (int l = 0; l < 4; ++l)
      {
        p[l] = *reinterpret_cast<const V*>(a.masters[s[l].corners[j]].x);
        q[l] = *reinterpret_cast<const V*>(a.masters[s[l].corners[j]].du);
      }
      transpose(p[0], p[1], p[2], p[3]);
      transpose(q[0], q[1], q[2], q[3]);
      for (int c = 0; c < 3; ++c)
      {
        X[j][c] = p[c];
        D[j][c] = q[c];
      }
    }
    V a1[3], a2[3], n[3];
    const auto tangents = [&](int c, V& e2, V& twist)
    {
      const V e1 = X[1][c] - X[0][c];
      e2 = X[2][c] - X[0][c];
      twist = X[3][c] - X[2][c] - e1;
      a1[c] = e1 + xi[1] * twist;
      a2[c] = e2 + xi[0] * twist;
    };
    V e2, twist;
    for (int step = 0; step < 2; ++step)
    {
      V g1 = {}, g2 = {}, h11 = {}, h22 = {}, h12 = {};
      for (int c = 0; c < 3; ++c)
      {
        tangents(c, e2, twist);
        const V rest = x[c] - X[0][c] - xi[0] * a1[c] - xi[1] * e2;
        g1 += rest * a1[c];
        g2 += rest * a2[c];
        h11 += a1[c] * a1[c];
        h22 += a2[c] * a2[c];
        h12 += a1[c] * a2[c] - rest * twist;
      }
      const V per = one / (h11 * h22 - h12 * h12);
      xi[0] += (h22 * g1 - h12 * g2) * per;
      xi[1] += (h11 * g2 - h12 * g1) * per;
    }
    for (int c = 0; c < 3; ++c)
      tangents(c, e2, twist);
    n[0] = a1[1] * a2[2] - a1[2] * a2[1];
    n[1] = a1[2] * a2[0] - a1[0] * a2[2];
    n[2] = a1[0] * a2[1] - a1[1] * a2[0];
    const V per = one / root(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const V phi[4] = {(one - xi[0]) * (one - xi[1]), xi[0] * (one - xi[1]), (one - xi[0]) * xi[1], xi[0] * xi[1]};
    V gap = {}, away = {}, motion[3], force[4] = {};
    for (int c = 0; c < 3; ++c)
    {
      n[c] *= per;
      V point = phi[0] * X[0][c], moved = phi[0] * D[0][c];
      for (int j = 1; j < 4; ++j)
      {
        point += phi[j] * X[j][c];
        moved += phi[j] * D[j][c];
      }
      motion[c] = d[c] - moved;
      gap += (x[c] - point) * n[c];
      away += motion[c] * n[c];
    }
    const V stiffness = zero + a.stiffness, pressed = gap < 0.0 ? -stiffness * gap : zero;
    for (int c = 0; c < 3; ++c)
      force[c] = pressed * n[c];
    if (a.friction > 0.0)
    {
      V squared = {};
      for (int c = 0; c < 3; ++c)
      {
        motion[c] -= away * n[c];
        t[c] -= stiffness * motion[c];
        squared += t[c] * t[c];
      }
      const V size = root(squared), limit = a.friction * pressed, part = limit < size ? limit / size : one;
      for (int c = 0; c < 3; ++c)
      {
        t[c] *= part;
        force[c] += t[c];
      }
    }
    V rows[4][4];
    for (int j = 0; j < 4; ++j)
    {
      for (int c = 0; c < 3; ++c)
        rows[j][c] = phi[j] * force[c];
      rows[j][3] = zero;
      transpose(rows[j][0], rows[j][1], rows[j][2], rows[j][3]);
    }
    for (int l = 0; l < 4; ++l)
    {
      SlaveNode& node = s[l];
      double* const f = a.f + 3 * std::int64_t(node.node);
      node.xi[0] = xi[0][l];
      node.xi[1] = xi[1][l];
      node.gap = gap[l];
      node.pressed = pressed[l];
      for (int c = 0; c < 3; ++c)
      {
        f[c] += force[c][l];
        if (a.friction > 0.0)
        {
          node.tangential[c] = t[c][l];
          node.slip[c] += motion[c][l];
        }
      }
      for (int j = 0; j < 4; ++j)
      {
        V& sum = *reinterpret_cast<V*>(a.sums + 4 * std::int64_t(node.corners[j]));
        sum -= rows[j][l];
      }
    }
  }
  add_to_master(a);
}
} // namespace dolfinx_impact::hand_written
