// SPDX-License-Identifier: MIT
#include "TransientProblem.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::problems
{
TransientProblem::TransientProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v,
                                   std::vector<PrescribedMotion> motions, FunctionsOfTime functions,
                                   std::shared_ptr<Function> a)
    : _u(std::move(u)), _v(v ? std::move(v) : std::make_shared<Function>(_u->function_space())),
      _a(a ? std::move(a) : std::make_shared<Function>(_u->function_space())), _functions(std::move(functions)),
      _supports(*_u, std::move(motions), _functions)
{
  if (_v->function_space() != _u->function_space())
    throw std::invalid_argument("the velocity is on another space than the displacement");
}

std::size_t TransientProblem::num_owned() const
{
  const auto& dofmap = *_u->function_space()->dofmap();
  return std::size_t(dofmap.index_map->size_local()) * dofmap.index_map_bs();
}

void TransientProblem::set_motion(std::span<const double> u, std::span<const double> v, std::span<const double> a)
{
  const auto set = [](Function& f, std::span<const double> values)
  {
    std::copy(values.begin(), values.end(), common::array(*f.x()).begin());
    f.x()->scatter_fwd();
  };
  set(*_u, u);
  set(*_v, v);
  set(*_a, a);
}
} // namespace dolfinx_impact::problems
