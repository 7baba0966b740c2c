// SPDX-License-Identifier: MIT
#include "SymmetricMatrices.h"
#include "../common/clones.h"
#include <cmath>
#include <limits>

namespace dolfinx_impact::operators
{
namespace
{
/// A number of each matrix.
typedef double Each __attribute__((vector_size(SymmetricMatrices::num * sizeof(double)), may_alias));
typedef long long EachMask __attribute__((vector_size(SymmetricMatrices::num * sizeof(double))));

IMPACT_INLINED void root(const Each& x, Each& out)
{
  for (int l = 0; l < SymmetricMatrices::num; ++l)
    out[l] = std::sqrt(x[l]);
}

IMPACT_INLINED bool any(const EachMask& mask)
{
  long long found = 0;
  for (int l = 0; l < SymmetricMatrices::num; ++l)
    found |= mask[l];
  return found != 0;
}

/// Divides by the largest absolute value: then squares do not overflow.
IMPACT_INLINED void scale(int n, Each* a, Each& largest)
{
  largest = Each{};
  const int size = n * (n + 1) / 2;
  for (int k = 0; k < size; ++k)
  {
    const Each absolute = a[k] < 0.0 ? -a[k] : a[k];
    largest = absolute > largest ? absolute : largest;
  }
  const Each factor = largest > 0.0 ? 1.0 / largest : largest;
  for (int k = 0; k < size; ++k)
    a[k] *= factor;
}

/// @param[in,out] a lower triangles; overwritten
/// @param[out] d, e diagonal, n, and absolute values beside it, n - 1
/// @param[out] v, w memory of n
IMPACT_INLINED void make_tridiagonal(int n, Each* __restrict a, Each* __restrict d, Each* __restrict e,
                                     Each* __restrict v, Each* __restrict w)
{
  const auto row = [a](int i) { return a + std::size_t(i) * (i + 1) / 2; };
  for (int k = 0; k + 1 < n; ++k)
  {
    d[k] = row(k)[k];
    Each square{};
    for (int i = k + 1; i < n; ++i)
    {
      v[i] = row(i)[k];
      square += v[i] * v[i];
      w[i] = Each{};
    }
    root(square, e[k]);
    if (k + 2 == n)
      break;
    const Each first = v[k + 1], end = first > 0.0 ? -e[k] : e[k], beta = square - first * end;
    const Each factor = beta > 0.0 ? 1.0 / beta : Each{};
    v[k + 1] = first - end;
    for (int i = k + 1; i < n; ++i)
    {
      const Each* __restrict r = row(i);
      const Each vi = v[i];
      Each sum = r[i] * vi;
      for (int j = k + 1; j < i; ++j)
      {
        sum += r[j] * v[j];
        w[j] += r[j] * vi;
      }
      w[i] += sum;
    }
    Each product{};
    for (int i = k + 1; i < n; ++i)
    {
      w[i] *= factor;
      product += w[i] * v[i];
    }
    const Each half = 0.5 * factor * product;
    for (int i = k + 1; i < n; ++i)
      w[i] -= half * v[i];
    for (int i = k + 1; i < n; ++i)
    {
      Each* __restrict r = row(i);
      const Each vi = v[i], wi = w[i];
      for (int j = k + 1; j <= i; ++j)
        r[j] -= vi * w[j] + wi * v[j];
    }
  }
  d[n - 1] = row(n - 1)[n - 1];
}

/// A factor of a minor is round-off of entries of one at least, or the point is an eigenvalue to round-off: so many of
/// them neither overflow nor vanish.
constexpr int steps_between_scalings = 4;

/// Bisection from Gershgorin's discs: leading minors of T - x are all positive below the spectrum, those of x - T above
/// it. They follow from each other without a quotient, on whose result the next one would wait; they are scaled now and
/// then. What comes after one that is not positive does not count.
/// @param[in] d, e diagonal and absolute values beside it
/// @param[in,out] e squared
/// @param[out] low, high ends of the spectrum
IMPACT_INLINED void bisect(int n, const Each* d, Each* e, Each& low, Each& high)
{
  Each inner_low = d[0], inner_high = d[0], outer_low = d[0], outer_high = d[0];
  for (int i = 0; i < n; ++i)
  {
    Each radius{};
    if (i > 0)
      radius += e[i - 1];
    if (i + 1 < n)
      radius += e[i];
    const Each below = d[i] - radius, above = d[i] + radius;
    inner_low = d[i] < inner_low ? d[i] : inner_low;
    inner_high = d[i] > inner_high ? d[i] : inner_high;
    outer_low = below < outer_low ? below : outer_low;
    outer_high = above > outer_high ? above : outer_high;
  }
  for (int i = 0; i + 1 < n; ++i)
    e[i] *= e[i];
  // Entries are one at most: the spectrum is known to some units of their round-off.
  const double tolerance = 2.0 * std::numeric_limits<double>::epsilon();
  const Each one = Each{} + 1.0;
  for (int step = 0; step < 60; ++step)
  {
    const Each left = 0.5 * (outer_low + inner_low), right = 0.5 * (inner_high + outer_high);
    Each p = d[0] - left, q = right - d[0], p_before = one, q_before = one;
    EachMask beyond = p > 0.0, within = q > 0.0; // is left below the spectrum, right above it?
    for (int i = 1; i < n; ++i)
    {
      const Each p_next = (d[i] - left) * p - e[i - 1] * p_before, q_next = (right - d[i]) * q - e[i - 1] * q_before;
      p_before = p, p = p_next;
      q_before = q, q = q_next;
      beyond &= p > 0.0;
      within &= q > 0.0;
      if (i % steps_between_scalings == 0)
      {
        p_before /= p, p = one;
        q_before /= q, q = one;
      }
    }
    outer_low = beyond ? left : outer_low;
    inner_low = beyond ? inner_low : left;
    outer_high = within ? right : outer_high;
    inner_high = within ? inner_high : right;
    if (!any((inner_low - outer_low > tolerance) | (outer_high - inner_high > tolerance)))
      break;
  }
  low = outer_low;
  high = outer_high;
}

IMPACT_CLONES void set_symmetric(int n, const double* given, const double* diagonals, double* entries, double* norms)
{
  constexpr int num = SymmetricMatrices::num;
  const Each* const S = reinterpret_cast<const Each*>(given);
  const Each* const d = reinterpret_cast<const Each*>(diagonals);
  Each* a = reinterpret_cast<Each*>(entries);
  Each all{}, skew{};
  for (int i = 0; i < n; ++i)
  {
    const Each* const row = S + std::size_t(n) * i;
    const Each half = 0.5 * d[i];
    for (int j = 0; j < i; ++j, ++a)
    {
      const Each to = row[j], fro = S[std::size_t(n) * j + i], scale = half * d[j];
      const Each even = (to + fro) * scale, odd = (to - fro) * scale;
      *a = even;
      all += even * even;
      skew += odd * odd;
    }
    *a = row[i] * d[i] * d[i];
    all += 0.5 * *a * *a; // the others count twice
    ++a;
  }
  for (int l = 0; l < num; ++l)
  {
    norms[2 * l] = std::sqrt(2.0 * all[l]);
    norms[2 * l + 1] = std::sqrt(2.0 * skew[l]);
  }
}

IMPACT_CLONES void find_ends(int n, double* entries, double* work, double* ends)
{
  constexpr int num = SymmetricMatrices::num;
  Each* const a = reinterpret_cast<Each*>(entries);
  Each *const d = reinterpret_cast<Each*>(work), *const e = d + n, *const v = e + n, *const w = v + n;
  Each largest, low, high;
  scale(n, a, largest);
  make_tridiagonal(n, a, d, e, v, w);
  bisect(n, d, e, low, high);
  low *= largest;
  high *= largest;
  for (int l = 0; l < num; ++l)
  {
    ends[2 * l] = low[l];
    ends[2 * l + 1] = high[l];
  }
}
} // namespace

SymmetricMatrices::SymmetricMatrices(int n)
    : _n(n), _entries(std::size_t(n) * (n + 1) / 2 * num), _work(std::size_t(4) * n * num)
{
}

std::array<SymmetricMatrices::Norms, SymmetricMatrices::num> SymmetricMatrices::set_scaled(const double* S,
                                                                                           const double* d)
{
  std::array<double, std::size_t(2) * num> norms;
  set_symmetric(_n, S, d, _entries.data(), norms.data());
  std::array<Norms, num> out;
  for (int l = 0; l < num; ++l)
    out[l] = {norms[2 * l], norms[2 * l + 1]};
  return out;
}

std::array<std::array<double, 2>, SymmetricMatrices::num> SymmetricMatrices::extreme_eigenvalues()
{
  std::array<std::array<double, 2>, num> out;
  find_ends(_n, _entries.data(), _work.data(), out.front().data());
  return out;
}
} // namespace dolfinx_impact::operators
