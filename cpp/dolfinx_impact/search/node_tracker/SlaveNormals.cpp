// SPDX-License-Identifier: MIT
#include "SlaveNormals.h"

namespace dolfinx_impact::search
{
namespace
{
constexpr double renewal = 0.8; ///< of normals: if one can have changed by more, all are evaluated anew
} // namespace

void SlaveNormals::renew()
{
  for (Stored& stored : _stored)
  {
    stored.deformation = std::numeric_limits<double>::infinity();
    stored.rate = 1.0;
  }
}

const double* SlaveNormals::present(std::size_t i, const double* u, RelativeMotion& motion, double* space)
{
  Stored& stored = _stored[i];
  if (_keep && std::isfinite(stored.deformation))
    return stored.normal;
  ++_evaluations;
  if (motion.slave_deformation() < stored.deformation)
  {
    const double rate = _evaluate.evaluate(i, {u}, stored.normal);
    stored.rate = _keep ? 0.0 : rate;
    stored.deformation = motion.slave_deformation();
    return stored.normal;
  }
  if (rotation(i, motion) > renewal)
    motion.request_renewal();
  _evaluate.evaluate(i, {u}, space);
  return space;
}
} // namespace dolfinx_impact::search
