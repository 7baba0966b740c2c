// SPDX-License-Identifier: MIT
#pragma once
#include "PlasticBody.h"
#include "RigidBall.h"
#include "contact.h"
#include <map>
#include <memory>

/// Central differences as docs/explicit/scheme.md states them.
namespace impact_reference
{
/// Step n, from t_n to t_(n+1), as passed to contacts.
struct ContactStep
{
  int n;
  double dt;             ///< from t_n to t_(n+1) [T]
  double h;              ///< a force f at t_n moves a node by h f / m [T^2]
  const Vector& u;       ///< at t_n (num_dofs) [L]
  const Vector& moved;   ///< since t_(n-1), zero at t_0 [L]
  const Vector& inverse; ///< 1 / m, zero where prescribed (num_dofs) [1/M]
  /// s: share of the absorbed energy that nodes which open in kinematic contact get back [1].
  double release_share = 0;
};

/// Forces, energies and state of a contact at t_n.
struct ContactAnswer
{
  Vector force, tangential;    ///< on both bodies, and its part from friction (num_dofs) [F]
  Vec<double> total, friction; ///< on the slave, likewise [F]
  Vector gap;                  ///< per slave node; infinite without master [L]
  Matrix traction;             ///< friction's force per slave node (num_slave_nodes, gdim) [F]
  Matrix slip;                 ///< since the node closed (num_slave_nodes, gdim) [L]
  std::vector<ContactStatus> status;
  double stored = 0;     ///< in penalty springs [F L]
  double dissipated = 0; ///< by slip, since the start, of penalty springs [F L]
  double absorbed = 0;   ///< by normal forces of penalty springs and not stored, since the start [F L]
  /// Sum of force times arm, f_a r_b, from what a rigid master turns about [F L].
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
};

/// What weighs on the nodes when kinematic contacts share out their overlaps.
struct KinematicWeights
{
  std::map<std::int64_t, double> sums; ///< s_k: of the parts that all closed nodes' forces have on node k [1]
  std::map<std::int64_t, Eigen::Matrix3d>
      directions;                           ///< the same parts times n n^T, or times the identity with friction [1]
  std::map<std::int64_t, int> num_surfaces; ///< that the node belongs to, as slave or as master
  std::map<std::int64_t, double> in_sweeps; ///< sigma_k [1]
};

/// A contact in an explicit analysis.
class ExplicitContact
{
public:
  virtual ~ExplicitContact() = default;
  /// Forces that are known before the step.
  virtual void before(const ContactStep&) {}
  // Forces that keep the displacements predicted for t_(n+1) from penetrating, by all kinematic contacts together:
  /// Which nodes are closed, and what they weigh.
  virtual void close(const ContactStep&, const Vector& /*predicted*/, KinematicWeights&) {}
  /// Responses to the forces, and forces of the nodes that open.
  virtual void respond(const ContactStep&, const Vector& /*predicted*/, const KinematicWeights&) {}
  /// Forces of one sweep, after the motion that those of all contacts have brought.
  virtual void sweep(const ContactStep&, const Vector& /*moved*/, int /*number*/) {}
  virtual int sweeps() const { return 0; }
  /// Adds the forces on all nodes.
  virtual void push(const ContactStep&, Vector& /*force*/) const {}
  /// The answer, after the motion that all forces have brought.
  virtual void conclude(const ContactStep&, const Vector& /*moved*/) {}
  /// The displacements that the forces of all contacts have led to at t_(n+1).
  virtual void corrected(const ContactStep&, const Vector& /*next*/) {}
  /// Energy that normal forces of kinematic contact have absorbed since the start, including the last step [F L].
  virtual double absorbed() const { return 0; }
  /// Sum of the positive absorbed energies E_i of the nodes that were closed in the last step [F L].
  virtual double recoverable() const { return 0; }
  /// True if the forces come from sweeps; then energies are the work of forces.
  virtual bool kinematic() const = 0;
  /// The rigid master, if forces move it.
  virtual RigidBall* ball() const { return nullptr; }
  virtual std::vector<std::int64_t> nodes() const = 0; ///< of the slave, increasing
  /// How far the rigid master moved from t_(n-1) to t_n [L].
  virtual Vec<double> master_moved(int n) const = 0;
  /// The rotation of the rigid master from t_(n-1) to t_n.
  virtual Eigen::Matrix3d master_turned(int) const { return Eigen::Matrix3d::Identity(); }
  const ContactAnswer& answer() const { return answer_; }

protected:
  ContactAnswer answer_;
};

struct ExplicitData
{
  Rule rule, mass_rule;
  std::string lumping = "auto";
  Vector steps;                                ///< one per step [T]
  Vector u0, v0;                               ///< (num_dofs) [L], [L/T]
  std::vector<std::int64_t> fixed_dofs;        ///< prescribed
  Matrix values;                               ///< (num_steps + 2, num_fixed) at t_0 ... t_(N+1) [L]
  Matrix loads;                                ///< one per row (num_loads, num_dofs) [F]
  Matrix amplitudes;                           ///< (num_steps + 1, num_loads) at t_0 ... t_N [1]
  double alpha = 0, beta = 0;                  ///< Rayleigh damping [1/T], [T]
  bool classical = false;                      ///< (3.68)-(3.71) instead of (3.72)-(3.77)
  double b1 = 0, b2 = 0;                       ///< bulk viscosity [1]
  int every = 1;                               ///< states between two that are kept
  std::vector<ExplicitContact*> contacts = {}; ///< not owned
  /// Takes the place of the model's elastic force and commits its history at every time level; not owned.
  PlasticBody* plastic = nullptr;
};

/// Columns of ExplicitHistory::energies.
enum Energy
{
  kinetic,
  internal_energy,
  contact_energy,
  friction_energy,
  impact_energy,
  damping_energy,
  viscosity_energy,
  plastic_energy, ///< work of the internal forces less the stored elastic energy
  external_energy,
  total_energy,
  drift,
  num_energies
};

/// A contact's part of the history; first index: state.
struct ContactHistories
{
  Matrix total;    ///< on the slave (num_states, gdim) [F]
  Matrix force;    ///< nodal, both bodies (num_states, num_dofs) [F]
  Matrix gap;      ///< (num_states, num_slave_nodes) [L]
  Matrix traction; ///< (num_states, num_slave_nodes * gdim) [F]
  Matrix slip;     ///< (num_states, num_slave_nodes * gdim) [L]
  Eigen::Matrix<std::int64_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> status;
};

/// States that were kept, rows.
struct ExplicitHistory
{
  Vector time;     ///< [T]
  Matrix u, v, a;  ///< at time levels (num_states, num_dofs)
  Matrix support;  ///< on prescribed degrees of freedom, zero elsewhere (num_states, num_dofs) [F]
  Matrix half;     ///< v_(n+1/2) (num_states, num_dofs) [L/T]
  Matrix energies; ///< (num_states, num_energies)
  std::vector<ContactHistories> contacts;
  /// History of a plastic body, by cells and points (num_states, num_points), tensors in rows of 9 values each; empty
  /// without one.
  Matrix equivalent, plastic, back_stress; ///< [1], [1], [F/L^2]
};

/// @throws std::invalid_argument for wrong sizes, steps that are not positive, a scheme that cannot do what is asked
/// @throws std::runtime_error if the displacements overflow: the step was too long
ExplicitHistory run_explicit(const Model& model, const ExplicitData& data);

/// Highest frequency of (K + springs) x = omega^2 M x with the prescribed degrees of freedom held: dense up to 400
/// degrees of freedom, Lanczos' method beyond [1/T].
double highest_frequency(const Csr& K, const std::vector<Csr*>& springs, const Vector& mass,
                         const std::vector<std::int64_t>& fixed_dofs);
} // namespace impact_reference
