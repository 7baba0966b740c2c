// SPDX-License-Identifier: MIT
#include "gather_float.h"
#include "../kernels/KernelTable.h"
#include <utility>
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#endif

namespace dolfinx_impact::operators
{
void gather_differences(int lanes, const double* u, int stride, const std::int32_t* dofs, int num_nodes, double scale,
                        float* w)
{
  for (int i = 0; i < num_nodes; ++i)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < lanes; ++l)
        w[(3 * i + k) * lanes + l] =
            float(scale * (u[std::int64_t(stride) * dofs[i * lanes + l] + k] - u[std::int64_t(stride) * dofs[l] + k]));
}

void scatter_balanced(int lanes, float* A, const std::int32_t* dofs, int num_nodes, int used, double scale, double* b,
                      int stride)
{
  for (int l = 0; l < used; ++l)
    for (int k = 0; k < 3; ++k)
    {
      double sum = 0.0;
      for (int i = 1; i < num_nodes; ++i)
      {
        const double force = A[(3 * i + k) * lanes + l];
        b[std::int64_t(stride) * dofs[i * lanes + l] + k] += scale * force;
        sum += force;
      }
      b[std::int64_t(stride) * dofs[l] + k] -= scale * sum;
    }
  for (int i = 0; i < 3 * num_nodes * lanes; ++i)
    A[i] = 0.0f;
}

#if defined(__x86_64__) && defined(__GNUC__)
namespace float_x86
{
#define IMPACT_FLOAT_AVX2 __attribute__((target("avx2,fma"))) inline

/// gather_differences of arrays with four entries per node: rows of eight cells are turned into columns.
template <int W>
IMPACT_FLOAT_AVX2 void gather(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes,
                              double scale, float* __restrict w)
{
  const __m256d factor = _mm256_set1_pd(scale);
  for (int half = 0; half < W; half += 8)
  {
    const std::int32_t* cells = dofs + half;
    float* out = w + half;
    __m256d first[8];
    for (int l = 0; l < 8; ++l)
      first[l] = _mm256_mul_pd(factor, _mm256_load_pd(u + 4 * std::int64_t(cells[l])));
    for (int k = 0; k < 3; ++k)
      _mm256_store_ps(out + k * W, _mm256_setzero_ps());
    for (int i = 1; i < num_nodes; ++i)
    {
      cells += W;
      out += 3 * W;
      __m256 rows[4]; // of the cells l and l + 4
#pragma GCC unroll 4
      for (int l = 0; l < 4; ++l)
      {
        const __m256d low = _mm256_load_pd(u + 4 * std::int64_t(cells[l]));
        const __m256d high = _mm256_load_pd(u + 4 * std::int64_t(cells[l + 4]));
        rows[l] = _mm256_set_m128(_mm256_cvtpd_ps(_mm256_fmsub_pd(factor, high, first[l + 4])),
                                  _mm256_cvtpd_ps(_mm256_fmsub_pd(factor, low, first[l])));
      }
      const __m256 t0 = _mm256_unpacklo_ps(rows[0], rows[1]), t1 = _mm256_unpackhi_ps(rows[0], rows[1]);
      const __m256 t2 = _mm256_unpacklo_ps(rows[2], rows[3]), t3 = _mm256_unpackhi_ps(rows[2], rows[3]);
      _mm256_store_ps(out, _mm256_shuffle_ps(t0, t2, 0x44));
      _mm256_store_ps(out + W, _mm256_shuffle_ps(t0, t2, 0xee));
      _mm256_store_ps(out + 2 * W, _mm256_shuffle_ps(t1, t3, 0x44));
    }
  }
}

/// scatter_balanced of an array with four entries per node.
template <int W>
IMPACT_FLOAT_AVX2 void scatter(float* __restrict A, const std::int32_t* __restrict dofs, int num_nodes, double scale,
                               double* __restrict b)
{
  const __m256d factor = _mm256_set1_pd(scale);
  const __m256 zero = _mm256_setzero_ps();
  for (int half = 0; half < W; half += 8)
  {
    const std::int32_t* cells = dofs + half;
    float* in = A + half;
    __m256d sum[8];
    for (int l = 0; l < 8; ++l)
      sum[l] = _mm256_setzero_pd();
    for (int i = 1; i < num_nodes; ++i)
    {
      cells += W;
      in += 3 * W;
      const __m256 x = _mm256_load_ps(in), y = _mm256_load_ps(in + W), z = _mm256_load_ps(in + 2 * W);
      const __m256 t0 = _mm256_unpacklo_ps(x, y), t1 = _mm256_unpackhi_ps(x, y);
      const __m256 z0 = _mm256_unpacklo_ps(z, zero), z1 = _mm256_unpackhi_ps(z, zero);
      const __m256 rows[4] = {_mm256_shuffle_ps(t0, z0, 0x44), _mm256_shuffle_ps(t0, z0, 0xee),
                              _mm256_shuffle_ps(t1, z1, 0x44), _mm256_shuffle_ps(t1, z1, 0xee)};
#pragma GCC unroll 8
      for (int l = 0; l < 8; ++l)
      {
        const __m256 row = rows[l % 4];
        const __m256d force = _mm256_cvtps_pd(l < 4 ? _mm256_castps256_ps128(row) : _mm256_extractf128_ps(row, 1));
        sum[l] = _mm256_add_pd(sum[l], force);
        double* node = b + 4 * std::int64_t(cells[l]);
        _mm256_store_pd(node, _mm256_fmadd_pd(factor, force, _mm256_load_pd(node)));
      }
      for (int k = 0; k < 3; ++k)
        _mm256_store_ps(in + k * W, zero);
    }
    for (int l = 0; l < 8; ++l)
    {
      double* node = b + 4 * std::int64_t(dofs[half + l]);
      _mm256_store_pd(node, _mm256_fnmadd_pd(factor, sum[l], _mm256_load_pd(node)));
    }
    for (int k = 0; k < 3; ++k)
      _mm256_store_ps(A + half + k * W, zero);
  }
}

/// The next batch is gathered before the present one is computed: its loads are on their way meanwhile.
template <int W>
IMPACT_FLOAT_AVX2 void sweep(const FloatSweep& given)
{
  const FloatSweep s = given; // a copy: stores could change what is read by reference
  const std::int32_t *nodes = s.nodes, *places = s.position_nodes;
  float *w = s.w[0], *x = s.x[0], *next_w = s.w[1], *next_x = s.x[1];
  gather<W>(s.positions, places, s.num_position_nodes, s.scale, x);
  gather<W>(s.values, nodes, s.num_nodes, s.scale, w);
  for (std::size_t k = 0; k < s.num_batches; ++k)
  {
    const std::int32_t* next = nodes + W * s.num_nodes;
    if (k + 1 < s.num_batches)
    {
      places += s.positions_per_batch;
      gather<W>(s.positions, places, s.num_position_nodes, s.scale, next_x);
      gather<W>(s.values, next, s.num_nodes, s.scale, next_w);
    }
    s.tabulate(s.A, w, s.constants, x);
    scatter<W>(s.A, nodes, s.num_nodes, s.force_scale, s.b);
    nodes = next;
    std::swap(w, next_w);
    std::swap(x, next_x);
  }
}
} // namespace float_x86

float_sweep_function float_sweep(int lanes)
{
  if (kernels::processor_width() < 4)
    return nullptr;
  return lanes == 16 ? float_x86::sweep<16> : float_x86::sweep<8>;
}
#else
float_sweep_function float_sweep(int)
{
  return nullptr;
}
#endif
} // namespace dolfinx_impact::operators
