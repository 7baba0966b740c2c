// SPDX-License-Identifier: MIT
#include "TimeExcitation.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
constexpr double difference = 0.01; // of a step: half the distance at which functions of time are differentiated
} // namespace

TimeExcitation::TimeExcitation(MPI_Comm comm, FunctionsOfTime& functions, const Supports& supports, BodyLoads loads,
                               std::shared_ptr<LoadedBody> body, std::vector<LoadInTime> forces,
                               const std::vector<ImplicitContact>& contacts,
                               const std::vector<ImplicitBodyInTime>& bodies)
    : _comm(comm), _functions(functions), _supports(supports), _loads(std::move(loads)), _body(std::move(body)),
      _forces(std::move(forces))
{
  for (std::size_t i = 0; i < _loads.scaled.size(); ++i)
    _columns.push_back(int(i));
  for (const LoadInTime& load : _forces)
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
    if ((c.motion || c.start) && !place)
      throw std::invalid_argument(c.contact->name() + " has no rigid master that could move");
    if (c.motion && c.motion->size() != 3)
      throw std::invalid_argument(c.contact->name() + ": the motion of a rigid master has three components");
    if (c.rotation && (c.rotation->size() != 3 || !c.contact->rotation()))
      throw std::invalid_argument(c.contact->name() + ": a rotation has three components, of a master that turns");
    const int motion = c.motion ? functions.add(*c.motion) : -1;
    _masters.push_back({c.start.value_or(place.value_or(std::array<double, 3>{})), motion,
                        c.rotation ? functions.add(*c.rotation) : -1});
  }
  for (const ImplicitBodyInTime& body : bodies)
  {
    for (const auto& load : {body.force, body.torque})
      if (load && load->size() != 3)
        throw std::invalid_argument("a load on a rigid body has three components");
    const int force = body.force ? functions.add(*body.force) : -1;
    _bodies.push_back({force, body.torque ? functions.add(*body.torque) : -1});
  }
}

integrators::TimeValues TimeExcitation::sample(std::optional<double> step, double time)
{
  const double small = difference * step.value_or(0.0), middle = std::max(time, small); // no time before the start
  const std::array<double, 4> times{middle - small, middle, middle + small, time};
  const std::vector<double> table = _functions.table_on_all_ranks(_comm, times);
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
  const auto vector = [&](int column)
  {
    std::array<double, 3> values{};
    for (int c = 0; column >= 0 && c < 3; ++c)
      values[c] = at(3, column + c);
    return values;
  };
  for (const Master& master : _masters)
  {
    std::array<double, 3> place = master.start;
    const std::array<double, 3> moved = vector(master.motion);
    for (int c = 0; c < 3; ++c)
      place[c] += moved[c];
    out.places.push_back(place);
    out.angles.push_back(vector(master.rotation));
  }
  for (const auto& [force, torque] : _bodies)
  {
    out.body_forces.push_back(vector(force));
    out.body_torques.push_back(vector(torque));
  }
  return out;
}

void TimeExcitation::scale(std::span<const double> factors)
{
  _given.clear();
  for (std::size_t i = 0; i < _loads.scaled.size(); ++i)
  {
    std::vector<double>& value = _loads.scaled[i].constant->value;
    _given.push_back(value);
    for (double& v : value)
      v *= factors[i];
  }
  std::ranges::fill(_body->forces(), 0.0);
  const std::span<const double> of_forces = factors.subspan(_loads.scaled.size());
  for (std::size_t i = 0; i < _forces.size(); ++i)
    for (std::size_t k = 0; k < _forces[i].dofs.size(); ++k)
      _body->forces()[_forces[i].dofs[k]] += of_forces[i] * _forces[i].values[k];
}

/// Nodal forces are set anew before they count.
void TimeExcitation::unscale()
{
  for (std::size_t i = 0; i < _given.size(); ++i)
    _loads.scaled[i].constant->value = _given[i];
  _given.clear();
}

std::vector<double> TimeExcitation::external_forces()
{
  std::vector<double> out = _body->forces();
  if (!_loads.work && _loads.kernels.empty())
    return out;
  const auto space = _loads.work ? _loads.work->function_spaces()[0] : _loads.kernels[0].force->test_space();
  const auto& dofmap = *space->dofmap();
  dolfinx::la::Vector<double> b(dofmap.index_map, dofmap.index_map_bs());
  common::fill(b, 0.0);
  for (const KernelForce& load : _loads.kernels)
    load.assemble(common::array(b));
  if (_loads.work)
    dolfinx::fem::assemble_vector(common::array(b), *_loads.work);
  b.scatter_rev(std::plus<double>());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] += b.array()[i];
  return out;
}
} // namespace dolfinx_impact::problems
