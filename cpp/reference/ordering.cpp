// SPDX-License-Identifier: MIT
#include "ordering.h"
#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Nodes = std::vector<std::int64_t>;

class Dissection
{
public:
  Dissection(const Field& field, const Pattern& pattern)
      : field_(field), pattern_(pattern), side_(field.points.rows(), 0)
  {
  }

  void run(const Nodes& nodes, Nodes& order)
  {
    if (nodes.size() <= 60)
    {
      order.insert(order.end(), nodes.begin(), nodes.end());
      return;
    }
    const Matrix x = field_.points(nodes, Eigen::all);
    Eigen::Index axis;
    (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff(&axis);
    std::vector<double> place(x.col(axis).begin(), x.col(axis).end());
    std::nth_element(place.begin(), place.begin() + place.size() / 2, place.end());
    const double cut = place[place.size() / 2];
    Nodes left, right, separator;
    const int mark = ++mark_; // marks of other calls are smaller
    for (std::int64_t node : nodes)
      if (field_.points(node, axis) < cut)
      {
        left.push_back(node);
        side_[node] = mark;
      }
    if (left.empty())
    {
      order.insert(order.end(), nodes.begin(), nodes.end());
      return;
    }
    for (std::int64_t node : nodes)
      if (side_[node] != mark)
      {
        const auto list = pattern_.neighbours(node);
        const bool touches = std::any_of(list.begin(), list.end(), [&](std::int64_t n) { return side_[n] == mark; });
        (touches ? separator : right).push_back(node);
      }
    run(left, order);
    run(right, order);
    order.insert(order.end(), separator.begin(), separator.end());
  }

private:
  const Field& field_;
  const Pattern& pattern_;
  std::vector<int> side_;
  int mark_ = 0;
};
} // namespace

Nodes dissection(const Field& field, const Pattern& pattern)
{
  Nodes nodes(field.points.rows()), order;
  std::iota(nodes.begin(), nodes.end(), 0);
  Dissection(field, pattern).run(nodes, order);
  return order;
}

Nodes free_numbers(const Nodes& order, int block, const Nodes& fixed_dofs)
{
  const auto num_dofs = std::int64_t(order.size()) * block;
  Nodes numbers(num_dofs, 0);
  for (std::int64_t dof : fixed_dofs)
  {
    if (dof < 0 or dof >= num_dofs)
      throw std::invalid_argument("fixed degree of freedom " + std::to_string(dof) +
                                  " is out of range: they are numbered 0 to " + std::to_string(num_dofs - 1));
    numbers[dof] = -1;
  }
  std::int64_t count = 0;
  for (std::int64_t node : order)
    for (int a = 0; a < block; ++a)
      if (numbers[block * node + a] == 0)
        numbers[block * node + a] = count++;
  return numbers;
}
} // namespace impact_reference
