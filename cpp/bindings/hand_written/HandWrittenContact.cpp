// SPDX-License-Identifier: MIT
#include "HandWrittenContact.h"
#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace dolfinx_impact::hand_written
{
namespace
{
constexpr std::size_t other_data = std::size_t(1) << 23; ///< numbers that push all else out of the caches
} // namespace

bool HandWrittenContact::available()
{
#if defined(__x86_64__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

HandWrittenContact::HandWrittenContact(std::span<const double> x, std::span<const std::int32_t> slaves,
                                       std::span<const std::int32_t> facets, double stiffness, double friction)
    : _forces(x.size(), 0.0), _others(other_data, 0.0), _stiffness(stiffness), _friction(friction)
{
  if (!available())
    throw std::invalid_argument("contact that is written by hand needs a processor with AVX2");
  if (slaves.empty() || slaves.size() % 4 != 0 || facets.size() != 4 * slaves.size() || x.size() % 3 != 0)
    throw std::invalid_argument(
        "positions have three entries per node, the number of slave nodes is a multiple of four, "
        "and each has a facet of four nodes");
  const std::int32_t num_nodes = std::int32_t(x.size() / 3);
  for (const std::span<const std::int32_t> nodes : {slaves, facets})
    if (std::ranges::min(nodes) < 0 || std::ranges::max(nodes) >= num_nodes)
      throw std::invalid_argument("a node of the contact is not among the nodes");
  _numbers.assign(facets.begin(), facets.end());
  std::ranges::sort(_numbers);
  const auto rest = std::ranges::unique(_numbers);
  _numbers.erase(rest.begin(), rest.end());
  for (const std::int32_t node : _numbers)
    _X.insert(_X.end(), x.begin() + 3 * node, x.begin() + 3 * node + 3);
  _masters.resize(_numbers.size());
  _sums.resize((_numbers.size() + 1) / 2); // four of its eight numbers for each node
  for (std::size_t i = 0; i < slaves.size(); ++i)
  {
    SlaveNode slave;
    slave.node = slaves[i];
    std::copy_n(x.begin() + 3 * slaves[i], 3, slave.X);
    for (int j = 0; j < 4; ++j)
      slave.corners[j] = std::int32_t(std::ranges::lower_bound(_numbers, facets[4 * i + j]) - _numbers.begin());
    _slaves.push_back(slave);
  }
}

double HandWrittenContact::evaluate(std::span<const double> u, std::span<const double> du, bool cold)
{
  if (u.size() != _forces.size() || du.size() != _forces.size())
    throw std::invalid_argument("displacements and their increments have three entries per node");
  if (cold)
    for (double& value : _others)
      value += 1.0;
  const auto begin = std::chrono::steady_clock::now();
#if defined(__x86_64__) // elsewhere there is no object of this class
  add_contact_forces({_slaves.data(), _slaves.size(), _masters.data(), _sums.data()->x, _numbers.data(), _X.data(),
                      _numbers.size(), u.data(), du.data(), _forces.data(), _stiffness, _friction});
#endif
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<double> HandWrittenContact::gap() const
{
  std::vector<double> out;
  for (const SlaveNode& slave : _slaves)
    out.push_back(slave.gap);
  return out;
}
} // namespace dolfinx_impact::hand_written
