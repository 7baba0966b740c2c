// SPDX-License-Identifier: MIT
#pragma once
// Gather, kernel and scatter in one function, for kernels of cells with straight sides: a call and its arrays cost as
// much as a node of a linear tetrahedron. Included by generated sources for widths of 4 and 8 on x86. Vectors are
// put together in registers: lanes that are written one by one and read whole stall the processor (the stores cannot be
// forwarded). Only the compiler's own vectors are used: a header of intrinsics takes longer to read than the kernel.
#include "Kernel.h"
#include "simd.h"
#if defined(__x86_64__) && defined(__GNUC__)
#define IMPACT_HAS_SWEEPS

namespace dolfinx_impact::kernels::swept
{
// Compiled for processors that the machine may not be: no copy may be left that the linker could use elsewhere.
#define IMPACT_ALWAYS_INLINE __attribute__((always_inline)) inline

/// A node of four entries in memory, aligned; a pair in memory, which need not be.
typedef double Row __attribute__((vector_size(32), may_alias));
typedef double Pair __attribute__((vector_size(16), aligned(8), may_alias));

/// Arrays of a kernel over the nodes of a cell.
struct NodalArrays
{
  int num_nodes;
  int num_positions;   ///< how many of them, the first, carry its position
  int components;      ///< of the coefficient that has components
  int offset;          ///< of its first entry in the kernel's coefficients
  int scalar_offset;   ///< of the scalar coefficient's first entry; -1: there is none
  int test_components; ///< of the result
  int num_constants;
  bool position_differences; ///< does the kernel read positions by their differences to that of the first node alone?
  bool value_differences;    ///< the same of the coefficient that has components

  /// Entries of the kernel's coefficients up to the last one that is gathered.
  constexpr int num_values() const
  {
    const int vectors = offset + num_nodes * components, scalars = scalar_offset + num_nodes;
    return scalar_offset >= 0 and scalars > vectors ? scalars : vectors;
  }
};

/// Arrays of a kernel over the points of a cell, and what it writes behind the element vector.
template <int num_outputs>
struct PointArrays
{
  int sizes[num_outputs]; ///< values of a cell that each output has as an internal variable; 0: it is none
  int size_A;             ///< entries of A in all
  int num_sums;
  int sum_offset;    ///< of the first sum in A
  int report_offset; ///< of the number of points that were not solved; -1: there are no equations

  static constexpr int count = num_outputs;
  /// Values of a cell that all internal variables have; 1 if there are none, as arrays have at least one entry.
  constexpr int num_values() const
  {
    int sum = 0;
    for (int size : sizes)
      sum += size;
    return sum > 0 ? sum : 1;
  }
};

/// One component of a node in each of four lanes.
typedef double Column __attribute__((vector_size(32)));

/// Components of one node of four cells.
template <int N>
struct Columns
{
  Column c[N];
};

/// The four columns of the matrix with these rows.
IMPACT_ALWAYS_INLINE Columns<4> transposed(Column r0, Column r1, Column r2, Column r3)
{
  const Column a = __builtin_shufflevector(r0, r1, 0, 4, 2, 6), b = __builtin_shufflevector(r0, r1, 1, 5, 3, 7);
  const Column c = __builtin_shufflevector(r2, r3, 0, 4, 2, 6), d = __builtin_shufflevector(r2, r3, 1, 5, 3, 7);
  return {{__builtin_shufflevector(a, c, 0, 1, 4, 5), __builtin_shufflevector(b, d, 0, 1, 4, 5),
           __builtin_shufflevector(a, c, 2, 3, 6, 7), __builtin_shufflevector(b, d, 2, 3, 6, 7)}};
}

template <int BS>
IMPACT_ALWAYS_INLINE Columns<BS> gather4(const double* values, const int* nodes)
{
  if constexpr (BS == 3)
  {
    Column r[4];
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l)
      r[l] = *reinterpret_cast<const Row*>(values + 4 * static_cast<long long>(nodes[l]));
    const Columns<4> t = transposed(r[0], r[1], r[2], r[3]);
    return {{t.c[0], t.c[1], t.c[2]}};
  }
  else if constexpr (BS == 1)
    return {{Column{values[nodes[0]], values[nodes[1]], values[nodes[2]], values[nodes[3]]}}};
  else
  {
    Pair r[4];
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l)
      r[l] = *reinterpret_cast<const Pair*>(values + 2 * static_cast<long long>(nodes[l]));
    const Column a = __builtin_shufflevector(r[0], r[2], 0, 1, 2, 3),
                 b = __builtin_shufflevector(r[1], r[3], 0, 1, 2, 3);
    return {{__builtin_shufflevector(a, b, 0, 4, 2, 6), __builtin_shufflevector(a, b, 1, 5, 3, 7)}};
  }
}

/// Adds to four nodes, one after the other: lanes may share a node.
template <int BS>
IMPACT_ALWAYS_INLINE void scatter4(double* result, const int* nodes, const Columns<BS>& f)
{
  if constexpr (BS == 3)
  {
    const Columns<4> rows = transposed(f.c[0], f.c[1], f.c[2], Column{});
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l)
    {
      Row& node = *reinterpret_cast<Row*>(result + 4 * static_cast<long long>(nodes[l]));
      node = node + rows.c[l];
    }
  }
  else if constexpr (BS == 1)
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l)
      result[nodes[l]] += f.c[0][l];
  else
  {
    const Column a = __builtin_shufflevector(f.c[0], f.c[1], 0, 4, 2, 6),
                 b = __builtin_shufflevector(f.c[0], f.c[1], 1, 5, 3, 7);
    const Pair rows[4] = {__builtin_shufflevector(a, a, 0, 1), __builtin_shufflevector(b, b, 0, 1),
                          __builtin_shufflevector(a, a, 2, 3), __builtin_shufflevector(b, b, 2, 3)};
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l)
    {
      Pair& node = *reinterpret_cast<Pair*>(result + 2 * static_cast<long long>(nodes[l]));
      node = node + rows[l];
    }
  }
}

template <int W, int BS, typename T>
IMPACT_ALWAYS_INLINE void gather(const double* values, const int* nodes, T* w)
{
  const Columns<BS> low = gather4<BS>(values, nodes);
  if constexpr (W == 8)
  {
    const Columns<BS> high = gather4<BS>(values, nodes + 4);
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
      w[c] = __builtin_shufflevector(low.c[c], high.c[c], 0, 1, 2, 3, 4, 5, 6, 7);
  }
  else
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
      w[c] = low.c[c];
}

template <int W, int BS, typename T>
IMPACT_ALWAYS_INLINE void scatter(double* result, const int* nodes, const T* A)
{
  Columns<BS> low;
  if constexpr (W == 8)
  {
    Columns<BS> high;
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
    {
      low.c[c] = __builtin_shufflevector(A[c], A[c], 0, 1, 2, 3);
      high.c[c] = __builtin_shufflevector(A[c], A[c], 4, 5, 6, 7);
    }
    scatter4<BS>(result, nodes, low);
    scatter4<BS>(result, nodes + 4, high);
  }
  else
  {
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
      low.c[c] = A[c];
    scatter4<BS>(result, nodes, low);
  }
}

/// Four of the lanes.
template <int part, typename T>
IMPACT_ALWAYS_INLINE Column lanes_of(T x)
{
  if constexpr (sizeof(T) == sizeof(Column))
    return x;
  else if constexpr (part == 0)
    return __builtin_shufflevector(x, x, 0, 1, 2, 3);
  else
    return __builtin_shufflevector(x, x, 4, 5, 6, 7);
}

/// Cells with more nodes would need more registers than there are.
constexpr int most_nodes_at_once = 4;

/// Adds to all nodes of four cells, a cell after the other: neighbouring cells share nodes, and an addition waits for
/// the last one's store.
template <int W, int N, int part, typename T>
IMPACT_ALWAYS_INLINE void scatter_cells4(double* result, const int* nodes, const T* A)
{
  Columns<4> rows[N];
#pragma GCC unroll 16
  for (int i = 0; i < N; ++i)
    rows[i] =
        transposed(lanes_of<part>(A[3 * i]), lanes_of<part>(A[3 * i + 1]), lanes_of<part>(A[3 * i + 2]), Column{});
#pragma GCC unroll 4
  for (int l = 0; l < 4; ++l)
#pragma GCC unroll 16
    for (int i = 0; i < N; ++i)
    {
      Row& node = *reinterpret_cast<Row*>(result + 4 * static_cast<long long>(nodes[W * i + 4 * part + l]));
      node = node + rows[i].c[l];
    }
}

/// Adds to all nodes of the cells.
template <int W, int N, int BS, typename T>
IMPACT_ALWAYS_INLINE void scatter_all(double* result, const int* nodes, const T* A)
{
  if constexpr (BS == 3 && N <= most_nodes_at_once)
  {
    scatter_cells4<W, N, 0>(result, nodes, A);
    if constexpr (W == 8)
      scatter_cells4<W, N, 1>(result, nodes, A);
  }
  else
#pragma GCC unroll 16
    for (int i = 0; i < N; ++i)
      scatter<W, BS>(result, nodes + W * i, A + BS * i);
}

/// Gathers the values of node i of the cells; with `differences` less those of the first node, which has `first`.
template <int W, int BS, bool differences, typename T>
IMPACT_ALWAYS_INLINE void gather_node(int i, const double* values, const int* nodes, T* first, T* w)
{
  gather<W, BS>(values, nodes + W * i, w);
  if constexpr (differences)
  {
#pragma GCC unroll 3
    for (int c = 0; c < BS; ++c)
      if (i == 0)
      {
        first[c] = w[c];
        w[c] = -T{}; // the kernel's differences to it are then the values of the others, or minus these
      }
      else
        w[c] = w[c] - first[c];
  }
}

/// @tparam kernel the kernel for vectors of W cells, which becomes a part of this function
/// @tparam of where its arrays are
/// @tparam num_sums what it sums up over the cells and writes behind the element vector
template <int W, auto kernel, NodalArrays of, int num_sums = 0>
IMPACT_ALWAYS_INLINE void sweep(const impact_cells& cells)
{
  typedef typename Lanes<W>::type T;
  constexpr int N = of.num_nodes, P = of.num_positions, size = of.test_components * N;
  const impact_cells s = cells; // a copy: what is added to the result could change what is read by reference
  const int* nodes = s.nodes;
  double constants[of.num_constants + 1]{}; // copies: what follows from them is computed once
  for (int i = 0; i < of.num_constants; ++i)
    constants[i] = s.constants[i];
  for (unsigned long long batch = 0; batch < s.num_batches; ++batch, nodes += W * N)
  {
    T x[3 * P], w[of.num_values()], A[size + num_sums];
    T first_x[3]{}, first_w[of.components]{};
    const auto gather_position = [&](int i) __attribute__((always_inline))
    { gather_node<W, 3, of.position_differences>(i, s.positions, nodes, first_x, x + 3 * i); };
    const auto gather_values = [&](int i) __attribute__((always_inline))
    {
      gather_node<W, of.components, of.value_differences>(i, s.values, nodes, first_w,
                                                          w + of.offset + of.components * i);
      if constexpr (of.scalar_offset >= 0)
        gather<W, 1>(s.scalars, nodes + W * i, w + of.scalar_offset + i);
    };
    // Of a linear simplex half of the values are left once their differences are known: there are registers for these.
    constexpr bool by_node = of.position_differences && of.value_differences;
#pragma GCC unroll 16
    for (int i = 0; i < P; ++i)
    {
      gather_position(i);
      if constexpr (by_node)
        gather_values(i);
    }
#pragma GCC unroll 16
    for (int i = by_node ? P : 0; i < N; ++i)
      gather_values(i);
#pragma GCC unroll 48
    for (int i = 0; i < size; ++i)
      A[i] = -T{}; // added to -0 a number is itself, also -0: compilers leave the sum out
    kernel(A, w, constants, x, 0);
    scatter_all<W, N, of.test_components>(s.result, nodes, A);
    for (int k = 0; k < num_sums; ++k)
      for (int lane = 0; lane < W; ++lane)
        s.sums[k] += A[size + k][lane];
  }
}

/// Is a value of the array other than +0?
template <typename T, int N>
IMPACT_ALWAYS_INLINE bool holds_bits(const T (&values)[N])
{
  typedef decltype(values[0] == values[0]) Bits;
  Bits all = __builtin_bit_cast(Bits, values[0]);
#pragma GCC unroll 8
  for (int i = 1; i < N; ++i)
    all = all | __builtin_bit_cast(Bits, values[i]);
  return any_lane(all != 0);
}

/// The same for a kernel with internal variables, which it reads and overwrites where they lie. The next batch is
/// gathered and fetched before the present one is computed. The virgin state is zero, and most cells of a body never
/// leave it: batches in it read zeros from the first cache, and none from memory.
/// @tparam kernel the kernel for vectors of W cells, in place
/// @tparam at its arrays at the points
template <int W, auto kernel, NodalArrays of, auto at>
IMPACT_ALWAYS_INLINE void sweep_history(const impact_cells& cells)
{
  typedef typename Lanes<W>::type T;
  constexpr int N = of.num_nodes, P = of.num_positions, size = of.test_components * N;
  constexpr int bytes_of_a_line = 64;
  // The first cache has no room for it beside the kernel's arrays; nor is it marked as written where no point yields.
  constexpr int second_cache = 1;
  const impact_cells s = cells;
  T x[2][3 * P], w[2][of.num_values()], A[at.size_A];
  double constants[of.num_constants + 1]{}; // as in `sweep`
  for (int i = 0; i < of.num_constants; ++i)
    constants[i] = s.constants[i];
  T virgin[at.num_values()], *virgins[at.count], *history[at.count];
  for (int i = 0; i < at.num_values(); ++i)
    virgin[i] = T{};
  for (int k = 0, first = 0; k < at.count; first += at.sizes[k++])
  {
    history[k] = reinterpret_cast<T*>(s.history[k]);
    virgins[k] = virgin + first;
  }
  const auto read = [&](const int* nodes, int buffer)
  {
#pragma GCC unroll 16
    for (int i = 0; i < P; ++i)
      gather<W, 3>(s.positions, nodes + W * i, x[buffer] + 3 * i);
#pragma GCC unroll 16
    for (int i = 0; i < N; ++i)
    {
      gather<W, of.components>(s.values, nodes + W * i, w[buffer] + of.offset + of.components * i);
      if constexpr (of.scalar_offset >= 0)
        gather<W, 1>(s.scalars, nodes + W * i, w[buffer] + of.scalar_offset + i);
    }
  };
  const int* nodes = s.nodes;
  if (s.num_batches > 0)
    read(nodes, 0);
  for (unsigned long long batch = 0; batch < s.num_batches; ++batch, nodes += W * N)
  {
    const int buffer = batch % 2;
    if (batch + 1 < s.num_batches)
    {
      read(nodes + W * N, 1 - buffer);
      for (int k = 0; k < at.count && s.has_history[batch + 1]; ++k)
        for (unsigned long long byte = 0; byte < at.sizes[k] * sizeof(T); byte += bytes_of_a_line)
          __builtin_prefetch(reinterpret_cast<const char*>(history[k] + at.sizes[k]) + byte, 0, second_cache);
    }
#pragma GCC unroll 48
    for (int i = 0; i < size; ++i)
      A[i] = T{};
    const bool is_virgin = !s.has_history[batch];
    kernel(A, w[buffer], constants, x[buffer], 0, is_virgin ? virgins : history);
    if (is_virgin && holds_bits(virgin))
    {
      for (int k = 0; k < at.count; ++k)
        for (int i = 0; i < at.sizes[k]; ++i)
        {
          history[k][i] = virgins[k][i];
          virgins[k][i] = T{};
        }
      s.has_history[batch] = 1;
    }
    scatter_all<W, N, of.test_components>(s.result, nodes, A);
    for (int k = 0; k < at.num_sums; ++k)
      for (int lane = 0; lane < W; ++lane)
        s.sums[k] += A[at.sum_offset + k][lane];
    if constexpr (at.report_offset >= 0)
      if (any_lane(A[at.report_offset] > 0.0)) [[unlikely]]
        s.report(s.owner, batch, reinterpret_cast<const double*>(A));
    for (int k = 0; k < at.count; ++k)
      history[k] += at.sizes[k];
  }
}
} // namespace dolfinx_impact::kernels::swept
#undef IMPACT_ALWAYS_INLINE
#endif
