// SPDX-License-Identifier: MIT
#include "gather.h"
#include "gather_x86.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
template <int W, int BS, int S>
void gather_nodes(const double* __restrict u, const std::int32_t* __restrict dofs, int num_nodes, double* __restrict w)
{
  for (int i = 0; i < num_nodes; ++i, w += W * BS, dofs += W)
#pragma GCC unroll 8
    for (int l = 0; l < W; ++l)
    {
      const double* node = u + S * std::int64_t(dofs[l]);
#pragma GCC unroll 3
      for (int c = 0; c < BS; ++c)
        w[c * W + l] = node[c];
    }
}

template <int W, int BS>
void scatter_nodes(const double* __restrict A, const std::int32_t* __restrict dofs, int num_nodes, int used,
                   double* __restrict b)
{
  if (used == W)
  {
    for (int i = 0; i < num_nodes; ++i, A += W * BS, dofs += W)
#pragma GCC unroll 8
      for (int l = 0; l < W; ++l)
      {
        double* node = b + BS * std::int64_t(dofs[l]);
#pragma GCC unroll 3
        for (int c = 0; c < BS; ++c)
          node[c] += A[c * W + l];
      }
    return;
  }
  for (int i = 0; i < num_nodes; ++i, A += W * BS, dofs += W)
    for (int l = 0; l < used; ++l)
      for (int c = 0; c < BS; ++c)
        b[BS * std::int64_t(dofs[l]) + c] += A[c * W + l];
}

#if defined(__x86_64__) && defined(__GNUC__)
template <int W, int BS>
void scatter_x86(const double* A, const std::int32_t* dofs, int num_nodes, int used, double* b)
{
  if (used == W)
    x86::scatter_whole<BS, W>(A, dofs, num_nodes, b);
  else
    scatter_nodes<W, BS>(A, dofs, num_nodes, used, b);
}

/// A width of 4 or 8 is in use only where the processor has AVX2 or AVX-512 (kernels::width).
gather_function gather_x86(int lanes, int bs)
{
  if (lanes == 4)
    return bs == 3 ? x86::gather4<3> : bs == 2 ? x86::gather4<2> : nullptr;
  if (lanes == 8)
    return bs == 3 ? x86::gather8<3> : bs == 2 ? x86::gather8<2> : nullptr;
  return nullptr;
}

scatter_function scatter_x86(int lanes, int bs)
{
  if (lanes == 4)
    return bs == 3 ? scatter_x86<4, 3> : bs == 2 ? scatter_x86<4, 2> : nullptr;
  if (lanes == 8)
    return bs == 3 ? scatter_x86<8, 3> : bs == 2 ? scatter_x86<8, 2> : nullptr;
  return nullptr;
}
clear_function clear_x86(int lanes)
{
  return lanes == 8 ? x86::clear8 : lanes == 4 ? x86::clear4 : nullptr;
}
#else
clear_function clear_x86(int)
{
  return nullptr;
}
gather_function gather_x86(int, int)
{
  return nullptr;
}
scatter_function scatter_x86(int, int)
{
  return nullptr;
}
#endif

template <int W>
gather_function pick_gather(int bs, int stride)
{
  const int key = 10 * bs + stride;
  switch (key)
  {
  case 11:
    return gather_nodes<W, 1, 1>;
  case 22:
    return gather_nodes<W, 2, 2>;
  case 33:
    return gather_nodes<W, 3, 3>;
  case 44:
    return gather_nodes<W, 4, 4>;
  case 66:
    return gather_nodes<W, 6, 6>;
  case 99:
    return gather_nodes<W, 9, 9>;
  default:
    throw std::runtime_error("spaces with " + std::to_string(bs) +
                             " components per node are not supported: use 1, 2, 3, "
                             "4, 6 or 9");
  }
}

template <int W>
scatter_function pick_scatter(int bs)
{
  switch (bs)
  {
  case 1:
    return scatter_nodes<W, 1>;
  case 2:
    return scatter_nodes<W, 2>;
  case 3:
    return scatter_nodes<W, 3>;
  default:
    throw std::runtime_error("test spaces with " + std::to_string(bs) +
                             " components per node are not supported: use 1, 2 or 3");
  }
}
} // namespace

gather_function gather(int lanes, int bs, int stride)
{
  if (gather_function fast = gather_x86(lanes, bs); fast && bs == stride)
    return fast;
  return lanes == 8 ? pick_gather<8>(bs, stride) : lanes == 4 ? pick_gather<4>(bs, stride) : pick_gather<1>(bs, stride);
}

clear_function clear(int lanes)
{
  const clear_function fast = clear_x86(lanes);
  return fast ? fast : [](double* A, std::size_t size) { std::fill_n(A, size, 0.0); };
}

scatter_function scatter(int lanes, int bs)
{
  if (scatter_function fast = scatter_x86(lanes, bs))
    return fast;
  return lanes == 8 ? pick_scatter<8>(bs) : lanes == 4 ? pick_scatter<4>(bs) : pick_scatter<1>(bs);
}
} // namespace dolfinx_impact::operators
