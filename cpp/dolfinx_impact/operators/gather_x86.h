// SPDX-License-Identifier: MIT
#pragma once
// Gather and scatter of nodes with two and three components by register transposes. Writing a vector lane by lane and
// reading it back whole stalls the processor (the stores cannot be forwarded), so lanes are put together in registers
// instead.
#if defined(__x86_64__) && defined(__GNUC__)
#include <cstdint>
#include <immintrin.h>

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

template <int BS>
IMPACT_AVX2 void gather4(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes,
                         double* __restrict w)
{
  for (int i = 0; i < num_nodes; ++i, w += 4 * BS, dofs += 4)
  {
    const Columns c = BS == 3 ? columns3(u, dofs) : columns2(u, dofs);
    _mm256_store_pd(w, c.x);
    _mm256_store_pd(w + 4, c.y);
    if constexpr (BS == 3)
      _mm256_store_pd(w + 8, c.z);
  }
}

template <int BS>
IMPACT_AVX512 void gather8(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes,
                           double* __restrict w)
{
  for (int i = 0; i < num_nodes; ++i, w += 8 * BS, dofs += 8)
  {
    const Columns a = BS == 3 ? masked3(u, dofs) : columns2(u, dofs);
    const Columns b = BS == 3 ? masked3(u, dofs + 4) : columns2(u, dofs + 4);
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
template <int BS>
IMPACT_AVX2 void add_lanes(double* b, const std::int32_t* dofs, __m256d x, __m256d y, __m256d z)
{
  const __m256d even = _mm256_unpacklo_pd(x, y), odd = _mm256_unpackhi_pd(x, y);
  const __m128d z01 = _mm256_castpd256_pd128(z), z23 = _mm256_extractf128_pd(z, 1);
  add_node<BS>(b + BS * std::int64_t(dofs[0]), _mm256_castpd256_pd128(even), z01);
  add_node<BS>(b + BS * std::int64_t(dofs[1]), _mm256_castpd256_pd128(odd), _mm_unpackhi_pd(z01, z01));
  add_node<BS>(b + BS * std::int64_t(dofs[2]), _mm256_extractf128_pd(even, 1), z23);
  add_node<BS>(b + BS * std::int64_t(dofs[3]), _mm256_extractf128_pd(odd, 1), _mm_unpackhi_pd(z23, z23));
}

IMPACT_AVX2 void clear4(double* A, std::size_t size)
{
  for (std::size_t i = 0; i < size; i += 4)
    _mm256_store_pd(A + i, _mm256_setzero_pd());
}

IMPACT_AVX512 void clear8(double* A, std::size_t size)
{
  for (std::size_t i = 0; i < size; i += 8)
    _mm512_store_pd(A + i, _mm512_setzero_pd());
}

template <int BS, int W>
IMPACT_AVX2 void scatter_whole(const double* __restrict A, const std::int32_t* __restrict dofs, int num_nodes,
                               double* __restrict b)
{
  for (int i = 0; i < num_nodes; ++i, A += W * BS, dofs += W)
    for (int half = 0; half < W; half += 4)
    {
      const __m256d z = BS == 3 ? _mm256_load_pd(A + 2 * W + half) : _mm256_setzero_pd();
      add_lanes<BS>(b, dofs + half, _mm256_load_pd(A + half), _mm256_load_pd(A + W + half), z);
    }
}
} // namespace dolfinx_impact::operators::x86
#endif
