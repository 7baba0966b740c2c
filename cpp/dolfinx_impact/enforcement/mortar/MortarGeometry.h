// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/MortarIntegrals.h"
#include "../../gap/Rigid.h"
#include "../../gap/rotation.h"
#include "../../operators/RigidBodyModes.h"
#include "../../state/State.h"
#include "MortarOptions.h"
#include <array>
#include <optional>

namespace dolfinx_impact::enforcement
{
class JoinedNodes;

/// Where an increment starts, and where prescribed degrees of freedom and a rigid master move in it.
struct MortarIncrement
{
  std::vector<double> start;                   ///< displacements, owned and ghosts [L]
  std::vector<double> driven;                  ///< motions of prescribed degrees of freedom, zero elsewhere [L]
  std::array<double, 3> start_displacement{};  ///< of a rigid master [L]
  std::array<double, 3> displacement{};        ///< at its end [L]
  gap::Matrix3 start_rotation = gap::identity; ///< of a rigid master, about its centre
  gap::Matrix3 rotation = gap::identity;       ///< at its end
};

/// The slave's nodes in one state of displacements. Arrays are by node, vectors [i*gdim + c]. At nodes that pairs have
/// in common `weight`, `cover` and `gap` are of all pairs together (JoinedNodes), `own_weight` and `own_cover` of this
/// one.
struct SlaveNodes
{
  std::vector<double> u;                  ///< displacements, owned and ghosts [L]
  std::vector<double> points;             ///< positions [L]
  std::vector<double> around;             ///< as `own_cover`, with nodes that carry no multiplier [L^2]
  std::vector<double> area;               ///< of the facets around a node, without those of `aside` [L^2]
  std::vector<std::int64_t> aside;        ///< numbers of the facets that take no part: they lie round a sharp edge
  std::vector<std::int8_t> participates;  ///< nodes at which a multiplier lives
  std::vector<std::int8_t> part;          ///< nodes that this pair has a force at
  std::vector<std::int8_t> carrier;       ///< false where another pair has the multiplier of a common node
  std::vector<std::int8_t> own_locked;    ///< `locked`, as this pair alone has it
  std::vector<std::int8_t> locked;        ///< components without motion against the master in this increment
  std::vector<double> own_weight, weight; ///< diagonal of D: force on the node per multiplier [L^2]
  std::vector<double> own_cover, cover;   ///< integral of the multiplier's function over the part that faces a master
  std::vector<double> weighted_gap;       ///< gap of this pair times its cover [L^3]
  std::vector<double> gap;                ///< [L]; infinite without master
  std::vector<double> normal;             ///< unit vectors out of the master
  std::vector<double> distance;           ///< of the node from a rigid master [L]
  std::vector<double> hessian;            ///< derivatives of a rigid master's normal, [(i*gdim + a)*gdim + b] [1/L]
};

/// Gaps and slips of the nodes, [i*gdim + c] [L].
struct GapAndSlip
{
  std::vector<double> gap, slip;
};

/// Geometry of a contact by multipliers: nodal gaps, normals and weights, and the map from multipliers to forces.
/// Arrays are by the owned nodes of the slave that a multiplier may live at. There is a present state, and a second one
/// in which other displacements are evaluated (`Elsewhere`).
class MortarGeometry
{
public:
  /// Collective.
  /// @param[in] slave this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  MortarGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, const MortarOptions& options,
                 std::vector<std::int8_t> fixed);
  virtual ~MortarGeometry() = default;
  MortarGeometry(const MortarGeometry&) = delete;
  MortarGeometry& operator=(const MortarGeometry&) = delete;

  // --- what the two kinds of masters differ in --------------------------------------------------------------------
  /// Facets of the master on this rank; null: it is rigid.
  virtual const surface::Facets* master() const { return nullptr; }
  /// The rigid master as given; null: it is deformable.
  virtual const gap::Rigid* obstacle() const { return nullptr; }
  /// What of each node faces the master, `around`, and sums of facet normals. Collective.
  virtual void update_cover(std::span<const double> u) = 0;
  /// Nodes of which enough is covered.
  virtual std::vector<std::int8_t> covered() const = 0;
  /// Sums of facet normals out of the master, [i*gdim + c].
  virtual std::vector<double> normal_sums() const = 0;
  /// Weights of the nodes, and `own_locked`. Collective.
  /// @param[in] carriers mask of the nodes that carry a multiplier
  virtual void integrate(std::span<const std::int8_t> carriers) = 0;
  /// Normals and `weighted_gap`. Collective.
  /// @param[in] locked as in SlaveNodes
  /// @param[in] sums of facet normals, where other surfaces continue this one; null: its own
  virtual void update_own_gap(std::span<const std::int8_t> locked, const std::vector<double>* sums) = 0;
  /// Displacements of slave against master times this pair's cover, [i*gdim + c]. Collective.
  /// @param[in] moved increments, owned [L]
  virtual std::vector<double> weighted_jump(std::span<const double> moved) const = 0;
  /// Rows of this pair's M over weights.
  /// @param[in] weights of all nodes [L^2]
  virtual gap::MasterRows weighted_rows(std::span<const std::int32_t> rows, std::span<const double> weights) const = 0;
  /// M times values of the owned nodes of the space. Collective.
  virtual std::vector<double> over_master(std::span<const double> values) const = 0;
  /// Derivative of minus the contact force at given multipliers; null: it is zero. Borrowed until the next call.
  /// Collective.
  /// @param[in] multiplier [F/L^2]
  /// @param[in] traction [i*gdim + c] [F/L^2]
  /// @param[in] active mask
  virtual Mat tangent(std::span<const double> multiplier, std::span<const double> traction,
                      std::span<const std::int8_t> active) = 0;
  /// Nodal forces of this pair's tractions on slave and master, owned [F]. Collective.
  /// @param[in] traction [i*gdim + c] [F/L^2]
  virtual std::vector<double> forces(std::span<const double> traction) const = 0;
  /// Angles between facets that meet at each node and count for its normal [degrees]: twice that between them and their
  /// mean; zero where normals are the master's. Collective.
  virtual std::vector<double> edge_angles() const;
  /// Part of a facet that must be covered to take part.
  virtual void set_least_cover(double) {}
  /// Forget candidates of the search and what is known of other states.
  virtual void forget();

  // --- common ------------------------------------------------------------------------------------------------------
  /// An increment starts: as StaticContact::begin_step.
  /// @param[in] rotation at its end, of a rigid master that turns
  void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                  std::span<const double> target, const std::optional<gap::Matrix3>& rotation = {});
  /// Is the master a rigid one that turns?
  bool turns() const { return obstacle() && obstacle()->rotates; }
  /// How a rigid master's point that was at a node's place when the increment began moves in it, [i*gdim + c] [L].
  std::vector<double> motion_of_master() const;
  /// Gaps, normals, weights and locked components. Collective.
  /// @param[in] u displacements, owned and ghosts [L]
  void update_gap(std::span<const double> u);
  /// The same against this pair's own master, also where nodes are joined. Collective.
  void update_alone(std::span<const double> u);
  /// Gaps and slips at other displacements; the present state stays. Collective.
  GapAndSlip evaluate_at(std::span<const double> u);
  /// Gaps against this pair's own master at a fraction of the way from the start of the increment; infinite without.
  /// The present state stays. Collective.
  std::vector<double> gap_on_the_way(double fraction);
  /// Means over the cover of the displacement of slave against master, [i*gdim + c] [L]. Collective.
  /// @param[in] moved increments, owned [L]
  std::vector<double> jump(std::span<const double> moved) const;
  /// Tangential displacement of slave against master in this increment, [i*gdim + c] [L]. Collective.
  std::vector<double> slip() const;
  /// Tangential part of displacements against a master at rest, as the master moves, [i*gdim + c] [L]. Slip is measured
  /// from the point of the master where the node was, so that it is linear in the node's displacement.
  std::vector<double> slip_of(std::vector<double> jump) const;
  /// Displacements in this increment, owned [L].
  std::vector<double> moved() const;
  /// What prescribed components of the nodes have yet to move in this increment, [i*gdim + c] [L].
  std::vector<double> ahead() const;
  /// Rows of D^-1 M of some of the nodes, D the diagonal.
  gap::MasterRows master_rows(std::span<const std::int32_t> rows) const;
  /// Nodal forces of tractions at carriers, of all pairs that share them, owned [F]. Collective.
  std::vector<double> joined_forces(std::span<const double> traction) const;
  /// Matrix of springs between nodes and what they face on the master, the caller's own [F/L]. Collective.
  /// @param[in] blocks [(k*gdim + a)*gdim + b] [F/L]
  Mat springs(std::span<const std::int32_t> rows, std::span<const double> blocks) const;
  /// Means of the absolute diagonal entries of the nodes' blocks: of the slave's nodes, and of what is opposite to them
  /// (zero: rigid) [F/L]. Collective.
  std::array<std::vector<double>, 2> diagonal_stiffness(Mat K) const;
  /// Jumps of some nodes under all rigid body modes, [(k*gdim + a)*num_modes + mode]. Collective.
  std::vector<double> rigid_body_jumps(const operators::RigidBodyModes& modes,
                                       std::span<const std::int32_t> rows) const;
  /// Mean sizes of the facets around the nodes [L]. Collective.
  std::vector<double> facet_sizes() const;
  /// Part of each node's area that is in contact [1]; docs/contact.md. More than 1: the contact reaches into the area
  /// of an open node beyond. Collective.
  std::vector<double> part_in_contact(std::span<const double> pressure, std::span<const std::int8_t> active) const;

  // --- constant ----------------------------------------------------------------------------------------------------
  MPI_Comm comm() const { return _space->mesh()->comm(); }
  int gdim() const { return _slave.gdim; }
  std::size_t num_nodes() const { return _nodes.nodes.size(); }
  const surface::FunctionSpace& space() const { return *_space; }
  std::shared_ptr<const dolfinx::common::IndexMap> map() const { return _space->dofmap()->index_map; }
  const surface::Facets& slave() const { return _slave; }
  const MortarOptions& options() const { return _options; }
  /// Owned blocks of the space.
  const std::vector<std::int32_t>& nodes() const { return _nodes.nodes; }
  /// Their global numbers.
  const std::vector<std::int64_t>& numbers() const { return _numbers; }
  /// Integrals of the nodes' functions over whole facets [L^2].
  const std::vector<double>& share() const { return _nodes.share; }
  /// Prescribed components of the nodes, [i*gdim + c].
  const std::vector<std::int8_t>& fixed() const { return _fixed; }
  /// Position of an owned or ghost node of the space in the reference configuration [L].
  const double* reference_point(std::int32_t node) const { return &_rest[std::size_t(node) * gdim()]; }
  /// Diagonal of the box around the bodies [L].
  double size() const { return _size; }
  /// Gaps below it are none [L].
  double tolerance() const { return 1e-12 * _size; }
  /// Added to gaps [L].
  std::vector<double> offset;
  MortarIncrement increment;

  // --- states and joined nodes -------------------------------------------------------------------------------------
  /// The present state, or the one that is evaluated.
  const SlaveNodes& now() const { return _states[_at]; }
  SlaveNodes& now() { return _states[_at]; }
  const JoinedNodes* joined() const { return _joined.get(); }
  /// Number of this pair among those that share nodes.
  int member() const { return _member; }
  /// Join nodes with other pairs.
  void join(std::shared_ptr<JoinedNodes> joined, int member);
  /// What an increment starts from.
  state::State state();

  /// While it lives, the second state of geometries is updated and read.
  class Elsewhere
  {
  public:
    explicit Elsewhere(std::vector<MortarGeometry*> geometries);
    ~Elsewhere();
    Elsewhere(const Elsewhere&) = delete;
    Elsewhere& operator=(const Elsewhere&) = delete;

  private:
    std::vector<MortarGeometry*> _geometries;
  };

protected:
  /// Move the slave, and take over displacements.
  void move(std::span<const double> u);
  int at() const { return _at; }
  const gap::MultiplierNodes& multiplier_nodes() const { return _nodes; }
  const std::shared_ptr<const surface::FunctionSpace>& shared_space() const { return _space; }
  /// Prescribed degrees of freedom, owned and ghosts.
  const std::vector<std::int8_t>& prescribed() const { return _prescribed; }
  /// Positions of all nodes in the reference configuration, owned and ghosts, [node*gdim + c] [L].
  const std::vector<double>& rest() const { return _rest; }
  /// Sums over the facets of values by facet and node, at this rank's nodes. Collective.
  std::vector<double> summed_at_nodes(std::vector<double> values) const;

private:
  std::shared_ptr<const surface::FunctionSpace> _space;
  surface::Facets _slave;
  MortarOptions _options;
  std::vector<std::int8_t> _prescribed, _fixed;
  gap::MultiplierNodes _nodes;
  std::vector<std::int64_t> _numbers;
  std::vector<double> _rest;
  double _size;
  std::array<SlaveNodes, 2> _states;
  int _at = 0;
  std::shared_ptr<JoinedNodes> _joined;
  int _member = 0;
};

/// A rule of Basix's on a reference facet, exact for polynomials of a degree.
struct FacetRule
{
  FacetRule(surface::FacetShape shape, int degree);
  /// The rule of the segments on which two surfaces meet.
  /// @param[in] degree nothing: exact where the facets are flat and their maps affine
  static FacetRule of_segments(const surface::Facets& slave, const surface::Facets& master, std::optional<int> degree);
  gap::SegmentRule view() const { return {points, weights}; }
  std::vector<double> points, weights;
};
} // namespace dolfinx_impact::enforcement
