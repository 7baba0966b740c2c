// SPDX-License-Identifier: MIT
#pragma once
#include "InterfaceField.h"
#include "InterfaceHistory.h"
#include "InterfacePoints.h"
#include "PointKernel.h"
#include <limits>
#include <span>

namespace dolfinx_impact::enforcement
{
/// A law of the interface: pressure and shear traction of contact points from gap, slip, their rates, fields and
/// internal variables, by a kernel that forms/interface.py has made of UFL expressions; docs/interface_laws.md.
class InterfaceLaw
{
public:
  /// @param[in] kernel of a form of forms/interface.py
  /// @param[in] gdim dimension of space
  /// @param[in] constants by the kernel's names
  /// @param[in] fields that the law reads
  /// @param[in] tangential names of the internal variables that are vectors along the surface
  /// @param[in] reach largest gap at which the law is asked [L]
  /// @throws std::invalid_argument for a kernel of another kind or dimension, or a constant or field that is missing
  InterfaceLaw(const impact_kernel* kernel, int gdim, const std::vector<std::pair<std::string, double>>& constants,
               std::vector<InterfaceField> fields = {}, const std::vector<std::string>& tangential = {},
               double reach = std::numeric_limits<double>::infinity());

  int gdim() const { return _gdim; }
  double reach() const { return _reach; }
  const std::vector<InterfaceField>& fields() const { return _fields; }
  /// Does it read rates? Then it needs a time step.
  bool has_rates() const { return _has_rates; }
  /// Has it a shear traction that depends on the slip, its rate or tangential variables?
  bool has_shear() const { return _has_shear; }
  /// Does it tell its stored energy?
  bool has_energy() const { return _energy >= 0; }
  /// Change a constant.
  /// @throws std::invalid_argument if there is none of the name
  void set_constant(const std::string& name, double value) { _kernel.set_constant(name, value); }

  /// Internal variables of points, all zero.
  InterfaceHistory make_history(std::size_t num_points) const;
  /// Points without values.
  InterfacePoints make_points(std::size_t num_points) const;
  /// Evaluate the law. Within the largest number of points so far nothing is allocated.
  /// @param[in] points
  /// @param[in,out] history committed values of the points' rows are read, turned ones of tangential variables; updated
  /// ones are written
  /// @param[in,out] out values at the points
  void evaluate(const InterfacePoints& points, InterfaceHistory& history, InterfaceTractions& out) const;

private:
  /// What an array of the kernel is filled from.
  enum class Source
  {
    gap,
    slip,
    gap_rate,
    slip_rate,
    normal,
    slave_field,
    master_field,
    variable
  };
  struct Input
  {
    Source source;
    int number; ///< of the field or variable
    int size, offset;
  };
  struct Output
  {
    int number, size, offset; ///< number of the variable
  };
  Input input(const impact_coefficient& c) const;
  const double* values(const Input& input, const InterfacePoints& points, const InterfaceHistory& history) const;
  InterfaceDerivative& derivative(InterfaceTractions& out, std::size_t i) const;

  PointKernel _kernel;
  int _gdim;
  double _reach;
  std::vector<InterfaceField> _fields;
  InterfaceHistory _history; ///< variables without points
  std::vector<Input> _inputs;
  mutable std::vector<PointKernel::Input> _given;
  std::vector<Output> _variables;
  std::vector<std::pair<Input, int>> _derivatives;                                 ///< input, and offset of the output
  int _pressure = -1, _shear = -1, _energy = -1, _shear_energy = -1, _sticks = -1; ///< offsets of outputs
  bool _has_rates = false, _has_shear = false;
};
} // namespace dolfinx_impact::enforcement
