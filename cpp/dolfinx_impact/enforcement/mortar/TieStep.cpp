// SPDX-License-Identifier: MIT
#include "TieStep.h"
#include <algorithm>

namespace dolfinx_impact::enforcement
{
void TieStep::assign_numbers(operators::Halo& halo, std::span<const double> inverse_mass)
{
  if (_ties.empty())
    return;
  _halo = &halo;
  if (!_system)
  {
    std::vector<const TieConditions*> conditions;
    for (const ExplicitTie* tie : _ties)
      conditions.push_back(&tie->conditions());
    _system = std::make_unique<TieSystem>(std::move(conditions), inverse_mass);
  }
  _force.assign(std::size_t(halo.num_nodes()) * _ties[0]->conditions().gdim(), 0.0);
  _b.assign(_system->size(), 0.0);
  _z.assign(_system->size(), 0.0);
}

void TieStep::correct(const PredictedStep& step, std::span<double> u, std::span<double> f)
{
  const int g = _ties[0]->conditions().gdim();
  std::size_t at = 0;
  for (const ExplicitTie* tie : _ties)
  {
    tie->jumps(u, std::span(_b).subspan(at, tie->size()));
    at += tie->size();
  }
  for (double& b : _b)
    b /= -step.h;
  _system->solve(_b, _z);
  std::ranges::fill(_force, 0.0);
  at = 0;
  for (ExplicitTie* tie : _ties)
  {
    tie->add_forces(std::span(_z).subspan(at, tie->size()), _force);
    at += tie->size();
  }
  _halo->reverse(_force, g);
  _before = _after = 0.0;
  for (std::size_t k = 0; k < std::size_t(_halo->num_owned()) * g; ++k)
  {
    u[k] += step.h * step.inverse_mass[k] * _force[k];
    f[k] += _force[k];
    if (step.inverse_mass[k] == 0.0)
    {
      _before -= 0.5 * _force[k] * step.du_before[k];
      _after -= 0.5 * _force[k] * step.du[k];
    }
  }
  _halo->forward(u, g);
}
} // namespace dolfinx_impact::enforcement
