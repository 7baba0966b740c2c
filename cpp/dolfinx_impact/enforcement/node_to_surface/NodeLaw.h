// SPDX-License-Identifier: MIT
#pragma once
#include "../interface/InterfaceLaw.h"
#include "FieldsAtNodes.h"
#include "MasterForces.h"
#include "NodeToSurface.h"
#include <memory>

namespace dolfinx_impact::enforcement
{
/// Where the force of the last step on a slave's node acts on the master.
struct LastForce
{
  std::int64_t facet = -1;                                ///< id; -1: none, or not known
  std::int32_t corners[surface::FacetElement::max_nodes]; ///< numbers of the facet's nodes
  double phi[surface::FacetElement::max_nodes];           ///< shape functions at the point [1]
  double turn[3 * surface::FacetElement::max_nodes];      ///< moment correction, [j*gdim + c] [F]
};

/// Explicit contact by a law of the interface: tractions at slave nodes times their areas, docs/interface_laws.md.
///
/// The law is asked in every step at all nodes within its reach, or within the search distance if that is less.
class NodeLaw : public NodeToSurface, public SpringForces
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space, a law of another
  /// dimension, or friction beside it
  NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
          std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options = {});
  NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
          std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options = {});

  const InterfaceLaw& law() const { return *_law; }
  void add_forces(const NodalState& state, std::span<double> f) override;
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  /// Of the law's largest stiffness where surfaces touch and at the nodes' last evaluation.
  double added_square_frequency(std::span<const double> mass) const override;
  double added_damping_rate(std::span<const double> mass) const override;
  std::int64_t num_unsolved() const override { return _tractions.num_unsolved; }

private:
  NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
          const gap::Rigid* rigid, std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options);
  void add_to(state::State& saved) const override;
  void resume_nodes(const state::State& saved) override;
  void drop_stored_energy(std::size_t i) override;
  /// Half of the work of the last tractions is done in the present step, over the node's area [F/L].
  struct HalfWork
  {
    double normal = 0.0, shear = 0.0;
  };
  HalfWork last_work(std::size_t i, const double* motion) const;
  template <int D>
  void find_points(const NodalState& state);
  template <int D>
  void add_point(std::size_t p, const NodalState& state, std::span<double> f);
  template <int D>
  void add_all(const NodalState& state, std::span<double> f);
  /// Largest derivative of the traction where surfaces touch: by gap and slip [F/L^3], by their rates [F T/L^3].
  struct Derivatives
  {
    double by_motion = 0.0, by_rate = 0.0;
  };
  Derivatives largest_derivatives() const;

  std::shared_ptr<const InterfaceLaw> _law;
  InterfaceHistory _history; ///< by slave node
  bool _begun = false;       ///< was there a step?
  // Of the last step, by slave node.
  std::vector<double> _last_pressure, _last_shear, _last_normal, _last_motion, _last_stored, _last_shear_stored;
  // Of the present step, by node in reach.
  std::vector<ContactPoint> _found;
  InterfacePoints _points;
  InterfaceTractions _tractions;
  std::vector<double> _motion; ///< increment relative to the master [L]
  FieldsAtNodes _fields;
  MasterForces _master_forces;
  std::vector<MomentCorrection> _corrections; ///< of the present step, by node in reach
  std::vector<double> _arms;                  ///< of them: positions of the facet's nodes about their mean [L]
  std::vector<LastForce> _last;               ///< by slave node
  const double* _du = nullptr;                ///< increments of the present step [L]
};
} // namespace dolfinx_impact::enforcement
