// SPDX-License-Identifier: MIT
#include "FrictionProblem.h"
#include "../common/vectors.h"
#include "../solve/dense.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::rolling
{
namespace
{
constexpr double still = 1e-12;  ///< error of the equations, over the largest force, at which they are solved
constexpr double nearly = 1e-10; ///< and this one, where round-off lets it not become smaller
constexpr int iterations = 25;   ///< of Levenberg and Marquardt's method, from one start
// What slip velocities count in the trial tractions, over what makes them as large as changes of traction: more of them
// keep the status of a solution that is nearly right, fewer find one from afar.
constexpr double keeping = 10.0, finding[] = {1.0, 0.1};
/// Weights of the splitting method, over the norm of the compliance of velocities, and numbers of its iterations.
constexpr double splitting[] = {1e5, 1e4, 1e6, 1e3};
constexpr int splittings[] = {200, 2000};
constexpr double least_decrease = 1e-4;
constexpr double first_damping = 1e-6, least_damping = 1e-13;

/// F_i J_ij F_j^T of all pairs of nodes.
std::vector<double> turned(std::span<const double> J, std::span<const double> frames, std::size_t n, std::size_t g)
{
  std::vector<double> out(J.size());
  const std::size_t row = n * g;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
    {
      double half[9];
      for (std::size_t a = 0; a < g; ++a)
        for (std::size_t c = 0; c < g; ++c)
        {
          half[a * g + c] = 0.0;
          for (std::size_t b = 0; b < g; ++b)
            half[a * g + c] += frames[(i * g + a) * g + b] * J[(i * g + b) * row + j * g + c];
        }
      for (std::size_t a = 0; a < g; ++a)
        for (std::size_t d = 0; d < g; ++d)
          out[(i * g + a) * row + j * g + d] = dot(&half[a * g], &frames[(j * g + d) * g], int(g));
    }
  return out;
}

/// Solution of A x = b, damped; nothing where the matrix is singular.
/// @param[in] A entries [i*n + j]
std::optional<std::vector<double>> damped_step(const std::vector<double>& A, std::vector<double> b, double damping)
{
  const int n = int(b.size());
  if (n == 0) // nothing touches
    return b;
  std::vector<double> columns(A.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      columns[std::size_t(j) * n + i] = A[std::size_t(i) * n + j];
  if (damping == 0.0)
    return solve::solve_dense(std::move(columns), std::move(b));
  std::vector<double> normal = solve::normal_matrix(A, n);
  double trace = 0.0;
  for (int i = 0; i < n; ++i)
    trace += normal[std::size_t(i) * n + i];
  for (int i = 0; i < n; ++i)
    normal[std::size_t(i) * n + i] += damping * trace / n;
  return solve::solve_dense(std::move(normal), solve::dense_product(columns, b, n));
}
} // namespace

LinearState LinearState::plus(double factor, const LinearState& other) const
{
  LinearState out(*this);
  for (std::size_t i = 0; i < gap.size(); ++i)
    out.gap[i] += factor * other.gap[i];
  for (std::size_t k = 0; k < slip.size(); ++k)
    out.slip[k] += factor * other.slip[k];
  return out;
}

double FrictionProblem::Equations::size() const
{
  double out = 0.0;
  for (double e : error)
    out += e * e;
  return out;
}

bool FrictionProblem::Equations::solved(double tolerance) const
{
  return common::largest_modulus(error) <= tolerance * common::largest_modulus(forces);
}

FrictionProblem::FrictionProblem(CandidateNodes nodes, const Compliance& compliance)
    : _nodes(std::move(nodes)), _num(_nodes.friction.size()), _normal_stiffness(_num), _resistance(_num)
{
  const std::size_t g = _nodes.gdim, row = _num * g;
  const std::vector<double> jump = turned(compliance.jump, _nodes.frames, _num, g);
  const std::vector<double> velocity = turned(compliance.velocity, _nodes.frames, _num, g);
  const auto own = [&](const std::vector<double>& J, std::size_t i, std::size_t a)
  { return std::abs(J[(i * g + a) * row + i * g + a]); };
  double sum = 0.0, typical = 1.0, fastest = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < _num; ++i)
    for (std::size_t a = 0; a < g; ++a)
      if (free(i, int(a)))
      {
        sum += own(jump, i, a);
        ++count;
      }
  if (count > 0)
    typical = sum / double(count);
  std::vector<double> softness(_num, 0.0);
  for (std::size_t i = 0; i < _num; ++i)
  {
    const double along = own(jump, i, 0);
    _normal_stiffness[i] = 1.0 / (free(i, 0) && along > 0.0 ? along : typical);
    double drift = 0.0;
    for (std::size_t a = 1; a < g; ++a)
    {
      const double across = own(jump, i, a);
      softness[i] += (across > 0.0 ? across : typical) / double(g - 1);
      drift = std::max(drift, own(velocity, i, a));
    }
    fastest = std::max(fastest, drift / softness[i]);
  }
  for (std::size_t i = 0; i < _num; ++i)
  {
    _resistance[i] = 1.0 / (softness[i] * (fastest > 0.0 ? fastest : 1.0));
    _gaps.insert(_gaps.end(), jump.begin() + i * g * row, jump.begin() + (i * g + 1) * row);
    _slips.insert(_slips.end(), velocity.begin() + (i * g + 1) * row, velocity.begin() + (i + 1) * g * row);
  }
}

std::vector<double> FrictionProblem::in_frames(std::span<const double> vectors) const
{
  const std::size_t g = _nodes.gdim;
  std::vector<double> out(vectors.size());
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = dot(&_nodes.frames[k * g], &vectors[k / g * g], int(g));
  return out;
}

std::vector<double> FrictionProblem::in_axes(std::span<const double> vectors) const
{
  const std::size_t g = _nodes.gdim;
  std::vector<double> out(vectors.size(), 0.0);
  for (std::size_t k = 0; k < out.size(); ++k)
    for (std::size_t c = 0; c < g; ++c)
      out[k / g * g + c] += _nodes.frames[k * g + c] * vectors[k];
  return out;
}

FrictionProblem::Solution FrictionProblem::solve(const LinearState& state, std::span<const double> start) const
{
  const LinearState base{in_frames(state.forces), state.gap, in_frames(state.slip)};
  std::vector<double> found = start.empty() ? base.forces : in_frames(start);
  bool done = newton(base, found, keeping);
  for (int count : splittings)
    for (double weight : splitting)
    {
      if (done)
        break;
      const std::vector<double> rough = split(base, found, weight, count);
      for (double caution : finding)
        if (!done)
        {
          found = rough;
          done = newton(base, found, caution);
        }
    }
  return {in_axes(found), done ? "" : "tractions that obey friction were not found"};
}

/// Coefficients of friction of all nodes.
/// @param[in] pressure normal forces [F]
/// @param[in] slip velocities in the frames, [i*(gdim - 1) + t]
FrictionProblem::Friction FrictionProblem::friction(std::span<const double> pressure,
                                                    std::span<const double> slip) const
{
  const std::size_t g = _nodes.gdim, t = g - 1;
  Friction out{_nodes.friction, std::vector<double>(_num, 0.0), std::vector<double>(_num * t, 0.0)};
  enforcement::FrictionCoefficients found;
  for (const CandidateLaw& law : _nodes.laws)
  {
    enforcement::FrictionPoints points = law.points;
    for (std::size_t q = 0; q < law.nodes.size(); ++q)
    {
      const std::size_t i = law.nodes[q];
      points.pressure[q] = law.areas[q] > 0.0 ? pressure[i] / law.areas[q] : 0.0;
      for (std::size_t c = 0; c < g; ++c)
      {
        points.slip_rate[q * g + c] = 0.0;
        for (std::size_t a = 0; a < t; ++a)
          points.slip_rate[q * g + c] += _nodes.frames[(i * g + 1 + a) * g + c] * slip[i * t + a];
      }
    }
    law.law->evaluate(points, found);
    for (std::size_t q = 0; q < law.nodes.size(); ++q)
    {
      const std::size_t i = law.nodes[q];
      out.value[i] = found.value[q];
      if (!found.by_pressure.empty() && law.areas[q] > 0.0)
        out.by_force[i] = found.by_pressure[q] / law.areas[q];
      for (std::size_t a = 0; a < t && !found.by_slip_rate.empty(); ++a)
        out.by_slip[i * t + a] = dot(&_nodes.frames[(i * g + 1 + a) * g], &found.by_slip_rate[q * g], int(g));
    }
  }
  return out;
}

/// Equations of all nodes; `base` is in frames, `caution` as keeping and finding.
FrictionProblem::Equations FrictionProblem::equations(const LinearState& base, std::vector<double> forces,
                                                      double caution) const
{
  const std::size_t g = _nodes.gdim, t = g - 1;
  std::vector<double> change(forces);
  for (std::size_t k = 0; k < change.size(); ++k)
    change[k] -= base.forces[k];
  const std::vector<double> gaps = solve::dense_product(_gaps, change, int(_num));
  const std::vector<double> slips = solve::dense_product(_slips, change, int(_num * t));
  Equations out{std::move(forces),
                {},
                std::vector<std::int8_t>(_num, 0),
                std::vector<std::int8_t>(_num, 0),
                std::vector<double>(_num * t, 0.0),
                std::vector<double>(_num, 1.0),
                std::vector<double>(_num, 0.0),
                std::vector<double>(_num * t, 0.0)};
  out.error = out.forces;
  std::vector<double> pressures(_num, 0.0), velocity(_num * t, 0.0);
  for (std::size_t i = 0; i < _num; ++i)
  {
    if (free(i, 0))
      pressures[i] = std::max(0.0, out.forces[i * g] - _normal_stiffness[i] * (base.gap[i] + gaps[i]));
    for (std::size_t a = 0; a < t; ++a)
      velocity[i * t + a] = base.slip[i * g + 1 + a] + slips[i * t + a];
  }
  const Friction friction = this->friction(pressures, velocity);
  for (std::size_t i = 0; i < _num; ++i)
  {
    const double pressure = pressures[i];
    if (!(pressure > 0.0))
      continue;
    out.limit_by_force[i] = friction.value[i] + pressure * friction.by_force[i];
    for (std::size_t a = 0; a < t; ++a)
      out.limit_by_slip[i * t + a] = pressure * friction.by_slip[i * t + a];
    out.active[i] = 1;
    double* trial = &out.direction[i * t];
    for (std::size_t a = 0; a < t; ++a)
      if (free(i, int(a) + 1))
        trial[a] = out.forces[i * g + 1 + a] - caution * _resistance[i] * velocity[i * t + a];
    const double size = std::sqrt(dot(trial, trial, int(t))), limit = friction.value[i] * pressure;
    out.sliding[i] = size > limit;
    out.kappa[i] = out.sliding[i] ? limit / size : 1.0;
    out.error[i * g] -= pressure;
    for (std::size_t a = 0; a < t; ++a)
    {
      out.error[i * g + 1 + a] -= out.kappa[i] * trial[a];
      trial[a] /= size > 0.0 ? size : 1.0;
    }
  }
  return out;
}

/// Method of Levenberg and Marquardt, without damping where it is not needed.
/// @param[in,out] forces where it starts and ends
/// @returns whether they solve the equations
bool FrictionProblem::newton(const LinearState& base, std::vector<double>& forces, double caution) const
{
  const std::size_t g = _nodes.gdim;
  Equations here = equations(base, forces, caution);
  double damping = 0.0;
  for (int iteration = 0; iteration < iterations; ++iteration)
  {
    if (here.solved(still))
      break;
    std::vector<int> on;
    std::vector<double> closed(here.forces);
    for (std::size_t i = 0; i < _num; ++i)
      if (here.active[i])
        on.push_back(int(i));
      else
        std::fill_n(&closed[i * g], g, 0.0);
    const std::vector<double> matrix = derivative(here, on, caution);
    const Equations at = equations(base, closed, caution);
    std::vector<double> right;
    for (int i : on)
      for (std::size_t a = 0; a < g; ++a)
        right.push_back(-at.error[i * g + a]);
    std::optional<Equations> better;
    while (!better && damping < 1.0)
    {
      if (const auto step = damped_step(matrix, right, damping))
      {
        std::vector<double> trial(closed);
        for (std::size_t k = 0; k < on.size(); ++k)
          for (std::size_t a = 0; a < g; ++a)
            trial[on[k] * g + a] += (*step)[k * g + a];
        Equations found = equations(base, std::move(trial), caution);
        if (found.size() <= (1.0 - least_decrease) * here.size())
          better = std::move(found);
      }
      if (!better)
        damping = std::max(10.0 * damping, first_damping);
    }
    if (!better)
      break;
    here = std::move(*better);
    damping = damping > least_damping ? damping * 0.1 : 0.0;
  }
  forces = here.forces;
  return here.solved(nearly);
}

/// Derivative of the errors of the active nodes by their forces, entries [i*m*gdim + j].
/// @param[in] on the m active nodes
std::vector<double> FrictionProblem::derivative(const Equations& at, std::span<const int> on, double caution) const
{
  const std::size_t g = _nodes.gdim, t = g - 1, m = on.size(), columns = m * g, row = _num * g;
  std::vector<double> out(columns * columns, 0.0);
  for (std::size_t k = 0; k < m; ++k)
  {
    const std::size_t i = on[k];
    const double* direction = &at.direction[i * t];
    for (std::size_t l = 0; l < m; ++l)
      for (std::size_t b = 0; b < g; ++b)
      {
        const std::size_t column = l * g + b, from = std::size_t(on[l]) * g + b;
        const double by_gap = _normal_stiffness[i] * _gaps[i * row + from];
        double trial[2] = {};
        for (std::size_t a = 0; a < t; ++a)
          if (free(i, int(a) + 1))
            trial[a] = double(k == l && b == a + 1) - caution * _resistance[i] * _slips[(i * t + a) * row + from];
        out[k * g * columns + column] = by_gap;
        const double along = dot(direction, trial, int(t)), pressure = double(k == l && b == 0) - by_gap;
        double limit = at.limit_by_force[i] * pressure;
        for (std::size_t a = 0; a < t; ++a)
          limit += at.limit_by_slip[i * t + a] * _slips[(i * t + a) * row + from];
        for (std::size_t a = 0; a < t; ++a)
        {
          const double limited =
              at.sliding[i] ? at.kappa[i] * (trial[a] - direction[a] * along) + direction[a] * limit : trial[a];
          out[(k * g + 1 + a) * columns + column] = double(k == l && b == a + 1) - limited;
        }
      }
  }
  return out;
}

/// Tractions after some iterations of the splitting method, with the pressures as they are.
std::vector<double> FrictionProblem::split(const LinearState& base, std::span<const double> forces, double weight,
                                           int count) const
{
  const std::size_t g = _nodes.gdim, t = g - 1, row = _num * g;
  std::vector<double> without(forces.size(), 0.0), limit(_num, 0.0);
  std::vector<std::size_t> used; // tangential unknowns, i*t + a
  for (std::size_t i = 0; i < _num; ++i)
  {
    const double pressed = free(i, 0) ? std::max(forces[i * g], 0.0) : 0.0;
    without[i * g] = pressed;
    for (std::size_t a = 0; a < t; ++a)
      if (pressed > 0.0 && free(i, int(a) + 1))
        used.push_back(i * t + a);
  }
  const auto place = [&](std::size_t unknown) { return unknown / t * g + 1 + unknown % t; };
  std::vector<double> change(without);
  for (std::size_t k = 0; k < change.size(); ++k)
    change[k] -= base.forces[k];
  const std::vector<double> slips = solve::dense_product(_slips, change, int(_num * t));
  std::vector<double> from(common::copy_of(forces)), pressures(_num), velocity;
  for (std::size_t k = 0; k < from.size(); ++k)
    from[k] -= base.forces[k];
  velocity = solve::dense_product(_slips, from, int(_num * t));
  for (std::size_t i = 0; i < _num; ++i)
  {
    pressures[i] = without[i * g];
    for (std::size_t a = 0; a < t; ++a)
      velocity[i * t + a] += base.slip[i * g + 1 + a];
  }
  const std::vector<double> coefficients = friction(pressures, velocity).value;
  for (std::size_t i = 0; i < _num; ++i)
    limit[i] = coefficients[i] * pressures[i];
  const int n = int(used.size());
  std::vector<double> A(std::size_t(n) * n), slip(n), z(n);
  for (int i = 0; i < n; ++i)
  {
    slip[i] = base.slip[place(used[i])] + slips[used[i]];
    z[i] = forces[place(used[i])];
    for (int j = 0; j < n; ++j)
      A[std::size_t(i) * n + j] = _slips[used[i] * row + place(used[j])];
  }
  const double size = solve::spectral_norm(A, n);
  if (size == 0.0)
    return common::copy_of(forces);
  weight /= size;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      A[std::size_t(i) * n + j] = weight * A[std::size_t(i) * n + j] + double(i == j);
  const std::optional<std::vector<double>> resolvent = solve::inverse(std::move(A), n);
  if (!resolvent)
    return common::copy_of(forces);
  std::vector<double> out(_num * t, 0.0), right(n);
  for (int iteration = 0; iteration < count; ++iteration)
  {
    for (int i = 0; i < n; ++i)
      right[i] = z[i] - weight * slip[i];
    const std::vector<double> x = solve::dense_product(*resolvent, right, n);
    for (int i = 0; i < n; ++i)
      out[used[i]] = 2.0 * x[i] - z[i];
    for (std::size_t i = 0; i < _num; ++i)
    {
      const double length = std::sqrt(dot(&out[i * t], &out[i * t], int(t)));
      for (std::size_t a = 0; a < t; ++a)
        out[i * t + a] *= std::min(1.0, limit[i] / (length > 0.0 ? length : 1.0));
    }
    for (int i = 0; i < n; ++i)
      z[i] += out[used[i]] - x[i];
  }
  for (std::size_t k = 0; k < out.size(); ++k)
    without[place(k)] = out[k];
  return without;
}
} // namespace dolfinx_impact::rolling
