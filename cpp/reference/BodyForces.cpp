// SPDX-License-Identifier: MIT
#include "BodyForces.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Forces of the displacement u = X: strains of 1.
double size_of_unit_strains(const Model& model, const Csr& K)
{
  Matrix points = model.field().points;
  points.rowwise() -= points.colwise().mean().eval();
  return K.dot(Eigen::Map<const Vector>(points.data(), points.size())).norm();
}
} // namespace

ElasticForces::ElasticForces(const Model& model, Rule rule)
    : model_(model), rule_(std::move(rule)), elastic_(model.stiffness(rule_)), stiffness_(elastic_)
{
  stiffness_.add(model.springs());
}

Vector ElasticForces::force(const Vector& u) const
{
  model_.check_vector(u);
  return model_.linear() ? stiffness_.dot(u) : model_.internal_force(rule_, u);
}

Csr ElasticForces::tangent(const Vector& u) const
{
  return model_.linear() ? stiffness_ : model_.tangent(rule_, u);
}

Csr ElasticForces::damping_stiffness(const Vector& u) const
{
  return model_.linear() ? elastic_ : model_.elastic_tangent(rule_, u);
}

double ElasticForces::unit_size() const
{
  return model_.linear() ? 0 : size_of_unit_strains(model_, stiffness_);
}

Vector PlasticForces::force(const Vector& u) const
{
  return body_.evaluate(u, false).force + body_.model().springs().dot(u);
}

Csr PlasticForces::tangent(const Vector& u) const
{
  Csr K = body_.evaluate(u, true).tangent;
  K.add(body_.model().springs());
  return K;
}

Csr PlasticForces::damping_stiffness(const Vector& /*u*/) const
{
  if (body_.finite_strain())
    throw std::invalid_argument("a plastic body of finite strain has no elastic stiffness that could damp it: beta is "
                                "for small strain");
  return body_.model().stiffness(rule_);
}

double PlasticForces::unit_size() const
{
  return size_of_unit_strains(body_.model(), body_.evaluate(Vector::Zero(body_.model().num_dofs()), true).tangent);
}
} // namespace impact_reference
