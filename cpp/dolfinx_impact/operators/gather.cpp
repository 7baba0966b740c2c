// SPDX-License-Identifier: MIT
#include "gather.h"
#include "gather_x86.h"
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

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

/// Components per node that have code of their own: displacements, tensors, and the fields of a shell or of several
/// species.
constexpr int most_components = 12;

[[noreturn]] void refuse(const std::string& what, int bs)
{
  throw std::runtime_error(what + " with " + std::to_string(bs) + " components per node are not supported: use 1 to " +
                           std::to_string(most_components) + ", or a mixed element of several fields");
}

template <int W>
gather_function pick_gather(int bs, int stride)
{
  constexpr auto functions = []<int... I>(std::integer_sequence<int, I...>)
  {
    return std::array<gather_function, most_components>{gather_nodes<W, I + 1, I + 1>...};
  }(std::make_integer_sequence<int, most_components>{});
  if (bs != stride || bs < 1 || bs > most_components)
    refuse("spaces", bs);
  return functions[bs - 1];
}

template <int W>
scatter_function pick_scatter(int bs)
{
  constexpr auto functions = []<int... I>(std::integer_sequence<int, I...>)
  {
    return std::array<scatter_function, most_components>{scatter_nodes<W, I + 1>...};
  }(std::make_integer_sequence<int, most_components>{});
  if (bs < 1 || bs > most_components)
    refuse("test spaces", bs);
  return functions[bs - 1];
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
