// SPDX-License-Identifier: MIT
#include "NewmarkProblem.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/text.h"
#include "../integrators/newmark/highest_frequency.h"
#include "LoadedBody.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

using dolfinx_impact::common::text;

namespace dolfinx_impact::problems
{
namespace
{
constexpr double difference = 0.01;    // of a step: half the distance at which functions of time are differentiated
constexpr double smallest_part = 1e-3; // of the largest step: ten cut-backs

} // namespace

/// Loads, supports and rigid masters of a problem at a time.
class NewmarkProblem::TimeExcitation : public integrators::Excitation
{
public:
  TimeExcitation(MPI_Comm comm, FunctionsOfTime& functions, const Supports& supports, std::shared_ptr<LoadedBody> body,
                 const std::vector<LoadInTime>& loads, const std::vector<ImplicitContact>& contacts)
      : _comm(comm), _supports(supports), _body(std::move(body)), _loads(loads)
  {
    for (const LoadInTime& load : loads)
    {
      if (load.dofs.size() != load.values.size())
        throw std::invalid_argument("a load has another number of values than degrees of freedom");
      const auto owned = [n = std::int32_t(_body->forces().size())](std::int32_t dof) { return dof >= 0 && dof < n; };
      if (!std::ranges::all_of(load.dofs, owned))
        throw std::invalid_argument("a load is on degrees of freedom that this rank does not own");
      if (load.amplitude && load.amplitude->size() != 1)
        throw std::invalid_argument("the amplitude of a load is a number");
      _columns.push_back(load.amplitude ? functions.add(*load.amplitude) : -1);
    }
    for (const ImplicitContact& c : contacts)
    {
      const auto place = c.contact->displacement();
      if (c.motion && !place)
        throw std::invalid_argument(c.contact->name() + " has no rigid master that could move");
      if (c.motion && c.motion->size() != 3)
        throw std::invalid_argument(c.contact->name() + ": the motion of a rigid master has three components");
      _masters.push_back({place.value_or(std::array<double, 3>{}), c.motion ? functions.add(*c.motion) : -1});
    }
    _functions = functions;
  }

  integrators::TimeValues sample(std::optional<double> step, double time) override
  {
    const double small = difference * step.value_or(0.0), middle = std::max(time, small); // no time before the start
    const std::array<double, 4> times{middle - small, middle, middle + small, time};
    std::vector<double> table;
    common::agree(_comm, [&] { table = _functions.table(times); });
    const std::size_t n = _body->forces().size(), width = _functions.num_columns();
    const auto at = [&](int row, int column) { return table[row * width + column]; };
    integrators::TimeValues out;
    out.time = time;
    out.displacement.assign(n, 0.0);
    out.velocity.assign(n, 0.0);
    out.acceleration.assign(n, 0.0);
    for (const Supports::Part& part : _supports.parts())
      for (std::size_t k = 0; k < part.dofs.size(); ++k)
      {
        const std::int32_t dof = part.dofs[k];
        const int c = part.column;
        out.displacement[dof] = part.values[k] * (c < 0 ? 1.0 : at(3, c));
        if (c >= 0 && small > 0.0)
        {
          out.velocity[dof] = part.values[k] * (at(2, c) - at(0, c)) / (2.0 * small);
          out.acceleration[dof] = part.values[k] * (at(2, c) - 2.0 * at(1, c) + at(0, c)) / (small * small);
        }
      }
    for (int column : _columns)
      out.factors.push_back(column < 0 ? 1.0 : at(3, column));
    for (const auto& [start, column] : _masters)
    {
      std::array<double, 3> place = start;
      for (int c = 0; column >= 0 && c < 3; ++c)
        place[c] += at(3, column + c);
      out.places.push_back(place);
    }
    return out;
  }

  void scale(std::span<const double> factors) override
  {
    std::ranges::fill(_body->forces(), 0.0);
    for (std::size_t i = 0; i < _loads.size(); ++i)
      for (std::size_t k = 0; k < _loads[i].dofs.size(); ++k)
        _body->forces()[_loads[i].dofs[k]] += factors[i] * _loads[i].values[k];
  }
  void unscale() override {} // the forces are set anew before they count
  std::vector<double> external_forces() override { return _body->forces(); }

private:
  MPI_Comm _comm;
  FunctionsOfTime _functions;
  const Supports& _supports;
  std::shared_ptr<LoadedBody> _body;
  std::vector<LoadInTime> _loads;
  std::vector<int> _columns;                                   ///< of the loads' amplitudes
  std::vector<std::pair<std::array<double, 3>, int>> _masters; ///< where rigid masters are, and their motions' columns
};

NewmarkProblem::NewmarkProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ImplicitBody body,
                               std::vector<PrescribedMotion> supports, std::vector<LoadInTime> loads,
                               std::vector<ImplicitContact> contacts, const NewmarkOptions& options)
    : TransientProblem(std::move(u), std::move(v), std::move(supports)), _options(options), _body(std::move(body)),
      _history(contacts.size())
{
  auto loaded = std::make_shared<LoadedBody>(_body.body, num_owned());
  auto moving = std::make_shared<integrators::MovingBody>(loaded, _u, _v, _body.inertia, _body.alpha, _body.damping);
  std::vector<std::shared_ptr<enforcement::StaticContact>> pairs;
  for (const ImplicitContact& c : contacts)
    pairs.push_back(c.contact);
  _equilibrium = make_equilibrium(_u, moving, std::move(pairs), _supports.mask(), options.solver, "impact_implicit_");
  std::shared_ptr<TimeExcitation> excitation;
  common::agree(
      comm(),
      [&] { excitation = std::make_shared<TimeExcitation>(comm(), _functions, _supports, loaded, loads, contacts); });
  _stepper = std::make_unique<integrators::ImplicitStepper>(_equilibrium, moving, options.scheme, excitation,
                                                            _body.mass, _v, _a);
  _stepper->enter_contact();
  _stepper->start({});
  add_row();
}

NewmarkProblem::~NewmarkProblem() = default;

/// Add the present energies and contact forces to the history. Collective.
void NewmarkProblem::add_row()
{
  const auto energies = _stepper->energies().values();
  std::vector<double> row(energies.begin(), energies.end());
  for (const auto& contact : _equilibrium->contacts)
  {
    const auto force = contact->force().value_or(std::array<double, 3>{});
    row.insert(row.end(), force.begin(), force.end());
  }
  _history.add({&_time, 1}, row);
}

void NewmarkProblem::resume()
{
  _u->x()->scatter_fwd();
  _stepper->resume();
  _time = _stepper->time();
  _step = _stepper->step();
  _history.begin_anew();
  add_row();
}

double NewmarkProblem::stable_step()
{
  const double product = _options.scheme.stable_frequency();
  if (std::isinf(product))
    return product;
  std::vector<std::int8_t> held(_supports.mask().begin(), _supports.mask().begin() + std::ptrdiff_t(num_owned()));
  for (std::size_t i = 0; i < held.size(); ++i)
    held[i] = held[i] || _body.inertia->massless()[i];
  const double omega = integrators::highest_frequency(_body.body->tangent(), _body.inertia->matrix(), held);
  return omega > 0.0 ? product / omega : std::numeric_limits<double>::infinity();
}

void NewmarkProblem::advance(double until, const ImplicitAdvance& options, const Callback& callback)
{
  const double smallest = options.smallest.value_or(smallest_part * options.dt);
  if (!(until >= _time) || !std::isfinite(until))
    throw common::BadValue("the time " + text("%.6g", until) + " has passed: the problem is at " + text("%.6g", _time));
  if (!(options.dt > 0.0) || !(smallest > 0.0 && smallest <= options.dt))
    throw common::BadValue("dt and smallest are steps, positive and smallest not greater than dt");
  if ((options.tolerance && !(*options.tolerance > 0.0)) || !(options.rtol >= 0.0 && options.rtol < 1.0) ||
      !(options.atol >= 0.0) || options.max_iterations < 1)
    throw common::BadValue("tolerances are positive, and there is one iteration at least");
  common::agree(comm(), [this] { _supports.check(); });
  for (const auto& contact : _equilibrium->contacts)
    contact->check_parameters();
  if (until == _time)
    return;
  if (_step == 0 && std::ranges::any_of(_supports.parts(), [](const auto& part) { return part.column >= 0; }))
  {
    // Only now is there a step over which prescribed motion can be differentiated.
    _stepper->start(options.dt);
    _history.begin_anew();
    add_row();
  }
  integrators::StepControl control(options.dt, smallest, options.tolerance);
  if (_control && _control->largest() == options.dt && _control->tolerance() == options.tolerance)
    control = {options.dt, smallest, options.tolerance, _control->length(), _control->last()};
  solve::NewtonOptions newton;
  newton.rtol = options.rtol;
  newton.atol = options.atol;
  newton.max_iterations = options.max_iterations;
  solve::Newton solver(_equilibrium, newton.with_database(_equilibrium->linear_solver->prefix()));
  while (_time < until)
  {
    _stepper->take_step(until, control, [&solver](std::span<const double> goal) { return solver.run(goal); });
    _time = _stepper->time();
    _step = _stepper->step();
    _control = control;
    add_row();
    if (callback)
    {
      const state::State now = state();
      common::agree(comm(), [&] { callback(_time, now); });
    }
  }
}
} // namespace dolfinx_impact::problems
