// SPDX-License-Identifier: MIT
#include "nodal_sums.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <dolfinx/la/Vector.h>
#include <functional>

namespace dolfinx_impact::operators
{
using dolfinx::common::IndexMap;

std::vector<double> sum_over_ranks(const std::shared_ptr<const IndexMap>& map, std::vector<double> values, int block)
{
  dolfinx::la::Vector<double> v(map, block);
  std::copy(values.begin(), values.end(), common::array(v).begin());
  v.scatter_rev(std::plus<double>());
  v.scatter_fwd();
  std::copy(v.array().begin(), v.array().end(), values.begin());
  return values;
}

std::vector<double> from_owners(const std::shared_ptr<const IndexMap>& map, std::vector<double> values, int block)
{
  dolfinx::la::Vector<double> v(map, block);
  std::copy(values.begin(), values.end(), common::array(v).begin());
  v.scatter_fwd();
  std::copy(v.array().begin(), v.array().end(), values.begin());
  return values;
}
} // namespace dolfinx_impact::operators
