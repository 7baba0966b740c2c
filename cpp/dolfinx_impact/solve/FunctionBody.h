// SPDX-License-Identifier: MIT
#pragma once
#include "Body.h"
#include <functional>
#include <utility>
#include <vector>

namespace dolfinx_impact::solve
{
/// Bodies whose residual and tangent are functions of one's own, for example assembled by DOLFINx from forms.
class FunctionBody : public Body
{
public:
  struct Functions
  {
    std::function<Vec()> residual;
    std::function<Mat()> tangent;
    std::function<std::string()> fault;                   ///< may be empty
    std::function<void()> accept_step;                    ///< may be empty
    std::function<std::vector<double>()> origin;          ///< may be empty
    std::function<std::optional<double>()> stored_energy; ///< may be empty
  };
  FunctionBody(Functions functions, BodyProperties properties)
      : _functions(std::move(functions)), _properties(properties)
  {
  }

  Vec residual() override { return _functions.residual(); }
  Mat tangent() override { return _functions.tangent(); }
  std::string fault() override { return _functions.fault ? _functions.fault() : ""; }
  void accept_step() override
  {
    if (_functions.accept_step)
      _functions.accept_step();
  }
  std::optional<double> stored_energy() override
  {
    return _functions.stored_energy ? _functions.stored_energy() : std::nullopt;
  }
  bool linear() const override { return _properties.linear; }
  bool keeps_tangent() const override { return _properties.keeps_tangent; }
  bool symmetric() const override { return _properties.symmetric; }
  bool inelastic() const override { return _properties.inelastic; }
  bool has_inertia() const override { return _properties.has_inertia; }
  bool has_springs() const override { return _properties.has_springs; }
  bool rounds_positions() const override { return _properties.rounds_positions; }
  std::span<const double> origin() const override
  {
    if (_functions.origin)
      _origin = _functions.origin();
    return _origin;
  }

private:
  Functions _functions;
  BodyProperties _properties;
  mutable std::vector<double> _origin;
};
} // namespace dolfinx_impact::solve
