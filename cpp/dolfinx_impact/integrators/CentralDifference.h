#pragma once
#include "../enforcement/NodalContact.h"
#include "../operators/InternalForce.h"
#include "energy.h"
#include "update.h"
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <mpi.h>
#include <string>
#include <vector>

/// Seventh stage: time stepping.
namespace impact::integrators
{
using operators::FunctionSpace;
using operators::Halo;
using operators::InternalForce;

enum class Scheme
{
  half_step, ///< seed (3.72)-(3.77), damping lags by half a step
  classical  ///< seed (3.68)-(3.71), damping at the time level
};

/// Forces of a form: cells that touch no ghost node, and the others.
struct Forces
{
  std::shared_ptr<InternalForce> inner, outer; ///< neither is null; an operator may have no cells
  /// Names of the coefficients that the integrator has; empty: it has none. The velocity is that half a step before.
  std::string displacement, velocity;
};

/// Explicit integration with lumped mass; docs/explicit.md has the equations. A step is: exchange ghosts, kernels,
/// contact, exchange forces, update. Cells without ghosts are computed while ghosts travel.
class CentralDifference
{
public:
  /// @param[in] V displacement space
  /// @param[in] internal internal force. linear: its energy is u . F/2
  /// @param[in] mass per degree of freedom, owned and ghosts [M]
  /// @param[in] alpha factor of mass-proportional damping [1/T]
  /// @throws std::invalid_argument for a mass of another size, an operator that is null, a name that none of its
  ///   kernels has
  CentralDifference(std::shared_ptr<const FunctionSpace> V, Forces internal, bool linear, std::span<const double> mass,
                    double alpha, Scheme scheme);
  ~CentralDifference();
  CentralDifference(const CentralDifference&) = delete;
  CentralDifference& operator=(const CentralDifference&) = delete;

  /// A force with an account of its own: damping and viscosity resist, external forces act.
  /// @throws std::invalid_argument as the constructor
  void add_term(Forces forces, Account account);
  /// A load: `values` on owned degrees of freedom times column `amplitude` of the table (-1: one).
  void add_load(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude);
  /// Replace the values of load i, in the order added.
  void set_load(std::size_t i, std::span<const double> values);
  /// Prescribe u = value * column `amplitude` of the table (-1: one) on owned degrees of freedom.
  void prescribe(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude);
  /// @param[in] columns of the table with the displacement of a rigid master; -1: it stays
  void add_contact(std::shared_ptr<enforcement::NodalContact> contact, std::array<int, 3> columns);
  /// The step that contact stiffnesses are made for, to be called before the first step of a run with contact [T].
  /// @throws std::invalid_argument unless it is positive
  void set_contact_step(double dt);

  /// Start from u and v (owned entries) at a time level; works count from here. Collective.
  void start(std::span<const double> u, std::span<const double> v);

  /// Steps of given lengths. Collective.
  /// @param[in] steps lengths [T]
  /// @param[in] table amplitudes before and after each step and one step beyond, (steps + 2) rows
  /// @param[in] columns of the table
  /// @param[out] history rows before each step, or empty: Energies, then three entries for each contact's force
  /// @param[in] asked is called now and then: is this rank asked to stop? If any is, all stop after the same step
  /// @returns steps done: fewer than asked for if the run went unstable, a node went through a contact, or it was asked
  /// to stop (all ranks alike)
  int run(std::span<const double> steps, std::span<const double> table, int columns, std::span<double> history,
          const std::function<bool()>& asked = {});
  /// Did the last run end because a rank was asked to stop? The same on all ranks.
  bool stopped() const { return _stopped; }

  /// Constants or coefficients of forms have changed: their forces at the present time level anew. Contact forces stay.
  /// Collective.
  void revise();

  /// Energies at the present time level, sums over ranks. Collective.
  Energies energies();
  /// Velocity (3.75) and acceleration at the present time level, owned entries; with the forces of kinematic contact of
  /// the last step. Collective.
  void motion(std::span<double> v, std::span<double> a);
  /// Bring the gaps of all contacts' nodes up to date.
  void look();
  /// Owned displacements [L].
  std::span<const double> displacement() const { return {_u.data(), _owned}; }

  /// Everything that a continued run needs beside the histories of contacts; owned entries. Collective.
  struct Saved
  {
    std::vector<double> u, v, r; ///< v half a step ago
    std::vector<double> parts;   ///< one array after the other, at last kinematic forces
    std::vector<double> accounts;
  };
  Saved save();
  void restore(const Saved& saved);

  /// Owned degree of freedom that moves fastest or is not a number, and its speed: where an unstable run broke.
  std::pair<std::int32_t, double> fastest() const;
  /// Energy gained without work, see EnergyGain; `run` stops where it is more than the limit.
  const EnergyGain& gain() const { return _gain; }
  double gain_limit() const { return _gain_limit; }
  void set_gain_limit(double limit) { _gain_limit = limit; }
  /// Contact that a slave node of this rank went through too fast to be held back (-1: none), and the fastest such
  /// node.
  std::pair<int, enforcement::Passage> passage() const;
  std::int64_t num_searches() const { return _num_searches; }
  /// Wall-clock time that this rank has spent on contact so far: searches, gaps, forces, their energies [s].
  double contact_seconds() const { return _contact_seconds; }
  /// Nodal values that this rank has sent to its neighbours so far. Not: the one sum over all ranks of every step, what
  /// candidates for contact are searched with.
  Halo::Traffic traffic() const;
  std::size_t row_size() const { return Energies::size + 3 * _contacts.size(); }
  /// Arrays in Saved::parts.
  std::size_t num_saved_parts() const { return _parts.size() + 1; }
  /// How many of the saved accounts add up over ranks; the others are the same on all.
  std::size_t num_additive() const { return 3 * _parts.size() + 5; }

private:
  struct Load
  {
    std::vector<std::int32_t> dofs;
    std::vector<double> values;
    int amplitude;
    double reached; ///< what _load has of it
  };
  /// A group of prescribed degrees of freedom; before an update their velocities and residuals are kept.
  struct Motion
  {
    std::vector<std::int32_t> dofs;
    std::vector<double> values;
    int amplitude;
    std::vector<double> u, v, r;
  };
  struct Contact
  {
    std::shared_ptr<enforcement::NodalContact> contact;
    std::array<int, 3> columns;
    std::array<double, 3> place{}, moved{}, moved_before{}; ///< of a rigid master: now, in the last steps
  };
  /// Forces with an account of their own: this rank's contributions over all nodes of the halo.
  struct Part
  {
    Forces forces; ///< none: contact
    Account account;
    double sign;               ///< in the residual
    std::vector<double> force; ///< over the halo's nodes; of contact over the near ones
    Work work;
    double position = 0.0; ///< u . force
  };

  /// Values at the nodes that contacts may act on (`_touched`, owned first), one after the other, so that what is done
  /// to them in every step stays in the cache.
  struct Near
  {
    std::unique_ptr<Halo> halo;
    std::vector<double> u, du, inverse;
    std::vector<double> v, du_before; ///< for kinematic contact
    std::vector<double> before;       ///< velocity and residual before an update
    std::vector<double> force;        ///< kinematic
    std::vector<double> kept; ///< by owned degree of freedom, until nodes are numbered: forces of springs, kinematic
  };

  /// Adds its own life to an account.
  class Stopwatch
  {
  public:
    explicit Stopwatch(double& seconds) : _seconds(seconds) {}
    ~Stopwatch() { _seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - _begin).count(); }

  private:
    double& _seconds;
    std::chrono::steady_clock::time_point _begin = std::chrono::steady_clock::now();
  };

  void check(const Forces& forces) const;
  void bind(const Forces& forces);
  void resize(std::shared_ptr<const dolfinx::common::IndexMap> map);
  void search();
  void number_contacts();
  double gather(Part* springs);
  std::vector<double> kept_forces();
  void take_forces(const std::vector<double>& forces);
  Part* springs();
  void receive();
  bool evaluate();
  void evaluate_part(Part& part);
  void evaluate_form(Part& part);
  void evaluate_contact(Part& part);
  double work(const Part& part) const;
  void advance(double dt, const double* amplitudes);
  void apply_loads(const double* amplitudes);
  void move_obstacles(const double* amplitudes, bool first);
  static double target(const Motion& motion, std::size_t k, const double* amplitudes);
  void prescribed_motion(double dt, double h, const double* amplitudes, Sums& sums);
  void kinematic_contact(double dt, double h, Sums& sums);
  void account(const Sums& sums, double dt, bool commit);
  Coefficients coefficients(double dt) const;
  const double* loads() const { return _load.empty() ? nullptr : _load.data(); }
  double load_at(std::size_t i) const { return _load.empty() ? 0.0 : _load[i]; }
  bool asked_to_stop(const std::function<bool()>& asked);
  void reduce_begin();
  bool reduce_end();
  bool passed() const;

  std::shared_ptr<const FunctionSpace> _V;
  int _bs;
  Forces _internal;
  bool _linear;
  double _alpha;
  Scheme _scheme;
  std::vector<Load> _loads;
  std::vector<Motion> _motions;
  std::vector<Contact> _contacts;
  std::vector<Part> _parts;
  std::unique_ptr<Halo> _halo;
  std::size_t _owned, _own_size;       ///< degrees of freedom: owned, with the space's ghosts
  std::vector<double> _u, _v, _r;      ///< over the halo's nodes
  std::vector<double> _mass, _inverse; ///< per degree of freedom over the halo's nodes
  std::vector<double> _load;           ///< owned; empty without loads
  std::vector<std::int32_t> _touched;  ///< nodes that contacts may act on
  Near _near;
  std::vector<double> _old_ghosts;
  std::vector<double> _beyond; ///< amplitudes one step on: velocities of prescribed motion now
  double _last_step = 0.0;     ///< that led here; 0 at the start
  double _contact_step = 0.0;
  double _release_share = 0.0; ///< of the energy taken from closed nodes: what they may be given back when they leave
  bool _fresh = false, _pending = false, _search_due = true, _kinematic = false, _penalty = false;
  double _used = 0.0; ///< contacts whose candidates are used up
  Work _residual_work, _load_work, _support_work, _damped;
  double _obstacle_work = 0.0, _support_before = 0.0, _reference = 0.0;
  EnergyGain _gain;
  double _gain_limit = std::numeric_limits<double>::infinity();
  std::vector<double> _local, _global; ///< Local, then the contacts' forces
  MPI_Request _request = MPI_REQUEST_NULL;
  std::int64_t _num_searches = 0;
  bool _stop = false, _stopped = false;         ///< this rank is asked to stop; the ranks have agreed on it
  std::chrono::steady_clock::time_point _asked; ///< when `asked` was called last
  double _contact_seconds = 0.0;
  Halo::Traffic _traffic; ///< of Halos that are no more
  double* _row = nullptr; ///< of the history that the pending sums belong to
};
} // namespace impact::integrators
