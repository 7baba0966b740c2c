// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <bit>
#include <cstddef>

namespace dolfinx_impact::integrators
{
/// Which energy the work of a force counts to.
enum class WorkKind
{
  contact,
  damping,
  viscosity,
  external,
  foundation ///< linear springs to the ground, whose energy u . force/2 is internal energy
};

/// What the internal energy is computed from.
enum class InternalEnergy
{
  quadratic, ///< u . F/2, of linear bodies
  work,      ///< work of the internal force
  elastic    ///< elastic energy of the materials; the rest of the work is plastic
};

/// Work of a force by the trapezoidal rule: half of a step's motion before a time level, half after it.
struct Work
{
  double done = 0.0;   ///< without the halves of the present time level [F L]
  double before = 0.0; ///< of the step that led here [F L]
  double value() const { return done + before; }
  void commit(double after)
  {
    done += before + after;
    before = 0.0;
  }
};

/// Energies at a time level, sums over ranks [F L]; docs/explicit/energies.md.
struct Energies
{
  double kinetic = 0.0;
  double internal = 0.0; ///< stored in the bodies and their foundations
  double contact = 0.0;  ///< stored in springs
  double friction = 0.0;
  double impact = 0.0; ///< what normal forces of contact take from the bodies and do not store
  double damping = 0.0;
  double viscosity = 0.0;
  double plastic = 0.0; ///< work of the internal forces that the bodies do not store
  double external = 0.0;

  static constexpr std::size_t size = 9;
  /// In the order above.
  std::array<double, size> values() const { return std::bit_cast<std::array<double, size>>(*this); }
};

/// What a rank contributes at a time level. Sums over ranks make Energies, and tell all ranks alike what to do next.
struct EnergySums
{
  double kinetic = 0.0;
  double speed = 0.0;    ///< kinetic energy with the velocities after the time level alone
  double position = 0.0; ///< u . residual/2
  double residual_work = 0.0;
  double elastic = 0.0;   ///< energy of materials with internal variables and of those beside them
  double load_work = 0.0; ///< of loads and of contact forces on rigid masters that move
  double support_work = 0.0;
  double damped = 0.0;          ///< by mass-proportional damping
  std::array<double, 5> work{}; ///< of force terms, by WorkKind
  double terms_position = 0.0;  ///< u . force/2 of force terms, with the signs that they have in the residual
  double foundation = 0.0;      ///< stored in springs to the ground
  double stored = 0.0;          ///< in springs of contact
  double friction = 0.0;
  double normal = 0.0;        ///< work of the normal forces of contact, of springs without what they store
  double kinematic = 0.0;     ///< the part of `normal` that kinematic contact does
  double taken = 0.0;         ///< minus that of kinematic contact, with the motion after the last forces
  double recoverable = 0.0;   ///< taken from nodes that are still closed
  double searches_due = 0.0;  ///< contacts that need a search
  double stops_asked = 0.0;   ///< ranks that were asked to stop
  double deformed = 0.0;      ///< ranks where a cell has deformed so far that its stable step may have changed
  double passages = 0.0;      ///< contacts that a node went through
  double unsolved = 0.0;      ///< points whose local equations were not solved
  double half_kinetic = 0.0;  ///< kinetic energy half a step before the time level
  double half_external = 0.0; ///< work of external forces up to then

  static constexpr std::size_t size = 28;
  std::array<double, size> values() const { return std::bit_cast<std::array<double, size>>(*this); }
  static EnergySums of(const std::array<double, size>& values) { return std::bit_cast<EnergySums>(values); }

  Energies energies(InternalEnergy internal) const;
};

/// What a run has gained without the work of loads and supports: kinetic, internal and stored energy, with what
/// kinematic contact has taken, less external work, above the lowest that this has been so far. All forces but these
/// only take, so it is zero but for fluctuations.
struct EnergyGain
{
  double lowest = 0.0;
  double largest = 0.0; ///< sum of the energies so far, what gains are relative to; 0: nothing was seen [F L]
  double now = 0.0;     ///< relative to it [1]
  double most = 0.0;    ///< of `now`, since the run began or went on from a checkpoint [1]

  /// @param[in] energies at a time level
  /// @param[in] taken by kinematic contact so far, which may give it back when nodes leave [F L]
  /// @param[in] round_off energy that rounding alone may bring: gains are relative to no less [F L]
  void update(const Energies& energies, double taken, double round_off);
};
} // namespace dolfinx_impact::integrators
