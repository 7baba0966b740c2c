// SPDX-License-Identifier: MIT
#pragma once
#include "InterfaceField.h"
#include "PointKernel.h"
#include <span>

namespace dolfinx_impact::enforcement
{
/// Contact points as a law of friction sees them. Vectors: [q*gdim + c].
struct FrictionPoints
{
  int gdim = 3;
  std::vector<double> pressure;  ///< positive in compression [F/L^2]
  std::vector<double> slip_rate; ///< tangential velocity of slave against master [L/T]
  std::vector<double> normal;    ///< unit, out of the master
  /// Values of the law's fields (FrictionLaw::fields) on both sides, one array for each field.
  std::vector<std::vector<double>> slave_fields, master_fields;

  std::size_t size() const { return pressure.size(); }
  /// Set the number of points; values are kept or zero. Within the largest number so far nothing is allocated.
  void resize(std::size_t num_points);
};

/// Coefficients of friction at points, and their derivatives; empty where the law does not depend on the input.
struct FrictionCoefficients
{
  std::vector<double> value;        ///< [1]
  std::vector<double> by_pressure;  ///< [L^2/F]
  std::vector<double> by_slip_rate; ///< [q*gdim + c] [T/L]
};

/// A law of friction: Coulomb's coefficient of contact points from pressure, slip velocity and fields, by a kernel that
/// forms/friction.py has made of a UFL expression; docs/interface_laws.md. A coefficient below zero counts as zero.
class FrictionLaw
{
public:
  /// @param[in] kernel of a form of forms/friction.py
  /// @param[in] gdim dimension of space
  /// @param[in] constants by the kernel's names
  /// @param[in] fields that the law reads
  /// @throws std::invalid_argument for a kernel of another kind or dimension, or a constant or field that is missing
  FrictionLaw(const impact_kernel* kernel, int gdim, const std::vector<std::pair<std::string, double>>& constants,
              std::vector<InterfaceField> fields = {});

  int gdim() const { return _gdim; }
  const std::vector<InterfaceField>& fields() const { return _fields; }
  /// Does it read the slip velocity? Then it needs a time step.
  bool has_rates() const { return _has_rates; }
  /// Does it read the pressure?
  bool has_pressure() const { return _by_pressure >= 0; }
  /// Change a constant.
  /// @throws std::invalid_argument if there is none of the name
  void set_constant(const std::string& name, double value) { _kernel.set_constant(name, value); }

  /// Points without values.
  FrictionPoints make_points(std::size_t num_points) const;
  /// Evaluate the law. Within the largest number of points so far nothing is allocated.
  /// @param[in,out] out values at the points
  void evaluate(const FrictionPoints& points, FrictionCoefficients& out) const;

private:
  enum class Source
  {
    pressure,
    slip_rate,
    normal,
    slave_field,
    master_field
  };
  struct Input
  {
    Source source;
    int number; ///< of the field
    int size, offset;
  };
  Input input(const impact_coefficient& c) const;
  const double* values(const Input& input, const FrictionPoints& points) const;

  PointKernel _kernel;
  int _gdim;
  std::vector<InterfaceField> _fields;
  std::vector<Input> _inputs;
  mutable std::vector<PointKernel::Input> _given;
  int _coefficient = -1, _by_pressure = -1, _by_slip_rate = -1; ///< offsets of outputs
  bool _has_rates = false;
};
} // namespace dolfinx_impact::enforcement
