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
  FunctionBody(Functions functions, BodyProperties properties) : Body(properties), _functions(std::move(functions)) {}

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
  std::span<const double> origin() const override
  {
    if (_functions.origin)
      _origin = _functions.origin();
    return _origin;
  }

private:
  Functions _functions;
  mutable std::vector<double> _origin;
};
} // namespace dolfinx_impact::solve
