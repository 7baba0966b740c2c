// SPDX-License-Identifier: MIT
#pragma once
#include "ContactForces.h"
#include "ForceTerm.h"
#include "History.h"
#include "PrescribedMotion.h"
#include "energy.h"
#include "update.h"
#include <algorithm>
#include <limits>
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
enum class Scheme
{
  half_step, ///< seed (3.72)-(3.77), damping lags by half a step
  classical  ///< seed (3.68)-(3.71), damping at the time level
};

/// The steps before and after a time level [T].
struct Steps
{
  double before = 0.0; ///< 0 at the start
  double after = 0.0;
};

/// Works and energies of a run: docs/explicit/energies.md. Sums over ranks are made while the next forces are
/// computed; they also tell whether the run is stable, so that all ranks know it alike.
class EnergyBalance
{
public:
  /// Kinetic energy between time levels may exceed all energy put in by 1/(1 - (omega dt/2)^2) in stable runs: 50 at
  /// 99 % of the limit. More than this factor is growth [1].
  static constexpr double largest_growth = 1000.0;

  /// @param[in] comm communicator of the run
  /// @param[in] internal what the internal energy is computed from
  /// @param[in] alpha factor of mass-proportional damping [1/T]
  EnergyBalance(MPI_Comm comm, InternalEnergy internal, Scheme scheme, double alpha)
      : _comm(comm), _internal(internal), _scheme(scheme), _alpha(alpha)
  {
  }
  ~EnergyBalance();
  EnergyBalance(const EnergyBalance&) = delete;
  EnergyBalance& operator=(const EnergyBalance&) = delete;

  /// Works count from zero.
  /// @param[in] uncertainty sum over all ranks of mass times the square of what rounding does to a position [M L^2]
  void reset(double uncertainty);
  /// What materials with internal variables have found at the present time level, on this rank.
  /// @param[in] energy elastic energy, for InternalEnergy::elastic [F L]
  /// @param[in] num_unsolved points whose local equations were not solved: the run counts as unstable
  void set_materials(double energy, std::size_t num_unsolved)
  {
    _elastic = energy;
    _unsolved = double(num_unsolved);
  }

  /// A step has been made: what this rank contributes at the time level before it, and the works of the step.
  /// @param[in] sums of the update
  /// @param[in] power of the support forces
  /// @param[in] steps before and after the time level
  /// @param[in,out] terms, contact: their works go into the sums
  /// @param[in] stop this rank was asked to stop
  /// @param[in] deformed see DeformationWatch
  void add_step(const Sums& sums, const PrescribedMotion::Power& power, const Steps& steps, std::span<ForceTerm> terms,
                ContactForces& contact, bool stop, bool deformed);
  /// Begin to sum over ranks what the last `add_step` has found. Collective.
  /// @param[in] history where the row `step` will be written to
  void begin_sum(const ContactForces& contact, int bs, const History& history, std::size_t step);
  /// The sums are there. Collective.
  /// @returns is the run stable? True if no sum was begun
  bool end_sum();
  /// Of the last sums: does a contact need a search, was a rank asked to stop, has a cell deformed too far? The same on
  /// all ranks.
  bool search_due() const { return _totals.searches_due > 0.0; }
  bool stop_asked() const { return _totals.stops_asked > 0.0; }
  bool deformed() const { return _totals.deformed > 0.0; }
  /// Part of the energy taken from nodes in kinematic contact that they are given back when they leave, so that in all
  /// no more is given back than was taken [1].
  double release_share() const { return _release_share; }

  /// Energies at the present time level, without a step. Collective.
  /// @param[in] sums of `measure`
  /// @param[in] support_power with the velocities half a step before [F L/T]
  Energies energies(const Sums& sums, double support_power, const Steps& steps, std::span<const ForceTerm> terms,
                    const ContactForces& contact);

  const EnergyGain& gain() const { return _gain; }
  double gain_limit() const { return _gain_limit; }
  /// @param[in] limit of EnergyGain::now, beyond which a run counts as unstable; infinite: energies stop no run [1]
  void set_gain_limit(double limit) { _gain_limit = limit; }
  /// What the bodies have given so far: minus their internal energy [F L].
  double released() const { return _released; }
  /// Most of it that counts as energy put in: what the bodies stored at the start is not known of residuals of a
  /// user's own, and a term of the wrong sign gives without end [F L].
  double release_limit() const { return _release_limit; }
  /// @param[in] limit without |u . residual/2| of the start, which is added; infinite: all counts
  void set_release_limit(double limit) { _given_limit = _release_limit = std::min(limit, unlimited); }

  /// What a run that goes on needs. The first five add up over ranks, the others are the same on all [F L].
  struct Saved
  {
    double residual_work = 0.0, load_work = 0.0, support_work = 0.0, damped = 0.0, elastic = 0.0;
    double reference = 0.0, lowest = 0.0, largest = 0.0;
    double release_share = 0.0; ///< [1]
    double release_limit = 0.0;
  };
  Saved save() const;
  void restore(const Saved& saved);

private:
  EnergySums local(const Sums& sums, const Steps& steps, std::span<const ForceTerm> terms,
                   const ContactForces& contact);

  MPI_Comm _comm;
  InternalEnergy _internal;
  Scheme _scheme;
  double _alpha;
  Work _residual_work, _load_work, _support_work, _damped;
  double _elastic = 0.0, _unsolved = 0.0;
  double _support_value = 0.0; ///< work of the supports up to the time level
  EnergySums _local, _totals;
  std::vector<double> _buffer, _summed; ///< EnergySums, then the contacts' forces
  MPI_Request _request = MPI_REQUEST_NULL;
  History _history;
  std::size_t _step = 0;
  Steps _steps;              ///< about the time level of the last `begin_sum` [T]
  double _uncertainty = 0.0; ///< see reset
  double _reference = 0.0;   ///< energy that was there at the start or put in since
  double _release_share = 0.0;
  double _released = 0.0;
  static constexpr double unlimited = std::numeric_limits<double>::max(); // checkpoints have finite numbers
  double _given_limit = unlimited, _release_limit = unlimited;
  EnergyGain _gain;
  double _gain_limit = std::numeric_limits<double>::infinity();
};
} // namespace dolfinx_impact::integrators
