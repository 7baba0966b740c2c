#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace impact::integrators
{
/// Whose work a force is.
enum class Account
{
  contact,
  damping,
  viscosity,
  external
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

/// What a rank contributes at a time level; sums over ranks make Energies.
struct Local
{
  enum Index
  {
    kinetic,
    speed,
    position, ///< u . residual/2
    residual_work,
    load_work,
    support_work,
    damped, ///< by mass-proportional damping
    part_work,
    parts_position = part_work + 4,
    stored,
    friction,
    normal,      ///< work of the normal forces of contact, of springs without what they store
    kinematic,   ///< the part of it that kinematic contact does
    taken,       ///< minus that of kinematic contact, with the motion after the last forces
    recoverable, ///< taken from nodes that are still closed
    search,      ///< contacts that need a search
    stop,        ///< ranks that were asked to stop
    passed,      ///< contacts that a node went through
    size
  };
};

/// Energies at a time level, sums over ranks [F L].
struct Energies
{
  enum Index
  {
    kinetic,
    internal,
    contact, ///< stored in springs
    friction,
    impact, ///< what normal forces of contact take from the bodies and do not store
    damping,
    viscosity,
    external,
    size
  };
  std::array<double, size> values{};
};

/// @param[in] sums over ranks. linear: internal energy is u . F/2
inline Energies energies_of(std::span<const double> e, bool linear)
{
  const double* work = &e[Local::part_work];
  const double parts = -work[int(Account::contact)] + work[int(Account::damping)] + work[int(Account::viscosity)] -
                       work[int(Account::external)];
  Energies out;
  auto& v = out.values;
  v[Energies::kinetic] = e[Local::kinetic];
  v[Energies::internal] = linear ? e[Local::position] - e[Local::parts_position] : e[Local::residual_work] - parts;
  v[Energies::contact] = e[Local::stored];
  v[Energies::friction] = e[Local::friction];
  v[Energies::impact] = -e[Local::normal];
  v[Energies::damping] = e[Local::damped] + work[int(Account::damping)];
  v[Energies::viscosity] = work[int(Account::viscosity)];
  v[Energies::external] = e[Local::load_work] + e[Local::support_work] + work[int(Account::external)];
  return out;
}

/// What a run has gained without the work of loads and supports: kinetic, internal and stored energy, with what
/// kinematic contact has taken, less external work, above the lowest that this has been so far. All forces but these
/// only take, so it is zero but for fluctuations.
struct EnergyGain
{
  double lowest = 0.0;
  double largest = 0.0; ///< sum of the energies so far, what gains are relative to; 0: nothing was seen [F L]
  double now = 0.0;     ///< relative to it [1]
  double most = 0.0;    ///< of `now`, since the run began or went on from a checkpoint [1]

  /// @param[in] taken by kinematic contact so far, which may give it back when nodes leave [F L]
  void see(const Energies& energies, double taken)
  {
    const auto& v = energies.values;
    const double value = v[Energies::kinetic] + v[Energies::internal] + v[Energies::contact] + std::max(0.0, taken) -
                         v[Energies::external];
    lowest = largest == 0.0 ? value : std::min(lowest, value);
    // Negative dissipation is what is gained: it must not hide itself.
    double size = 0.0;
    for (int k = 0; k < Energies::size; ++k)
    {
      const bool taken = k != Energies::kinetic && k != Energies::internal && k != Energies::external;
      size += taken ? std::max(0.0, v[k]) : std::abs(v[k]);
    }
    largest = std::max(largest, size);
    now = largest > 0.0 ? (value - lowest) / largest : 0.0;
    most = std::max(most, now);
  }
};
} // namespace impact::integrators
