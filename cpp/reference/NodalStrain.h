// SPDX-License-Identifier: MIT
#pragma once
#include "NodalPressure.h"

namespace impact_reference
{
/// Strain of linear tetrahedra and triangles averaged at the nodes, which then bend (docs/averaged_pressure.md):
/// W = sum over nodes of V_a w(H_a), with H_a the mean displacement gradient of the cells of one material around the
/// node, weighted by their undeformed volumes, and V_a their shares of these volumes.
///
/// Gradients of shape functions are derivatives of the cell's volume by the positions of its vertices, over the volume.
class NodalStrain
{
public:
  /// Energy and its derivative by the displacement gradient.
  struct Law
  {
    std::function<double(const Matrix&)> energy; ///< [F L/L^3]
    std::function<Matrix(const Matrix&)> stress; ///< [F/L^2]
  };

  /// @param model must outlive this object
  /// @throws std::invalid_argument as NodalPressure
  explicit NodalStrain(const Model& model);

  /// Energy and forces of the nodes' mean gradients.
  /// @param law of a material, by its tag
  NodalPressure::Answer at_nodes(const Vector& u, const std::function<Law(int)>& law) const;

private:
  const Model& model_;
};

/// mu eps:eps.
NodalStrain::Law squared_strain_law(double mu);
/// mu/2 (tr C - 3) - mu ln J, in the plane with the stretch 1 across it.
NodalStrain::Law stretched_law(double mu);
} // namespace impact_reference
