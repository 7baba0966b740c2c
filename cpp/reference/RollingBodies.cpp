// SPDX-License-Identifier: MIT
#include "RollingBodies.h"
#include <stdexcept>

namespace impact_reference
{
FlowMatrices flow_matrices(const Model& model, const Rule& rule, const std::vector<std::int64_t>& body,
                           const std::vector<BodyFlow>& flows)
{
  if (std::int64_t(body.size()) != model.num_cells())
    throw std::invalid_argument("there are " + std::to_string(model.num_cells()) + " cells, but " +
                                std::to_string(body.size()) + " numbers of bodies");
  const Sampler sampler = model.sampler(rule);
  const int d = model.gdim();
  FlowMatrices result{model.pattern().matrix(d), model.pattern().matrix(d), Vector::Zero(model.num_dofs())};
  for (std::int64_t c = 0; c < model.num_cells(); ++c)
  {
    if (body[c] < 0 or body[c] >= std::int64_t(flows.size()))
      throw std::invalid_argument("cell " + std::to_string(c) + " belongs to no body with a flow");
    const BodyFlow& flow = flows[body[c]];
    const Matrix X = model.cell_points(c);
    const Ale e = flow.spin.size() > 0 ? ale(sampler, X, model.material(c), flow.spin, flow.centre, c)
                                       : ale_translation(sampler, X, model.material(c), flow.velocity, c);
    const auto nodes = model.cell_nodes(c);
    model.pattern().add(result.gyroscopic, d, nodes, e.gyroscopic);
    model.pattern().add(result.inertia, d, nodes, e.inertia);
    model.scatter(result.load, d, c, e.load);
  }
  return result;
}

RollingBodies::RollingBodies(const Model& model, Rule rule, Csr inertia)
    : internal_(model, std::move(rule)), inertia_(std::move(inertia))
{
}

Vector RollingBodies::force(const Vector& u) const
{
  return internal_.force(u) - inertia_.dot(u);
}

Csr RollingBodies::tangent(const Vector& u) const
{
  Csr result = internal_.tangent(u);
  if (result.indices != inertia_.indices)
    throw std::logic_error("inertia and stiffness have different patterns");
  for (std::size_t k = 0; k < result.data.size(); ++k)
    result.data[k] -= inertia_.data[k];
  return result;
}

double RollingBodies::size(const Vector& u, const Vector& force) const
{
  return internal_.force(u).norm() + force.norm();
}
} // namespace impact_reference
