// SPDX-License-Identifier: MIT
#pragma once
#include "AssembledBody.h"

namespace dolfinx_impact::problems
{
/// Bodies whose residual and tangent are forms of DOLFINx, with the kernels that FFCx has written: a residual of one's
/// own, follower loads, springs.
class FormBody : public AssembledBody
{
public:
  /// @param[in] u displacement, a coefficient of the forms
  /// @param[in] residual form of rank 1: internal minus external forces
  /// @param[in] tangent form of rank 2: its derivative
  /// @param[in] properties what is known of them; without it, nothing is taken for granted but symmetry
  FormBody(std::shared_ptr<dolfinx::fem::Function<double>> u, Form residual, const Form& tangent,
           solve::BodyProperties properties = {})
      : AssembledBody(u, std::move(residual),
                      std::make_shared<operators::KernelTangent>(std::array{u->function_space(), u->function_space()},
                                                                 std::vector<operators::Integral>{},
                                                                 operators::Coefficients{}, tangent),
                      properties)
  {
  }
};
} // namespace dolfinx_impact::problems
