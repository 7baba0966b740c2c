// SPDX-License-Identifier: MIT
#include "Newton.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../operators/petsc_check.h"
#include "LinearisedActiveSet.h"
#include "equilibrium.h"
#include "rigid_supports.h"
#include "unconstrained_modes.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <dolfinx/mesh/utils.h>
#include <limits>
#include <numeric>
#include <stdexcept>

using dolfinx_impact::common::joined;
using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::solve
{
namespace
{
constexpr double loose_digits = 1e-3; // relative tolerance of linear solutions while the active set changes
// The same with springs and factors, which give a digit for one solution more: with 1e-3 friction of springs takes 16
// iterations in the place of 6 (Cattaneo and Mindlin's cylinder, 40 facets in contact), and more time.
constexpr double digits_of_springs = 1e-4;
constexpr int plain_iterations = 6; // without a line search
constexpr int plain_inelastic = 2;  // those with internal variables and without multipliers
// Round-off over the largest force at which displacements are those of a body that has flown away.
constexpr double far = 1e-6;
// Order of convergence that the accuracy of a linear solution counts on: the second of Newton's method, the first where
// the tangent of multiplier forces is left to the next iteration (EquilibriumProblem::exact_tangent), so that residuals
// fall by about the same factor every time.
constexpr double order_of_newton = 2.0, order_with_iterations = 1.0;
constexpr double parts[] = {1.0, 0.5, 0.25, 0.125, 0.0625}; // fractions of a step that a line search tries
constexpr int searches = 8;                                 // evaluations of a line search
constexpr double steep_end = 0.5;                           // slope at its end relative to that at its start

// Nodes of the predicted active set overlap by more than this part of the largest overlap, were the bodies rigid. Round
// bodies touch where undeformed gaps are less than a part of their approach: a half in space (Hertz); in the plane the
// part is 1/(2 log(2 d/a)) with d the depth of the bodies and a the half-width of contact (Johnson, Contact mechanics,
// 1985, 5.6), a fifth where d is ten times a. In space some more nodes are closed than Hertz's: to a multigrid
// hierarchy nodes that open later cost less than nodes that close. A prediction costs or saves time; the solution does
// not depend on it.
constexpr double overlap_in_space = 0.42;
constexpr double overlap_in_plane = 0.8;

/// Adds the time that it lives to a sum.
class Clock
{
public:
  explicit Clock(double& sum) : _sum(sum), _start(std::chrono::steady_clock::now()) {}
  ~Clock() { _sum += std::chrono::duration<double>(std::chrono::steady_clock::now() - _start).count(); }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

private:
  double& _sum;
  std::chrono::steady_clock::time_point _start;
};

/// Sum of the products of matrices with values, owned; keeps its vectors as long as it lives.
class MatrixProduct
{
public:
  explicit MatrixProduct(std::span<const Mat> matrices) : _matrices(matrices)
  {
    check(MatCreateVecs(matrices.front(), &_x, &_y), "vectors are made");
  }
  ~MatrixProduct()
  {
    VecDestroy(&_x);
    VecDestroy(&_y);
  }
  MatrixProduct(const MatrixProduct&) = delete;
  MatrixProduct& operator=(const MatrixProduct&) = delete;

  /// Collective.
  std::vector<double> operator()(std::span<const double> values) const
  {
    {
      Entries entries(_x);
      std::ranges::copy(values, &entries[0]);
    }
    check(MatMult(_matrices.front(), _x, _y), "a matrix is multiplied");
    for (Mat matrix : _matrices.subspan(1))
      check(MatMultAdd(matrix, _x, _y, _y), "a matrix is multiplied");
    return operators::values_of(_y);
  }

private:
  std::span<const Mat> _matrices;
  Vec _x = nullptr, _y = nullptr;
};

std::vector<double> diagonal_of(Mat K)
{
  Vec diagonal = nullptr;
  check(MatCreateVecs(K, nullptr, &diagonal), "a vector is made");
  check(MatGetDiagonal(K, diagonal), "a diagonal is read");
  std::vector<double> out = operators::values_of(diagonal);
  check(VecDestroy(&diagonal), "a vector is destroyed");
  return out;
}

void subtract(std::vector<double>& from, std::span<const double> values)
{
  for (std::size_t i = 0; i < values.size(); ++i)
    from[i] -= values[i];
}

void add(std::vector<double>& to, std::span<const double> values)
{
  for (std::size_t i = 0; i < values.size(); ++i)
    to[i] += values[i];
}
} // namespace

NewtonOptions NewtonOptions::with_database(const std::string& prefix) const
{
  NewtonOptions out = *this;
  PetscInt most = max_changes;
  PetscBool by_responses = responses ? PETSC_TRUE : PETSC_FALSE;
  check(PetscOptionsGetReal(nullptr, prefix.c_str(), "-contact_tolerance", &out.violation, nullptr),
        "options are read");
  check(PetscOptionsGetInt(nullptr, prefix.c_str(), "-contact_max_updates", &most, nullptr), "options are read");
  check(PetscOptionsGetBool(nullptr, prefix.c_str(), "-contact_responses", &by_responses, nullptr), "options are read");
  if (!(out.violation > 0.0) || most < 1)
    throw std::invalid_argument("the options contact_tolerance and contact_max_updates of " + prefix +
                                " are positive numbers, not " + common::text("%g", out.violation) + " and " +
                                std::to_string(int(most)));
  out.max_changes = int(most);
  out.responses = by_responses == PETSC_TRUE;
  return out;
}

Newton::Newton(std::shared_ptr<const EquilibriumProblem> problem, NewtonOptions options, NewtonEvents told)
    : events(std::move(told)), _problem(std::move(problem)), _options(options), _comm(_problem->comm()),
      _num_owned(_problem->num_owned()), _gdim(_problem->space().mesh()->geometry().dim()),
      _saddle(_problem->keeps_multipliers), _inelastic(_problem->body->properties().inelastic)
{
  for (std::size_t i = 0; i < _num_owned; ++i)
    if (_problem->fixed[i])
      _prescribed.push_back(std::int32_t(i));
  bool friction = false;
  for (const auto& contact : _problem->contacts)
  {
    _contacts.push_back(contact.get());
    friction = friction || contact->has_friction();
    if (contact->has_multipliers())
      _multipliers.push_back(dynamic_cast<enforcement::MultiplierContact*>(contact.get()));
  }
  // Perfect plasticity near collapse: the tangents of two iterations may be far apart. The body's residual is the
  // gradient of the increment's energy, or nearly so (recovery of the back stress, finite strain).
  const bool search = _inelastic && _multipliers.empty();
  _plain = search ? plain_inelastic : plain_iterations;
  for (const enforcement::StaticContact* contact : _contacts)
    if (contact->needs_line_search())
      _plain = 0;
  // Contact by penalty has kinks where points close, slip or change facets; there is no active set for them.
  _rough = (!_contacts.empty() && _multipliers.empty()) || search;
  _conservative = _rough && !friction;
  _margin = _problem->linear_solver->direct() ? 1e-3 : 0.3; // with factors, accuracy is cheap
  if (!_problem->fields.empty())
    _fields.emplace(_comm, _problem->fields, _problem->fixed);
  if (_saddle)
  {
    std::vector<std::size_t> sizes;
    for (const enforcement::MultiplierContact* contact : _multipliers)
      sizes.push_back(contact->nodes().size());
    _rows = std::make_unique<enforcement::SaddlePoint>(_comm, _num_owned, _gdim, sizes);
    _forces.assign(_gdim * std::accumulate(sizes.begin(), sizes.end(), std::size_t(0)), 0.0);
  }
}

void Newton::log(const std::string& text) const
{
  if (events.log)
    events.log(text);
}

Increment Newton::run(std::span<const double> target)
{
  const EquilibriumProblem& p = *_problem;
  Body& body = *p.body;
  Increment result;
  // Forces that residuals are relative to: those of the start of the increment, which has been accepted, and those of
  // the present iterate. One that is far away on the way does not count any more when it has been left.
  double first = 0.0, first_inner = 0.0, scale = 0.0, inner = 0.0, largest = 0.0, noise = 0.0, before = 0.0;
  double unbalanced = std::numeric_limits<double>::infinity();
  int round_start = 0;
  std::int64_t settling = 0;
  _K = nullptr;
  if (_fields)
    _fields->begin();
  for (int iteration = 0;; ++iteration)
  {
    Vec b = nullptr;
    std::string unsolved;
    {
      const Clock clock(seconds.bodies);
      b = body.residual();
      unsolved = body.fault();
    }
    if (!unsolved.empty())
    {
      result.residual_norms.push_back(std::numeric_limits<double>::quiet_NaN());
      return result.failed(unsolved + " in Newton iteration " + std::to_string(iteration));
    }
    std::vector<double> bodies = operators::values_of(b);
    if (!std::isfinite(norm(bodies)))
    {
      result.residual_norms.push_back(std::numeric_limits<double>::quiet_NaN());
      return result.failed("the residual is nan in Newton iteration " + std::to_string(iteration) +
                           ": the state cannot be evaluated (inverted cells?)");
    }
    std::vector<double> residual;
    std::int64_t changes = 0, pending = 0;
    double free = 0.0;
    {
      const Clock clock(seconds.contact);
      for (enforcement::StaticContact* contact : _contacts)
      {
        contact->update_gap(u());
        if (!contact->has_multipliers())
          contact->add_residual(b);
      }
      residual = operators::values_of(b);
      if (_saddle && iteration > 0)
        for (enforcement::MultiplierContact* contact : _multipliers)
          contact->rotate_friction_traction();
      std::tie(changes, pending) = update_active_sets(residual, iteration == 0);
      if (_saddle)
        for (const enforcement::MultiplierContact* contact : _multipliers)
          subtract(residual, contact->contact_forces());
      scale = norm(residual);
      largest = std::max(largest, scale);
      first = iteration == 0 ? scale : first;
      scale = std::max(scale, first);
      std::vector<double> without = residual;
      if (!_saddle)
        for (const enforcement::MultiplierContact* contact : _multipliers)
          subtract(without, contact->imposed_friction_forces());
      free = free_norm(without);
    }
    std::vector<double> jump;
    int far_from_target = 0;
    for (std::int32_t i : _prescribed)
    {
      jump.push_back(target[i] - u()[i]);
      far_from_target = far_from_target || jump.back() != 0.0;
    }
    MPI_Allreduce(MPI_IN_PLACE, &far_from_target, 1, MPI_INT, MPI_MAX, _comm);
    const bool moved = !far_from_target;
    double violation = 0.0;
    std::int64_t active = 0;
    for (const enforcement::StaticContact* contact : _contacts)
    {
      violation = std::max(violation, contact->violation());
      active += contact->num_active();
    }
    result.add(free, active, changes + settling);
    if (events.iteration)
      events.iteration(iteration, free, std::max(scale, inner), active, result.changes.back());
    const bool settled = iteration > 0 || _contacts.empty();
    double tolerance = std::max({_options.atol, noise, _options.rtol * std::max(scale, inner)});
    bool small = free <= tolerance;
    if (_fields)
    {
      if (_K)
        _fields->measure(_K, moved_from_origin(), residual);
      small = _fields->small(residual, _options.rtol, _options.atol) && small;
    }
    if (small && iteration > 0 && !body.properties().linear &&
        (_fields || free > std::max(_options.atol, _options.rtol * scale)))
    {
      // It is small beside what the tangent of the last iterate has told: this one's own must tell so, too.
      Mat K = stiffness();
      inner = std::max(first_inner, tangent_force(K));
      noise = round_off(K);
      tolerance = std::max({_options.atol, noise, _options.rtol * std::max(scale, inner)});
      small = free <= tolerance;
      if (_fields)
      {
        _fields->measure(K, moved_from_origin(), residual);
        small = _fields->small(residual, _options.rtol, _options.atol) && small;
      }
    }
    if (iteration > 0 && !_multipliers.empty() && std::max(scale, inner) <= gap_round_off())
    {
      // Nothing acts: the multipliers that close gaps of round-off have no state that could be found.
      small = true;
      pending = 0;
    }
    if (iteration == 0)
      for (const enforcement::StaticContact* contact : _contacts)
        result.closed.push_back(contact->num_active() > 0);
    if (moved && settled && pending == 0 && violation < _options.violation && small)
    {
      if (const std::string lost = lost_contact(result.closed); !lost.empty())
        return result.failed(lost);
      bool again = false;
      std::vector<std::string> faults;
      for (enforcement::StaticContact* contact : _contacts)
        again = contact->augment() || again;
      for (const enforcement::StaticContact* contact : _contacts)
        faults.push_back(contact->fault());
      if (const std::string found = joined(faults); !found.empty())
        return result.failed(found, true);
      if (again)
      {
        round_start = iteration;
        continue;
      }
      const std::optional<Imbalance> missing = out_of_balance(p, bodies, tolerance);
      if (!missing)
        return result.converged();
      // Directions of friction follow the normals one iteration later: what is missing falls then.
      const bool last = iteration - round_start == _options.max_iterations;
      if (last || missing->norm > 0.5 * unbalanced)
        return result.failed(missing->text, true);
      unbalanced = missing->norm;
    }
    if (iteration - round_start == _options.max_iterations || result.stalled())
      return did_not_converge(std::move(result), moved, small, pending, violation);
    const int period = iteration - round_start > 0 ? result.cycle() : 0;
    Mat K = stiffness();
    if (iteration == 0 && !_contacts.empty() && !body.properties().has_inertia)
      if (const std::string loose = unconstrained_modes(K); !loose.empty())
        return result.failed(loose, true);
    if (iteration == 0 && !moved)
      predict_active_sets(jump);
    inner = tangent_force(K);
    first_inner = iteration == 0 ? inner : first_inner;
    inner = std::max(inner, first_inner);
    if (_fields)
    {
      _fields->measure(K, moved_from_origin(), residual);
      forget_factors(K);
    }
    const double in_bodies = round_off_of_bodies(K);
    noise = in_bodies + round_off_of_contact();
    if (_inelastic && iteration > 0 && largest > 0.0 && in_bodies > far * largest)
      return result.failed("Newton's method diverged: in iteration " + std::to_string(iteration) +
                           " the displacements are so large that the residual is round-off");
    // The accuracy that is still needed, but no more than the quadratic convergence of the next step.
    const bool springs = !_contacts.empty() && _multipliers.empty() && p.linear_solver->direct();
    const double loose = springs ? digits_of_springs : loose_digits;
    double digits = _contacts.empty() && body.properties().linear ? 1e-10 : loose;
    if (moved && free > 0.0)
    {
      const double enough = _margin * std::max(_options.atol, _options.rtol * std::max(scale, inner)) / free;
      const double order = _multipliers.empty() || p.exact_tangent ? order_of_newton : order_with_iterations;
      const double likely = before > 0.0 ? 0.1 * std::pow(free / before, order) : 1e-4;
      digits = std::min(digits, std::max(enough, std::min(likely, loose)));
    }
    before = moved ? free : 0.0;
    const std::vector<double> start(u().begin(), u().end());
    const LinearisedSolution solution = solve_linearised(K, residual, jump, digits, result.unsettled);
    settling = solution.changes;
    ++result.iterations;
    result.unsettled += solution.wrong > 0;
    result.unsettled_in_succession = solution.wrong > 0 ? result.unsettled_in_succession + 1 : 0;
    for (std::size_t i = 0; i < p.fixed.size(); ++i) // without round-off
      if (p.fixed[i])
        u()[i] = target[i];
    if (!solution.fault.empty())
    {
      if (!_contacts.empty() && !body.properties().has_inertia)
        if (const std::string loose = unconstrained_modes(K); !loose.empty())
          // What was held as the increment began may lose its contact on the way, and keep it in smaller increments.
          return result.failed(loose + "; the linear solver failed (" + solution.fault + ")", iteration == 0);
      if (const std::string crowded = over_constrained(); !crowded.empty())
      {
        result.advice.clear();
        return result.failed("the linear problem has no solution: " + crowded);
      }
      return result.failed("the linear solver failed (" + solution.fault + "): is the body held against rigid motion?" +
                           (_inelastic ? " Is the load more than the body can bear?" : ""));
    }
    if (period && moved) // half a step leaves the cycle
      for (std::size_t i = 0; i < start.size(); ++i)
        u()[i] = start[i] + 0.5 * (u()[i] - start[i]);
    else if (_rough && moved && iteration - round_start >= _plain)
    {
      if (_conservative)
        descend(K, start, residual, digits);
      else
        backtrack(start, free);
    }
  }
}

/// Message about points that have passed through a master, or bodies that nothing holds any more as contacts have
/// opened; empty if there are none. Collective.
std::string Newton::lost_contact(std::span<const std::int8_t> closed)
{
  std::vector<std::string> passed;
  for (enforcement::StaticContact* contact : _contacts)
    passed.push_back(contact->passed_through());
  if (const std::string text = joined(passed); !text.empty())
    return text;
  if (_problem->body->properties().has_inertia)
    return "";
  const std::vector<std::string> lost = open_contacts(*_problem, closed);
  if (lost.empty())
    return "";
  std::vector<enforcement::StaticContact*> bearing;
  for (enforcement::StaticContact* contact : _contacts)
    if (contact->num_active() > 0)
      bearing.push_back(contact);
  Mat springs = _problem->body->properties().has_springs ? stiffness() : nullptr;
  const std::vector<std::string> loose =
      solve::unconstrained_modes(_problem->space(), _problem->fixed, bearing, u(), _problem->axisymmetric, springs);
  return loose.empty() ? "" : "contact was lost (" + joined(lost) + "), and " + joined(loose);
}

std::string Newton::over_constrained() const
{
  constexpr std::size_t shown = 3;
  std::vector<std::string> sentences;
  for (const enforcement::MultiplierContact* contact : _multipliers)
  {
    const std::vector<std::int32_t> nodes = contact->over_constrained();
    int count = int(nodes.size());
    MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, _comm);
    if (count == 0)
      continue;
    std::string names = contact->name();
    for (const enforcement::MultiplierContact* other : _multipliers)
    {
      int common = 0;
      for (std::int32_t node : other->nodes())
        common = common || std::ranges::count(nodes, node);
      MPI_Allreduce(MPI_IN_PLACE, &common, 1, MPI_INT, MPI_MAX, _comm);
      if (other != contact && common)
        names += " and " + other->name();
    }
    // Reference positions of the first of them, of all ranks.
    const std::vector<double> x = _problem->space().tabulate_dof_coordinates(false);
    std::vector<double> here;
    for (std::size_t i = 0; i < std::min(shown, nodes.size()); ++i)
      here.insert(here.end(), x.data() + 3 * nodes[i], x.data() + 3 * nodes[i] + _gdim);
    std::vector<double> first = common::gather(_comm, here);
    first.resize(std::min(first.size(), shown * _gdim));
    sentences.push_back(std::to_string(count) + " nodes, the first at " + common::places(first, _gdim) +
                        ", cannot fulfil the conditions of " + names +
                        " at once: leave them out of one of the tags, or free their supports");
  }
  return joined(sentences);
}

/// Write into an increment why it did not converge, and what to do. Collective.
Increment Newton::did_not_converge(Increment result, bool moved, bool small, std::int64_t pending, double violation)
{
  std::vector<std::string> found;
  const std::vector<double>& norms = result.residual_norms;
  const int period = result.cycle();
  if (!small)
    found.push_back("the residual is " + common::text("%.3e", norms.back()));
  if (pending)
    found.push_back(std::to_string(pending) + " contact points change their state");
  if (violation >= _options.violation)
    for (const enforcement::StaticContact* contact : _contacts)
      found.push_back(contact->largest_violation());
  found.push_back(over_constrained());
  if (!moved)
    found.push_back("prescribed values are not reached");
  if (result.stalled())
    found.push_back("the linearised problems have no active set that fits, and the residual does not fall");
  if (period)
    found.push_back("the same states come again after " + std::to_string(period) + " iterations");
  std::string history;
  for (double n : norms)
    history += (history.empty() ? "" : ", ") + common::text("%.3e", n);
  const std::string text = "Newton's method did not converge in " + std::to_string(result.iterations) +
                           " iterations: " + joined(found, ", ") + "; residual norms: " + history;
  if (small && moved && !pending)
    // Equilibrium and active set have converged, but a condition is violated: smaller increments do not help.
    return result.failed(text, true);
  std::vector<std::string> meshes;
  for (const enforcement::StaticContact* contact : _contacts)
    meshes.push_back(contact->mesh_advice());
  if (const std::string advice = joined(meshes); !advice.empty())
    result.advice = advice + ". " + result.advice;
  return result.failed(text);
}

// --- line searches
// ----------------------------------------------------------------------------------------------------

/// Halve the step from `start`, at most four times, until the norm of the residual is less than `norm`, which it is at
/// the start. Newton's method can cycle where points change between stick and slip. Collective.
void Newton::backtrack(std::span<const double> start, double norm)
{
  std::vector<double> step(u().begin(), u().end());
  subtract(step, start);
  const auto go = [&](double part)
  {
    for (std::size_t i = 0; i < step.size(); ++i)
      u()[i] = start[i] + part * step[i];
  };
  double best = 1.0, least = std::numeric_limits<double>::infinity();
  for (double part : parts)
  {
    go(part);
    const double here = residual_norm();
    if (here < norm)
      return;
    if (here < least)
    {
      best = part;
      least = here;
    }
  }
  go(best);
}

/// Line search along the step from `start` for a problem without friction: the residual is the gradient of an energy,
/// which may decrease while the norm of the residual increases. If Newton's step is no descent direction, a step with
/// the positive semi-definite part of the contact tangent is taken instead. Collective.
/// @param[in] residual at the start [F]
/// @param[in] digits relative tolerance of a linear solution [1]
void Newton::descend(Mat K, std::span<const double> start, std::span<const double> residual, double digits)
{
  std::vector<double> end(u().begin(), u().end());
  const auto slope = [&](std::span<const double> forces)
  {
    double out = 0.0;
    for (std::size_t i = 0; i < _num_owned; ++i)
      if (!_problem->fixed[i])
        out += forces[i] * (end[i] - start[i]);
    MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_DOUBLE, MPI_SUM, _comm);
    return out;
  };
  double steep = slope(residual);
  if (steep >= 0.0 && _contacts.empty())
    return;
  if (steep >= 0.0)
  {
    std::ranges::copy(start, u().begin());
    for (enforcement::StaticContact* contact : _contacts)
    {
      contact->update_gap(start);
      contact->set_convex(true);
    }
    const std::vector<double> none(_prescribed.size(), 0.0);
    const LinearisedSolution found = solve_linearised(K, {residual.begin(), residual.end()}, none, digits);
    for (enforcement::StaticContact* contact : _contacts)
      contact->set_convex(false);
    if (!found.fault.empty())
    {
      std::ranges::copy(start, u().begin());
      return;
    }
    end.assign(u().begin(), u().end());
    steep = slope(residual);
  }
  double low = 0.0, high = 1.0, part = high;
  for (int k = 0; k < searches; ++k)
  {
    for (std::size_t i = 0; i < end.size(); ++i)
      u()[i] = start[i] + part * (end[i] - start[i]);
    const double here = slope(free_residual());
    if (here <= steep_end * std::abs(steep) && (part == 1.0 || here >= -steep_end * std::abs(steep)))
      return;
    (here < 0.0 ? low : high) = part;
    part = 0.5 * (low + high);
  }
}

/// Free residual at u of a problem without multipliers, owned [F]. Collective.
std::vector<double> Newton::free_residual()
{
  Vec b = _problem->body->residual();
  {
    const Clock clock(seconds.contact);
    for (enforcement::StaticContact* contact : _contacts)
    {
      contact->update_gap(u());
      contact->add_residual(b);
    }
  }
  std::vector<double> out = operators::values_of(b);
  for (std::int32_t i : _prescribed)
    out[i] = 0.0;
  return out;
}

/// Norm of `free_residual`, infinite where it is not a number [F]. Collective.
double Newton::residual_norm()
{
  const double found = norm(free_residual());
  return std::isfinite(found) && _problem->body->fault().empty() ? found : std::numeric_limits<double>::infinity();
}

// --- checks of an iteration
// -------------------------------------------------------------------------------------------

double Newton::norm(std::span<const double> values) const
{
  double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, _comm);
  return std::sqrt(sum);
}

/// Update multipliers and active sets. Collective.
/// @returns number of points that changed, and number of those that must not change in a converged state
std::pair<std::int64_t, std::int64_t> Newton::update_active_sets(std::span<const double> residual, bool first)
{
  std::int64_t changes = 0, pending = 0;
  for (enforcement::StaticContact* contact : _contacts)
  {
    auto* multipliers = contact->has_multipliers() ? dynamic_cast<enforcement::MultiplierContact*>(contact) : nullptr;
    if (multipliers && !first && !_saddle)
      multipliers->update_multipliers(residual);
    const int changed = contact->update_active_set(first);
    changes += changed;
    // The residual of penalty contact is already that of the new status; where the friction limit is reached exactly,
    // round-off decides on the status.
    pending += multipliers ? changed : 0;
  }
  if (!first)
    for (const enforcement::MultiplierContact* contact : _multipliers)
      pending += contact->num_turning();
  return {changes, pending};
}

/// Close the nodes that are likely to close, before the first factorisation or hierarchy: where bodies would overlap if
/// they followed their supports without deformation. Collective.
/// @param[in] jump increments of the prescribed displacements [L]
void Newton::predict_active_sets(std::span<const double> jump)
{
  const Clock clock(seconds.contact);
  const EquilibriumProblem& p = *_problem;
  // Where multipliers stay in the system every update is a factorisation of its own, whatever it starts from; bodies
  // with inertia do not follow their supports at once.
  if (_multipliers.empty() || _saddle || _fields || p.body->properties().has_inertia)
    return;
  const operators::RigidBodyModes motions(p.space(), u(), p.axisymmetric);
  const std::vector<double> increments = rigid_extrapolation(motions, p.fixed, jump);
  const double part = _gdim == 3 || p.axisymmetric ? overlap_in_space : overlap_in_plane;
  for (enforcement::MultiplierContact* contact : _multipliers)
    contact->predict_active_set(increments, part);
}

/// Norm of a residual without the equations of multipliers and supports [F]. Collective.
double Newton::free_norm(std::span<const double> residual)
{
  const std::unique_ptr<enforcement::Condensation> condensed = condensation();
  std::vector<double> free =
      condensed ? condensed->residual(residual) : std::vector<double>(residual.begin(), residual.end());
  for (std::int32_t i : _prescribed)
    free[i] = 0.0;
  return norm(free);
}

std::string Newton::unconstrained_modes(Mat K)
{
  Mat springs = _problem->body->properties().has_springs ? K : nullptr;
  const std::vector<std::string> loose =
      solve::unconstrained_modes(_problem->space(), _problem->fixed, _contacts, u(), _problem->axisymmetric, springs);
  if (loose.empty())
    return "";
  std::vector<std::string> apart;
  for (const enforcement::StaticContact* contact : _contacts)
    if (const double gap = contact->smallest_gap(); gap > 0.0)
      apart.push_back(contact->name() + ": smallest gap " + common::text("%.3e", gap));
  const std::string hint =
      apart.empty() ? "" : " (" + joined(apart) + ": let them touch first, or hold or move the body)";
  return "not held against rigid motion: " + joined(loose) + hint;
}

/// Tangent of the bodies at u [F/L]; that of a linear law is assembled once per increment. Collective.
Mat Newton::stiffness()
{
  if (!_K || !_problem->body->properties().linear)
  {
    const Clock clock(seconds.bodies);
    _K = _problem->body->tangent();
  }
  return _K;
}

/// Displacements that internal forces are due to, owned [L].
std::vector<double> Newton::moved_from_origin() const
{
  std::vector<double> out(u().begin(), u().begin() + _num_owned);
  subtract(out, _problem->body->origin());
  return out;
}

double Newton::tangent_force(Mat K)
{
  std::vector<double> forces = product(std::array{K}, moved_from_origin());
  for (std::int32_t i : _prescribed)
    forces[i] = 0.0;
  return norm(forces);
}

/// Forget factors of another tangent: they would solve the equations of several fields in one norm of all, in which the
/// small ones are lost. Collective.
void Newton::forget_factors(Mat K)
{
  PetscObjectState state = 0;
  check(PetscObjectStateGet(PetscObject(K), &state), "a matrix is asked for its state");
  if (_factorised != std::pair{K, state})
  {
    _problem->linear_solver->reset();
    _factorised = {K, state};
  }
}

bool Newton::fields_balance(Mat K, std::span<const double> residual)
{
  if (!_fields)
    return true;
  _fields->begin();
  _fields->measure(K, {u().data(), _num_owned}, residual);
  return _fields->small(residual, _options.rtol, _options.atol);
}

double Newton::round_off(Mat K)
{
  return round_off_of_bodies(K) + round_off_of_contact();
}

double Newton::round_off_of_contact() const
{
  double sum = 0.0;
  for (const enforcement::StaticContact* contact : _contacts)
    sum += contact->round_off();
  return sum;
}

double Newton::gap_round_off() const
{
  double sum = 0.0;
  for (const enforcement::MultiplierContact* contact : _multipliers)
    sum += contact->gap_round_off();
  return sum;
}

/// Norm of the round-off in the residual of the bodies: that of a stiff body with a rigid displacement; with finite
/// strain also that of 1 + Grad u, which is the stiffness times a cell's size, however small u is [F]. Collective.
double Newton::round_off_of_bodies(Mat K)
{
  const Body& body = *_problem->body;
  std::vector<double> forces = diagonal_of(K);
  const bool positions =
      body.properties().rounds_positions && !body.properties().linear && !body.properties().has_inertia;
  if (positions && _sizes.empty())
  {
    const dolfinx::fem::FunctionSpace<double>& V = _problem->space();
    const auto dofs = V.dofmap()->map();
    const int bs = V.dofmap()->index_map_bs();
    const auto map = V.dofmap()->index_map;
    std::vector<std::int32_t> cells(dofs.extent(0));
    std::iota(cells.begin(), cells.end(), 0);
    const std::vector<double> h = dolfinx::mesh::h(*V.mesh(), cells, V.mesh()->topology()->dim());
    std::vector<double> least(map->size_local() + map->num_ghosts(), std::numeric_limits<double>::infinity());
    for (std::size_t cell = 0; cell < dofs.extent(0); ++cell)
      for (std::size_t i = 0; i < dofs.extent(1); ++i)
        least[dofs(cell, i)] = std::min(least[dofs(cell, i)], h[cell]);
    _sizes.resize(_num_owned);
    for (std::size_t i = 0; i < _num_owned; ++i)
      _sizes[i] = least[i / bs];
  }
  for (std::size_t i = 0; i < _num_owned; ++i)
    forces[i] *= std::abs(u()[i]) + (positions ? _sizes[i] : 0.0);
  return 4 * std::numeric_limits<double>::epsilon() * norm(forces);
}

// --- the linear problem
// -----------------------------------------------------------------------------------------------

/// Condensation of the multipliers; null if there are none, or if they stay in the system. Collective.
std::unique_ptr<enforcement::Condensation> Newton::condensation()
{
  if (_multipliers.empty() || _saddle)
    return nullptr;
  const auto& dofmap = *_problem->space().dofmap();
  std::vector<enforcement::Constraints> constraints;
  for (enforcement::MultiplierContact* contact : _multipliers)
    constraints.push_back(contact->constraints());
  return std::make_unique<enforcement::Condensation>(
      _comm, _num_owned, dofmap.index_map->local_range()[0] * dofmap.index_map_bs(), _gdim, std::move(constraints));
}

Newton::LinearisedSolution Newton::solve_linearised(Mat K, std::vector<double> residual, std::span<const double> jump,
                                                    double rtol, int unsettled)
{
  LinearisedSolution out;
  Stiffness stiffness{K, {}, {}, _problem->body->properties().symmetric, 1.0};
  if (_saddle)
  {
    for (const enforcement::MultiplierContact* contact : _multipliers)
      add(residual, contact->contact_forces());
    _start = _forces;
  }
  {
    const Clock clock(seconds.contact);
    for (enforcement::StaticContact* contact : _contacts)
      contact->update_nodal_stiffness(K);
    for (enforcement::StaticContact* contact : _contacts)
      if (Mat tangent = contact->tangent())
        (contact->has_multipliers() ? stiffness.geometric : stiffness.penalties).push_back(tangent);
    for (const enforcement::StaticContact* contact : _contacts)
      stiffness.symmetric = contact->symmetric() && stiffness.symmetric;
    for (const enforcement::StaticContact* contact : _contacts)
      add(residual, contact->closing_forces());
  }
  double sums[2] = {0.0, double(_num_owned)};
  for (double d : diagonal_of(K))
    sums[0] += std::abs(d);
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, _comm);
  if (sums[0] > 0.0)
    stiffness.mean = sums[0] / sums[1];
  std::vector<double> moved(_num_owned, 0.0);
  for (std::size_t i = 0; i < _prescribed.size(); ++i)
    moved[_prescribed[i]] = jump[i];
  double digits = _multipliers.empty() ? rtol : loose_digits;
  ActiveSetIteration updates;
  RepeatedStates repeated(_comm, unsettled);
  bool corrected = false;
  while (true)
  {
    OneSolution found = solve_once(stiffness, residual, moved, digits);
    moved = std::move(found.moved);
    out.changes += found.changes;
    out.fault = std::move(found.fault);
    if (!out.fault.empty() || _multipliers.empty())
      break;
    int changed = 0;
    {
      const Clock clock(seconds.contact);
      std::vector<double> balance = residual;
      add(balance, found.forces);
      for (enforcement::MultiplierContact* contact : _multipliers)
      {
        contact->update_linearised_gap(moved);
        if (!_saddle)
          contact->update_multipliers(balance);
      }
      if (_saddle)
        set_multipliers(stiffness.mean);
      changed = updates.change(_multipliers);
      if (events.progress)
        events.progress("update " + std::to_string(updates.count()) + " of the active set: " + std::to_string(changed) +
                        " nodes change");
    }
    if (changed == 0)
    {
      if (corrected && digits <= rtol)
        break;
      digits = rtol;
      if (!corrected)
      {
        const Clock clock(seconds.contact);
        correct(moved);
        corrected = true;
      }
    }
    else
    {
      // Do updates of single nodes go round?
      bool repeats = false;
      if (updates.count() < _options.max_changes)
      {
        if (updates.patience() > 0)
          repeated.forget();
        else
          repeats = repeated.stops(_multipliers);
      }
      if (updates.count() == _options.max_changes || repeats)
      {
        log("    active set not converged after " + std::to_string(updates.count()) +
            " updates: " + std::to_string(changed) + " nodes still change");
        out.wrong = changed;
        break;
      }
    }
    out.changes += changed;
  }
  for (std::size_t i = 0; i < _num_owned; ++i)
    u()[i] += moved[i];
  _problem->u->x()->scatter_fwd();
  return out;
}

/// Apply the second-order correction of contacts at the solution of the linearised problem. Collective.
/// @param[in] moved displacement increments, owned [L]
void Newton::correct(std::span<const double> moved)
{
  const std::vector<double> here(u().begin(), u().end());
  for (std::size_t i = 0; i < _num_owned; ++i)
    u()[i] += moved[i];
  _problem->u->x()->scatter_fwd();
  for (enforcement::MultiplierContact* contact : _multipliers)
    contact->correct_linearisation(u());
  std::ranges::copy(here, u().begin());
}

/// Solve the linear system of the present active set. Collective.
/// @param[in] guess displacement increments that the solver starts from, owned [L]
Newton::OneSolution Newton::solve_once(const Stiffness& stiffness, std::vector<double> residual,
                                       std::span<const double> guess, double rtol)
{
  LinearSolver& solver = *_problem->linear_solver;
  std::shared_ptr<enforcement::Condensation> condensed;
  std::vector<Mat> springs, extra = stiffness.penalties;
  {
    const Clock clock(seconds.contact);
    condensed = condensation();
    for (enforcement::MultiplierContact* contact : _multipliers)
      if (auto found = contact->friction_springs())
      {
        springs.push_back(found->first);
        add(residual, found->second);
      }
  }
  std::vector<std::int8_t> pinned(_problem->fixed.begin(), _problem->fixed.begin() + _num_owned);
  if (condensed)
    for (std::size_t i = 0; i < _num_owned; ++i)
      pinned[i] = pinned[i] || condensed->pinned()[i];
  extra.insert(extra.end(), springs.begin(), springs.end());
  if (_problem->exact_tangent)
    extra.insert(extra.end(), stiffness.geometric.begin(), stiffness.geometric.end());
  else if (!stiffness.geometric.empty()) // from the guess: small, but not symmetric
    add(residual, product(stiffness.geometric, guess));
  std::unique_ptr<LinearSystem> system;
  std::vector<double> start(guess.begin(), guess.end());
  if (_saddle)
  {
    std::vector<enforcement::Constraints> constraints;
    for (enforcement::MultiplierContact* contact : _multipliers)
      constraints.push_back(contact->constraints());
    _rows->assign(constraints, pinned, _start, stiffness.mean);
    for (std::size_t k = 0; k < _multipliers.size(); ++k)
      _multipliers[k]->set_redundant(_rows->redundant()[k]);
    system = std::make_unique<SaddlePointSystem>(stiffness.K, extra, *_rows);
    start = _rows->unknowns(guess, _forces);
  }
  else
  {
    system =
        std::make_unique<CondensedSystem>(stiffness.K, extra, stiffness.symmetric, condensed, pinned, stiffness.mean);
    if (condensed)
      start = condensed->unknowns(guess);
    if (UpdatedFactors* const updated = solver.updated(); updated && condensed)
      updated->select(dynamic_cast<CondensedSystem&>(*system), _multipliers.front()->numbers(),
                      _multipliers.front()->active());
  }
  OneSolution out;
  Vec x = system->create_vector(), b = system->create_vector();
  {
    Entries values(x);
    std::ranges::copy(start, &values[0]);
  }
  system->load(residual, x, b);
  {
    const Clock clock(seconds.linear);
    out.fault = solver.solve(*system, b, x, rtol);
  }
  out.moved = system->displacements(x);
  if (_saddle)
    _forces = _rows->forces(x);
  std::vector<Mat> matrices{stiffness.K};
  matrices.insert(matrices.end(), stiffness.penalties.begin(), stiffness.penalties.end());
  matrices.insert(matrices.end(), stiffness.geometric.begin(), stiffness.geometric.end());
  out.forces = product(matrices, out.moved);
  Mat factors = solver.factors(*system);
  if (_options.responses && out.fault.empty() && factors && !_saddle && _multipliers.size() == 1)
    update_by_responses(dynamic_cast<CondensedSystem&>(*system), condensed, factors, residual, matrices, out);
  for (Vec* v : {&x, &b})
    check(VecDestroy(v), "a vector is destroyed");
  system.reset();
  for (Mat& matrix : springs)
    check(MatDestroy(&matrix), "a matrix is destroyed");
  return out;
}

/// Update the active set of a contact without friction by LinearisedActiveSet. Collective.
/// @param[in] system that was solved, its condensation and its factors
/// @param[in] residual owned [F]
/// @param[in] matrices stiffness of bodies and contacts [F/L]
/// @param[in,out] found the solution
void Newton::update_by_responses(CondensedSystem& system, std::shared_ptr<enforcement::Condensation> condensed,
                                 Mat factors, std::span<const double> residual, std::span<const Mat> matrices,
                                 OneSolution& found)
{
  enforcement::MultiplierContact& contact = *_multipliers.front(); // the only one
  if (contact.has_friction())
    return;
  std::optional<std::pair<std::vector<double>, int>> updated;
  {
    const Clock clock(seconds.linear);
    contact.update_linearised_gap(found.moved);
    std::vector<double> balance(residual.begin(), residual.end());
    add(balance, found.forces);
    contact.update_multipliers(balance);
    const MatrixProduct forces(matrices);
    LinearisedActiveSet set(
        contact, system, factors, [&](std::span<const double> v) { return forces(v); },
        *_problem->space().dofmap()->index_map);
    updated = set.update();
    if (updated && updated->second > 0)
      _problem->linear_solver->set_updated(set.updated_factors(std::move(condensed)));
  }
  if (!updated || updated->second == 0)
    return;
  add(found.moved, updated->first);
  found.forces = product(matrices, found.moved);
  found.changes = updated->second;
}

/// Sum of the products of matrices with values, owned. Collective.
std::vector<double> Newton::product(std::span<const Mat> matrices, std::span<const double> values) const
{
  return MatrixProduct(matrices)(values);
}

/// Set the multipliers of all contacts from the solution of the saddle point, whose unit of force is `unit`.
void Newton::set_multipliers(double unit)
{
  std::size_t start = 0;
  for (enforcement::MultiplierContact* contact : _multipliers)
  {
    const std::size_t size = _gdim * contact->nodes().size();
    std::vector<double> forces(_forces.begin() + start, _forces.begin() + start + size);
    for (double& f : forces)
      f *= unit;
    contact->set_multipliers(forces);
    start += size;
  }
}
} // namespace dolfinx_impact::solve
