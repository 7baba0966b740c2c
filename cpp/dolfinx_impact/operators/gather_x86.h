// SPDX-License-Identifier: MIT
#pragma once
// Gather and scatter of nodes with two and three components by register transposes; three may be padded to four.
// Writing a vector lane by lane and reading it back whole stalls the processor (the stores cannot be forwarded), so
// lanes are put together in registers instead.
#if defined(__x86_64__) && defined(__GNUC__)
#include "gather.h"
#include <cstdint>
#include <immintrin.h>
#include <utility>

namespace dolfinx_impact::operators::x86
{
#define IMPACT_AVX2 __attribute__((target("avx2,fma"))) inline
#define IMPACT_AVX512 __attribute__((target("avx2,fma,avx512f,avx512dq,avx512vl"))) inline

/// The three components of one node in four lanes.
struct Columns
{
  __m256d x, y, z;
};

/// Rows (x, y, z, -) of four nodes -> columns.
IMPACT_AVX2 Columns transposed(__m256d r0, __m256d r1, __m256d r2, __m256d r3)
{
  const __m256d t0 = _mm256_unpacklo_pd(r0, r1), t1 = _mm256_unpackhi_pd(r0, r1);
  const __m256d t2 = _mm256_unpacklo_pd(r2, r3), t3 = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(t0, t2, 0x20), _mm256_permute2f128_pd(t1, t3, 0x20),
          _mm256_permute2f128_pd(t0, t2, 0x31)};
}

/// Four nodes. The fourth entry is masked out: it may lie behind the end of the array.
IMPACT_AVX2 Columns columns3(const double* u, const std::int32_t* dofs)
{
  const __m256i mask = _mm256_set_epi64x(0, -1, -1, -1);
  const __m256d r0 = _mm256_maskload_pd(u + 3 * std::int64_t(dofs[0]), mask);
  const __m256d r1 = _mm256_maskload_pd(u + 3 * std::int64_t(dofs[1]), mask);
  const __m256d r2 = _mm256_maskload_pd(u + 3 * std::int64_t(dofs[2]), mask);
  const __m256d r3 = _mm256_maskload_pd(u + 3 * std::int64_t(dofs[3]), mask);
  return transposed(r0, r1, r2, r3);
}

/// The same with masks of AVX-512, which cost nothing.
IMPACT_AVX512 Columns masked3(const double* u, const std::int32_t* dofs)
{
  constexpr __mmask8 three = 7;
  return transposed(_mm256_maskz_loadu_pd(three, u + 3 * std::int64_t(dofs[0])),
                    _mm256_maskz_loadu_pd(three, u + 3 * std::int64_t(dofs[1])),
                    _mm256_maskz_loadu_pd(three, u + 3 * std::int64_t(dofs[2])),
                    _mm256_maskz_loadu_pd(three, u + 3 * std::int64_t(dofs[3])));
}

IMPACT_AVX2 Columns columns2(const double* u, const std::int32_t* dofs)
{
  const __m256d r0 = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(u + 2 * std::int64_t(dofs[0]))),
                                          _mm_loadu_pd(u + 2 * std::int64_t(dofs[2])), 1);
  const __m256d r1 = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(u + 2 * std::int64_t(dofs[1]))),
                                          _mm_loadu_pd(u + 2 * std::int64_t(dofs[3])), 1);
  return {_mm256_unpacklo_pd(r0, r1), _mm256_unpackhi_pd(r0, r1), _mm256_setzero_pd()};
}

/// Four nodes of four entries each, aligned.
IMPACT_AVX2 Columns padded3(const double* u, const std::int32_t* dofs)
{
  return transposed(_mm256_load_pd(u + 4 * std::int64_t(dofs[0])), _mm256_load_pd(u + 4 * std::int64_t(dofs[1])),
                    _mm256_load_pd(u + 4 * std::int64_t(dofs[2])), _mm256_load_pd(u + 4 * std::int64_t(dofs[3])));
}

template <int BS, int S>
IMPACT_AVX2 void gather4(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes,
                         double* __restrict w)
{
  for (int i = 0; i < num_nodes; ++i, w += 4 * BS, dofs += 4)
  {
    const Columns c = S == 4 ? padded3(u, dofs) : BS == 3 ? columns3(u, dofs) : columns2(u, dofs);
    _mm256_store_pd(w, c.x);
    _mm256_store_pd(w + 4, c.y);
    if constexpr (BS == 3)
      _mm256_store_pd(w + 8, c.z);
  }
}

template <int BS, int S>
IMPACT_AVX512 void gather8(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes,
                           double* __restrict w)
{
  for (int i = 0; i < num_nodes; ++i, w += 8 * BS, dofs += 8)
  {
    const Columns a = S == 4 ? padded3(u, dofs) : BS == 3 ? masked3(u, dofs) : columns2(u, dofs);
    const Columns b = S == 4 ? padded3(u, dofs + 4) : BS == 3 ? masked3(u, dofs + 4) : columns2(u, dofs + 4);
    _mm512_store_pd(w, _mm512_insertf64x4(_mm512_castpd256_pd512(a.x), b.x, 1));
    _mm512_store_pd(w + 8, _mm512_insertf64x4(_mm512_castpd256_pd512(a.y), b.y, 1));
    if constexpr (BS == 3)
      _mm512_store_pd(w + 16, _mm512_insertf64x4(_mm512_castpd256_pd512(a.z), b.z, 1));
  }
}

template <int BS>
IMPACT_AVX2 void add_node(double* p, __m128d xy, __m128d z)
{
  _mm_storeu_pd(p, _mm_add_pd(_mm_loadu_pd(p), xy));
  if constexpr (BS == 3)
    _mm_store_sd(p + 2, _mm_add_sd(_mm_load_sd(p + 2), z));
}

/// Columns of four lanes added to four nodes, one after the other: lanes may share a node.
template <int BS, int S>
IMPACT_AVX2 void add_lanes(double* b, const std::int32_t* dofs, __m256d x, __m256d y, __m256d z)
{
  const __m256d even = _mm256_unpacklo_pd(x, y), odd = _mm256_unpackhi_pd(x, y);
  if constexpr (S == 4)
  {
    const __m256d zero = _mm256_setzero_pd();
    const __m256d even_z = _mm256_unpacklo_pd(z, zero), odd_z = _mm256_unpackhi_pd(z, zero);
    const __m256d rows[4] = {_mm256_permute2f128_pd(even, even_z, 0x20), _mm256_permute2f128_pd(odd, odd_z, 0x20),
                             _mm256_permute2f128_pd(even, even_z, 0x31), _mm256_permute2f128_pd(odd, odd_z, 0x31)};
    for (int l = 0; l < 4; ++l)
    {
      double* node = b + 4 * std::int64_t(dofs[l]);
      _mm256_store_pd(node, _mm256_add_pd(_mm256_load_pd(node), rows[l]));
    }
    return;
  }
  const __m128d z01 = _mm256_castpd256_pd128(z), z23 = _mm256_extractf128_pd(z, 1);
  add_node<BS>(b + BS * std::int64_t(dofs[0]), _mm256_castpd256_pd128(even), z01);
  add_node<BS>(b + BS * std::int64_t(dofs[1]), _mm256_castpd256_pd128(odd), _mm_unpackhi_pd(z01, z01));
  add_node<BS>(b + BS * std::int64_t(dofs[2]), _mm256_extractf128_pd(even, 1), z23);
  add_node<BS>(b + BS * std::int64_t(dofs[3]), _mm256_extractf128_pd(odd, 1), _mm_unpackhi_pd(z23, z23));
}

/// Lanes [half, half + 4) of one node of each of W cells.
template <int BS, int S, int W>
IMPACT_AVX2 void add_half(const double* A, int half, const std::int32_t* dofs, double* b)
{
  const __m256d z = BS == 3 ? _mm256_load_pd(A + 2 * W + half) : _mm256_setzero_pd();
  add_lanes<BS, S>(b, dofs + half, _mm256_load_pd(A + half), _mm256_load_pd(A + W + half), z);
}

template <int BS, int S>
IMPACT_AVX2 void scatter4(double* __restrict A, const std::int32_t* __restrict dofs, int num_nodes,
                          double* __restrict b)
{
  for (int i = 0; i < num_nodes; ++i, A += 4 * BS, dofs += 4)
  {
    add_half<BS, S, 4>(A, 0, dofs, b);
    for (int c = 0; c < BS; ++c)
      _mm256_store_pd(A + 4 * c, _mm256_setzero_pd());
  }
}

/// Zeros are written by registers as wide as those that the kernel reads them with.
template <int BS, int S>
IMPACT_AVX512 void scatter8(double* __restrict A, const std::int32_t* __restrict dofs, int num_nodes,
                            double* __restrict b)
{
  for (int i = 0; i < num_nodes; ++i, A += 8 * BS, dofs += 8)
  {
    add_half<BS, S, 8>(A, 0, dofs, b);
    add_half<BS, S, 8>(A, 4, dofs, b);
    for (int c = 0; c < BS; ++c)
      _mm512_store_pd(A + 8 * c, _mm512_setzero_pd());
  }
}
/// The next batch is gathered before the present one is computed, into the other half of the buffers: its loads are on
/// their way meanwhile. The functions that are passed are compiled for a processor; this one becomes a part of its
/// caller, which is compiled for the same.
template <int W, auto gather_positions, auto gather_values, auto scatter>
__attribute__((always_inline)) inline void sweep_batches(const Sweep& sweep)
{
  const Sweep s = sweep; // a copy: stores to A could change what is read by reference
  const std::int32_t* nodes = s.nodes;
  const std::int32_t* places = s.position_nodes;
  double *w = s.w[0], *x = s.x[0], *next_w = s.w[1], *next_x = s.x[1], *all = s.all_w[0], *next_all = s.all_w[1];
  gather_positions(s.positions, places, s.num_position_nodes, x);
  gather_values(s.values, nodes, s.num_nodes, w);
  if (s.load)
    s.load(s.owner, 0, all);
  for (std::size_t k = 0; k < s.num_batches; ++k)
  {
    const std::int32_t* next = nodes + W * s.num_nodes;
    if (k + 1 < s.num_batches)
    {
      places += s.positions_per_batch;
      gather_positions(s.positions, places, s.num_position_nodes, next_x);
      gather_values(s.values, next, s.num_nodes, next_w);
      if (s.load)
        s.load(s.owner, k + 1, next_all);
    }
    s.tabulate(s.A, w, s.constants, x, 0);
    scatter(s.A, nodes, s.num_nodes, s.b);
    if (s.store)
      s.store(s.owner, k, s.A);
    nodes = next;
    std::swap(w, next_w);
    std::swap(x, next_x);
    std::swap(all, next_all);
  }
}

template <int BS, int S>
IMPACT_AVX2 void sweep4(const Sweep& sweep)
{
  sweep_batches<4, gather4<3, 4>, gather4<BS, S>, scatter4<BS, S>>(sweep);
}

template <int BS, int S>
IMPACT_AVX512 void sweep8(const Sweep& sweep)
{
  sweep_batches<8, gather8<3, 4>, gather8<BS, S>, scatter8<BS, S>>(sweep);
}
} // namespace dolfinx_impact::operators::x86
#endif
