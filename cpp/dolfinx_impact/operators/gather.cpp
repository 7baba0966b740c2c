// SPDX-License-Identifier: MIT
#include "gather.h"
#include "gather_x86.h"
#include "lanes.h"
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

template <int W, int BS, int S>
void scatter_nodes(double* __restrict A, const std::int32_t* __restrict dofs, int num_nodes, int used,
                   double* __restrict b)
{
  const auto add = [b](double* entries, int l, std::int32_t dof)
  {
    double* node = b + S * std::int64_t(dof);
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
    {
      node[c] += entries[c * W + l];
      entries[c * W + l] = 0.0;
    }
  };
  for (int i = 0; i < num_nodes; ++i, A += W * BS, dofs += W)
    if (used == W)
#pragma GCC unroll 8
      for (int l = 0; l < W; ++l)
        add(A, l, dofs[l]);
    else
    {
      for (int l = 0; l < used; ++l)
        add(A, l, dofs[l]);
      std::fill_n(A, W * BS, 0.0);
    }
}

#if defined(__x86_64__) && defined(__GNUC__)
template <int W, int BS, int S>
void scatter_x86(double* A, const std::int32_t* dofs, int num_nodes, int used, double* b)
{
  if (used < W)
    scatter_nodes<W, BS, S>(A, dofs, num_nodes, used, b);
  else if constexpr (W == 8)
    x86::scatter8<BS, S>(A, dofs, num_nodes, b);
  else
    x86::scatter4<BS, S>(A, dofs, num_nodes, b);
}

/// A width of 4 or 8 is in use only where the processor has AVX2 or AVX-512 (kernels::width).
template <int BS, int S>
gather_function gather_x86(int lanes)
{
  return lanes == 8 ? x86::gather8<BS, S> : lanes == 4 ? x86::gather4<BS, S> : nullptr;
}
template <int BS, int S>
scatter_function scatter_x86(int lanes)
{
  return lanes == 8 ? scatter_x86<8, BS, S> : lanes == 4 ? scatter_x86<4, BS, S> : nullptr;
}
template <int BS, int S>
sweep_function sweep_x86(int lanes)
{
  return lanes == 8 ? x86::sweep8<BS, S> : lanes == 4 ? x86::sweep4<BS, S> : nullptr;
}
sweep_function sweep_x86(int lanes, int bs, int stride)
{
  return bs == 2 ? sweep_x86<2, 2>(lanes) : bs == 3 && stride == 4 ? sweep_x86<3, 4>(lanes) : nullptr;
}
gather_function gather_x86(int lanes, int bs, int stride)
{
  return bs == 2       ? gather_x86<2, 2>(lanes)
         : bs != 3     ? nullptr
         : stride == 4 ? gather_x86<3, 4>(lanes)
                       : gather_x86<3, 3>(lanes);
}
scatter_function scatter_x86(int lanes, int bs, int stride)
{
  return bs == 2       ? scatter_x86<2, 2>(lanes)
         : bs != 3     ? nullptr
         : stride == 4 ? scatter_x86<3, 4>(lanes)
                       : scatter_x86<3, 3>(lanes);
}
#else
sweep_function sweep_x86(int, int, int)
{
  return nullptr;
}
gather_function gather_x86(int, int, int)
{
  return nullptr;
}
scatter_function scatter_x86(int, int, int)
{
  return nullptr;
}
#endif

/// Components per node that have code of their own: displacements, tensors, and the fields of a shell or of several
/// species.
constexpr int most_components = 12;

/// @throws std::runtime_error for numbers that there is no code for
void check(const std::string& what, int bs, int stride)
{
  if (bs < 1 || bs > most_components)
    throw std::runtime_error(what + " with " + std::to_string(bs) +
                             " components per node are not supported: use 1 to " + std::to_string(most_components) +
                             ", or a mixed element of several fields");
  if (stride != bs && stride != padded_stride(bs))
    throw std::runtime_error(what + " with " + std::to_string(bs) + " components per node cannot have " +
                             std::to_string(stride) + " entries per node");
}

template <int W>
gather_function pick_gather(int bs, int stride)
{
  constexpr auto functions = []<int... I>(std::integer_sequence<int, I...>)
  {
    return std::array<gather_function, most_components>{gather_nodes<W, I + 1, I + 1>...};
  }(std::make_integer_sequence<int, most_components>{});
  return stride != bs ? gather_nodes<W, 3, 4> : functions[bs - 1];
}

template <int W>
scatter_function pick_scatter(int bs, int stride)
{
  constexpr auto functions = []<int... I>(std::integer_sequence<int, I...>)
  {
    return std::array<scatter_function, most_components>{scatter_nodes<W, I + 1, I + 1>...};
  }(std::make_integer_sequence<int, most_components>{});
  return stride != bs ? scatter_nodes<W, 3, 4> : functions[bs - 1];
}
} // namespace

gather_function gather(int lanes, int bs, int stride)
{
  check("spaces", bs, stride);
  if (gather_function fast = gather_x86(lanes, bs, stride))
    return fast;
  return lanes == 8 ? pick_gather<8>(bs, stride) : lanes == 4 ? pick_gather<4>(bs, stride) : pick_gather<1>(bs, stride);
}

scatter_function scatter(int lanes, int bs, int stride)
{
  check("test spaces", bs, stride);
  if (scatter_function fast = scatter_x86(lanes, bs, stride))
    return fast;
  return lanes == 8   ? pick_scatter<8>(bs, stride)
         : lanes == 4 ? pick_scatter<4>(bs, stride)
                      : pick_scatter<1>(bs, stride);
}

sweep_function sweep(int lanes, int bs, int stride)
{
  return sweep_x86(lanes, bs, stride);
}
} // namespace dolfinx_impact::operators
