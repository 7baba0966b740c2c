// SPDX-License-Identifier: MIT
#pragma once
#include "RigidBall.h"
#include "RigidPlace.h"
#include "contact_projection.h"
#include "explicit.h"
#include <functional>
#include <memory>

/// Node-to-surface contact in explicit dynamics as docs/explicit/penalty.md states it, with brute-force closest points.
namespace impact_reference
{
/// What a slave node meets.
struct Meeting
{
  double gap = std::numeric_limits<double>::infinity(); ///< without master [L]
  Vec<double> x, normal;                                ///< position of the node, normal out of the master [L], [1]
  std::vector<std::int64_t> masters;                    ///< nodes of the facet; none if the master is rigid
  std::vector<double> phi;                              ///< its shape functions at the closest point
  std::int64_t facet = -1;                              ///< of the master
  Local xi{0, 0};                                       ///< the closest point's place on it
  bool on_facet = false;                                ///< the normal is the facet's (not that from an edge or vertex)
  bool beside = false; ///< the outer rim, by more than a twentieth of the facet; also without master
  bool below = false;  ///< beside the rim and below the facet that ends there
  double width = std::numeric_limits<double>::infinity(); ///< of the facet, at rest; infinite if rigid [L]
};

/// Stiffness by node of a surface [F/L].
using NodalStiffness = std::map<std::int64_t, double>;

/// Height of the cell behind a facet [L].
double height_behind(const Model& model, const Surface& s, const Facet& facet);

/// What the nodes of a surface at rest offer to penalty springs (docs/explicit/penalty.md, "Stiffness").
/// @param s without curved facets
/// @param stiffness of a cell, on its nodes [F/L]
NodalStiffness nodal_stiffness(const Model& model, const Surface& s,
                               const std::function<Matrix(std::int64_t)>& stiffness, const Rule& mass_rule,
                               const std::string& scheme);

/// The nodes of a slave surface and their master.
class NodePairs
{
public:
  /// @param search_distance without a value: the longest distance between corners of any facet of both, at rest [L]
  /// @param mass lumped (num_dofs) [M]
  /// @param displacement of the rigid master, a row per time level t_0 ... t_(N+1) [L]
  NodePairs(const Model& model, Surface slave, Surface master, std::optional<Rigid> rigid,
            std::optional<double> search_distance, const Vector& mass, const Matrix& displacement);

  /// From now on gaps are less by the thickness of layers; nodes whose gap at rest is then at most `adjust` (without a
  /// value: all with a master, if there is a clearance) have the clearance, or without one no gap. Without a search
  /// distance, layers and two of the largest facets take its place.
  void adjust_gaps(double layers, std::optional<double> clearance, std::optional<double> adjust, bool default_distance);

  const std::vector<std::int64_t>& nodes() const { return nodes_; }
  int gdim() const { return model_.gdim(); }
  std::int64_t num_dofs() const { return model_.num_dofs(); }
  double mass(std::int64_t node) const { return mass_(gdim() * node); }
  double area(std::int64_t node) const { return areas_.at(node); } ///< of a slave node [L^2]
  /// Areas of the master's nodes; none if it is rigid [L^2].
  const std::map<std::int64_t, double>& master_areas() const { return master_areas_; }
  /// 1 / m_i + sum_j |phi_j| (1 + A_j / A_i) / m_j [1/M].
  double compliance(std::int64_t node, const Meeting& meeting) const;
  /// The stiffness of the nodes of both surfaces; empty of a rigid master.
  void set_stiffness(NodalStiffness slave, NodalStiffness master);
  /// 1 / k_i + sum_j |phi_j| (1 + A_j / A_i) / k_j, where no k exceeds what a step dt bears [L/F].
  double spring_compliance(std::int64_t node, const Meeting& meeting, double dt) const;

  Vec<double> at(const Vector& field, std::int64_t node) const; ///< a node's value of a field
  Vec<double> position(const Vector& u, std::int64_t node) const;
  RigidPlace obstacle(int n) const; ///< place of the rigid master at t_n
  /// The same a part of the step before t_n.
  RigidPlace obstacle_before(int n, double part) const;
  Vec<double> master_moved(int n) const;                       ///< of the rigid master, from t_(n-1) to t_n [L]
  Vec<double> master_moved(int n, const Vec<double>& x) const; ///< the same of its point that is at x at t_n [L]
  /// The rigid master turns as prescribed: rotation vectors, a row per time level t_0 ... t_(N+1) [1].
  void set_angles(Matrix angles) { angles_ = std::move(angles); }
  bool turns() const { return angles_.rows() > 0; }
  /// The rotation of the rigid master from t_(n-1) to t_n.
  Eigen::Matrix3d master_turned(int n) const;
  /// From what the rigid master turns about to a point at t_n [L].
  Vec<double> arm(int n, const Vec<double>& x) const;
  /// The rigid master is a ball that forces move; none: it moves as prescribed.
  RigidBall* ball() const { return ball_.get(); }
  void set_ball(std::shared_ptr<RigidBall> ball) { ball_ = std::move(ball); }
  double slave_area() const; ///< [L^2]
  /// D_min: least diameter of the master's facets; of a rigid master the largest of the slave's [L].
  double smallest_diameter() const;
  /// Motion of the slave node against the master's point.
  Vec<double> relative(const Vector& motion, const Vec<double>& rigid, std::int64_t node, const Meeting& m) const;
  /// The facet's normal at the closest point's place in the configuration u.
  Vec<double> facet_normal(const Meeting& m, const Vector& u) const;
  /// Adds f to the slave node and the opposite to the master.
  void add(Vector& force, const Vec<double>& f, std::int64_t node, const Meeting& m) const;
  /// Forces c_j on the facet's nodes that cancel the moment of f and its reaction at the positions of u.
  std::vector<Vec<double>> moment_forces(const Vec<double>& f, const Vector& u, std::int64_t node,
                                         const Meeting& m) const;
  void add_moment(Vector& force, const Vec<double>& f, const Vector& u, std::int64_t node, const Meeting& m) const;
  /// What the facet's rotation moves the slave node by, as if it were fixed to it, more than the master's point; none
  /// if no moment is cancelled.
  Vec<double> carried(const Vector& motion, const Vector& u, std::int64_t node, const Meeting& m) const;

private:
  struct Lever
  {
    Vec<double> arm;            // from the slave node to the master's point [L]
    std::vector<Vec<double>> y; // the facet's nodes from their mean [L]
    Eigen::Matrix3d J;          // sum of |y|^2 I - y y^T [L^2]
  };
  Lever lever(const Vector& u, std::int64_t node, const Meeting& m) const;
  Vec<double> spin(const Lever& lever, const Vec<double>& moment) const; // J^-1 moment
  friend class Configuration;
  const Model& model_;
  Surface slave_, master_;
  std::optional<Rigid> rigid_;
  std::shared_ptr<RigidBall> ball_;
  double search_distance_ = 0;
  std::vector<double> shift_; // added to the gap, per slave node; empty: nothing [L]
  Vector mass_;
  Matrix displacement_, angles_;
  std::vector<std::int64_t> nodes_;
  std::map<std::int64_t, double> areas_, master_areas_;
  NodalStiffness stiffness_, master_stiffness_;
};

/// The longest distance between corners of a facet in the reference configuration [L].
double diameter(const Facet& facet);

/// Both surfaces at one time.
class Configuration
{
public:
  /// @param obstacle place of the rigid master
  Configuration(const NodePairs& pairs, const Vector& u, const RigidPlace& obstacle);
  Configuration(const Configuration&) = delete;

  /// The closest point of slave node i.
  /// @param moved motion of the step: masters within twice the node's motion against them count [L]
  /// @param closed in the step before: then they count however far
  Meeting meet(std::size_t i, const Vector& moved, bool closed) const;

private:
  Meeting meet_surface(std::size_t i, const Vector& moved, bool closed) const;

  const NodePairs& pairs_;
  Vector u_;
  RigidPlace obstacle_;
  std::map<std::int64_t, Vec<double>> normals_;
  std::optional<Projector> projector_;
};

/// The straight motion of a step, at whose end slave nodes meet the master.
class Approach
{
public:
  /// @param end displacements at the step's end; of the rigid master those of time level `level` [L]
  /// @param moved in the step (num_dofs) [L]
  Approach(const NodePairs& pairs, const Vector& end, const Vector& moved, int level, double dt);

  /// What slave node i meets at the end. If its way is long it is followed, and held back if it has come through the
  /// surface.
  /// @param closed in the step before
  /// @throws std::runtime_error if the step is too long for it
  Meeting arrival(std::size_t i, bool closed, bool marked) const;
  /// What it met at the step's start.
  Meeting departure(std::size_t i, bool closed) const;

private:
  Configuration at(double theta) const;
  [[noreturn]] void refuse(std::int64_t node, const Vec<double>& x, double facets) const;

  const NodePairs& pairs_;
  Vector end_, moved_;
  int level_;
  double dt_, smallest_;
  Configuration last_;
  mutable std::optional<Configuration> first_; // made when it is asked for
  double farthest_;                            // any node moves [L]
};

/// Slave nodes close only through the master's surface: a node that is below it beside its rim, or is found deep below
/// it, is marked and stays open until it has been above.
class Gate
{
public:
  explicit Gate(std::size_t num_nodes) : marked_(num_nodes, false) {}
  /// Whether slave node i may close now; once per step.
  /// @param before at the step's start
  /// @param now where marks are set: the present configuration of penalty contact, the predicted one of kinematic
  /// @param closed in the step before
  bool lets(std::size_t i, const std::function<Meeting()>& before, const Meeting& now, bool closed);
  bool marked(std::size_t i) const { return marked_[i]; }

private:
  std::vector<bool> marked_;
};

/// Areas of the nodes of a surface: int phi dA_0 at degree 1, shares of the facets' area in proportion to int phi^2 at
/// degree 2.
std::map<std::int64_t, double> nodal_areas(const Surface& surface);

/// A row as a vector, and back.
Vec<double> get(const Matrix& rows, std::int64_t row);
void put(Matrix& rows, std::int64_t row, const Vec<double>& v);

/// A tangential vector rotated into the plane orthogonal to n, of the same length.
Vec<double> rotated(const Vec<double>& t, const Vec<double>& n);

/// An answer without contact.
ContactAnswer no_contact(const NodePairs& pairs);

class NodalPenalty : public ExplicitContact
{
public:
  /// @param directions one, or two for the balanced form, in which each has half the stiffness
  /// @param penalty [F/L^3], or 0: from the stiffness of the pairs' nodes
  /// @param stiffness_step that such springs are made for; 0: each step [T]
  NodalPenalty(std::vector<NodePairs> directions, double friction, double penalty, double stiffness_step = 0);

  void before(const ContactStep& step) override;
  bool kinematic() const override { return false; }
  std::vector<std::int64_t> nodes() const override { return directions_[0].pairs.nodes(); }
  Vec<double> master_moved(int n) const override { return directions_[0].pairs.master_moved(n); }
  Eigen::Matrix3d master_turned(int n) const override { return directions_[0].pairs.master_turned(n); }
  RigidBall* ball() const override { return directions_[0].pairs.ball(); }

  /// What a given penalty adds to the square of the highest frequency at most [1/T^2].
  double added_frequency(const Vector& u) const;
  /// Springs of a given penalty on all nodes that have a master, closed or not: entries of a stiffness matrix [F/L].
  Entries springs(const Vector& u) const;

private:
  // What a node keeps of the step before.
  struct Spring
  {
    bool closed = false;
    double gap = 0;                   // [L]
    double normal = 0, stiffness = 1; // while it is closed [F], [F/L]
    double e = 0;                     // taken from the bodies by normal forces beyond what is stored [F L]
    double q = 0;                     // the same of tangential forces, never positive [F L]
  };
  struct Direction
  {
    NodePairs pairs;
    std::vector<Spring> springs;
    Gate gate;
    Matrix traction, slip; // per slave node, as in ContactAnswer
  };
  double stiffness(const NodePairs& pairs, std::int64_t node, const Meeting& m, double dt) const;
  void evaluate(Direction& direction, const ContactStep& step, bool first);

  std::vector<Direction> directions_;
  double friction_, penalty_, part_, stiffness_step_;
};

class NodalKinematic : public ExplicitContact
{
public:
  NodalKinematic(NodePairs pairs, double friction, int sweeps);

  void close(const ContactStep& step, const Vector& predicted, KinematicWeights& all) override;
  void respond(const ContactStep& step, const Vector& predicted, const KinematicWeights& all) override;
  void sweep(const ContactStep& step, const Vector& moved, int number) override;
  int sweeps() const override { return sweeps_; }
  void push(const ContactStep& step, Vector& force) const override;
  void conclude(const ContactStep& step, const Vector& moved) override;
  void corrected(const ContactStep& step, const Vector& next) override;
  bool kinematic() const override { return true; }
  std::vector<std::int64_t> nodes() const override { return pairs_.nodes(); }
  Vec<double> master_moved(int n) const override { return pairs_.master_moved(n); }
  double absorbed() const override { return absorbed_; }
  double recoverable() const override;

private:
  // A node on which a force acts in a step.
  struct Closed
  {
    std::int64_t row, node;
    Meeting m;
    Vec<double> moved, f;          // predicted relative motion, force
    Vec<double> carried = {};      // the part of the motion that is the facet's rotation
    double normal = 0, across = 0; // responses: 1 / effective mass along and across the normal
    bool cut = false;
    bool leaves = false; // its normal force is known before the sweeps
  };
  // Energy that a node's forces have absorbed since it closed, and the impulse of about 20 steps.
  struct Absorbed
  {
    double energy = 0, impulse = 0; // [F L], [F T]
  };
  std::vector<Vec<double>> weights(const Closed& node, const Vector& u) const;
  double release(const Closed& node, const ContactStep& step, const Vector& predicted,
                 const std::map<std::int64_t, double>& sums) const;
  void push(Vector& force, const Closed& closed, const ContactStep& step) const;
  double work(const Closed& node, const Vec<double>& f, const std::vector<Vec<double>>& c, const ContactStep& step,
              const Vector& motion) const;

  NodePairs pairs_;
  Gate gate_;
  double friction_;
  int sweeps_;
  std::vector<Closed> closed_; // of the last step, with those that left
  std::vector<bool> was_closed_;
  std::vector<Absorbed> absorbed_energies_;
  Matrix slip_before_; // per slave node, as in ContactAnswer
  double absorbed_ = 0;
};
} // namespace impact_reference
