// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/petsc_check.h"
#include "../solve/Body.h"
#include <memory>
#include <vector>

namespace dolfinx_impact::problems
{
/// Bodies with nodal external forces that do not follow them.
class LoadedBody : public solve::Body
{
public:
  /// @param[in] num_owned owned degrees of freedom
  LoadedBody(std::shared_ptr<solve::Body> body, std::size_t num_owned)
      : Body(body->properties()), _body(std::move(body)), _forces(num_owned)
  {
  }

  Vec residual() override
  {
    Vec b = _body->residual();
    operators::subtract(_forces, b);
    return b;
  }
  Mat tangent() override { return _body->tangent(); }
  std::string fault() override { return _body->fault(); }
  void accept_step() override { _body->accept_step(); }
  state::State state() override { return _body->state(); }
  state::State saved_state() override { return _body->saved_state(); }
  void resume(const state::State& saved) override { _body->resume(saved); }
  std::optional<double> stored_energy() override { return _body->stored_energy(); }
  std::span<const double> origin() const override { return _body->origin(); }

  /// External forces, owned [F].
  std::vector<double>& forces() { return _forces; }

private:
  std::shared_ptr<solve::Body> _body;
  std::vector<double> _forces;
};
} // namespace dolfinx_impact::problems
