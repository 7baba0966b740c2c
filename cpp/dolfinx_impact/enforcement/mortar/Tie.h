// SPDX-License-Identifier: MIT
#pragma once
#include "../ContactTotals.h"
#include "../StaticContact.h"
#include "TieConditions.h"

namespace dolfinx_impact::enforcement
{
/// Two surfaces tied to each other in equilibrium or in a step of implicit dynamics, whose meshes need not match: a
/// mortar tie of the reference configuration with multipliers; docs/tie.md. All slave nodes that face the master are
/// tied always, in all directions or along the normal alone: there is no active set, and tractions may pull. The
/// conditions are linear and never change. With the dual basis multipliers are condensed. Multipliers are along the
/// directions of TieConditions, [i*gdim + d] [F/L^2].
class Tie : public MultiplierContact
{
public:
  /// Collective.
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  /// @throws std::invalid_argument as TieConditions
  Tie(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
      const TieOptions& options, std::vector<std::int8_t> fixed);

  const TieConditions& conditions() const { return _conditions; }
  /// See TieConditions::leave_out. Collective.
  void leave_out(std::span<const std::int8_t> taken);
  /// Set the multipliers, by direction [F/L^2].
  void assign(std::span<const double> multipliers);
  const ContactTotals& totals() const { return _totals; }
  ContactTotals& totals() { return _totals; }

  const std::string& name() const override { return _conditions.options().name; }
  void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                  std::span<const double> target) override;
  std::optional<std::array<double, 3>> displacement() const override { return std::nullopt; }
  state::State state() override;
  void accept_step() override;
  std::string passed_through() override { return ""; }

  void update_gap(std::span<const double> u) override;
  int update_active_set(bool first, std::optional<std::int64_t> last = {}) override;
  std::vector<double> contact_forces() const override { return _conditions.forces(_multipliers); }
  void add_residual(Vec b) const override;
  void update_nodal_stiffness(Mat K) override;
  Mat tangent() override { return nullptr; }
  bool has_friction() const override { return false; }
  std::int64_t num_active() const override;
  double violation() const override;
  std::string largest_violation() const override;
  double smallest_gap() const override { return 0.0; }
  state::State saved_state() override;
  void resume(const state::State& saved, std::span<const double> u) override;
  void forget() override {}
  std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const override
  {
    return _conditions.rigid_body_products(modes);
  }

  std::vector<double> points() const override;
  /// Distance in the reference configuration and what the conditions lack, along the normal [L].
  std::vector<double> gap() const override;
  std::vector<double> normal() const override { return _normal; }
  /// Negative where the tie pulls [F/L^2].
  std::vector<double> pressure() const override;
  std::vector<double> traction() const override { return _conditions.traction(_multipliers); }
  std::vector<double> slip() const override;
  std::vector<ContactStatus> status() const override;
  std::vector<double> weight() const override { return _conditions.area(); }
  std::vector<double> covered() const override { return std::vector<double>(_conditions.num_nodes(), 1.0); }
  std::optional<std::array<double, 3>> force() const override { return _totals.known_force(); }
  double dissipated() const override { return 0.0; }

  std::span<const std::int32_t> nodes() const override { return _conditions.nodes(); }
  std::span<const std::int64_t> numbers() const override { return _conditions.numbers(); }
  std::span<const std::int8_t> active() const override { return _active; }
  std::span<const std::int8_t> sliding() const override { return _sliding; }
  /// Normal tractions, see `pressure`.
  std::span<const double> multiplier() const override { return _pressure; }
  std::int64_t last_change() const override { return -1; }
  void update_multipliers(std::span<const double> residual) override;
  double gap_round_off() const override;
  Constraints constraints() override;
  std::optional<std::pair<Mat, std::vector<double>>> friction_springs() override { return std::nullopt; }
  std::vector<double> imposed_friction_forces() const override { return {}; }
  void update_linearised_gap(std::span<const double> increments) override;
  std::pair<std::vector<double>, std::vector<double>>
  linearised_response(std::span<const double> increments, std::span<const double> forces) const override;
  void correct_linearisation(std::span<const double>) override {} // the conditions are linear
  void set_multipliers(std::span<const double> forces) override;
  std::int64_t num_turning() const override { return 0; }
  void set_redundant(std::span<const std::int32_t>) override {}
  std::vector<std::int32_t> over_constrained() const override { return {}; }
  void rotate_friction_traction() override {}
  std::vector<double> unit_gap(std::int64_t number) const override;
  std::vector<double> unit_force(std::int64_t number) const override;
  std::span<const double> linearised_gap() const override { return _linearised; }
  void set_linearised(std::span<const std::int8_t>, std::span<const double>, std::span<const double>) override {}

private:
  std::vector<double> along_normal(std::span<const double> values) const;

  TieConditions _conditions;
  std::vector<double> _multipliers; ///< by direction
  std::vector<double> _u;           ///< owned and ghosts [L]
  std::vector<double> _jump;        ///< at u, by direction [L]
  std::vector<double> _target;      ///< prescribed displacements at the end of the increment; empty: as they are
  std::vector<double> _normal;      ///< in the present configuration
  std::vector<double> _pressure;    ///< along it
  std::vector<double> _linearised;  ///< jumps of the linearised problem along the normal [L]
  std::vector<double> _stiffness;   ///< of the bodies at the nodes [F/L]
  std::vector<std::int8_t> _active, _sliding, _fixed;
  ContactTotals _totals;
};
} // namespace dolfinx_impact::enforcement
