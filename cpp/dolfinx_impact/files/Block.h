// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include "Attribute.h"

/// How a tree is laid out in a file:
///
/// | field | of the tree itself | of a part |
/// |---|---|---|
/// | at all nodes | table nodes/FIELD | table nodes/FIELD with the digits at the end of the part's name |
/// | at some nodes, at facets | table some/FIELD, facets/FIELD | table some/PART, facets/PART: fields side by side |
/// | of cells | table cells/values/FIELD | table cells/values/FIELD |
/// | of ranks | table ranks/FIELD | table ranks/PART: fields one after the other |
/// | of none | attribute FIELD | attribute PART: fields one after the other |
///
/// Values are real numbers there; whole ones are checked when they are read. Parts at any depth have names of their
/// own.
namespace dolfinx_impact::files
{
/// Fields of a state that are one table, or one attribute, of a file. It views the state, which must stay.
class Block
{
public:
  Block(std::string name, state::Place place, const state::State& owner, std::vector<const state::Field*> fields);

  const std::string& name() const { return _name; }
  state::Place place() const { return _place; }
  /// Nodes or facets of the rows; null: all.
  const std::vector<std::int64_t>* numbers() const { return _owner->numbers(_place); }
  /// Whether the values are one vector, and not rows by place.
  bool flat() const { return _place == state::Place::rank || _place == state::Place::all; }
  /// Number of columns; of a vector its length.
  std::size_t width() const;
  /// The fields side by side, [row*width + column], or one after the other, as real numbers.
  std::vector<double> values() const;
  /// Set the fields to values in the order of `values`.
  /// @throws std::invalid_argument for another number of values, or a whole number that is none
  void assign(std::span<const double> values) const;
  /// Value of an attribute: a number where the tree has one.
  Value attribute() const;

private:
  std::size_t width(const state::Field& field) const { return flat() ? field.size() : field.columns; }

  std::string _name;
  state::Place _place;
  const state::State* _owner;
  std::vector<const state::Field*> _fields;
};

/// Tables and attributes of a state, which must stay.
std::vector<Block> blocks(const state::State& state);
} // namespace dolfinx_impact::files
