// SPDX-License-Identifier: MIT
#include "BodyForces.h"

namespace impact_reference
{
Csr ElasticForces::tangent(const Vector& u) const
{
  return model_.linear() ? model_.stiffness(rule_) : model_.tangent(rule_, u);
}
} // namespace impact_reference
