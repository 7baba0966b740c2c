// SPDX-License-Identifier: MIT
#include "energy.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::integrators
{
Energies EnergySums::energies(InternalEnergy internal) const
{
  const auto work_of = [this](WorkKind kind) { return work[std::size_t(kind)]; };
  const double terms = -work_of(WorkKind::contact) + work_of(WorkKind::damping) + work_of(WorkKind::viscosity) -
                       work_of(WorkKind::external) + work_of(WorkKind::foundation);
  Energies e;
  e.kinetic = kinetic;
  e.internal = internal == InternalEnergy::quadratic ? position - terms_position
               : internal == InternalEnergy::elastic ? elastic
                                                     : residual_work - terms;
  e.internal += foundation;
  e.plastic = internal == InternalEnergy::elastic ? residual_work - terms - elastic : 0.0;
  e.contact = stored;
  e.friction = friction;
  e.impact = -normal;
  e.damping = damped + work_of(WorkKind::damping);
  e.viscosity = work_of(WorkKind::viscosity);
  e.external = load_work + support_work + work_of(WorkKind::external);
  return e;
}

void EnergyGain::update(const Energies& e, double taken, double round_off)
{
  const double value = e.kinetic + e.internal + e.contact + std::max(0.0, taken) - e.external;
  lowest = largest == 0.0 ? value : std::min(lowest, value);
  // Negative dissipation is energy that was gained: it must not make the scale larger.
  double size = std::abs(e.kinetic) + std::abs(e.internal) + std::abs(e.external);
  for (double dissipated : {e.plastic, e.contact, e.friction, e.impact, e.damping, e.viscosity})
    size += std::max(0.0, dissipated);
  largest = std::max(largest, size);
  const double scale = std::max(largest, round_off);
  now = scale > 0.0 ? (value - lowest) / scale : 0.0;
  most = std::max(most, now);
}
} // namespace dolfinx_impact::integrators
