// SPDX-License-Identifier: MIT
#pragma once
#include "MomentCorrection.h"
#include "NodeToSurface.h"

namespace dolfinx_impact::enforcement
{
struct KinematicContactOptions : NodeToSurfaceOptions
{
  int sweeps = 3; ///< sweeps over the closed nodes in each step
};

/// Explicit contact by the kinematic method: forces that correct the predicted step (docs/explicit/kinematic.md).
class KinematicContact : public NodeToSurface, public StepCorrection
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

  void correct(const PredictedStep& step, std::span<double> u, std::span<double> f) override;
  void number(operators::Halo& halo, std::span<const std::int32_t> numbers, std::span<const double> mass) override;
  void restore_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment) override;

  /// Energy that contact has absorbed since the node closed, by owned slave node [F L].
  const std::vector<double>& absorbed_energy() const { return _absorbed_energy; }
  /// Decaying sum of the impulses of the normal forces, by owned slave node [F T].
  const std::vector<double>& impulse() const { return _impulse; }
  /// @throws std::invalid_argument for another number of nodes
  void set_release_history(std::vector<double> taken, std::vector<double> pulse);

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
  template <int D>
  void relative_to_master(std::size_t q, const double* values, double* out) const;
  template <int D>
  void predict(const PredictedStep& step, const double* u);
  template <int D>
  void reaction(std::size_t q, double* out) const;
  template <int D>
  void add_masses(const double* inverse_mass);
  template <int D>
  void solve_release_forces(const PredictedStep& step);
  template <int D>
  void solve_forces(double h, double factor);
  template <int D>
  void apply(const double* inverse_mass, double h);
  template <int D>
  void record(double h, double dt);
  template <int D>
  void correct_all(const PredictedStep& step, std::span<double> u, std::span<double> f);

  int _sweeps;
  int _num_masters; ///< nodes of a master facet; 0 if the master is rigid
  std::array<double, 3> _obstacle_before{};
  std::vector<double> _absorbed_energy, _impulse;
  std::vector<Closed> _closed_now;
  std::size_t _num_closed = 0;
  std::vector<double> _phi, _motion, _nodal_force, _normal_mass, _isotropic_mass;
  std::vector<MomentCorrection> _moment_corrections;
  std::vector<double> _arms; ///< of the moment corrections
  // Values at the Halo's nodes. Ghost entries of `_contact_force` outside `_contact_nodes` stay zero: the array is
  // summed over the ranks and never sent forward.
  std::vector<std::int32_t> _contact_nodes;
  std::vector<double> _weight, _contact_force, _correction, _previous_increment;
};
} // namespace dolfinx_impact::enforcement
