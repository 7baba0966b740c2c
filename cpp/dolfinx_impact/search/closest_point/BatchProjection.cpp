// SPDX-License-Identifier: MIT
#include "BatchProjection.h"
#include "../../common/clones.h"
#include "linear_facet.h"

// Compiled without contraction of multiplications and additions: all instruction sets give the same numbers.
namespace dolfinx_impact::search
{
namespace
{
using surface::FacetShape;

/// What belongs to one lane.
template <FacetShape S>
struct Lane
{
  double X[4][3], point[3], xi[2];
  Lane(const BatchProjection& b, int l) : xi{b.xi[0][l], b.xi[1][l]}
  {
    for (int c = 0; c < linear::dimension<S>; ++c)
    {
      for (int i = 0; i < linear::num_nodes<S>; ++i)
        X[i][c] = b.X[i][c][l];
      point[c] = b.point[c][l];
    }
  }
};

template <FacetShape S>
IMPACT_INLINED void closest(BatchProjection& b, int l)
{
  constexpr int D = linear::dimension<S>;
  Lane<S> lane(b, l);
  if constexpr (S != FacetShape::quadrilateral)
  {
    linear::flat_foot<S>(lane.X, lane.point, lane.xi);
    b.xi[0][l] = lane.xi[0];
    b.xi[1][l] = lane.xi[1];
    b.over[l] = 1.0;
  }
  double x[3], n[3], gap = 0.0, along = 0.0;
  const double squared = linear::place<S>(lane.X, lane.point, lane.xi, x);
  linear::normal<S>(lane.X, lane.xi, b.orientation[l], n);
  for (int c = 0; c < D; ++c)
  {
    gap += (lane.point[c] - x[c]) * n[c];
    along += n[c] * b.slave_normal[c][l];
  }
  b.distance[l] = std::sqrt(squared);
  b.gap[l] = gap;
  for (int c = 0; c < 3; ++c)
    b.normal[c][l] = n[c];
  b.over[l] = linear::inside<S>(lane.xi) & (along < -(b.rotation[l] + right_angle)) ? b.over[l] : 0.0;
}

IMPACT_CLONES void intervals(BatchProjection& b)
{
#pragma omp simd
  for (int l = 0; l < b.num; ++l)
    closest<FacetShape::interval>(b, l);
}

IMPACT_CLONES void triangles(BatchProjection& b)
{
#pragma omp simd
  for (int l = 0; l < b.num; ++l)
    closest<FacetShape::triangle>(b, l);
}

/// A step of Newton's method for a lane that is still going (1, else 0).
IMPACT_INLINED void step_quadrilateral(BatchProjection& b, double* __restrict going, int l)
{
  const Lane<FacetShape::quadrilateral> lane(b, l);
  const linear::Step s = linear::newton_step(lane.X, lane.point, lane.xi);
  const double on = going[l], fine = on * s.fine;
  b.xi[0][l] = lane.xi[0] + on * s.xi[0];
  b.xi[1][l] = lane.xi[1] + on * s.xi[1];
  b.over[l] += fine * s.done;
  going[l] = fine * (1.0 - s.done);
}

IMPACT_CLONES void step_quadrilaterals(BatchProjection& b, double* __restrict going)
{
#pragma omp simd
  for (int l = 0; l < b.num; ++l)
    step_quadrilateral(b, going, l);
}

IMPACT_CLONES void finish_quadrilaterals(BatchProjection& b)
{
#pragma omp simd
  for (int l = 0; l < b.num; ++l)
    closest<FacetShape::quadrilateral>(b, l);
}

void quadrilaterals(BatchProjection& b)
{
  double going[BatchProjection::size];
  std::fill_n(going, b.num, 1.0);
  std::fill_n(b.over, b.num, 0.0);
  for (int step = 0; step < linear::most_steps; ++step)
  {
    step_quadrilaterals(b, going);
    if (std::count(going, going + b.num, 0.0) == b.num)
      break;
  }
  finish_quadrilaterals(b);
}
} // namespace

void project_batch(FacetShape shape, BatchProjection& block)
{
  switch (shape)
  {
  case FacetShape::interval:
    return intervals(block);
  case FacetShape::triangle:
    return triangles(block);
  case FacetShape::quadrilateral:
    return quadrilaterals(block);
  }
}
} // namespace dolfinx_impact::search
