// SPDX-License-Identifier: MIT
#pragma once
#include "../node_to_surface/NodalContact.h"
#include "TieConditions.h"
#include <memory>

namespace dolfinx_impact::enforcement
{
/// A tie in an explicit problem: the conditions of TieConditions on the predicted displacements of a step. TieStep
/// solves for the forces of all ties of a run. Forces do no work: what they take from one body they give to the other.
class ExplicitTie : public NodalContact
{
public:
  /// Collective.
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  /// @throws std::invalid_argument as TieConditions
  ExplicitTie(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
              const TieOptions& options, std::vector<std::int8_t> fixed);

  const TieConditions& conditions() const { return _conditions; }
  /// See TieConditions::leave_out. Collective.
  void leave_out(std::span<const std::int8_t> taken);

  // --- a step, by TieStep -------------------------------------------------------------------------------------------
  /// Number of conditions of this rank.
  std::size_t size() const { return _num_conditions; }
  /// C u of this rank's conditions [L^3].
  /// @param[in] u displacements by number, ghosts valid [L]
  void jumps(std::span<const double> u, std::span<double> out) const;
  /// Add C^T z to nodal forces by number, and keep z and the force on the slave as results.
  void add_forces(std::span<const double> z, std::span<double> forces);

  // --- results ------------------------------------------------------------------------------------------------------
  /// Tractions on the slave in the last step, [i*gdim + c], i over the nodes of the conditions [F/L^2].
  std::vector<double> traction() const;
  /// Sum of the forces on the slave in the last step, of this rank [F].
  const std::array<double, 3>& force() const override { return _force; }
  /// Nodal forces of the last step on both surfaces, owned [F]. Collective.
  std::vector<double> forces() const { return _conditions.forces(_multipliers); }

  // --- NodalContact -------------------------------------------------------------------------------------------------
  void search(std::span<const double>, std::span<const double>) override {} // the conditions never change
  std::span<const std::int64_t> remote_nodes() const override { return _remote; }
  std::span<const int> remote_owners() const override { return _owners; }
  std::span<const std::int32_t> required_nodes(operators::Halo& all) override;
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  double largest_position() const override { return 0.0; }
  void set_obstacle(const gap::RigidMotion&) override {}
  double increment_used(const NodalState&) const override { return 0.0; }
  void forget_search() override {}
  void update_gaps(std::span<const double>) override {}
  ContactEnergy energy() const override { return {}; }
  Passage passage() const override { return {}; }
  state::State saved_state() const override;
  void resume(const state::State& saved) override;
  void reset() override;

private:
  void find_remote();

  TieConditions _conditions;
  std::size_t _num_conditions = 0;
  std::vector<std::int64_t> _remote;
  std::vector<int> _owners;
  std::vector<std::int64_t> _columns;   ///< global nodes of the entries of all conditions
  std::vector<std::int32_t> _needed;    ///< nodes of a Halo
  std::vector<std::int32_t> _positions; ///< of `_columns` among the nodes of a Halo
  std::vector<std::size_t> _pointers;   ///< of each condition's entries, and the end
  std::vector<std::size_t> _dofs;       ///< number*gdim + c, of each entry
  std::vector<double> _values;          ///< entries of C [L^2]
  std::vector<double> _multipliers;     ///< of the last step, [i*gdim + d] [F/L^2]
  std::array<double, 3> _force{};
};
} // namespace dolfinx_impact::enforcement
