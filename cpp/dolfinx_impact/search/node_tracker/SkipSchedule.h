// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace dolfinx_impact::search
{
/// Until when slave nodes need no evaluation. It owns, for each node, the path (RelativeMotion::path) and the
/// deformation of both sides (RelativeMotion::deformation) up to which no negative gap can occur. A node that is not
/// skipped is active.
class SkipSchedule
{
public:
  SkipSchedule() = default;
  explicit SkipSchedule(std::size_t num_nodes) : _limits(num_nodes) {}

  /// Is node i skipped? Then it does not come closer to the surface than half a step's motion.
  /// @param[in] path of the node now, step: motion of the step [L]
  bool skipped(std::size_t i, double path, double step) const { return path + 0.5 * step < _limits[i].path; }
  /// Skip node i until its path has this length [L].
  void skip_until(std::size_t i, double path) { _limits[i].path = path; }
  /// And no longer than until the sum of the deformations is this [L].
  void skip_until_deformed(std::size_t i, double deformation)
  {
    _limits[i].deformation = deformation;
    _least_deformation = std::min(_least_deformation, deformation);
  }
  void activate(std::size_t i) { _limits[i] = {}; }
  void activate_all()
  {
    std::fill(_limits.begin(), _limits.end(), Limits{});
    _least_deformation = std::numeric_limits<double>::infinity();
  }
  /// Must nodes be activated because of deformations?
  bool deformed(double deformation) const { return deformation > _least_deformation; }
  /// Activate the nodes whose limit of deformation is reached.
  /// @param[in] deformation now [L]
  /// @param[in] renewal are deformations counted from zero from now on (RelativeMotion::renew)?
  /// @param[in] step motion of the step: a limit that is reached within it counts as reached at a renewal [L]
  void activate_deformed(double deformation, bool renewal, double step)
  {
    _least_deformation = std::numeric_limits<double>::infinity();
    for (Limits& limits : _limits)
      if (limits.deformation <= deformation + (renewal ? step : 0.0))
        limits = {};
      else
      {
        limits.deformation -= renewal ? deformation : 0.0;
        _least_deformation = std::min(_least_deformation, limits.deformation);
      }
  }

private:
  struct Limits
  {
    double path = -std::numeric_limits<double>::infinity();
    double deformation = std::numeric_limits<double>::infinity();
  };
  std::vector<Limits> _limits;
  double _least_deformation = 0.0; ///< of all nodes
};
} // namespace dolfinx_impact::search
