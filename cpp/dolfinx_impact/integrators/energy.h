#pragma once
#include <array>
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
    kinematic,   ///< work of the normal forces of kinematic contact
    taken,       ///< minus the same with the motion after the last forces
    recoverable, ///< taken from nodes that are still closed
    search,      ///< contacts that need a search
    stop,        ///< ranks that were asked to stop
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
    impact, ///< what normal forces of kinematic contact take out
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
  v[Energies::impact] = -e[Local::kinematic];
  v[Energies::damping] = e[Local::damped] + work[int(Account::damping)];
  v[Energies::viscosity] = work[int(Account::viscosity)];
  v[Energies::external] = e[Local::load_work] + e[Local::support_work] + work[int(Account::external)];
  return out;
}
} // namespace impact::integrators
