// SPDX-License-Identifier: MIT
#pragma once
#include "MasterForces.h"
#include "NodeToSurface.h"
#include "SpringBatch.h"
#include "spring.h"
#include <array>

namespace dolfinx_impact::enforcement
{
struct NodePenaltyOptions : NodeToSurfaceOptions
{
  double penalty = 0.0; ///< pressure per penetration; 0: nodal stiffness of the surfaces [F/L^3]
  double kappa = 0.5;   ///< stiffness of a node times dt^2 over its mass where no nodal stiffness is known [1]
  double share = 1.0;   ///< of the stiffness; half for each direction of balanced contact, see NodalPair [1]
  /// Without a given penalty the springs follow from masses and step, whatever the stiffness of the bodies.
  bool by_step = false;
};

/// Reciprocals of the nodal stiffness of two surfaces, by node that this rank owns; zero where none is known [L/F].
struct NodalCompliances
{
  std::vector<double> slave, master;
};

/// Springs of given stiffness at all slave nodes that have a master, in contact or open.
struct NodalSprings
{
  int num_masters = 0;
  std::vector<std::int32_t> nodes;   ///< slave nodes
  std::vector<std::int32_t> masters; ///< nodes of the master facet of slave s, [s*num_masters + j]
  std::vector<double> phi;           ///< shape functions at the projection, as `masters` [1]
  std::vector<double> normal;        ///< [s*gdim + c]
  std::vector<double> stiffness;     ///< [F/L]
};

/// Explicit contact by penalty: springs between slave nodes and the master, docs/explicit/penalty.md. Balanced contact
/// has two of them, see NodalPair.
class NodePenalty : public NodeToSurface, public SpringForces
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space
  NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
              const NodePenaltyOptions& options = {});
  NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
              const NodePenaltyOptions& options = {});

  void add_forces(const NodalState& state, std::span<double> f) override;
  std::span<const std::int32_t> required_nodes(operators::Halo& all) override;
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  /// Nodal stiffness of both surfaces (docs/explicit/penalty.md, "Stiffness"); call before `needs`.
  /// @throws std::invalid_argument for another number of nodes, negative or infinite values
  void set_nodal_compliances(NodalCompliances compliances);
  const NodalCompliances& nodal_compliances() const { return _known; }
  /// Given penalty; 0: none [F/L^3].
  double penalty() const { return _penalty; }
  /// Options that it was made with.
  NodePenaltyOptions penalty_options() const { return {_options, _penalty, _kappa, _share, _by_step}; }
  /// Are the springs to follow from the stiffness of the bodies, which nobody has told yet?
  bool lacks_compliances() const { return !(_penalty > 0.0) && !_by_step && _known.slave.empty(); }
  /// Of springs of given stiffness: the largest sum of stiffness over mass at a slave node and at the nodes of its
  /// facet, from the largest areas and ratios of area to mass; docs/explicit/penalty.md, "A given penalty". Others do
  /// not shorten the stable step.
  double added_square_frequency(std::span<const double> mass) const override;

  /// Contact stiffness of each owned slave node in the last step; zero where open [F/L].
  std::vector<double> stiffness() const;
  /// Springs in a given configuration, outside of time stepping; call after `number`.
  /// @param[in] u displacements of the Halo's nodes [L]
  /// @throws std::invalid_argument without a given penalty
  NodalSprings springs_at(std::span<const double> u);

private:
  /// The spring of a slave node: what a step needs of it lies in one line of the cache.
  struct alignas(64) NodeSpring : Spring
  {
    double node_compliance = 0.0; ///< of the node in the present step [L/F]
    double per_area = 0.0;        ///< reciprocal of its area
  };

  NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
              const gap::Rigid* rigid, const NodePenaltyOptions& options);
  double deepest_penetration() const override;
  void add_to(state::State& saved) const override;
  void resume_nodes(const state::State& saved) override;
  void drop_stored_energy(std::size_t i) override;
  double node_compliance(double known, double inverse_mass, double dt) const;
  void update_compliances(double dt);
  template <int D>
  void open_spring(std::size_t i, const double* n, double change, const double* motion);
  template <int D>
  void add_node(const ContactPoint& point, const NodalState& state);
  template <int D>
  void add_batch(const NodalState& state, std::span<double> f);
  template <int D>
  void add_force(const ContactPoint& point, int l, const NodalState& state, std::span<double> f);
  template <int D>
  void add_all(const NodalState& state, std::span<double> f);

  double _penalty, _kappa, _share;
  bool _by_step;
  NodalCompliances _known;          ///< empty: none known
  std::vector<double> _all_known;   ///< of the master over the nodes of the Halo of `needs` [L/F]
  std::vector<double> _master_here; ///< by position in NodeTracker's list of master nodes [L/F]
  double _compliance_step = 0.0;    ///< step that compliances were made for; 0: none yet [T]
  MasterForces _master_forces;
  SpringBatch _batch = {};
  std::array<ContactPoint, SpringBatch::size> _points; ///< of the nodes in the batch
  std::vector<NodeSpring> _springs;                    ///< by slave node
};
} // namespace dolfinx_impact::enforcement
