// SPDX-License-Identifier: MIT
#include "penalty.h"
#include "../friction.h"
#include "LawPoints.h"
#include "variation.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Displacement of slave against master since the last converged state, at one point.
void relative_increment(const PenaltyPair& pair, std::size_t q, double* out)
{
  double shape[18];
  const gap::Points& p = pair.points;
  const int num = relative_shape(p, pair.slave, pair.master, q, shape), gdim = p.gdim;
  const int num_slave = pair.slave.displacement.num_nodes();
  const std::int32_t* slave = pair.slave.nodes_of(p.facet[q]);
  const std::int32_t* master = pair.master ? pair.master->nodes_of(p.master[q]) : nullptr;
  for (int c = 0; c < gdim; ++c)
  {
    out[c] = 0.0;
    if (pair.master)
      continue;
    const RigidIncrement& rigid = pair.rigid_increment;
    out[c] = -rigid.displacement[c];
    for (int d = 0; d < gdim; ++d)
      out[c] -= rigid.turn[3 * c + d] * (p.x[q * gdim + d] - rigid.centre[d]);
  }
  for (int i = 0; i < num; ++i)
  {
    const std::int32_t node = i < num_slave ? slave[i] : master[i - num_slave];
    for (int c = 0; c < gdim; ++c)
      out[c] += shape[i] * pair.increment[node * gdim + c];
  }
}

/// The master's increment, differentiated along free parameter r: what D,r gives of it.
void increment_derivative(const PenaltyPair& pair, std::size_t q, const Variation& v, int r, double* out)
{
  const std::int32_t* nodes = pair.master->nodes_of(pair.points.master[q]);
  std::fill_n(out, v.gdim, 0.0);
  for (int i = 0; i < v.num_master; ++i)
    for (int c = 0; c < v.gdim; ++c)
      out[c] += v.shape[1 + r][v.num_slave + i] * pair.increment[nodes[i] * v.gdim + c];
}

/// Pressure, were the contact glued.
double trial_pressure(const PenaltyPair& pair, std::size_t q)
{
  // Layers end where the master does, and what is beside it was not adjusted.
  const double gap = pair.points.gap[q] + (pair.points.beside[q] ? 0.0 : pair.history.offset[q]);
  return pair.history.multiplier[q] - pair.normal_penalty(q) * gap;
}

/// Part of the step's motion that counts for friction: what comes after closing, if pressure and gap go straight from
/// the beginning of the step to its end (docs/contact.md).
/// @param[out] slope its derivative with respect to the pressure
double counted_part(const PenaltyPair& pair, double pressure, std::size_t q, double& slope)
{
  const double before = pair.history.multiplier[q] - pair.normal_penalty(q) * pair.history.gap[q];
  slope = 0.0;
  if (!(pair.history.gap[q] > 0.0) || before >= 0.0)
    return 1.0;
  if (std::isinf(before))
    return 0.0;
  const double whole = pressure - before;
  slope = -before / (whole * whole);
  return pressure / whole;
}

Friction friction_point(const PenaltyPair& pair, const PenaltyState& state, std::size_t q, const double* increment)
{
  const int gdim = pair.points.gdim;
  return {gdim,
          state.pressure[q],
          pair.parameters.friction,
          pair.parameters.tangential * pair.share_of(q),
          pair.points.normal.data() + q * gdim,
          pair.history.traction.data() + q * gdim,
          increment};
}

/// Derivative of the traction with respect to q = (D, D,r): gdim x num.
void traction_derivative(const PenaltyPair& pair, const PenaltyState& state, std::size_t q, const Variation& v,
                         double* dz)
{
  const int gdim = v.gdim, num = v.num;
  const double* n = pair.points.normal.data() + q * gdim;
  double dp[Variation::max_num], dt[3 * Variation::max_num];
  for (int j = 0; j < num; ++j)
    dp[j] = -pair.normal_penalty(q) * v.d_gap[j];
  for (int c = 0; c < gdim; ++c)
    for (int j = 0; j < num; ++j)
      dz[c * num + j] = dp[j] * n[c] + state.pressure[q] * v.d_normal[c * num + j];
  if (!pair.law && !(pair.parameters.friction > 0.0))
    return;
  double increment[3], d_increment[3 * Variation::max_num] = {};
  relative_increment(pair, q, increment);
  for (int c = 0; c < gdim; ++c)
  {
    d_increment[c * num + c] = 1.0;
    if (!pair.master)
      for (int d = 0; d < gdim; ++d)
        d_increment[c * num + d] -= pair.rigid_increment.turn[3 * c + d];
  }
  for (int r = 0; r < v.k; ++r)
  {
    double slope[3];
    increment_derivative(pair, q, v, r, slope);
    for (int c = 0; c < gdim; ++c)
      for (int j = 0; j < num; ++j)
        d_increment[c * num + j] -= slope[c] * v.d_xi[r * num + j];
  }
  if (pair.law)
    return pair.law->traction_derivative(q, v, n, increment, d_increment, dz);
  double slope;
  const double part = counted_part(pair, state.pressure[q], q, slope);
  for (int c = 0; c < gdim; ++c)
  {
    for (int j = 0; j < num; ++j)
      d_increment[c * num + j] = part * d_increment[c * num + j] + slope * dp[j] * increment[c];
    increment[c] *= part;
  }
  const Friction point = friction_point(pair, state, q, increment);
  linearise(point, evaluate(point), num, dp, v.d_normal, d_increment, dt);
  for (int i = 0; i < gdim * num; ++i)
    dz[i] += dt[i];
}

/// Add a point's part to the block of its slave and master facet, block[(a*gdim + c)*size + b*gdim + d].
/// @param convex only what is positive semi-definite
void add_point(const PenaltyPair& pair, const PenaltyState& state, std::size_t q, bool convex, double* block)
{
  const Variation v = vary(pair.points, pair.slave, pair.master, q);
  const int gdim = v.gdim, num = v.num, nodes = v.num_slave + v.num_master, size = nodes * gdim;
  const double* z = state.traction.data() + q * gdim;
  // Virtual work w (D . z): its derivative is w (D . dz - D,r . z dxi_r).
  double B[3 * 3 * Variation::max_num];
  if (convex)
  {
    const double* n = pair.points.normal.data() + q * gdim;
    const double stiffness = pair.law ? std::max(pair.law->stiffness(q), 0.0) : pair.normal_penalty(q);
    for (int i = 0; i < num; ++i)
      for (int j = 0; j < num; ++j)
        B[i * num + j] = i < gdim ? -stiffness * n[i] * v.d_gap[j] : 0.0;
  }
  else
  {
    traction_derivative(pair, state, q, v, B);
    for (int r = 0; r < v.k; ++r)
      for (int c = 0; c < gdim; ++c)
        for (int j = 0; j < num; ++j)
          B[((1 + r) * gdim + c) * num + j] = -z[c] * v.d_xi[r * num + j];
  }
  const double w = pair.points.weight[q];
  for (int b = 0; b < nodes; ++b)
  {
    // C = B with the columns' shape functions at node b.
    double C[3 * 3][3];
    for (int i = 0; i < num; ++i)
      for (int d = 0; d < gdim; ++d)
      {
        C[i][d] = 0.0;
        for (int r = 0; r <= v.k; ++r)
          C[i][d] -= w * B[i * num + r * gdim + d] * v.shape[r][b];
      }
    for (int a = 0; a < nodes; ++a)
      for (int r = 0; r <= (a < v.num_slave ? 0 : v.k); ++r)
        for (int c = 0; c < gdim; ++c)
          for (int d = 0; d < gdim; ++d)
            block[(a * gdim + c) * size + b * gdim + d] += v.shape[r][a] * C[r * gdim + c][d];
  }
}

void check(const PenaltyPair& pair)
{
  const gap::Points& p = pair.points;
  const std::size_t num = p.size();
  if (pair.history.multiplier.size() != num || pair.history.traction.size() != num * p.gdim ||
      pair.history.slip.size() != num * p.gdim || pair.history.gap.size() != num || pair.history.offset.size() != num ||
      (!pair.share.empty() && pair.share.size() != num))
    throw std::invalid_argument("the history belongs to other points");
  if (p.gdim != pair.slave.gdim || num != p.per_facet * pair.slave.size())
    throw std::invalid_argument("the points belong to another slave");
  for (std::size_t q = 0; q < num && pair.master; ++q)
    if (p.gdim != pair.master->gdim || p.master[q] >= std::int32_t(pair.master->size()) ||
        (p.master[q] < 0 && p.status[q] != search::ProjectionStatus::outside))
      throw std::invalid_argument("these points were updated for another master");
  if (!(pair.parameters.normal > 0.0) || !(pair.parameters.friction >= 0.0))
    throw std::invalid_argument("a penalty is positive, a friction coefficient not negative");
  if (!pair.master && p.hessian.size() != num * p.gdim * p.gdim)
    throw std::invalid_argument("these points were not updated for a rigid master");
  if (pair.parameters.friction > 0.0 && !(pair.parameters.tangential > 0.0))
    throw std::invalid_argument("friction needs a positive tangential penalty");
  std::int32_t last = -1;
  for (const surface::Facets* side : {&pair.slave, pair.master})
    if (side && (pair.law || pair.parameters.friction > 0.0))
      for (std::int32_t node : side->nodes)
        last = std::max(last, node);
  if (std::size_t(last + 1) * p.gdim > pair.increment.size())
    throw std::invalid_argument("friction needs the increments of displacement of all nodes");
}
} // namespace

PenaltyHistory make_history(const gap::Points& points)
{
  const std::size_t num = points.size() * points.gdim;
  return {std::vector<double>(points.size(), 0.0), std::vector<double>(num, 0.0),
          std::vector<double>(num, 0.0),           std::vector<double>(points.size(), 0.0),
          std::vector<double>(points.size(), 0.0), std::vector<double>(points.size(), 0.0)};
}

PenaltyState stretched(const PenaltyPair& pair, const PenaltyState& state)
{
  PenaltyState out = state;
  const int gdim = pair.points.gdim;
  for (std::size_t q = 0; q < pair.points.size(); ++q)
    for (int c = 0; c < gdim; ++c)
      out.traction[q * gdim + c] = state.status[q] == ContactStatus::open
                                       ? 0.0
                                       : std::min(trial_pressure(pair, q), 0.0) * pair.points.normal[q * gdim + c];
  return out;
}

std::vector<double> relative_increments(const PenaltyPair& pair)
{
  check(pair);
  const std::size_t gdim = pair.points.gdim;
  std::vector<double> out(pair.points.size() * gdim, 0.0);
  for (std::size_t q = 0; q < pair.points.size(); ++q)
    if (std::isfinite(pair.points.gap[q]))
      relative_increment(pair, q, out.data() + q * gdim);
  return out;
}

namespace
{
/// The points' state by a law of the interface.
PenaltyState evaluate_law(const PenaltyPair& pair)
{
  const gap::Points& p = pair.points;
  const int gdim = p.gdim;
  PenaltyState out{std::vector<ContactStatus>(p.size(), ContactStatus::open), std::vector<double>(p.size(), 0.0),
                   std::vector<double>(p.size() * gdim, 0.0), std::vector<double>(p.size() * gdim, 0.0),
                   std::vector<double>(p.size() * gdim, 0.0)};
  for (std::size_t q = 0; q < p.size(); ++q)
  {
    const double* shear = pair.law->shear(q);
    if (!shear) // beyond the law's reach a point forgets its slip
      continue;
    out.status[q] = pair.law->status(q);
    out.pressure[q] = pair.law->pressure(q);
    std::copy_n(pair.law->slip(q), gdim, out.slip.data() + q * gdim);
    std::copy_n(shear, gdim, out.tangential.data() + q * gdim);
    for (int c = 0; c < gdim; ++c)
      out.traction[q * gdim + c] = out.pressure[q] * p.normal[q * gdim + c] + shear[c];
  }
  return out;
}
} // namespace

PenaltyState evaluate(const PenaltyPair& pair)
{
  check(pair);
  if (pair.law)
    return evaluate_law(pair);
  const gap::Points& p = pair.points;
  const int gdim = p.gdim;
  PenaltyState out{std::vector<ContactStatus>(p.size(), ContactStatus::open), std::vector<double>(p.size(), 0.0),
                   std::vector<double>(p.size() * gdim, 0.0), std::vector<double>(p.size() * gdim, 0.0),
                   pair.history.slip};
  for (std::size_t q = 0; q < p.size(); ++q)
  {
    const double trial = trial_pressure(pair, q);
    if (!(trial > -pair.parameters.touch * pair.share_of(q)))
    {
      std::fill_n(out.slip.data() + q * gdim, gdim, 0.0); // an open point forgets
      continue;
    }
    const double pressure = std::max(trial, 0.0);
    out.pressure[q] = pressure;
    out.status[q] = ContactStatus::slip;
    if (pair.parameters.friction > 0.0)
    {
      double increment[3], unused;
      relative_increment(pair, q, increment);
      const double part = counted_part(pair, pressure, q, unused);
      for (int c = 0; c < gdim; ++c)
        increment[c] *= part;
      const FrictionResult result = evaluate(friction_point(pair, out, q, increment));
      out.status[q] = result.slips ? ContactStatus::slip : ContactStatus::stick;
      std::copy_n(result.traction, gdim, out.tangential.data() + q * gdim);
      for (int c = 0; c < gdim; ++c)
        out.slip[q * gdim + c] += result.slip[c];
    }
    for (int c = 0; c < gdim; ++c)
      out.traction[q * gdim + c] = pressure * p.normal[q * gdim + c] + out.tangential[q * gdim + c];
  }
  return out;
}

double energy(const PenaltyPair& pair, const PenaltyState& state)
{
  double sum = 0.0;
  for (std::size_t q = 0; q < pair.points.size(); ++q)
    sum += pair.points.weight[q] * state.pressure[q] * state.pressure[q] / pair.share_of(q);
  return sum / (2.0 * pair.parameters.normal);
}

void add_force(const PenaltyPair& pair, const PenaltyState& state, std::span<double> force)
{
  const gap::Points& p = pair.points;
  const int gdim = p.gdim, num_slave = pair.slave.displacement.num_nodes();
  for (std::size_t q = 0; q < p.size(); ++q)
  {
    if (state.status[q] == ContactStatus::open)
      continue;
    double shape[18];
    const int num = relative_shape(p, pair.slave, pair.master, q, shape);
    for (int i = 0; i < num; ++i)
    {
      const std::int32_t node =
          i < num_slave ? pair.slave.nodes_of(p.facet[q])[i] : pair.master->nodes_of(p.master[q])[i - num_slave];
      for (int c = 0; c < gdim; ++c)
        force[node * gdim + c] += p.weight[q] * shape[i] * state.traction[q * gdim + c];
    }
  }
}

int coupled_nodes(const PenaltyPair& pair, std::size_t q, std::int32_t* nodes)
{
  const int num_slave = pair.slave.displacement.num_nodes();
  std::copy_n(pair.slave.nodes_of(pair.points.facet[q]), num_slave, nodes);
  if (!pair.master)
    return num_slave;
  std::copy_n(pair.master->nodes_of(pair.points.master[q]), pair.master->displacement.num_nodes(), nodes + num_slave);
  return num_slave + pair.master->displacement.num_nodes();
}

void tangent(const PenaltyPair& pair, const PenaltyState& state, bool convex, const InsertBlock& insert)
{
  const gap::Points& p = pair.points;
  const auto together = [&](std::size_t a, std::size_t b)
  { return state.status[a] != ContactStatus::open && p.master[a] == p.master[b]; };
  double block[18 * 3 * 18 * 3];
  std::int32_t nodes[18];
  for (std::size_t first = 0; first < p.size(); first += p.per_facet)
    for (std::size_t q = first; q < first + p.per_facet; ++q)
    {
      // One block per pair of facets: the first of its points adds up all of them.
      bool done = state.status[q] == ContactStatus::open;
      for (std::size_t earlier = first; earlier < q && !done; ++earlier)
        done = together(earlier, q);
      if (done)
        continue;
      const std::size_t num = coupled_nodes(pair, q, nodes), size = num * num * p.gdim * p.gdim;
      std::fill_n(block, size, 0.0);
      for (std::size_t other = q; other < first + p.per_facet; ++other)
        if (together(other, q))
          add_point(pair, state, other, convex, block);
      insert({nodes, num}, {block, size});
    }
}

void advance(const PenaltyState& state, PenaltyHistory& history)
{
  history.traction = state.tangential;
  history.slip = state.slip;
}
} // namespace dolfinx_impact::enforcement
