// SPDX-License-Identifier: MIT
#include "machine.h"
#include <cstdlib> // defines __GLIBC__ where that is the C library
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace dolfinx_impact::common
{
namespace
{
double seconds_since(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Twelve accumulators keep the multiply-add units of today's processors busy; 64 bytes is one AVX-512 register or two
// AVX2.
constexpr int chains = 12;
constexpr int lanes = 8;
constexpr long repeats = 4000000;

#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target_clones("avx512f", "arch=haswell", "default"), optimize("O3", "fp-contract=fast")))
#endif
double
multiply_add(double* a, double x, double y)
{
  typedef double Vector __attribute__((vector_size(lanes * sizeof(double))));
  Vector s[chains];
  for (int c = 0; c < chains; ++c)
    s[c] = Vector{} + a[c];
  for (long i = 0; i < repeats; ++i)
#pragma GCC unroll 12
    for (int c = 0; c < chains; ++c)
      s[c] = s[c] * x + y;
  double sum = 0.0;
  for (int c = 0; c < chains; ++c)
    for (int l = 0; l < lanes; ++l)
      sum += s[c][l];
  return sum;
}
} // namespace

double triad_bandwidth()
{
  const std::size_t n = 1 << 24;
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  double best = 0.0;
  for (int r = 0; r < 5; ++r)
  {
    const double s = 0.5 + r;
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < n; ++i)
      a[i] = b[i] + s * c[i];
    best = std::max(best, 3.0 * sizeof(double) * n / seconds_since(start));
    b[r] = a[n / 2]; // keeps the loop alive
  }
  return best;
}

double peak_flops()
{
  std::vector<double> a(chains, 1.0);
  double best = 0.0;
  for (int r = 0; r < 5; ++r)
  {
    const auto start = std::chrono::steady_clock::now();
    a[0] = multiply_add(a.data(), 0.999, 1e-3) * 1e-30;
    best = std::max(best, 2.0 * lanes * chains * repeats / seconds_since(start));
  }
  return best;
}

void release_memory()
{
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}
} // namespace dolfinx_impact::common
