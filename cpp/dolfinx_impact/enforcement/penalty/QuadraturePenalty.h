// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/InitialPenetration.h"
#include "../ContactTotals.h"
#include "../StaticContact.h"
#include "FacetKeeper.h"
#include "PenaltyForces.h"
#include "Uzawa.h"
#include <functional>
#include <memory>
#include <optional>

namespace dolfinx_impact::enforcement
{
/// Parameters of penalty contact at quadrature points.
struct PenaltyOptions
{
  double penalty = 0.0;          ///< pressure per penetration; 0: automatic_penalty [F/L^3]
  double tangential = 0.0;       ///< tangential traction per slip, with friction; 0: equal to the penalty [F/L^3]
  double friction = 0.0;         ///< coefficient [1]
  bool augmented = false;        ///< increments are repeated with augmented multipliers (Uzawa)
  double tolerance = 1e-8;       ///< largest mean penetration if augmented, relative to the size of the bodies [1]
  int max_augmentations = 200;   ///< of an increment
  int quadrature_degree = 0;     ///< of the rule on slave facets; 0: 2 degree + 2
  double search_distance = 0.0;  ///< see search::PairSearch [L]
  gap::GapAdjustment adjustment; ///< of gaps in the reference configuration
  bool axisymmetric = false;     ///< x is the radius
  /// A law of the interface in the place of penalties and friction; null: none.
  std::shared_ptr<const InterfaceLaw> law = nullptr;
};

/// Penalty contact of one pair in increments, docs/contact.md. Its points are the quadrature points of this rank's
/// slave facets. The increment moves PenaltyForces' points, keeps them on their facets, augments multipliers, and makes
/// tractions and slips history when it is accepted.
class QuadraturePenalty final : public StaticContact
{
public:
  /// Assembles the tangent of the bodies at their present state, borrowed until the next call [F/L]. Collective.
  typedef std::function<Mat()> TangentFunction;

  /// A deformable master. Collective.
  /// @param[in] name of the pair, for messages
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] bodies an automatic penalty is made from, and a given one is compared with; may be empty if one is
  /// given
  /// @throws std::invalid_argument on all ranks, if the bodies penetrate too deep or an option is not as it says
  QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                    surface::Facets master, const PenaltyOptions& options, TangentFunction bodies = {});
  /// A rigid one, at its place in the reference configuration; its displacement comes with begin_step. Collective.
  /// @throws std::invalid_argument on all ranks, also if the obstacle's surface does not face the slave
  QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                    gap::Rigid master, const PenaltyOptions& options, TangentFunction bodies = {});

  /// General contact: all facets of a surface may meet each other, and each point bears half of the penalty, as points
  /// of both sides do. Collective.
  /// @param[in] facets this rank's facets of the surface (make_surface)
  /// @param[in] named pairs of surfaces that are left to other contacts
  /// @throws std::invalid_argument on all ranks, also for augmentation, laws of the interface and adjusted gaps, and if
  /// bodies overlap by more than a twentieth of a cell
  QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V, surface::Facets facets,
                    std::span<const search::NamedPair> named, const PenaltyOptions& options,
                    TangentFunction bodies = {});

  const std::string& name() const override { return _name; }
  std::string fault() const override { return _fault; }
  void check_parameters() override;
  void check_without_time() const override;
  void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                  std::span<const double> target = {}) override;
  std::optional<std::array<double, 3>> displacement() const override;
  void set_rotation(const gap::Matrix3& rotation) override;
  std::optional<gap::Matrix3> rotation() const override;
  std::array<double, 3> centre() const override;
  state::State state() override;
  void accept_step() override;
  bool augment() override;
  std::string passed_through() override;
  void update_gap(std::span<const double> u) override;
  int update_active_set(bool first, std::optional<std::int64_t> last = {}) override;
  std::vector<double> contact_forces() const override { return _forces.contact_forces(); }
  void add_residual(Vec b) const override { _forces.add_residual(b); }
  /// Nothing: the penalty is the scale of force per displacement.
  void update_nodal_stiffness(Mat) override {}
  Mat tangent() override { return _forces.tangent(_convex); }
  void set_convex(bool convex) override { _convex = convex; }
  bool has_friction() const override { return _options.friction > 0.0 || (_options.law && _options.law->has_shear()); }
  bool needs_line_search() const override { return _options.law != nullptr; }
  void set_time_step(double dt) override;
  bool symmetric() const override;
  std::int64_t num_active() const override;
  double round_off() const override;
  std::string mesh_advice() const override;
  double smallest_gap() const override;
  state::State saved_state() override;
  void resume(const state::State& saved, std::span<const double> u) override;
  void forget() override { _forces.forget(); }
  std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const override;
  bool close_nearest() override;
  std::vector<double> closing_forces() const override;
  std::vector<double> points() const override { return _forces.points().x; }
  std::vector<double> gap() const override;
  std::vector<double> normal() const override { return _forces.points().normal; }
  std::vector<double> pressure() const override { return _forces.state().pressure; }
  std::vector<double> traction() const override;
  std::vector<double> slip() const override { return _forces.state().slip; }
  std::vector<ContactStatus> status() const override;
  std::vector<double> weight() const override { return _forces.points().weight; }
  std::vector<double> covered() const override;
  std::optional<std::array<double, 3>> force() const override { return _totals.known_force(); }
  double dissipated() const override { return _totals.dissipated; }
  double stored_energy() const override;

  /// Do all facets of a surface meet each other?
  bool meets_itself() const { return general(); }
  /// Deepest penetration of all ranks in the present state, zero without any [L]. Collective.
  double deepest() const;
  /// Penalty in use; of general contact that between the stiffest bodies; 0 before the first increment with an
  /// automatic one [F/L^3].
  double penalty() const { return _penalty; }
  /// Tangential penalty in use; 0 before the first increment [F/L^3].
  double tangential() const { return _tangential; }
  bool convex() const { return _convex; }
  const PenaltyOptions& options() const { return _options; }
  const gap::InitialPenetration& initial() const { return *_initial; }
  ContactTotals& totals() { return _totals; }
  PenaltyForces& forces() { return _forces; }
  Uzawa& uzawa() { return _uzawa; }
  /// Are the points of close_nearest closed in this iteration?
  bool closes_nearest() const { return _closes_nearest; }
  /// Has an increment begun?
  bool has_begun() const { return _touch.has_value(); }

  /// Means of point values at the slave's nodes, weighted with squares of the shape functions. Collective.
  /// @param[in] values [point*columns + c]
  /// @returns owned nodes, and means, [i*columns + c]
  std::pair<std::vector<std::int32_t>, std::vector<double>> nodal_means(std::span<const double> values,
                                                                        std::size_t columns) const;

private:
  std::vector<double> facing_gap() const;
  QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                    std::optional<surface::Facets> master, std::shared_ptr<gap::Rigid> rigid,
                    std::unique_ptr<search::GeneralSearch> general, const PenaltyOptions& options,
                    TangentFunction bodies);
  bool general() const { return _forces.general() != nullptr; }
  void refuse_overlap();
  void set_penalties();
  void keep_depths();
  std::string too_deep() const;
  MPI_Comm comm() const { return _space->mesh()->comm(); }
  const gap::Points& at() const { return _forces.points(); }
  double sum_over_ranks(double value) const;
  double automatic() const;
  double stiffness() const;
  void locate(std::span<const double> u);
  std::vector<std::int64_t> facet_ids() const;
  void keep_facets(std::span<const std::int64_t> ids);
  bool leave_facets();
  std::vector<double> closest_points() const;
  std::vector<double> gap_without_overhang();
  bool turns() const { return _rigid && _rigid->rotates; }
  RigidIncrement rigid_increment() const;

  std::string _name;
  std::shared_ptr<const surface::FunctionSpace> _space;
  PenaltyOptions _options;
  TangentFunction _bodies;
  surface::Facets _slave; ///< nodes of the space; moved where that is said
  std::optional<surface::Facets> _master;
  std::shared_ptr<gap::Rigid> _rigid;
  double _size; ///< of the bodies [L]
  surface::QuadratureRule _rule;
  PenaltyForces _forces;
  Uzawa _uzawa;
  std::optional<FacetKeeper> _keeper; ///< of deformable masters
  std::optional<gap::InitialPenetration> _initial;
  ContactTotals _totals;
  double _penalty, _tangential;
  std::string _fault;
  bool _convex = false;
  bool _seen = false;           ///< points have been assigned to facets; not in the reference configuration
  bool _closes_nearest = false; ///< in this iteration
  /// Trial pressure below zero up to which points close in an increment's first evaluation; nothing: none has begun.
  std::optional<double> _touch;
  std::vector<double> _u, _start; ///< displacements now and when the increment began; ghosts follow in update_gap
  std::array<double, 3> _displacement{}, _start_displacement{};            ///< of a rigid master
  gap::Matrix3 _rotation = gap::identity, _start_rotation = gap::identity; ///< of one that turns
  std::optional<gap::Matrix3> _next_rotation;                              ///< at the end of the next increment
  std::vector<std::int8_t> _touched;                         ///< points that were closed in the last converged state
  std::vector<double> _gap_before;                           ///< facing_gap in the last converged state
  std::vector<ContactStatus> _last_status;                   ///< of the last iteration
  std::optional<std::vector<ContactStatus>> _resumed_status; ///< that of a checkpoint, until the next evaluation
};
} // namespace dolfinx_impact::enforcement
