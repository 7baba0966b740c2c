// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Contact points as a law of the interface sees them. Vectors: [q*gdim + c].
struct InterfacePoints
{
  int gdim = 3;
  std::vector<std::int32_t> row; ///< of each point in the internal variables
  std::vector<double> gap;       ///< [L]
  std::vector<double> slip;      ///< tangential displacement of slave against master [L]
  std::vector<double> gap_rate;  ///< [L/T]
  std::vector<double> slip_rate; ///< [L/T]
  std::vector<double> normal;    ///< unit, out of the master
  /// Values of the law's fields (InterfaceLaw::fields) on both sides, one array for each field.
  std::vector<std::vector<double>> slave_fields, master_fields;

  std::size_t size() const { return gap.size(); }
  /// Set the number of points; values are kept or zero. Within the largest number so far nothing is allocated.
  void resize(std::size_t num_points);
};

/// Derivative of pressure and shear traction by an input with `size` components: [(q*(1 + gdim) + i)*size + j], the
/// pressure first; empty where the law does not depend on the input.
struct InterfaceDerivative
{
  int size = 1;
  std::vector<double> values;
};

/// What a law returns at contact points. Vectors: [q*gdim + c].
struct InterfaceTractions
{
  std::vector<double> pressure;     ///< positive in compression [F/L^2]
  std::vector<double> shear;        ///< traction on the slave along the surface [F/L^2]
  std::vector<double> energy;       ///< stored per area; empty: the law does not know it [F/L]
  std::vector<double> shear_energy; ///< without `energy`, its part of the shear traction; empty: not known [F/L]
  std::vector<double> sticks;       ///< one or zero; empty: the law does not say
  InterfaceDerivative by_gap, by_slip, by_gap_rate, by_slip_rate, by_normal;
  std::vector<InterfaceDerivative> by_history; ///< of each internal variable; empty but for tangential ones
  std::int64_t num_unsolved = 0;               ///< points whose local equations were not solved
};
} // namespace dolfinx_impact::enforcement
