// SPDX-License-Identifier: MIT
#pragma once
#include "Motion.h"
#include <array>
#include <mpi.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Forces at one time, over owned degrees of freedom [F].
struct Forces
{
  std::vector<double> internal;
  std::vector<double> external; ///< of loads
  std::vector<double> damping;  ///< that resist the velocity
  std::vector<double> support;  ///< of supports on the bodies, zero elsewhere
  /// Of each contact's rigid master on its slave; zero for deformable ones.
  std::vector<std::array<double, 3>> obstacles;
  /// Of each contact on its rigid master, torque about its centre; zero for those that do not turn as prescribed [F L].
  std::vector<std::array<double, 3>> torques = {};
};

/// Works so far, over all ranks [F L].
struct Works
{
  double internal = 0.0; ///< against internal forces
  double external = 0.0; ///< of loads, of supports, and of obstacles that move
  double damping = 0.0;  ///< against damping
};

/// Sums up the works of implicit steps by the trapezoidal rule; docs/implicit/energies.md.
class ImplicitEnergyBalance
{
public:
  /// Forces at the present time.
  const Forces& forces() const { return _forces; }
  void set_forces(Forces forces) { _forces = std::move(forces); }
  const Works& works() const { return _works; }
  void set_works(const Works& works) { _works = works; }

  /// Add the works of a step. Collective.
  /// @param[in] forces at its end
  /// @param[in] before, after displacements at its start and end, owned [L]
  /// @param[in] from, to displacements of rigid masters then [L]
  /// @param[in] turned rotation vectors of rigid masters in the step [1]
  void add_step(MPI_Comm comm, Forces forces, std::span<const double> before, std::span<const double> after,
                std::span<const std::array<double, 3>> from, std::span<const std::array<double, 3>> to,
                std::span<const std::array<double, 3>> turned);

  /// @param[in] block_size degrees of freedom of a node
  state::State state(std::size_t block_size)
  {
    state::State out("account");
    out.add("internal", state::Place::node, _forces.internal, block_size);
    out.add("external", state::Place::node, _forces.external, block_size);
    out.add("damping", state::Place::node, _forces.damping, block_size);
    out.add("support", state::Place::node, _forces.support, block_size);
    for (std::size_t k = 0; k < _forces.obstacles.size(); ++k)
      out.add("obstacle " + std::to_string(k), state::Place::all, state::View(std::span(_forces.obstacles[k])), 3);
    for (std::size_t k = 0; k < _forces.torques.size(); ++k)
      out.add("torque " + std::to_string(k), state::Place::all, state::View(std::span(_forces.torques[k])), 3);
    out.add("internal work", state::Place::all, _works.internal);
    out.add("external work", state::Place::all, _works.external);
    out.add("damping work", state::Place::all, _works.damping);
    return out;
  }

private:
  Forces _forces;
  Works _works;
};
} // namespace dolfinx_impact::integrators
