// SPDX-License-Identifier: MIT
#pragma once
#include "../../state/State.h"
#include <array>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Motion at one time, over owned degrees of freedom.
struct Motion
{
  std::vector<double> displacement; ///< [L]
  std::vector<double> velocity;     ///< [L/T]
  std::vector<double> acceleration; ///< M a = forces [L/T^2]
  std::vector<double> mean;         ///< the scheme's acceleration A, a mean of accelerations [L/T^2]

  /// @param[in] block_size degrees of freedom of a node
  state::State state(std::size_t block_size)
  {
    state::State out("motion");
    out.add("displacement", state::Place::node, displacement, block_size);
    out.add("velocity", state::Place::node, velocity, block_size);
    out.add("acceleration", state::Place::node, acceleration, block_size);
    out.add("mean", state::Place::node, mean, block_size);
    return out;
  }
};

/// What functions of time prescribe at one time.
struct TimeValues
{
  double time = 0.0; ///< [T]
  /// Motion of prescribed degrees of freedom, over owned ones of which the others are not read: displacements [L],
  /// velocities [L/T], accelerations [L/T^2].
  std::vector<double> displacement, velocity, acceleration;
  std::vector<double> factors;               ///< amplitudes of loads [1]
  std::vector<std::array<double, 3>> places; ///< displacement of each contact's rigid master; zero for others [L]
  std::vector<std::array<double, 3>> angles; ///< rotation vector of each contact's rigid master; zero for others [1]
  /// External force on each rigid body that moves [F], and torque about its centre [F L].
  std::vector<std::array<double, 3>> body_forces, body_torques;
};
} // namespace dolfinx_impact::integrators
