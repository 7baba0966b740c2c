// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/InitialPenetration.h"
#include "../../gap/Rigid.h"
#include "../../search/node_tracker/NodeTracker.h"
#include "../ContactStatus.h"
#include "../friction.h"
#include "../interface/FrictionLaw.h"
#include "NodalContact.h"
#include "NodeCandidates.h"
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Options of every node-to-surface contact.
struct NodeToSurfaceOptions
{
  double friction = 0.0;                                     ///< coefficient, without `friction_law` [1]
  double search_distance = 0.0;                              ///< 0 means the largest facet diameter [L]
  bool axisymmetric = false;                                 ///< nodal areas are multiplied by 2 pi R
  std::string name = "contact";                              ///< for messages
  gap::GapAdjustment adjustment = {};                        ///< of gaps in the reference configuration
  std::shared_ptr<const FrictionLaw> friction_law = nullptr; ///< of kinematic contact; null: a constant coefficient

  bool has_friction() const { return friction > 0.0 || friction_law; }
};

/// Results of the last step at the slave nodes that this rank owns. Vectors: [i*gdim + c].
struct NodalResults
{
  std::vector<ContactStatus> status;
  std::vector<double> gap;      ///< for open nodes the value of the last evaluation; infinite without a master [L]
  std::vector<double> normal;   ///< unit, outward from the master [1]
  std::vector<double> pressure; ///< normal force per area of the node [F/L^2]
  std::vector<double> traction; ///< force on the slave per area [F/L^2]
  std::vector<double> slip;     ///< accumulated since the node closed [L]
};

/// Detects in each step which slave nodes are in contact with the master surface or a rigid obstacle, where they
/// project, and whether they have passed through the surface (docs/explicit/penalty.md). Derived classes compute the
/// forces.
class NodeToSurface : public NodalContact
{
public:
  void search(std::span<const double> u, std::span<const double> du) override;
  std::span<const std::int64_t> remote_nodes() const override { return _candidates.remote_nodes(); }
  std::span<const int> remote_owners() const override { return _candidates.remote_owners(); }
  std::span<const std::int32_t> required_nodes(operators::Halo& all) override;
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  double increment_used(const NodalState& state) const override { return _candidates.increment_used(state); }
  void forget_search() override { _candidates.forget(); }
  void update_gaps(std::span<const double> u) override;
  ContactEnergy energy() const override { return _energy; }
  Passage passage() const override { return _passage; }
  const std::array<double, 3>& force() const override { return _force; }
  double largest_position() const override { return _obstacle_size; }
  gap::Matrix3 force_moment() const override { return _force_moment; }
  void set_obstacle(const gap::RigidMotion& motion) override;
  /// The master is a rigid body: area of the slaves of all its contacts times an upper bound of what a unit force at a
  /// contact point accelerates it by, at any contact point; zero: it moves as prescribed [L^2/M].
  void set_mobility(double mobility) { _mobility = mobility; }

  const NodeCandidates& candidates() const { return _candidates; }
  const NodeToSurfaceOptions& options() const { return _options; }
  /// The rigid master where it is now; null: the master is deformable.
  const gap::Rigid* obstacle() const { return _rigid ? &_obstacle : nullptr; }
  /// Areas of the master's nodes, zero elsewhere, over the nodes of the Halo of the last `needs`; empty: rigid [L^2].
  std::span<const double> master_areas() const { return _areas; }
  const NodalResults& results() const { return _results; }
  const search::NodeTracker& tracker() const { return _tracker; }
  /// Longest slave facet of all ranks: the diagonal of its box in the reference configuration [L].
  double facet_length() const { return _facet_length; }
  /// Number of owned slave nodes that lie in a rigid master by more than half a facet; nothing: the master is
  /// deformable.
  /// @param[in] u displacements of owned nodes of the space [L]
  std::optional<std::int64_t> too_deep(std::span<const double> u) const;
  /// Penetrations in the reference configuration and what gaps were adjusted by; nothing unless that was asked for.
  const std::optional<gap::InitialPenetration>& initial() const { return _initial; }
  /// Number of nodes that were left open because their first penetration was implausibly deep.
  std::int64_t implausible() const { return _num_implausible; }
  /// By node: "tangential" forces [F], "slip" [L], "xi" and "facet" (coordinates on and id of the master's facet that
  /// it is tracked on, -1: none), fields of the derived class, "closed" (1: in contact, 0: open, -1: marked,
  /// docs/explicit/penalty.md).
  state::State saved_state() const override;
  void resume(const state::State& saved) override;
  void reset() override;
  /// For tests of the tests only: judge whether surfaces face each other by the normals of the last search.
  void keep_normals(bool keep) { _tracker.keep_normals(keep); }

protected:
  /// A slave node and its projection on the master.
  struct ContactPoint
  {
    std::size_t i;
    std::int32_t node;
    int num = 0;                           ///< master nodes
    const std::int32_t* masters = nullptr; ///< numbers
    const std::int32_t* corners = nullptr; ///< positions in NodeTracker::masters()
    double phi[surface::FacetElement::max_nodes];
    search::Projection at;
  };
  static constexpr std::int8_t marked = -1; ///< value of `_closed`: the node stays open until its gap is positive

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave this rank's facets (make_surface)
  /// @param[in] master this rank's facets; null: rigid
  /// @param[in] rigid the obstacle; null: deformable
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space
  NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                const gap::Rigid* rigid, const NodeToSurfaceOptions& options);

  /// Deepest penetration of a closed node; facets within it must stay candidates [L].
  virtual double deepest_penetration() const { return 0.0; }
  /// Add fields of the nodes to what is saved, values of their own.
  virtual void add_to(state::State&) const {}
  /// Set them from a state of the same structure.
  virtual void resume_nodes(const state::State&) {}
  /// Called when node i opens although its gap did not become positive; its tangential force is still valid.
  virtual void drop_stored_energy(std::size_t) {}

  /// Detect contact of node i and set its projection.
  /// @param[in] reach a node whose gap is larger is open [L]
  /// @param[in] keep_closed report nodes that were closed in the last step whatever their gap
  /// @param[out] point the projection, valid if true is returned
  /// @returns true if the node is in contact; otherwise it has been set to open
  bool find_contact(std::size_t i, const double* u, const double* du, double reach, bool keep_closed,
                    ContactPoint& point);
  void open(std::size_t i, const search::Projection& at, const double* u);
  /// How the rigid master has moved in the last step at a place.
  /// @param[in] x the place, (gdim) [L]
  /// @param[out] increment (gdim) [L]
  void obstacle_increment(const double* x, double* increment) const;
  /// Place of node i, (gdim) [L].
  void position(std::size_t i, const double* u, double* x) const;
  /// Add the moment of a force on node i, where somebody reads it.
  void add_to_moments(std::size_t i, const double* u, const double* force)
  {
    if (_rigid && _obstacle_motion.rotates)
      add_moment(i, u, force);
  }
  /// Projection of node i on the rigid master in the configuration u - back*du.
  search::Projection rigid_point(std::size_t i, const double* u, const double* du = nullptr, double back = 0.0) const;
  /// Upper bound of what forces per motion and area, at slave nodes wherever they meet the master, are over the masses
  /// of the nodes that they act on. Collective.
  /// @param[in] per_area force per motion and area
  /// @param[in] mass of owned nodes of the space [M]
  double per_mass(double per_area, std::span<const double> mass) const;
  /// True if contact forces need a moment correction (deformable master, not axisymmetric).
  bool corrects_moments() const { return !_rigid && !_options.axisymmetric; }
  std::size_t num_nodes() const { return _closed.size(); }

  NodeToSurfaceOptions _options;
  int _gdim;
  bool _rigid;
  gap::Rigid _obstacle;
  gap::RigidMotion _obstacle_motion;
  double _mobility = 0.0;
  NodeCandidates _candidates;
  search::NodeTracker _tracker;
  operators::Halo* _halo = nullptr;
  std::vector<double> _inverse_mass, _per_area; ///< by slave node: reciprocals of mass and area
  /// By position in NodeTracker's list of master nodes: reciprocals of masses, and areas.
  std::vector<double> _master_inverse_mass, _master_areas;
  NodalResults _results;
  std::vector<double> _tangential;
  std::vector<std::int8_t> _closed;
  ContactEnergy _energy;
  std::array<double, 3> _force{};
  gap::Matrix3 _force_moment{};
  Passage _passage;

private:
  void add_moment(std::size_t i, const double* u, const double* force);
  std::vector<double> reference_gaps(const surface::FunctionSpace& V);
  /// A projection whose gap is that of the node, adjusted as it was in the reference configuration.
  search::Projection adjusted(std::size_t i, search::Projection at) const;
  void adjust(std::size_t i, search::Projection& at) const;
  template <int D>
  double rounding(std::size_t i, const double* u) const;
  template <int D>
  double most_rounding(std::size_t i) const;
  template <int D>
  bool find_contact_in(std::size_t i, const double* u, const double* du, double reach, bool keep_closed,
                       ContactPoint& point);
  bool is_marked(const ContactPoint& point, const double* u, const double* du);
  /// Projection in the configuration u - back*du.
  search::Projection point_before(std::size_t i, const double* u, const double* du, double back) const;
  /// Increment of the step relative to the master at the projection.
  void relative_motion(std::size_t i, const search::Projection& at, const double* u, const double* du,
                       double* motion) const;
  /// Follow an open node along its path in the step.
  /// @returns true if it passed through more than one facet diameter of the master: too far to be pushed back
  bool passes_through(ContactPoint& point, const double* u, const double* du);

  // Numbered by the Halo passed to `needs`: nodes, candidate facets, areas of master nodes.
  std::vector<std::int32_t> _needed;
  surface::Facets _facets, _slave_facets; ///< candidates; slave facets at the nodes
  std::vector<double> _areas;
  std::optional<gap::InitialPenetration> _initial;
  std::vector<double> _shift; ///< added to gaps, by slave node; empty: nothing [L]
  std::int64_t _num_implausible = 0;
  double _facet_length = 0.0;
  double _undisplaced_size = 0.0, _obstacle_size = 0.0; ///< of the numbers in the rigid master's position [L]
};
} // namespace dolfinx_impact::enforcement
