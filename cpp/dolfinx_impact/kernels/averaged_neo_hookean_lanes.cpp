// SPDX-License-Identifier: MIT
// The sweeps of averaged_neo_hookean.h for vectors of IMPACT_LANES cells; compiled once for each width.
#include "averaged_neo_hookean.h"
#include "functions.h"
#include "sweep.h"
#ifdef IMPACT_HAS_SWEEPS

namespace dolfinx_impact::kernels
{
namespace
{
#define IMPACT_ALWAYS_INLINE __attribute__((always_inline)) inline
using swept::Column;
using swept::Columns;
using swept::lanes_of;
using swept::Row;

constexpr int W = IMPACT_LANES;
typedef Lanes<W>::type V;

struct Vector
{
  V c[3];
};
/// row[d] belongs to the reference coordinate or position d.
struct Tensor
{
  Vector row[3];
};

IMPACT_ALWAYS_INLINE Vector cross(const Vector& a, const Vector& b)
{
  return {{a.c[1] * b.c[2] - a.c[2] * b.c[1], a.c[2] * b.c[0] - a.c[0] * b.c[2], a.c[0] * b.c[1] - a.c[1] * b.c[0]}};
}
IMPACT_ALWAYS_INLINE V dot(const Vector& a, const Vector& b)
{
  return a.c[0] * b.c[0] + a.c[1] * b.c[1] + a.c[2] * b.c[2];
}
IMPACT_ALWAYS_INLINE Tensor cofactors(const Tensor& a)
{
  return {{cross(a.row[1], a.row[2]), cross(a.row[2], a.row[0]), cross(a.row[0], a.row[1])}};
}
IMPACT_ALWAYS_INLINE Tensor operator+(const Tensor& a, const Tensor& b)
{
  Tensor sum;
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < 3; ++i)
      sum.row[d].c[i] = a.row[d].c[i] + b.row[d].c[i];
  return sum;
}
/// Row j: the sum over d of a's row d times entry j of b's row d.
IMPACT_ALWAYS_INLINE Tensor product(const Tensor& a, const Tensor& b)
{
  Tensor out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      out.row[j].c[i] = a.row[0].c[i] * b.row[0].c[j] + a.row[1].c[i] * b.row[1].c[j] + a.row[2].c[i] * b.row[2].c[j];
  return out;
}

IMPACT_ALWAYS_INLINE Vector node(const double* values, const int* nodes)
{
  Vector out;
  swept::gather<W, 3>(values, nodes, out.c);
  return out;
}
/// Derivatives by the reference coordinates: differences to the first node.
IMPACT_ALWAYS_INLINE Tensor derivatives(const double* values, const int* nodes)
{
  const Vector first = node(values, nodes);
  Tensor out;
#pragma GCC unroll 3
  for (int d = 0; d < 3; ++d)
  {
    const Vector other = node(values, nodes + (d + 1) * W);
    for (int i = 0; i < 3; ++i)
      out.row[d].c[i] = other.c[i] - first.c[i];
  }
  return out;
}

/// All lanes; of vectors of four the first are all.
template <typename T = V>
IMPACT_ALWAYS_INLINE T joined(Column low, Column high)
{
  if constexpr (sizeof(T) == sizeof(Column))
    return low;
  else
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
/// Entries of a node one after the other, of each of four lanes.
template <int part>
IMPACT_ALWAYS_INLINE Columns<4> rows_of_lanes(const Vector& v, Column fourth = Column{})
{
  return swept::transposed(lanes_of<part>(v.c[0]), lanes_of<part>(v.c[1]), lanes_of<part>(v.c[2]), fourth);
}

IMPACT_ALWAYS_INLINE Row* rows(double* means, int node)
{
  return reinterpret_cast<Row*>(means + entries_of_means * static_cast<long long>(node));
}
IMPACT_ALWAYS_INLINE const Row* rows(const double* means, int node)
{
  return reinterpret_cast<const Row*>(means + entries_of_means * static_cast<long long>(node));
}

/// Adds the same to all nodes of a cell. Nodes follow each other before lanes: neighbouring cells share nodes, and an
/// addition would wait for the last one's store.
template <int part>
IMPACT_ALWAYS_INLINE void add_to_nodes(double* means, const int* nodes, const Tensor& H, V log_J)
{
  const Columns<4> first = rows_of_lanes<part>(H.row[0], lanes_of<part>(log_J)), second = rows_of_lanes<part>(H.row[1]),
                   third = rows_of_lanes<part>(H.row[2]);
#pragma GCC unroll 4
  for (int l = 0; l < 4; ++l)
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i)
    {
      Row* at = rows(means, nodes[W * i + 4 * part + l]);
      at[0] = at[0] + first.c[l];
      at[1] = at[1] + second.c[l];
      at[2] = at[2] + third.c[l];
    }
}

/// Sums over the nodes of each cell: entry i of row j in columns[j].c[i].
template <int part>
IMPACT_ALWAYS_INLINE void sum_of_nodes(const double* means, const int* nodes, Columns<4> (&columns)[3])
{
  Row sums[3][4];
#pragma GCC unroll 4
  for (int l = 0; l < 4; ++l)
  {
    const int* own = nodes + 4 * part + l;
    const Row *a = rows(means, own[0]), *b = rows(means, own[W]), *c = rows(means, own[2 * W]),
              *d = rows(means, own[3 * W]);
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j)
      sums[j][l] = (a[j] + b[j]) + (c[j] + d[j]);
  }
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j)
    columns[j] = swept::transposed(sums[j][0], sums[j][1], sums[j][2], sums[j][3]);
}

/// Adds forces of all nodes but the first, and to that one the opposite.
IMPACT_ALWAYS_INLINE void scatter(double* forces, const int* nodes, const Tensor& f)
{
  V of_nodes[12];
  for (int i = 0; i < 3; ++i)
  {
    of_nodes[i] = -(f.row[0].c[i] + f.row[1].c[i] + f.row[2].c[i]);
    for (int d = 0; d < 3; ++d)
      of_nodes[3 * (d + 1) + i] = f.row[d].c[i];
  }
  swept::scatter_all<W, 4, 3>(forces, nodes, of_nodes);
}

/// One in lanes that count.
IMPACT_ALWAYS_INLINE V ones(int used)
{
  V out{};
  for (int l = 0; l < W; ++l)
    out[l] = l < used ? 1.0 : 0.0;
  return out;
}

/// With the cofactors C of the Jacobian, whose determinant is det = 6 V up to its sign, grad u = sum_d u_,d C_d / det,
/// and J is the quotient of the determinants of the deformed and the undeformed derivatives of positions.
void add_means(const AveragedCells& cells)
{
  const AveragedCells s = cells; // a copy: what is added could change what is read by reference
  const int* nodes = s.nodes;
  V weight = splat<V>(1.0 / 24.0); // a quarter of the volume, over the determinant
  for (unsigned long long batch = 0; batch < s.num_batches; ++batch, nodes += 4 * W)
  {
    if (batch + 1 == s.num_batches)
      weight *= ones(s.used);
    const Tensor x = derivatives(s.positions, nodes), u = derivatives(s.displacement, nodes), deformed = x + u;
    Tensor C = cofactors(x);
    const V det = dot(x.row[0], C.row[0]);
    const V log_J = math::log(V(dot(deformed.row[0], cross(deformed.row[1], deformed.row[2])) / det));
    const V signed_weight = math::times_sign(weight, det);
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < 3; ++i)
        C.row[d].c[i] = signed_weight * C.row[d].c[i];
    const Tensor H = product(u, C);
    const V of_log_J = signed_weight * det * log_J;
    add_to_nodes<0>(s.means, nodes, H, of_log_J);
    if constexpr (W == 8)
      add_to_nodes<1>(s.means, nodes, H, of_log_J);
  }
}

/// With the cofactors D of the deformed derivatives of positions, V F^-T grad N_d = det D_d / (6 det_deformed): of this
/// part no gradient by positions is computed.
void add_forces(const AveragedCells& cells, const AveragedModuli& moduli)
{
  const AveragedCells s = cells;
  const int* nodes = s.nodes;
  const double mu = moduli.cells_mu;
  V weight = splat<V>(1.0 / 6.0);
  for (unsigned long long batch = 0; batch < s.num_batches; ++batch, nodes += 4 * W)
  {
    if (batch + 1 == s.num_batches)
      weight *= ones(s.used);
    Columns<4> low[3], high[3] = {};
    sum_of_nodes<0>(s.means, nodes, low);
    if constexpr (W == 8)
      sum_of_nodes<1>(s.means, nodes, high);
    const Tensor x = derivatives(s.positions, nodes), u = derivatives(s.displacement, nodes), deformed = x + u;
    const Tensor C = cofactors(x), D = cofactors(deformed);
    const V det = dot(x.row[0], C.row[0]), deformed_det = dot(deformed.row[0], D.row[0]);
    const V inverse = 1.0 / (det * deformed_det), of_gradient = mu * deformed_det * inverse;
    const V pressure = joined(low[0].c[3], high[0].c[3]);
    const V signed_weight = math::times_sign(weight, det);
    const V of_inverse = signed_weight * (pressure - mu) * det * det * inverse;
    Tensor P = product(u, C); // what the cell's own gradient and the nodes' stress give, times the weight
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
      {
        const V of_nodes = joined(low[j].c[i], high[j].c[i]);
        P.row[j].c[i] = signed_weight * ((i == j ? of_nodes + mu : of_nodes) + of_gradient * P.row[j].c[i]);
      }
    Tensor f;
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < 3; ++i)
        f.row[d].c[i] = P.row[0].c[i] * C.row[d].c[0] + P.row[1].c[i] * C.row[d].c[1] + P.row[2].c[i] * C.row[d].c[2] +
                        of_inverse * D.row[d].c[i];
    scatter(s.forces, nodes, f);
  }
}

/// Entry i + 1 in the place of i, of three.
IMPACT_ALWAYS_INLINE Row next(Row a)
{
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}

/// Cofactors are vector products of rows.
void set_stress(unsigned long long num_nodes, const double* inverse_volumes, const AveragedModuli& moduli,
                double* means)
{
  const double mu = moduli.nodes_mu / 4, lambda = moduli.lambda / 4;
  for (unsigned long long k = 0; k < num_nodes; ++k)
  {
    Row* at = reinterpret_cast<Row*>(means + entries_of_means * k);
    const double inverse = inverse_volumes[k];
    const Row f0 = at[0] * inverse + Row{1.0}, f1 = at[1] * inverse + Row{0.0, 1.0},
              f2 = at[2] * inverse + Row{0.0, 0.0, 1.0};
    const Row n0 = next(f0), n1 = next(f1), n2 = next(f2);
    const Row c0 = next(f1 * n2 - n1 * f2), c1 = next(f2 * n0 - n2 * f0), c2 = next(f0 * n1 - n0 * f1);
    const Row terms = f0 * c0;
    const double factor = mu / (terms[0] + terms[1] + terms[2]);
    Row first = mu * f0 - factor * c0;
    first[3] = lambda * f0[3];
    at[0] = first;
    at[1] = mu * f1 - factor * c1;
    at[2] = mu * f2 - factor * c2;
  }
}
#undef IMPACT_ALWAYS_INLINE
} // namespace

#if IMPACT_LANES == 4
AveragedNeoHookeanKernels averaged_neo_hookean_4();
AveragedNeoHookeanKernels averaged_neo_hookean_4()
#else
AveragedNeoHookeanKernels averaged_neo_hookean_8();
AveragedNeoHookeanKernels averaged_neo_hookean_8()
#endif
{
  return {add_means, set_stress, add_forces};
}
} // namespace dolfinx_impact::kernels
#endif
