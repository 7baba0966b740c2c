// SPDX-License-Identifier: MIT
#pragma once
#include "ClosedBatch.h"
#include "FieldsAtNodes.h"
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
  // Vectors by node, in space padded to four numbers: a whole register.
  std::vector<double> force, correction; ///< sums of the contacts' forces [F], displacements by them [L]
  std::vector<double> before;            ///< increments of the step before [L]

  /// Numbers of a node in these vectors.
  static constexpr int stride(int gdim) { return gdim == 3 ? 4 : gdim; }

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
  /// Coefficients of a law of friction.
  void begin(const PredictedStep& step, const CorrectedNodes& nodes);
  /// Place of a sweep in the step.
  struct Sweep
  {
    bool first; ///< nothing is corrected yet; masses and the forces of the nodes that open are set
    bool last;  ///< `record` reads how the forces act
  };
  /// One sweep: update the forces, project them on the admissible set (no tension, Coulomb's cone), and add them to
  /// those of the nodes.
  /// @param[in] factor over-relaxation of the increments [1]
  void sweep(const PredictedStep& step, CorrectedNodes& nodes, double factor, Sweep which);
  /// Results and work of the step.
  void record(const CorrectedNodes& nodes, double h, double dt);

  int sweeps() const { return _sweeps; }
  /// Nodes that it reads or acts on, by number, ascending.
  std::span<const std::int32_t> nodes() const { return _contact_nodes; }
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  void restore_obstacle(const gap::RigidMotion& motion) override;

private:
  KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                   const gap::Rigid* rigid, const KinematicContactOptions& options);
  void add_to(state::State& saved) const override;
  void resume_nodes(const state::State& saved) override;
  /// Batch and lane of closed node q.
  ClosedBatch& batch(std::size_t q) { return _batches[q / ClosedBatch::size]; }
  static int lane(std::size_t q) { return int(q % ClosedBatch::size); }
  std::size_t num_batches() const { return (_num_closed + ClosedBatch::size - 1) / ClosedBatch::size; }
  /// Calls each(batch) for all batches that have closed nodes.
  void for_batches(auto&& each)
  {
    for (std::size_t k = 0; k < num_batches(); ++k)
      each(_batches[k]);
  }
  /// Calls each(batch, l, i) for all closed nodes, i their position among the slave's nodes.
  void for_closed(auto&& each) const
  {
    for (std::size_t k = 0; k < num_batches(); ++k)
      for (int l = 0; l < _batches[k].num; ++l)
        each(_batches[k], l, std::size_t(_batches[k].slave[l]));
  }
  template <int D>
  void relative_to_master(const ClosedBatch& b, int l, const double* values, double* out) const;
  template <int D>
  void find_closed(const PredictedStep& step, const double* u);
  template <int D>
  void add_node(const ContactPoint& point, bool releases, const PredictedStep& step, const double* u);
  template <int D>
  void reaction(const ClosedBatch& b, int l, double* out) const;
  template <int D>
  void weigh(CorrectedNodes& nodes) const;
  template <int D>
  void set_masses(ClosedBatch& b, const double* inverse_mass, const std::vector<double>& weight);
  template <int D>
  void solve_release_forces(ClosedBatch& b, const PredictedStep& step, const CorrectedNodes& nodes);
  template <int D>
  void sweep_all(const PredictedStep& step, CorrectedNodes& nodes, double factor, Sweep which);
  template <int D>
  void begin_friction(const PredictedStep& step, const CorrectedNodes& nodes);
  void update_friction();
  void take_coefficients();
  template <int D>
  void record_all(const CorrectedNodes& nodes, double h, double dt);

  int _sweeps;
  int _num_masters;                     ///< nodes of a master facet; 0 if the master is rigid
  gap::RigidMotion _obstacle_before;    ///< in the step before
  std::vector<double> _absorbed_energy; ///< by contact since the node closed, by slave node [F L]
  std::vector<double> _impulse;         ///< decaying sum of those of the normal forces, by slave node [F T]
  std::vector<ClosedBatch> _batches;    ///< nodes that receive a force in this step
  std::size_t _num_closed = 0;          ///< their number
  ClosedRules _rules;
  ClosedInput _input;
  ClosedResult _result;
  std::vector<std::int32_t> _contact_nodes;
  // Friction of the closed nodes.
  FieldsAtNodes _fields;
  FrictionPoints _friction_points;
  FrictionCoefficients _coefficients;
};
} // namespace dolfinx_impact::enforcement
