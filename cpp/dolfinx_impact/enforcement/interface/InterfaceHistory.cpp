// SPDX-License-Identifier: MIT
#include "InterfaceHistory.h"

namespace dolfinx_impact::enforcement
{
void InterfaceHistory::resize(std::size_t num_points)
{
  for (Variable& v : variables)
  {
    for (std::vector<double>* values : {&v.committed, &v.updated})
      values->assign(num_points * v.size, 0.0);
    v.turned.assign(v.tangential ? num_points * v.size : 0, 0.0);
  }
}

void InterfaceHistory::commit()
{
  for (Variable& v : variables)
    v.committed = v.updated;
}
} // namespace dolfinx_impact::enforcement
