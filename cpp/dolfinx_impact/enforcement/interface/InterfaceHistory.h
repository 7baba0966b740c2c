// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Internal variables of a law of the interface at contact points: those of the last converged step, and those of the
/// last evaluation.
struct InterfaceHistory
{
  struct Variable
  {
    std::string name;
    int size = 1;            ///< components
    bool tangential = false; ///< a vector along the surface: it turns with the normal, and keeps its length
    std::vector<double> committed, updated; ///< [q*size + c]
    std::vector<double> turned; ///< of tangential ones: the committed values in the present tangent planes; else empty
  };
  std::vector<Variable> variables;

  /// Make room for points, whose variables are zero.
  void resize(std::size_t num_points);
  /// The values of the last evaluation become those of the last converged step.
  void commit();
};
} // namespace dolfinx_impact::enforcement
