// SPDX-License-Identifier: MIT
#include "InterfacePoints.h"

namespace dolfinx_impact::enforcement
{
void InterfacePoints::resize(std::size_t num_points)
{
  row.resize(num_points);
  for (std::vector<double>* values : {&gap, &gap_rate})
    values->resize(num_points);
  for (std::vector<double>* values : {&slip, &slip_rate, &normal})
    values->resize(num_points * gdim);
  for (std::vector<std::vector<double>>* side : {&slave_fields, &master_fields})
    for (std::vector<double>& values : *side)
      values.resize(num_points);
}
} // namespace dolfinx_impact::enforcement
