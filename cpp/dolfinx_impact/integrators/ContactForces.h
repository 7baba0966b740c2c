// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/mortar/TieStep.h"
#include "../enforcement/node_to_surface/KinematicStep.h"
#include "../enforcement/node_to_surface/NodalPair.h"
#include "ContactNodes.h"
#include "Loads.h"
#include "RigidBody.h"
#include "RigidContact.h"
#include "energy.h"
#include "update.h"
#include <array>
#include <memory>
#include <mpi.h>
#include <utility>
#include <vector>

namespace dolfinx_impact::integrators
{
/// The contacts of all pairs of a run: their candidates, rigid masters that move, and their forces. Springs act at a
/// time level and are part of the residual; kinematic contact corrects what an update has predicted, and ties correct
/// it last. Candidates, nodes and forces are those of the directions of the pairs; resultants, passages and obstacles
/// are told by pair.
class ContactForces
{
public:
  /// Motion of a rigid master.
  struct Obstacle
  {
    std::array<double, 3> displacement{};     ///< [L]
    std::array<double, 3> increment{};        ///< in the last step [L]
    std::array<double, 3> increment_before{}; ///< in the step before it [L]
    bool rotates = false;                     ///< without, what follows is zero
    std::array<double, 3> angle{};            ///< rotation vector [1]
    gap::Matrix3 turn{};                      ///< in the last step, see RigidMotion [1]
  };

  /// @param[in] comm communicator of the run
  explicit ContactForces(MPI_Comm comm = MPI_COMM_SELF) : _comm(comm) {}

  /// @param[in] pair contact of a pair, in one direction or both
  /// @param[in] columns of the amplitudes with the displacement of a rigid master; -1: it stays
  /// @param[in] rotation columns with its rotation vector; -1: it does not turn
  /// @throws std::invalid_argument for a direction that is neither SpringForces nor a KinematicContact nor an
  /// ExplicitTie, or directions that act differently
  void add(enforcement::NodalPair pair, std::array<int, 3> columns, std::array<int, 3> rotation = {-1, -1, -1});
  /// The master is a rigid body, which several pairs may share.
  /// @param[in] pair contact of a pair, in one direction
  /// @throws std::invalid_argument unless the pair acts by SpringForces in one direction
  void add(enforcement::NodalPair pair, std::shared_ptr<RigidBody> body);
  /// A rigid body that may be the master of no pair.
  void add_body(std::shared_ptr<RigidBody> body);
  /// Contact of rigid bodies, which have been added.
  /// @throws std::invalid_argument for bodies that have not
  void add(std::shared_ptr<RigidContact> contact);
  /// Loads of a rigid body.
  /// @param[in] force, torque columns of the amplitudes; -1: there is none
  /// @throws std::invalid_argument for a body of no pair
  void set_body_loads(const RigidBody& body, std::array<int, 3> force, std::array<int, 3> torque);
  bool empty() const { return _pairs.empty(); }
  /// Number of pairs.
  std::size_t size() const { return _pairs.size(); }
  /// Largest size of a number that positions of rigid masters are computed from [L].
  double largest_position() const;
  bool has_springs() const { return !_springs.empty(); }
  /// Are there contacts that correct updates: kinematic ones, or ties?
  bool has_corrections() const { return !_kinematic_step.empty() || !_tie_step.empty(); }

  /// The step that automatic stiffnesses are made for; to be set before the first step [T].
  /// @throws std::invalid_argument unless it is positive
  void set_step(double dt);
  double step() const { return _step; }
  /// @throws std::invalid_argument if there are contacts, but no step was set
  void check_step() const;

  /// A run starts, or goes on from other displacements: candidates are searched anew.
  void reset();
  void request_search() { _search_due = true; }
  bool search_due() const { return _search_due && !empty(); }
  /// Find candidates, ask for their nodes and number them. Collective.
  /// @param[in,out] fields get ghosts for all candidates' nodes
  /// @param[in] last_step that led here; 0 at the start [T]
  void search(NodalFields& fields, double last_step);
  std::int64_t num_searches() const { return _num_searches; }

  /// Bring rigid masters to the next time level.
  /// @param[in] amplitudes there
  /// @param[in] first this is the start: nothing has moved
  void move_obstacles(const double* amplitudes, bool first);
  /// Loads of rigid bodies at the present time level.
  void apply_loads(const double* amplitudes);
  /// Bring rigid bodies to the next time level.
  /// @param[in] dt step [T]
  /// @param[in] h mean of the steps before and after the present time level [T]
  /// @param[in] starts nothing moved before
  void advance_bodies(double dt, double h, bool starts);
  /// Energies of rigid bodies at the present time level, with a step that is not made.
  void measure_bodies(double h, bool starts);

  /// The springs' forces of the last time level, and the forces on rigid masters, do work in the step since: take it,
  /// and the nodes' present motion. Collective where a search is due.
  /// @returns was there a search? Then the fields have other ghosts
  bool work_of_step(NodalFields& fields, double last_step);
  /// Springs' forces at the present time level, added to the residual. To be called after `work_of_step`.
  void evaluate(NodalFields& fields);
  /// Sum the forces on rigid bodies up, in the same order on all ranks. To be called after `evaluate`. Collective.
  /// No allocation.
  void sum_forces_on_bodies();
  /// Look two steps ahead: do candidates last so long? The sums of the next step tell all ranks.
  void predict_searches();

  /// Corrections: keep what an update is about to change.
  void keep(const NodalFields& fields);
  /// Correct an update. Collective. No allocation.
  /// @param[in,out] fields owned values as predicted; on return corrected, ghosts valid
  /// @param[in] dt, last_step this step and the one before [T]
  /// @param[in] h a force changes velocities by h force/mass [T]
  /// @param[in] release_share see EnergyBalance::release_share
  /// @param[in,out] sums of the update, corrected
  void correct(NodalFields& fields, double dt, double last_step, double h, double release_share, const Loads& loads,
               Sums& sums);

  /// What this rank adds to the sums of a time level.
  void add_energies(EnergySums& sums) const;
  /// Work of rigid masters, and of supports at tied nodes against the ties, so far, of this rank [F L].
  double obstacle_work() const { return _obstacle_work; }
  /// The same up to half a step before the present time level [F L].
  double half_obstacle_work() const;
  /// Kinetic energy of rigid bodies half a step before the time level, which one rank has [F L].
  double half_body_energy() const;
  /// Three components of the force on the slave of each pair in the last step, of this rank [F].
  /// @param[out] out three entries for each pair; those beyond `bs` components stay as they are
  void resultants(int bs, double* out) const;
  /// Bring the gaps of all nodes up to date in the contacts' results.
  void update_gaps();
  /// The pair with the fastest passage of a slave node of this rank through the master (-1: none), and the node.
  std::pair<int, enforcement::Passage> passage() const;
  double seconds() const { return _seconds; }
  Halo::Traffic traffic() const { return _nodes.traffic(); }

  ContactNodes::Forces forces(const NodalFields& fields) { return _nodes.forces(fields); }
  const Work& spring_work() const { return _work; }
  double spring_position() const { return _position; }
  std::vector<Obstacle> obstacles() const;
  /// Rigid bodies, each once.
  std::vector<RigidBodyState> bodies() const;
  std::size_t num_bodies() const { return _bodies.size(); }
  /// The next search does not depend on the ones before: a run that goes on from a checkpoint makes the same ones.
  void forget_searches();
  void restore(ContactNodes::Forces forces, const Work& work, double position, double obstacle_work,
               const std::vector<Obstacle>& obstacles, const std::vector<RigidBodyState>& bodies = {});
  /// The time level is complete: works of the step go into the sums.
  void commit();

private:
  struct Pair
  {
    enforcement::NodalPair contact;
    bool corrects; ///< kinematic, or a tie
    std::array<int, 3> columns, rotation;
    Obstacle obstacle;
    std::shared_ptr<RigidBody> body; ///< null: the master is none
  };
  struct Body
  {
    std::shared_ptr<RigidBody> body;
    std::array<int, 3> force{-1, -1, -1}, torque{-1, -1, -1}; ///< columns of the amplitudes
  };
  void place_bodies();
  double* sums_of(const RigidBody* body);
  enforcement::NodalState state() const;
  /// Half the work of a pair's force in the motion of its rigid master.
  /// @param[in] turn what its rotation adds to the arms of the forces
  static double half_work(const Pair& pair, const std::array<double, 3>& increment, const gap::Matrix3& turn, int bs);
  gap::RigidMotion motion_of(const Pair& pair) const;

  MPI_Comm _comm;
  std::vector<Pair> _pairs;
  std::vector<Body> _bodies;
  std::vector<std::shared_ptr<RigidContact>> _rigid_contacts;
  /// For each body force and moment, of this rank and of all.
  std::vector<double> _forces, _gathered;
  bool _first_rank = true;                             ///< has it what is the same on all ranks?
  std::vector<enforcement::NodalContact*> _directions; ///< of all pairs, in their order
  std::vector<enforcement::SpringForces*> _springs;    ///< those of them that are springs
  ContactNodes _nodes;
  enforcement::KinematicStep _kinematic_step;
  enforcement::TieStep _tie_step;
  bool _search_due = true;
  double _searches_due = 0.0; ///< directions whose candidates are used up, as far as this rank knows
  double _step = 0.0;
  Work _work;             ///< of the springs
  double _position = 0.0; ///< u . springs' forces
  double _obstacle_work = 0.0, _half_obstacle_work = 0.0;
  std::int64_t _num_searches = 0;
  double _seconds = 0.0;
};
} // namespace dolfinx_impact::integrators
