// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/Halo.h"
#include "../interface/InterfaceField.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Present values of a law's fields at the nodes of a contact, on both sides.
class FieldsAtNodes
{
public:
  FieldsAtNodes() = default;
  explicit FieldsAtNodes(std::vector<InterfaceField> fields) : _fields(std::move(fields)), _values(_fields.size()) {}

  std::size_t size() const { return _fields.size(); }
  /// Take the nodes of a search.
  /// @param[in] numbers in the Halo, of the nodes of the space
  /// @param[in] num_owned owned nodes of the space
  void assign_numbers(const operators::Halo& halo, std::span<const std::int32_t> numbers, std::size_t num_owned);
  /// Update the values. Collective where there are fields.
  void gather(operators::Halo& halo);
  /// Value of a field at a node, by its number.
  double at(std::size_t field, std::int32_t node) const { return _values[field][node]; }
  /// Value of a field at a projection on the master; zero on a rigid one.
  /// @param[in] num nodes of the master's facet
  double at(std::size_t field, int num, const std::int32_t* masters, const double* phi) const;

private:
  std::vector<InterfaceField> _fields;
  std::vector<std::vector<double>> _values; ///< of each field, by number in the Halo
  std::vector<std::int32_t> _owned_numbers; ///< in the Halo, of the owned nodes of the space
};
} // namespace dolfinx_impact::enforcement
