// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"
#include <cstdint>
#include <functional>

namespace impact_reference
{
class Model;

/// Pressure of linear tetrahedra and triangles averaged at the nodes, which then do not lock
/// (docs/averaged_pressure.md): W = sum over nodes of V_a U(m_a), with m_a the mean of a measure m of the change of
/// volume over the cells of one material around the node, weighted by their undeformed volumes, and V_a their shares of
/// these volumes.
///
/// Written with volumes of cells and their derivatives by positions of vertices: no gradients, no stresses.
class NodalPressure
{
public:
  /// A volumetric law.
  struct Law
  {
    std::function<double(double)> measure, measure_slope; ///< m and dm/dJ of J = v / V; small strain: of 1 + tr eps
    std::function<double(double)> energy, pressure;       ///< U(m) and dU/dm [F/L^2]
  };
  struct Answer
  {
    Vector force;      ///< [F]
    double energy = 0; ///< [F L]
  };

  /// @param model must outlive this object
  /// @throws std::invalid_argument for other cells than simplices of degree 1, plane stress or bodies of revolution
  explicit NodalPressure(const Model& model);

  /// Forces of pressures at nodes.
  /// @param small volumes are linear in the displacements
  /// @param law of a material, by its tag
  Answer at_nodes(const Vector& u, bool small, const std::function<Law(int)>& law) const;
  /// The same with means over each cell alone: forces that plain cells have.
  Answer in_cells(const Vector& u, bool small, const std::function<Law(int)>& law) const;

  struct Volume
  {
    double value;
    Matrix slope; ///< by the positions of the vertices (num_vertices, gdim) [L^(d-1)]
  };
  /// Of a simplex.
  /// @param x positions of its vertices (num_vertices, gdim) [L]
  static Volume volume(const Matrix& x);

private:
  Answer evaluate(const Vector& u, bool small, const std::function<Law(int)>& law, bool nodes) const;

  const Model& model_;
};

/// lambda/2 m^2 of the laws linear_elastic (m = tr eps) and neo_hookean (m = ln J).
NodalPressure::Law squared_law(double lambda, bool small);
/// K/2 ((J^2 - 1)/2 - ln J) of Simo's law, or K/2 (tr eps)^2 of small strain.
NodalPressure::Law plastic_law(double bulk, bool small);
} // namespace impact_reference
