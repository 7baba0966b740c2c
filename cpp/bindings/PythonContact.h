// SPDX-License-Identifier: MIT
#pragma once
#include "arrays.h"
#include "dolfinx_impact/enforcement/StaticContact.h"

namespace dolfinx_impact::bindings
{
/// A static contact that is a Python object with the members of contact/protocol.py, as Newton's method in C++ sees it.
/// The object knows its problem, whose C++ part has this, and which keeps it alive: here is a weak reference only, as
/// Python could not free a ring through C++.
class PythonContact : public enforcement::MultiplierContact
{
public:
  explicit PythonContact(const nb::object& contact);

  const std::string& name() const override { return _name; }
  bool has_multipliers() const override { return _has_multipliers; }
  enforcement::MortarContact* mortar() override;
  bool has_friction() const override { return _has_friction; }
  std::string fault() const override;
  std::optional<std::array<double, 3>> displacement() const override;
  void check_parameters() override;
  void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                  std::span<const double> target) override;
  state::State state() override;
  void accept_step() override;
  bool augment() override;
  std::string prescribed_overlap() override;
  std::string passed_through() override;
  void update_gap(std::span<const double> u) override;
  int update_active_set(bool first, std::optional<std::int64_t> last) override;
  std::vector<double> contact_forces() const override;
  void add_residual(Vec b) const override;
  void update_nodal_stiffness(Mat K) override;
  Mat tangent() override;
  void set_convex(bool convex) override;
  bool symmetric() const override;
  std::int64_t num_active() const override;
  double violation() const override;
  double round_off() const override;
  std::string largest_violation() const override;
  std::string mesh_advice() const override;
  double smallest_gap() const override;
  state::State saved_state() override;
  void resume(const state::State& saved, std::span<const double> u) override;
  void forget() override;
  std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const override;
  bool close_nearest() override;
  std::vector<double> closing_forces() const override;
  std::vector<double> points() const override { return numbers_of("points"); }
  std::vector<double> gap() const override { return numbers_of("gap"); }
  std::vector<double> normal() const override { return numbers_of("normal"); }
  std::vector<double> pressure() const override { return numbers_of("pressure"); }
  std::vector<double> traction() const override { return numbers_of("traction"); }
  std::vector<double> slip() const override { return numbers_of("slip"); }
  std::vector<enforcement::ContactStatus> status() const override;
  std::vector<double> weight() const override { return numbers_of("weight"); }
  std::vector<double> covered() const override;
  std::optional<std::array<double, 3>> force() const override;
  double dissipated() const override;
  double stored_energy() const override;

  std::span<const std::int32_t> nodes() const override;
  std::span<const std::int64_t> numbers() const override;
  std::span<const std::int8_t> active() const override;
  std::span<const std::int8_t> sliding() const override;
  std::span<const double> multiplier() const override;
  std::int64_t last_change() const override;
  void update_multipliers(std::span<const double> residual) override;
  double gap_round_off() const override;
  enforcement::Constraints constraints() override;
  std::optional<std::pair<Mat, std::vector<double>>> friction_springs() override;
  std::vector<double> imposed_friction_forces() const override;
  void update_linearised_gap(std::span<const double> increments) override;
  std::pair<std::vector<double>, std::vector<double>>
  linearised_response(std::span<const double> increments, std::span<const double> forces) const override;
  void correct_linearisation(std::span<const double> u) override;
  void set_multipliers(std::span<const double> forces) override;
  std::int64_t num_turning() const override;
  void set_redundant(std::span<const std::int32_t> redundant) override;
  std::vector<std::int32_t> over_constrained() const override;
  void rotate_friction_traction() override;
  std::vector<double> unit_gap(std::int64_t number) const override;
  std::vector<double> unit_force(std::int64_t number) const override;
  std::span<const double> linearised_gap() const override;
  void set_linearised(std::span<const std::int8_t> active, std::span<const double> gap,
                      std::span<const double> multiplier) override;

private:
  std::vector<double> numbers_of(const char* attribute) const;

  /// @throws std::runtime_error if the problem is gone
  nb::object contact() const;

  nb::weakref _contact;
  std::string _name;
  bool _has_multipliers, _has_friction;
  nb::object _kept; ///< a matrix that is borrowed
  // What spans are views of, as Python told it last.
  mutable std::vector<std::int32_t> _nodes;
  mutable std::vector<std::int64_t> _numbers;
  mutable std::vector<std::int8_t> _active, _sliding;
  mutable std::vector<double> _multiplier, _linearised_gap;
};
} // namespace dolfinx_impact::bindings
