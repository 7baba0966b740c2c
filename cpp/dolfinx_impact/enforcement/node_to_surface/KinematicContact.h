// SPDX-License-Identifier: MIT
#pragma once
#include "FieldsAtNodes.h"
#include "MomentCorrection.h"
#include "NodeToSurface.h"

namespace dolfinx_impact::enforcement
{
struct KinematicContactOptions : NodeToSurfaceOptions
{
  int sweeps = 3; ///< sweeps over the closed nodes in each step
};

/// Values at the nodes of the Halo that all kinematic contacts of a run have in common in a step. Ghost entries of
/// `force` outside the contacts' nodes stay zero: the array is summed over the ranks and never sent forward.
struct CorrectedNodes
{
  std::vector<double> weight;  ///< sum of the parts that all closed nodes' forces have on a node [1]
  std::vector<double> largest; ///< of these, all that can add up in one direction; empty: no node has several surfaces
  std::array<std::vector<double>, 2> tensor; ///< parts by direction: xx, xy, yy and xz, yz, zz, three for each node
  std::vector<char> shared;                  ///< does the node belong to several surfaces?
  std::vector<double> force, correction;     ///< sums of the contacts' forces [F], displacements by them [L]
  std::vector<double> before;                ///< increments of the step before [L]

  /// What weighs on a node in a sweep.
  const std::vector<double>& in_sweeps() const { return largest.empty() ? weight : largest; }
};

/// Explicit contact by the kinematic method: forces that correct the predicted step (docs/explicit/kinematic.md).
class KinematicContact : public NodeToSurface
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space
  KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                   const KinematicContactOptions& options);
  KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
                   const KinematicContactOptions& options);

  // The parts of a step, in their order; KinematicStep does what lies between them. `predict` is collective.

  /// Find the nodes in contact in the predicted configuration, and the nodes that open in this step.
  /// @param[in] u predicted displacements, ghosts valid [L]
  void predict(const PredictedStep& step, std::span<const double> u);
  /// Add what the closed nodes' forces weigh on all nodes.
  void add_weights(CorrectedNodes& nodes) const;
  /// Masses for the sweeps, and forces of the nodes that open.
  void begin(const PredictedStep& step, const CorrectedNodes& nodes);
  /// One sweep: update the forces and project them on the admissible set (no tension, Coulomb's cone).
  /// @param[in] factor over-relaxation of the increments [1]
  /// @param[in] first it is the first one: nothing is corrected yet
  void solve_forces(const CorrectedNodes& nodes, double h, double factor, bool first);
  /// Add the forces to those of the nodes.
  /// @param[in] last after the last sweep: `record` reads how they act
  void add_forces(std::span<double> forces, bool last);
  /// Results and work of the step.
  void record(const CorrectedNodes& nodes, double h, double dt);

  int sweeps() const { return _sweeps; }
  /// Nodes that it reads or acts on, by number, ascending.
  std::span<const std::int32_t> nodes() const { return _contact_nodes; }
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  void restore_obstacle(const gap::RigidMotion& motion) override;

private:
  /// A node that receives a contact force in this step; its shape functions are in `_phi`.
  struct alignas(64) Closed
  {
    const std::int32_t *masters, *corners; ///< as in ContactPoint
    double normal[3], overlap;             ///< [L]
    std::uint32_t i;
    std::int32_t node;
    bool releases; ///< it opens in this step: its force is fixed before the sweeps
  };

  KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                   const gap::Rigid* rigid, const KinematicContactOptions& options);
  void add_to(state::State& saved) const override;
  void resume_nodes(const state::State& saved) override;
  template <int D>
  void relative_to_master(std::size_t q, const double* values, double* out) const;
  template <int D>
  void find_closed(const PredictedStep& step, const double* u);
  template <int D>
  void reaction(std::size_t q, double* out) const;
  template <int D>
  void weigh(CorrectedNodes& nodes) const;
  template <int D>
  void set_masses(const double* inverse_mass, const std::vector<double>& weight);
  template <int D>
  void solve_release_forces(const PredictedStep& step, const CorrectedNodes& nodes);
  template <int D>
  void begin_friction(const PredictedStep& step, const CorrectedNodes& nodes);
  void update_friction();
  template <int D>
  void sweep(const double* correction, double h, double factor, bool first);
  template <int D>
  void add_all(std::span<double> forces, bool last);
  template <int D>
  void record_all(const CorrectedNodes& nodes, double h, double dt);

  int _sweeps;
  int _num_masters;                     ///< nodes of a master facet; 0 if the master is rigid
  gap::RigidMotion _obstacle_before;    ///< in the step before
  std::vector<double> _absorbed_energy; ///< by contact since the node closed, by slave node [F L]
  std::vector<double> _impulse;         ///< decaying sum of those of the normal forces, by slave node [F T]
  std::vector<Closed> _closed_now;
  std::size_t _num_closed = 0;
  std::vector<double> _phi, _motion, _turn, _nodal_force, _normal_mass, _isotropic_mass;
  std::vector<MomentCorrection> _moment_corrections;
  std::vector<double> _arms; ///< of the moment corrections
  /// Of the forces that were added last, on the master's nodes of closed node q: [(q*num_masters + j)*gdim + c] [F].
  std::vector<double> _corrections;
  std::vector<std::int32_t> _contact_nodes;
  // Friction of the closed nodes.
  FieldsAtNodes _fields;
  FrictionPoints _friction_points;
  FrictionCoefficients _coefficients;
};
} // namespace dolfinx_impact::enforcement
