// SPDX-License-Identifier: MIT
#include "ClosedBatch.h"
#include "../../common/clones.h"
#include "../../common/columns.h"
#include "../../search/closest_point/linear_facet.h"
#include <algorithm>
#include <cmath>
#include <limits>

// Compiled without contraction of multiplications and additions: all instruction sets give the same numbers.
#if defined(__GNUC__)
#define IMPACT_FLATTEN __attribute__((flatten))
#else
#define IMPACT_FLATTEN
#endif

namespace dolfinx_impact::enforcement
{
namespace
{
using common::Column, common::column, common::LooseColumn;
using surface::FacetShape;

constexpr int any = -1;  ///< number of a facet's nodes that is not known to the compiler
constexpr int group = 4; ///< lanes of a register: those of a batch are computed four at a time
constexpr int lanes = ClosedBatch::size, most = ClosedBatch::most;

template <int N>
constexpr int room = N == any ? most : N;

/// A vector of each of four nodes.
struct Vector
{
  Column c[3];
};

template <int D>
IMPACT_INLINED Column dot(const Vector& a, const Vector& b)
{
  Column sum = a.c[0] * b.c[0];
#pragma GCC unroll 4
  for (int c = 1; c < D; ++c)
    sum += a.c[c] * b.c[c];
  return sum;
}

/// Rows of a batch, from lane l on.
template <int D>
IMPACT_INLINED Vector read_rows(const double (&rows)[3][lanes], int l)
{
  Vector out = {};
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    out.c[c] = column(rows[c] + l);
  return out;
}
template <int D>
IMPACT_INLINED void write_rows(const Vector& values, double (&rows)[3][lanes], int l)
{
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    column(rows[c] + l) = values.c[c];
}

/// Values of four nodes, by number: in space padded to four numbers each.
template <int D>
IMPACT_INLINED Vector gather(const double* values, const std::int32_t* nodes)
{
  Vector out = {};
  if constexpr (D == 3)
  {
    Column rows[4];
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k)
      rows[k] = column(values + 4 * std::size_t(nodes[k]));
    common::transpose(rows);
#pragma GCC unroll 4
    for (int c = 0; c < 3; ++c)
      out.c[c] = rows[c];
  }
  else
#pragma GCC unroll 4
    for (int k = 0; k < group; ++k)
      for (int c = 0; c < D; ++c)
        out.c[c][k] = values[std::size_t(nodes[k]) * D + c];
  return out;
}

/// The corrections of the moments of four nodes.
/// @param[out] r as MomentCorrection::set returns
template <int D, typename T>
IMPACT_INLINED MomentCorrectionOf<T> moments_of(int num, const ClosedBatch& b, auto&& at, T* r)
{
  MomentCorrectionOf<T> out;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    out.e[c] = at(b.arm[c]);
#pragma GCC unroll 6
  for (int k = 0; k < (D == 2 ? 1 : 6); ++k)
    out.inverse[k] = at(b.inverse[k]);
  for_nodes(num,
            [&](int j)
            {
#pragma GCC unroll 4
              for (int c = 0; c < D; ++c)
                r[j * D + c] = at(b.masters[j].from_mean[c]);
            });
  return out;
}

template <int D, int N, bool turns, bool rubs>
IMPACT_CLONES IMPACT_FLATTEN void begin_lanes(const ClosedRules& rules, ClosedBatch& b, const ClosedInput& input,
                                              const search::MasterNode* nodes)
{
  const int num = N == any ? rules.num_masters : N;
  for (int l = 0; l < lanes; l += group)
  {
    Vector X[room<N>], du[room<N>]; // of the nodes of the facets: positions at the last time level, increments
    Vector motion = read_rows<D>(b.motion, l), turn = {};
    for_nodes(num,
              [&](int j)
              {
                search::MasterColumns master;
                search::read(nodes, b.masters[j].corner + l, master);
                const Column phi = column(b.masters[j].phi + l);
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                {
                  X[j].c[c] = master.x[c] - master.du[c];
                  du[j].c[c] = master.du[c];
                  motion.c[c] -= phi * master.du[c];
                }
              });
    write_rows<D>(motion, b.motion, l);
    if constexpr (N != any)
      if (rules.linear_facets)
      {
        constexpr FacetShape S = N == 2   ? FacetShape::interval
                                 : N == 3 ? FacetShape::triangle
                                          : FacetShape::quadrilateral;
        const Column xi[2] = {column(input.xi[0] + l), column(input.xi[1] + l)}, along = column(input.along_facet + l),
                     orientation = column(input.orientation + l);
        Column x[N][3], n[3];
#pragma GCC unroll 4
        for (int j = 0; j < N; ++j)
#pragma GCC unroll 4
          for (int c = 0; c < D; ++c)
            x[j][c] = X[j].c[c];
        search::linear::normal<S>(x, xi, orientation, n);
#pragma GCC unroll 4
        for (int c = 0; c < D; ++c)
          column(b.normal[c] + l) = along > 0.0 ? n[c] : column(b.normal[c] + l);
      }
    if constexpr (turns)
    {
      MomentCorrectionOf<Column> correction;
      Column phi[room<N>], r[room<N> * D];
      const Vector x = read_rows<D>(input.x, l);
      for_nodes(num, [&](int j) { phi[j] = column(b.masters[j].phi + l); });
      correction.set<D>(num, [&](int j, int c) -> const Column& { return X[j].c[c]; }, phi, x.c, r);
      // A node that sticks at a distance, within layers of the surfaces, turns with the facet: that is no slip.
      if constexpr (rubs)
        correction.add_rotation<D>(num, r, [&](int j, int c) -> const Column& { return du[j].c[c]; }, turn.c);
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        column(b.arm[c] + l) = correction.e[c];
#pragma GCC unroll 6
      for (int k = 0; k < (D == 2 ? 1 : 6); ++k)
        column(b.inverse[k] + l) = correction.inverse[k];
      for_nodes(num,
                [&](int j)
                {
#pragma GCC unroll 4
                  for (int c = 0; c < D; ++c)
                    column(b.masters[j].from_mean[c] + l) = r[j * D + c];
                });
    }
    write_rows<D>(turn, b.turn, l);
  }
}

template <int D, int N, bool rubs>
IMPACT_CLONES IMPACT_FLATTEN void solve_lanes(const ClosedRules& rules, ClosedBatch& b, const double* correction,
                                              double per_h, bool first)
{
  const int num = N == any ? rules.num_masters : N;
  for (int l = 0; l < lanes; l += group)
  {
    const Vector n = read_rows<D>(b.normal, l);
    Vector f = read_rows<D>(b.force, l), moved = {}, more = {};
    if (!first)
    {
      moved = gather<D>(correction, b.node + l);
      for_nodes(num,
                [&](int j)
                {
                  const Vector at = gather<D>(correction, b.masters[j].node + l);
                  const Column phi = column(b.masters[j].phi + l);
#pragma GCC unroll 4
                  for (int c = 0; c < D; ++c)
                    moved.c[c] -= phi * at.c[c];
                });
    }
    const Column pushed = per_h * column(b.normal_mass + l) * (column(b.overlap + l) - dot<D>(n, moved));
    const Column push = column(b.releases + l) > 0.0 ? Column{} : pushed;
    if constexpr (rubs)
    {
      const Vector motion = read_rows<D>(b.motion, l), turn = read_rows<D>(b.turn, l);
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        moved.c[c] += motion.c[c] + turn.c[c];
      const Column away = dot<D>(n, moved), mass = per_h * column(b.isotropic_mass + l);
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        more.c[c] = mass * (away * n.c[c] - moved.c[c]);
    }
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      more.c[c] += push * n.c[c];
    const Column along = dot<D>(n, more), before = dot<D>(n, f), sum = before + along;
    const Column normal = sum > 0.0 ? sum : Column{};
    if constexpr (rubs)
    {
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        f.c[c] = f.c[c] - before * n.c[c] + more.c[c] - along * n.c[c];
      // Where a law returns no number, `part` is none: it is seen in the motion, and ends the run.
      constexpr double least = std::numeric_limits<double>::min();
      const Column limit = column(b.friction + l) * normal;
      Column size = dot<D>(f, f);
      common::take_root(size);
      const Column share = limit / (size < least ? Column{} + least : size);
      const Column one = Column{} + 1.0, part = one < share ? one : share;
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        f.c[c] = normal * n.c[c] + part * f.c[c];
      column(b.sticks + l) = ((size <= limit) & (normal > 0.0)) ? one : Column{};
    }
    else
    {
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        f.c[c] = normal * n.c[c];
      column(b.sticks + l) = Column{};
    }
    write_rows<D>(f, b.force, l);
  }
}

template <int D, int N, bool turns>
IMPACT_CLONES IMPACT_FLATTEN void add_lanes(const ClosedRules& rules, ClosedBatch& b, double* forces, bool last)
{
  const int num = N == any ? rules.num_masters : N;
  for (int l = 0; l < lanes; l += group)
  {
    const Vector f = read_rows<D>(b.force, l);
    Column rows[room<N> + 1][4] = {}; // [0] the slave's node, then those of the facet
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      rows[0][c] = f.c[c];
    for_nodes(num,
              [&](int j)
              {
                const Column phi = column(b.masters[j].phi + l);
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                  rows[j + 1][c] = -phi * f.c[c];
              });
    if constexpr (turns)
    {
      Column r[room<N> * D];
      const auto moments =
          moments_of<D, Column>(num, b, [l](const double* row) -> const LooseColumn& { return column(row + l); }, r);
      moments.template forces<D>(num, r, f.c,
                                 [&](int j, int c, const Column& value)
                                 {
                                   if (last)
                                     column(b.masters[j].correction[c] + l) = value;
                                   rows[j + 1][c] += value;
                                 });
    }
    const int used = std::min(b.num - l, group);
    if constexpr (D == 3)
    {
      common::transpose(rows[0]);
      for_nodes(num, [&](int j) { common::transpose(rows[j + 1]); });
      for (int k = 0; k < used; ++k)
      {
        column(forces + 4 * std::size_t(b.node[l + k])) += rows[0][k];
        for_nodes(num, [&](int j) { column(forces + 4 * std::size_t(b.masters[j].node[l + k])) += rows[j + 1][k]; });
      }
    }
    else
      for (int k = 0; k < used; ++k)
        for (int c = 0; c < D; ++c)
        {
          forces[std::size_t(b.node[l + k]) * D + c] += rows[0][c][k];
          for_nodes(num, [&](int j) { forces[std::size_t(b.masters[j].node[l + k]) * D + c] += rows[j + 1][c][k]; });
        }
  }
}

template <int D, int N, bool turns>
IMPACT_CLONES IMPACT_FLATTEN void measure_lanes(const ClosedRules& rules, const ClosedBatch& b,
                                                const search::MasterNode* nodes, const double* correction,
                                                const double* before, const double* obstacle, ClosedResult& out)
{
  const int num = N == any ? rules.num_masters : N;
  for (int l = 0; l < lanes; l += group)
  {
    const Vector n = read_rows<D>(b.normal, l), f = read_rows<D>(b.force, l), motion = read_rows<D>(b.motion, l),
                 turn = read_rows<D>(b.turn, l);
    Vector moved = gather<D>(correction, b.node + l), last = gather<D>(before, b.node + l), slip;
    Column extra = {}, later_extra = {};
    for_nodes(num,
              [&](int j)
              {
                const Vector now = gather<D>(correction, b.masters[j].node + l),
                             then = gather<D>(before, b.masters[j].node + l);
                const Column phi = column(b.masters[j].phi + l);
                search::MasterColumns master;
                if constexpr (turns)
                  search::read(nodes, b.masters[j].corner + l, master);
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                {
                  moved.c[c] -= phi * now.c[c];
                  last.c[c] -= phi * then.c[c];
                  if constexpr (turns)
                  {
                    const Column half = 0.5 * column(b.masters[j].correction[c] + l);
                    extra += half * then.c[c];
                    later_extra += half * (master.du[c] + now.c[c]);
                  }
                }
              });
    column(out.gap + l) = dot<D>(n, moved) - column(b.overlap + l);
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      moved.c[c] += motion.c[c];
      last.c[c] -= obstacle[c];
      slip.c[c] = moved.c[c] + turn.c[c];
    }
    const Column normal = dot<D>(n, f), along = 0.5 * normal * dot<D>(n, last), later = 0.5 * normal * dot<D>(n, moved),
                 away = dot<D>(n, slip);
    column(out.normal + l) = normal;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      column(out.tangential[c] + l) = f.c[c] - normal * n.c[c];
      column(out.slip[c] + l) = slip.c[c] - away * n.c[c];
    }
    column(out.work + l) = along + extra;
    column(out.later_work + l) = later + later_extra;
    column(out.friction_work + l) = 0.5 * dot<D>(f, last) - along;
    column(out.later_friction_work + l) = 0.5 * dot<D>(f, moved) - later;
  }
}

/// Calls run<D, N>() for the dimension and the number of nodes of a facet.
void with_facets(const ClosedRules& rules, auto&& run)
{
  if (rules.gdim == 2)
    return rules.num_masters == 2 ? run.template operator()<2, 2>() : run.template operator()<2, any>();
  if (rules.num_masters == 4)
    return run.template operator()<3, 4>();
  rules.num_masters == 3 ? run.template operator()<3, 3>() : run.template operator()<3, any>();
}
} // namespace

MomentCorrection ClosedBatch::moments(const ClosedRules& rules, int l, double* r) const
{
  const auto at = [l](const double* row) { return row[l]; };
  return rules.gdim == 2 ? moments_of<2, double>(rules.num_masters, *this, at, r)
                         : moments_of<3, double>(rules.num_masters, *this, at, r);
}

void fill_lanes(const ClosedRules& rules, ClosedBatch& b, ClosedInput& input)
{
  if (b.num == lanes)
    return;
  const auto repeat = [last = b.num - 1](auto* row)
  {
    for (int l = last + 1; l < lanes; ++l)
      row[l] = row[last];
  };
  repeat(b.node);
  for (double* row : {b.releases, b.overlap, input.orientation, input.along_facet, input.xi[0], input.xi[1]})
    repeat(row);
  for (int c = 0; c < 3; ++c)
    for (double* row : {b.normal[c], b.motion[c], input.x[c]})
      repeat(row);
  for (int j = 0; j < rules.num_masters; ++j)
  {
    repeat(b.masters[j].node);
    repeat(b.masters[j].corner);
    repeat(b.masters[j].phi);
  }
}

void read_masters(const ClosedRules& rules, ClosedBatch& b, const ClosedInput& input, const search::MasterNode* nodes)
{
  with_facets(rules,
              [&]<int D, int N>()
              {
                if (!rules.turns)
                  return begin_lanes<D, N, false, false>(rules, b, input, nodes);
                rules.has_friction ? begin_lanes<D, N, true, true>(rules, b, input, nodes)
                                   : begin_lanes<D, N, true, false>(rules, b, input, nodes);
              });
}

void solve_forces(const ClosedRules& rules, ClosedBatch& b, const double* correction, double h, double factor,
                  bool first)
{
  const double per_h = factor / h;
  with_facets(rules,
              [&]<int D, int N>()
              {
                rules.has_friction ? solve_lanes<D, N, true>(rules, b, correction, per_h, first)
                                   : solve_lanes<D, N, false>(rules, b, correction, per_h, first);
              });
}

void add_forces(const ClosedRules& rules, ClosedBatch& b, double* forces, bool last)
{
  with_facets(rules,
              [&]<int D, int N>()
              {
                rules.turns ? add_lanes<D, N, true>(rules, b, forces, last)
                            : add_lanes<D, N, false>(rules, b, forces, last);
              });
}

void measure(const ClosedRules& rules, const ClosedBatch& b, const search::MasterNode* nodes, const double* correction,
             const double* before, const double* obstacle, ClosedResult& result)
{
  with_facets(rules,
              [&]<int D, int N>()
              {
                rules.turns ? measure_lanes<D, N, true>(rules, b, nodes, correction, before, obstacle, result)
                            : measure_lanes<D, N, false>(rules, b, nodes, correction, before, obstacle, result);
              });
}
} // namespace dolfinx_impact::enforcement
