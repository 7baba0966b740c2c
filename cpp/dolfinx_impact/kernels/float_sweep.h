// SPDX-License-Identifier: MIT
#pragma once
// Gather, kernel in float and scatter in one function: nodes are in double, and cells in float. Included by generated
// sources for 8 and 16 lanes on x86, which are compiled for processors that the machine may not be (sweep.h).
#include "FloatKernel.h"
#include "float_lanes.h"
#if defined(__x86_64__) && defined(__GNUC__)
#define IMPACT_HAS_FLOAT_SWEEPS

namespace dolfinx_impact::kernels::floats::swept
{
#define IMPACT_ALWAYS_INLINE __attribute__((always_inline)) inline

constexpr int line = 64; // bytes of a line of the caches

/// A node of four entries in memory, aligned.
typedef double Row __attribute__((vector_size(32), may_alias));
typedef double Doubles __attribute__((vector_size(32)));
typedef float Half __attribute__((vector_size(16)));
typedef float Eight __attribute__((vector_size(32)));

/// Halves of eight lanes, one behind the other.
IMPACT_ALWAYS_INLINE Eight joined(Half low, Half high)
{
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// The same numbers in double. GCC has the instruction for it, but makes five of the conversion of its vectors.
IMPACT_ALWAYS_INLINE Doubles widened(Half x)
{
#if defined(__AVX__) && !defined(__clang__)
  return __builtin_ia32_cvtps2pd256(x);
#else
  return __builtin_convertvector(x, Doubles);
#endif
}

IMPACT_ALWAYS_INLINE Doubles node(const double* values, int number)
{
  return *reinterpret_cast<const Row*>(values + 4 * static_cast<long long>(number));
}

/// The three components of one node of eight cells.
struct Columns
{
  Eight c[3];
};

/// scale (value - first), the difference in double.
/// @param[in] first scaled values at the first node of the eight cells
IMPACT_ALWAYS_INLINE Columns differences(const double* values, const int* nodes, double scale, const Doubles* first)
{
  Eight rows[4]; // of the cells l and l + 4
#pragma GCC unroll 4
  for (int l = 0; l < 4; ++l)
    rows[l] = joined(__builtin_convertvector(scale * node(values, nodes[l]) - first[l], Half),
                     __builtin_convertvector(scale * node(values, nodes[l + 4]) - first[l + 4], Half));
  const Eight a = __builtin_shufflevector(rows[0], rows[1], 0, 8, 1, 9, 4, 12, 5, 13),
              b = __builtin_shufflevector(rows[2], rows[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Eight c = __builtin_shufflevector(rows[0], rows[1], 2, 10, 3, 11, 6, 14, 7, 15),
              d = __builtin_shufflevector(rows[2], rows[3], 2, 10, 3, 11, 6, 14, 7, 15);
  return {{__builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15),
           __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13)}};
}

/// Adds forces to the nodes of eight cells, one after the other: cells may share a node.
/// @param[in,out] sum of the forces of each cell, before they are scaled
IMPACT_ALWAYS_INLINE void add(double* result, const int* nodes, double scale, const Columns& f, Doubles* sum)
{
  const Eight zero{};
  const Eight a = __builtin_shufflevector(f.c[0], f.c[1], 0, 8, 1, 9, 4, 12, 5, 13),
              b = __builtin_shufflevector(f.c[0], f.c[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Eight c = __builtin_shufflevector(f.c[2], zero, 0, 8, 1, 9, 4, 12, 5, 13),
              d = __builtin_shufflevector(f.c[2], zero, 2, 10, 3, 11, 6, 14, 7, 15);
  const Eight rows[4] = {__builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13),
                         __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15),
                         __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13),
                         __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15)};
#pragma GCC unroll 8
  for (int l = 0; l < 8; ++l)
  {
    const Eight row = rows[l % 4];
    const Half half =
        l < 4 ? __builtin_shufflevector(row, row, 0, 1, 2, 3) : __builtin_shufflevector(row, row, 4, 5, 6, 7);
    const Doubles force = widened(half);
    sum[l] = sum[l] + force;
    Row& place = *reinterpret_cast<Row*>(result + 4 * static_cast<long long>(nodes[l]));
    place = place + scale * force;
  }
}

/// Differences to the first node at N nodes of W cells.
template <int W, int N, typename T>
IMPACT_ALWAYS_INLINE void gather(const double* values, const int* nodes, double scale, T* w)
{
  Doubles first[W];
#pragma GCC unroll 16
  for (int l = 0; l < W; ++l)
    first[l] = scale * node(values, nodes[l]);
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c)
    w[c] = T{};
#pragma GCC unroll 16
  for (int i = 1; i < N; ++i)
  {
    const Columns low = differences(values, nodes + W * i, scale, first);
    if constexpr (W == 16)
    {
      const Columns high = differences(values, nodes + W * i + 8, scale, first + 8);
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c)
        w[3 * i + c] =
            __builtin_shufflevector(low.c[c], high.c[c], 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    }
    else
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c)
        w[3 * i + c] = low.c[c];
  }
}

/// Adds the forces of W cells. The first node takes what is opposite to the sum of the others: forces of a cell are in
/// equilibrium to the round-off of double, and so the momentum is kept.
template <int W, int N, typename T>
IMPACT_ALWAYS_INLINE void scatter(double* result, const int* nodes, double scale, const T* A)
{
  Doubles sum[W];
#pragma GCC unroll 16
  for (int l = 0; l < W; ++l)
    sum[l] = Doubles{};
#pragma GCC unroll 16
  for (int i = 1; i < N; ++i)
  {
    Columns low;
    if constexpr (W == 16)
    {
      Columns high;
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c)
      {
        const T a = A[3 * i + c];
        low.c[c] = __builtin_shufflevector(a, a, 0, 1, 2, 3, 4, 5, 6, 7);
        high.c[c] = __builtin_shufflevector(a, a, 8, 9, 10, 11, 12, 13, 14, 15);
      }
      add(result, nodes + W * i, scale, low, sum);
      add(result, nodes + W * i + 8, scale, high, sum + 8);
    }
    else
    {
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c)
        low.c[c] = A[3 * i + c];
      add(result, nodes + W * i, scale, low, sum);
    }
  }
#pragma GCC unroll 16
  for (int l = 0; l < W; ++l)
  {
    Row& place = *reinterpret_cast<Row*>(result + 4 * static_cast<long long>(nodes[l]));
    place = place - scale * sum[l];
  }
}

/// @tparam kernel the kernel for vectors of W cells, which becomes a part of this function
/// @tparam N nodes of a cell, with three components each
/// @tparam P nodes of its geometry
/// @tparam C number of constants
template <int W, auto kernel, int N, int P, int C>
IMPACT_ALWAYS_INLINE void sweep(const impact_float_cells& cells)
{
  typedef typename Lanes<W>::type T;
  typedef T Place __attribute__((may_alias));
  constexpr int size = 3 * (P - 1) * W; // differences of positions of a batch
  const impact_float_cells s = cells;   // a copy: what is added to the result could change what is read by reference
  const int* nodes = s.nodes;
  const float* places = s.places;
  double constants[C + 1]{}; // copies: what follows from them is computed once
  for (int i = 0; i < C; ++i)
    constants[i] = s.constants[i];
  for (unsigned long long batch = 0; batch < s.num_batches; ++batch)
  {
    T x[3 * P], w[3 * N], A[3 * N];
    // All cells have more of them than the caches hold. The processor's own prefetching comes too late: a quarter more
    // time for hexahedra with one point.
#pragma GCC unroll 32
    for (int byte = 0; byte < size * int(sizeof(float)); byte += line)
      __builtin_prefetch(reinterpret_cast<const char*>(places + 2 * size) + byte);
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c)
      x[c] = T{};
#pragma GCC unroll 48
    for (int i = 3; i < 3 * P; ++i)
      x[i] = reinterpret_cast<const Place*>(places)[i - 3];
    gather<W, N>(s.values, nodes, s.scale, w);
#pragma GCC unroll 48
    for (int i = 0; i < 3 * N; ++i)
      A[i] = -T{}; // added to -0 a number is itself, also -0: compilers leave the sum out
    kernel(A, w, constants, x);
    scatter<W, N>(s.result, nodes, s.force_scale, A);
    nodes += W * N;
    places += size;
  }
}
#undef IMPACT_ALWAYS_INLINE
} // namespace dolfinx_impact::kernels::floats::swept
#endif
