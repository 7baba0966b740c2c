// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/interface/FrictionLaw.h"
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::rolling
{
/// What unit forces at candidate nodes change, in the axes of the mesh, [((i*gdim + a)*n + j)*gdim + b]: component a at
/// node i by a force of component b at node j.
struct Compliance
{
  std::vector<double> jump;     ///< displacements of slave against master [L/F]
  std::vector<double> velocity; ///< velocities of slave against master [L/(T F)]
};

/// A law of friction of some of the candidate nodes.
struct CandidateLaw
{
  const enforcement::FrictionLaw* law;
  std::vector<std::size_t> nodes;     ///< numbers among the candidates
  std::vector<double> areas;          ///< of these, by which forces are tractions [L^2]
  enforcement::FrictionPoints points; ///< normals and fields of these
};

/// Constants of the candidate nodes of a FrictionProblem.
struct CandidateNodes
{
  int gdim = 3;
  std::vector<double> frames;        ///< normal and tangents as rows, [(i*gdim + a)*gdim + c]
  std::vector<double> friction;      ///< coefficients of nodes without a law
  std::vector<std::int8_t> carriers; ///< nodes with a multiplier
  std::vector<std::int8_t> held;     ///< normals and tangents along which nothing can move, [i*gdim + a]
  std::vector<CandidateLaw> laws = {};
};

/// Bodies at given multipliers, of which all else is a linear function; by candidate node, vectors [i*gdim + c].
struct LinearState
{
  std::vector<double> forces; ///< multipliers as nodal forces [F]
  std::vector<double> gap;    ///< [L]
  std::vector<double> slip;   ///< velocities of slave against master [L/T]

  /// This state and a multiple of another one's gaps and slip velocities.
  LinearState plus(double factor, const LinearState& other) const;
};

/// Contact and friction of the nodes of linear bodies, reduced to their multipliers: nodal forces that obey Coulomb's
/// law, a dense problem; docs/rolling.md.
///
/// The equations of the nodes (Alart and Curnier 1991) are semi-smooth. The method of Levenberg and Marquardt solves
/// them where it starts near enough. Where it ends at a kink, it starts again from what some iterations of a splitting
/// method (Lions and Mercier 1979) make of the tractions, which are rough and come from anywhere. Nothing communicates.
class FrictionProblem
{
public:
  FrictionProblem(CandidateNodes nodes, const Compliance& compliance);

  /// Forces, and what went wrong; empty if nothing did.
  struct Solution
  {
    std::vector<double> forces; ///< [i*gdim + c] [F]
    std::string fault;
  };
  /// Forces that obey contact and friction.
  /// @param[in] state of the bodies
  /// @param[in] start forces to start from; empty: those of the state [F]
  Solution solve(const LinearState& state, std::span<const double> start = {}) const;

private:
  /// The equations of the nodes at given forces, in frames: normal, then tangents.
  struct Equations
  {
    std::vector<double> forces, error;        ///< [i*gdim + a] [F]
    std::vector<std::int8_t> active, sliding; ///< nodes in contact; those that slip
    std::vector<double> direction;            ///< of the trial tractions, [i*(gdim - 1) + t]
    std::vector<double> kappa;          ///< friction times pressure over the length of the trial traction, at most 1
    std::vector<double> limit_by_force; ///< derivative of friction times pressure by the pressure
    std::vector<double> limit_by_slip;  ///< and by the slip velocity in the frame, [i*(gdim - 1) + t]

    double size() const;
    bool solved(double tolerance) const;
  };

  /// Coefficients of friction, and derivatives by the normal force and the slip velocity in the frame.
  struct Friction
  {
    std::vector<double> value, by_force, by_slip;
  };
  Friction friction(std::span<const double> pressure, std::span<const double> slip) const;
  std::vector<double> in_frames(std::span<const double> vectors) const;
  std::vector<double> in_axes(std::span<const double> vectors) const;
  Equations equations(const LinearState& base, std::vector<double> forces, double caution) const;
  bool newton(const LinearState& base, std::vector<double>& forces, double caution) const;
  std::vector<double> derivative(const Equations& at, std::span<const int> on, double caution) const;
  std::vector<double> split(const LinearState& base, std::span<const double> forces, double weight, int count) const;
  bool free(std::size_t i, int a) const { return _nodes.carriers[i] && !_nodes.held[i * _nodes.gdim + a]; }

  CandidateNodes _nodes;
  std::size_t _num;
  std::vector<double> _normal_stiffness; ///< [F/L]
  std::vector<double> _resistance;       ///< [F T/L]
  std::vector<double> _gaps;             ///< change of gaps by forces, [i*n*gdim + j*gdim + b] [L/F]
  std::vector<double> _slips;            ///< of slip velocities, [(i*(gdim - 1) + t)*n*gdim + j*gdim + b] [L/(T F)]
};
} // namespace dolfinx_impact::rolling
