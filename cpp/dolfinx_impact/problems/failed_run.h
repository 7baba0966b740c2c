// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/CentralDifference.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// Number, cell and undeformed coordinates of a node, with numbers as in the mesh's input.
/// @param[in] node number on this rank
std::string describe_node(const dolfinx::fem::FunctionSpace<double>& V, std::int32_t node);

/// About energy that a run has gained: what was found and what to do.
/// @param[in] gain relative to the energies so far [1]
std::string gain_message(double gain);
/// Strain of all cells that bodies may have at the start, of which a residual does not tell what they store [1].
inline constexpr double start_strain = 0.1;
/// About energy that a residual has given: what was found and what to do.
/// @param[in] released the energy [F L]
/// @param[in] limit what bodies may have stored at `start_strain` [F L]
/// @param[in] go_on how to let the run go on
std::string released_message(double released, double limit, const std::string& go_on);

/// Where and why an integrator stopped before the last step.
class FailedRun
{
public:
  /// Collective.
  /// @param[in] contacts names of the integrator's contacts
  /// @param[in] unsolved which local equations of the materials were not solved, or an empty text
  /// @param[in] time of the step that failed [T]
  /// @param[in] step length of the steps [T]
  /// @param[in] stable_step as last found [T]
  FailedRun(const integrators::CentralDifference& integrator, const dolfinx::fem::FunctionSpace<double>& V,
            std::span<const std::string> contacts, std::string unsolved, double time, double step, double stable_step);

  /// Text of the error about a fault that is known.
  /// @param[in] back_at time of the state that the problem has returned to [T]
  std::string message_of(const std::string& fault, double back_at) const;
  /// What happened, when and where, and what to do.
  /// @param[in] back_at time of the state that the problem has returned to [T]
  /// @param[in] stable_step of that state [T]
  std::string message(double back_at, double stable_step) const;

private:
  std::string _unsolved, _place, _contact;
  double _time, _step, _stable_step;
  double _gain, _gain_limit, _released, _release_limit;
  bool _pressed = false; ///< it was held back, but pressed through by a force
  double _passed = 0.0;  ///< facets by which a slave node passed through the master in one step
};
} // namespace dolfinx_impact::problems
