// SPDX-License-Identifier: MIT
#include "SpringBatch.h"
#include "../../common/clones.h"
#include "../../common/columns.h"
#include "../friction.h"
#include "MomentCorrection.h"
#include "overlap.h"
#include <algorithm>
#include <cmath>

// Compiled without contraction of multiplications and additions: all instruction sets give the same numbers.
namespace dolfinx_impact::enforcement
{
namespace
{
#if defined(__GNUC__)
#define IMPACT_LAMBDA __attribute__((always_inline))
#else
#define IMPACT_LAMBDA
#endif

constexpr int any = -1; ///< number of a facet's nodes that is not known to the compiler

/// The spring of one node.
/// @tparam N nodes of a facet, or `any`
/// @tparam rubs is there friction?
/// @tparam turns may forces need a moment correction?
template <int D, int N, bool rubs, bool turns>
IMPACT_INLINED void evaluate_lane(SpringBatch& b, int l)
{
  constexpr int most = N == any ? SpringBatch::most : N;
  const int num = N == any ? b.num_masters : N;
  double n[3] = {}, motion[D], r = 0.0, way_squared = 0.0;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    n[c] = b.normal[c][l];
    motion[c] = b.motion[c][l];
  }
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    r += n[c] * motion[c];
    way_squared += motion[c] * motion[c];
  }
  Spring spring = b.spring(l);
  const double gap = b.gap[l], mean = mean_overlap(gap, r);
  // Nodes that pass outside the master's boundary receive no force.
  const double overlap = (gap >= 0.0) & (b.beside[l] > 0.0) ? 0.0 : mean;
  const bool begins = b.begins[l] > 0.0, oblique = b.oblique[l] > 0.0;
  double change = begins ? r : gap - spring.gap;
  // The nearest facet has changed: no motion of the step explains this change.
  const double most_change = std::copysign(2.0 * std::sqrt(way_squared), change);
  change = change * change > 4.0 * way_squared ? most_change : change;
  b.overlap[l] = overlap;
  b.change[l] = change;

  MomentCorrection correction;
  double arms[most * D];
  if constexpr (turns)
  {
    double x[D], phi[most];
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      x[c] = b.x[c][l];
    for_nodes(num, [&](int j) { phi[j] = b.phi[j][l]; });
    correction.set<D>(num, [&](int j, int c) { return b.X[j][c][l]; }, phi, x, arms);
    // A node that sticks to a facet turns with it: that is no slip.
    if constexpr (rubs)
    {
      double moved[D];
      std::copy_n(motion, D, moved);
      correction.add_rotation<D>(num, arms, [&](int j, int c) { return b.du[j][c][l]; }, moved);
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        motion[c] = (overlap > 0.0) | !begins ? moved[c] : motion[c];
    }
  }
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    b.motion[c][l] = motion[c];

  // Reciprocal of the contact stiffness: slave and master in series.
  const double per_area = b.per_area[l];
  const double last_compliance = spring.compliance;
  const double per_k =
                   b.given > 0.0 ? per_area / b.given : (b.compliance[l] + b.area_compliance[l] * per_area) / b.share,
               k = 1.0 / per_k;
  b.normal_loss[l] = normal_step(spring, k * overlap, k, per_k, gap, change, begins);
  const double normal_force = spring.force;
  double total[D], squared = 0.0;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    total[c] = normal_force * n[c];
  if constexpr (rubs)
  {
    const double part = part_below(gap, r), limit = b.friction * normal_force;
    double t[D], trial[D], turned[D], slip[D], stored = 0.0, along = 0.0;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      t[c] = b.tangential[c][l];
      along += n[c] * motion[c];
    }
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      stored += 0.5 * t[c] * t[c] * last_compliance;
      motion[c] -= along * n[c];
      slip[c] = part * motion[c];
    }
    bool changed = false;
    const bool slips = coulomb<D>(n, k, per_k, limit, t, slip, trial);
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      turned[c] = trial[c] + k * part * motion[c];
    b.friction_loss[l] =
        tangential_step<D>(spring.tangential_surplus, turned, stored, motion, k, per_k, limit, t, changed);
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      const double corrected = part * motion[c] + (t[c] - turned[c]) * per_k;
      b.slip[c][l] = changed ? corrected : slip[c];
      squared += t[c] * t[c];
      total[c] += t[c];
      b.tangential[c][l] = t[c];
    }
    b.sticks[l] = slips | changed ? 0.0 : 1.0;
  }
  if constexpr (turns)
  {
    b.corrected[l] = (squared > 0.0) | oblique ? 1.0 : 0.0;
    correction.forces<D>(num, arms, total, [&](int j, int c, double value) { b.correction[j][c][l] = value; });
  }
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
    b.total[c][l] = total[c];
  b.set_spring(l, spring);
  b.stored[l] = spring.stored() + 0.5 * squared * per_k;
}

using common::Column, common::column;

/// Lanes of a batch are taken four at a time. Those of the last four that are not in use read the last node's facet.
constexpr int lanes = 4;

/// @tparam turns do forces need the positions and the increments of the nodes themselves?
template <int D, bool turns>
IMPACT_CLONES void read_lanes(SpringBatch& b, const search::MasterNode* nodes)
{
  for (int l = 0; l < b.num; l += lanes)
  {
    Column motion[D], own = column(b.compliance + l), by_area = column(b.area_compliance + l);
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      motion[c] = column(b.motion[c] + l);
    for_nodes(b.num_masters,
              [&](int j) IMPACT_LAMBDA
              {
                search::MasterColumns master;
                search::read(nodes, b.corners[j] + l, master);
                const Column phi = column(b.phi[j] + l), weight = phi < 0.0 ? -phi : phi;
                own += weight * master.compliance;
                by_area += weight * master.area_compliance;
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                {
                  motion[c] -= phi * master.du[c];
                  if constexpr (turns)
                  {
                    column(b.X[j][c] + l) = master.x[c];
                    column(b.du[j][c] + l) = master.du[c];
                  }
                }
              });
    column(b.compliance + l) = own;
    column(b.area_compliance + l) = by_area;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      column(b.motion[c] + l) = motion[c];
  }
}

/// @tparam turns are there moment corrections in the batch?
template <int D, bool turns>
IMPACT_CLONES void add_lanes(const SpringBatch& b, NodalSum* sums)
{
  constexpr int most = SpringBatch::most;
  for (int l = 0; l < b.num; l += lanes)
  {
    Column rows[most][4];
    for_nodes(b.num_masters,
              [&](int j) IMPACT_LAMBDA
              {
                const Column phi = column(b.phi[j] + l);
#pragma GCC unroll 4
                for (int c = 0; c < 4; ++c)
                  rows[j][c] = Column{};
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                {
                  rows[j][c] = -phi * column(b.total[c] + l);
                  if constexpr (turns)
                    rows[j][c] =
                        column(b.corrected + l) > 0.0 ? rows[j][c] + column(b.correction[j][c] + l) : rows[j][c];
                }
                common::transpose(rows[j]);
              });
    const int last = std::min(b.num - l, lanes);
    for (int k = 0; k < last; ++k)
      if (b.overlap[l + k] > 0.0)
        for_nodes(b.num_masters,
                  [&](int j) IMPACT_LAMBDA
                  {
                    Column& sum = reinterpret_cast<Column&>(sums[b.corners[j][l + k]]);
                    sum += rows[j][k];
                  });
  }
}

#if defined(__GNUC__)
#define IMPACT_FLATTEN __attribute__((flatten))
#else
#define IMPACT_FLATTEN
#endif

template <int D, int N, bool rubs, bool turns>
IMPACT_CLONES IMPACT_FLATTEN void evaluate_lanes(SpringBatch& b)
{
#pragma omp simd
  for (int l = 0; l < SpringBatch::size; ++l)
    evaluate_lane<D, N, rubs, turns>(b, l);
}

template <int D, int N>
void evaluate_all(SpringBatch& b)
{
  const bool friction = b.friction > 0.0,
             oblique = std::any_of(b.oblique, b.oblique + b.num, [](double o) { return o > 0.0; });
  const bool moments = b.corrects_moments && (friction || oblique);
  if (!moments)
    std::fill_n(b.corrected, b.num, 0.0);
  const auto run = [&b]<bool rubs, bool turns>()
  {
    if constexpr (N == any)
      for (int l = 0; l < b.num; ++l)
        evaluate_lane<D, N, rubs, turns>(b, l);
    else
      evaluate_lanes<D, N, rubs, turns>(b);
  };
  if (friction)
    return moments ? run.template operator()<true, true>() : run.template operator()<true, false>();
  moments ? run.template operator()<false, true>() : run.template operator()<false, false>();
}
} // namespace

void read_masters(SpringBatch& b, const search::MasterNode* nodes)
{
  for (int j = 0; j < b.num_masters; ++j)
    for (int l = b.num; l % lanes != 0; ++l)
      b.corners[j][l] = b.corners[j][b.num - 1];
  const bool turns = b.corrects_moments &&
                     (b.friction > 0.0 || std::any_of(b.oblique, b.oblique + b.num, [](double o) { return o > 0.0; }));
  if (b.gdim == 2)
    return turns ? read_lanes<2, true>(b, nodes) : read_lanes<2, false>(b, nodes);
  turns ? read_lanes<3, true>(b, nodes) : read_lanes<3, false>(b, nodes);
}

void add_reactions(const SpringBatch& b, NodalSum* sums)
{
  const bool turns = std::any_of(b.corrected, b.corrected + b.num, [](double c) { return c > 0.0; });
  if (b.gdim == 2)
    return turns ? add_lanes<2, true>(b, sums) : add_lanes<2, false>(b, sums);
  turns ? add_lanes<3, true>(b, sums) : add_lanes<3, false>(b, sums);
}

void evaluate(SpringBatch& batch)
{
  if (batch.gdim == 2)
    return batch.num_masters == 2 ? evaluate_all<2, 2>(batch) : evaluate_all<2, any>(batch);
  if (batch.num_masters == 4)
    return evaluate_all<3, 4>(batch);
  batch.num_masters == 3 ? evaluate_all<3, 3>(batch) : evaluate_all<3, any>(batch);
}
} // namespace dolfinx_impact::enforcement
