// SPDX-License-Identifier: MIT
#include "machine.h"
#include <cstdlib> // defines __GLIBC__ where that is the C library
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <stdexcept>
#include <string>
#include <vector>

namespace dolfinx_impact::common
{
namespace
{
double seconds_since(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Multiply-adds that do not wait for one another: 12 keep two units of a latency of up to 6 cycles busy, and with the
// two factors they fit in the 16 vector registers of SSE2 and AVX2 (32 of AVX-512), so that nothing is spilled to
// memory.
constexpr int chains = 12;
constexpr long repeats = 2000000;

template <int bytes>
struct Register
{
  using type [[gnu::vector_size(bytes)]] = double;
};

/// A sum of `chains` accumulators of `bytes` each; inlined into one function per instruction set.
template <int bytes>
[[gnu::always_inline]] inline double multiply_add(const double* a, double x, double y)
{
  using Vector = typename Register<bytes>::type;
  Vector s[chains];
  for (int c = 0; c < chains; ++c)
    s[c] = Vector{} + a[c];
  for (long i = 0; i < repeats; ++i)
#pragma GCC unroll 12
    for (int c = 0; c < chains; ++c)
      s[c] = s[c] * x + y;
  double sum = 0.0;
  for (int c = 0; c < chains; ++c)
    for (std::size_t l = 0; l < bytes / sizeof(double); ++l)
      sum += s[c][l];
  return sum;
}

[[gnu::optimize("O3", "fp-contract=fast")]] double multiply_add_base(const double* a, double x, double y)
{
  return multiply_add<16>(a, x, y);
}

#if defined(__x86_64__) && defined(__GNUC__)
[[gnu::target("avx2,fma"), gnu::optimize("O3", "fp-contract=fast")]] double multiply_add_avx2(const double* a, double x,
                                                                                              double y)
{
  return multiply_add<32>(a, x, y);
}

[[gnu::target("avx512f,prefer-vector-width=512"), gnu::optimize("O3", "fp-contract=fast")]] double
multiply_add_avx512(const double* a, double x, double y)
{
  return multiply_add<64>(a, x, y);
}
#endif

/// a = b + s c, in the vectors of each instruction set: in the cache, their length is what counts.
[[gnu::always_inline]] inline void scaled_sum(double* __restrict a, const double* __restrict b,
                                              const double* __restrict c, double s, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i)
    a[i] = b[i] + s * c[i];
}

[[gnu::optimize("O3")]] void scaled_sum_base(double* a, const double* b, const double* c, double s, std::size_t n)
{
  scaled_sum(a, b, c, s, n);
}

#if defined(__x86_64__) && defined(__GNUC__)
[[gnu::target("avx2,fma"), gnu::optimize("O3")]] void scaled_sum_avx2(double* a, const double* b, const double* c,
                                                                      double s, std::size_t n)
{
  scaled_sum(a, b, c, s, n);
}

[[gnu::target("avx512f,prefer-vector-width=512"), gnu::optimize("O3")]] void
scaled_sum_avx512(double* a, const double* b, const double* c, double s, std::size_t n)
{
  scaled_sum(a, b, c, s, n);
}
#endif

auto widest_scaled_sum()
{
#if defined(__x86_64__) && defined(__GNUC__)
  if (__builtin_cpu_supports("avx512f"))
    return scaled_sum_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return scaled_sum_avx2;
#endif
  return scaled_sum_base;
}

/// Operations per second of one function, best of several runs in processor time.
template <typename Function>
double rate(Function function, int lanes)
{
  const std::vector<double> a(chains, 1.0);
  double best = 0.0;
  for (int r = 0; r < 7; ++r)
  {
    const std::clock_t start = std::clock();
    volatile double result = function(a.data(), 0.999, 1e-3);
    (void)result;
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (seconds > 0.0)
      best = std::max(best, 2.0 * lanes * chains * repeats / seconds);
  }
  return best;
}
} // namespace

double triad_bandwidth(std::size_t n)
{
  if (n == 0)
    throw std::invalid_argument("triad_bandwidth: arrays need entries");
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  const auto sum = widest_scaled_sum();
  const std::size_t sweeps = std::max<std::size_t>(1, (1 << 20) / n); // long against the clock's resolution
  double best = 0.0;
  for (int r = 0; r < 5; ++r)
  {
    const double s = 0.5 + r;
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t k = 0; k < sweeps; ++k)
    {
      sum(a.data(), b.data(), c.data(), s, n);
      asm volatile("" : : "r"(a.data()) : "memory"); // every sweep counts, although the next one writes the same
    }
    best = std::max(best, 3.0 * sizeof(double) * double(n * sweeps) / seconds_since(start));
    b[r % n] = a[n / 2]; // keeps the loop alive
  }
  return best;
}

double peak_flops(int lanes)
{
  if (lanes != 0 && lanes != 2 && lanes != 4 && lanes != 8)
    throw std::invalid_argument("peak_flops: vectors have 2, 4 or 8 numbers (0: the best of this processor), not " +
                                std::to_string(lanes));
  double best = lanes == 0 || lanes == 2 ? rate(multiply_add_base, 2) : 0.0;
#if defined(__x86_64__) && defined(__GNUC__)
  if ((lanes == 0 || lanes == 4) && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    best = std::max(best, rate(multiply_add_avx2, 4));
  if ((lanes == 0 || lanes == 8) && __builtin_cpu_supports("avx512f"))
    best = std::max(best, rate(multiply_add_avx512, 8));
#endif
  return best;
}

void release_memory()
{
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}
} // namespace dolfinx_impact::common
