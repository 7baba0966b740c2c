// SPDX-License-Identifier: MIT
#pragma once
#include "MomentCorrection.h"
#include "NodeToSurface.h"

namespace dolfinx_impact::enforcement
{
struct KinematicContactOptions : NodeToSurfaceOptions
{
  int sweeps = 3; ///< over the closed nodes, in each step
};

/// Explicit contact by the kinematic method: forces that correct a predicted step, docs/explicit/kinematic.md.
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

  void correct(const PredictedStep& step, double* u, double* f) override;
  void number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass) override;

  /// By owned slave node: energy taken from it since it closed [F L]; impulse of its last normal forces, fading [F T].
  const std::vector<double>& taken() const { return _taken; }
  const std::vector<double>& pulse() const { return _pulse; }
  /// @throws std::invalid_argument for another number of nodes
  void set_taken(std::vector<double> taken, std::vector<double> pulse);

private:
  /// A node that contact acts on in this step; shape functions are in `_phi`.
  struct alignas(64) Closed
  {
    const std::int32_t *masters, *corners; ///< as of Touch
    double normal[3], overlap;             ///< [L]
    std::uint32_t i;
    std::int32_t node;
    bool releases; ///< it leaves the master in this step: its force is known beforehand
  };

  KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                   const gap::Rigid* rigid, const KinematicContactOptions& options);
  template <int D>
  void relative(std::size_t q, const double* values, double* out) const;
  template <int D>
  void predict(const PredictedStep& step, const double* u);
  template <int D>
  void reaction(std::size_t q, double* out) const;
  template <int D>
  void add_masses(const double* inverse_mass);
  template <int D>
  void release(const PredictedStep& step);
  template <int D>
  void solve_forces(double h, double factor);
  template <int D>
  void apply(const double* inverse_mass, double h);
  template <int D>
  void record(double h, double dt);
  template <int D>
  void correct_all(const PredictedStep& step, double* u, double* f);

  int _sweeps;
  int _num_masters; ///< nodes of a master's facet; 0: rigid
  std::array<double, 3> _obstacle_before{};
  std::vector<double> _taken, _pulse;
  std::vector<Closed> _closed_now;
  std::size_t _num_closed = 0;
  std::vector<double> _phi, _motion, _nodal_force, _along, _across;
  std::vector<MomentCorrection> _corrections;
  std::vector<double> _arms; ///< of the moment corrections
  // Values at the Halo's nodes. `_sum` is summed over ranks: it is zero at all ghosts but those in `_touched`, and
  // never sent forward.
  std::vector<std::int32_t> _touched;
  std::vector<double> _weight, _sum, _moved, _before;
};
} // namespace dolfinx_impact::enforcement
