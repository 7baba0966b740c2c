// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// State as data: named arrays that belong to nodes, facets, cells or ranks. Saving, restoring, copying and handing
/// over are operations on them, written once; who acts on a state only describes it.
namespace dolfinx_impact::state
{
/// What the rows of an array belong to.
enum class Place
{
  node,  ///< owned nodes of the displacement space: all, or those that the state names
  facet, ///< facets of a surface on this rank, which the state names
  cell,  ///< owned cells of the mesh
  rank,  ///< this rank: sums over ranks are meant
  all    ///< no place: the same on all ranks
};

std::string to_string(Place place);

/// Values of a field: memory of the object that has the state.
typedef std::variant<std::span<double>, std::span<std::int8_t>, std::span<std::int32_t>, std::span<std::int64_t>> View;

/// A named array. Row i has the entries [i*columns, (i + 1)*columns).
struct Field
{
  std::string name;
  Place place = Place::all;
  std::size_t columns = 1;
  View values;

  /// Number of entries.
  std::size_t size() const;
  /// Number of rows.
  std::size_t rows() const { return columns == 0 ? 0 : size() / columns; }
};

/// A tree of named arrays. The arrays are views of an object's memory, valid as long as the object is and keeps their
/// sizes; those of a copy are the copy's own.
class State
{
public:
  explicit State(std::string name = "") : _name(std::move(name)) {}

  const std::string& name() const { return _name; }
  const std::vector<Field>& fields() const { return _fields; }
  const std::vector<State>& parts() const { return _parts; }

  /// Add a field.
  /// @throws std::invalid_argument for a name that is taken, or a number of entries that is no multiple of `columns`
  State& add(std::string name, Place place, View values, std::size_t columns = 1);
  /// Add a field with rows at this state's places.
  template <typename T>
  State& add(std::string name, Place place, std::vector<T>& values, std::size_t columns = 1)
  {
    return add(std::move(name), place, View(std::span<T>(values)), columns);
  }
  /// Add a number.
  template <typename T>
  State& add(std::string name, Place place, T& value)
  {
    return add(std::move(name), place, View(std::span<T>(&value, 1)), 1);
  }
  /// Add a field with values of its own.
  template <typename T>
  State& add_own(std::string name, Place place, std::vector<T> values, std::size_t columns = 1)
  {
    auto memory = std::make_shared<std::vector<T>>(std::move(values));
    add(std::move(name), place, *memory, columns);
    keep(std::move(memory));
    return *this;
  }
  /// Add fields of another state with values of their own, in the order of the names.
  /// @throws std::out_of_range for a name that is none
  State& add_copies(const State& other, std::span<const std::string> names);
  /// Add the state of a part.
  /// @throws std::invalid_argument for a name that is taken
  State& add(State part);
  /// Say which nodes or facets the rows of this state's fields at a place belong to; without, to all of them.
  /// @param[in] numbers of nodes on this rank, or of facets, which do not depend on the ranks
  State& at(Place place, std::vector<std::int64_t> numbers);
  State& rename(std::string name);
  /// Keep an object alive that has the memory of fields.
  void keep(std::shared_ptr<const void> owner) { _owners.push_back(std::move(owner)); }

  /// @throws std::out_of_range naming what there is
  const Field& field(const std::string& name) const;
  /// @throws std::out_of_range naming what there is
  const State& part(const std::string& name) const;

  /// Which nodes or facets the rows at a place belong to; null: all of them.
  const std::vector<std::int64_t>* numbers(Place place) const;
  /// Values of a field of this state.
  /// @throws std::out_of_range naming what there is
  /// @throws std::bad_variant_access for another type
  template <typename T>
  std::span<T> values(const std::string& name) const
  {
    return std::get<std::span<T>>(field(name).values);
  }

  /// A state of the same places with some fields of this one, see add_copies.
  State copy_of(std::span<const std::string> names) const;
  /// The same tree with values of its own.
  State copy() const;
  /// Set the values of this tree to those of another one with the same fields and parts. Nothing is changed if they
  /// differ.
  /// @throws std::invalid_argument naming the first field that differs in name, place, type or size
  void assign(const State& other);
  /// Set the fields of this state that another one has, too, whatever else either has; parts stay.
  /// @throws std::invalid_argument for a field that differs in place, type or size; nothing is changed then
  void assign_common(const State& other);
  /// First field in which another tree differs in name, place, type or size, or in its nodes or facets, in words; empty
  /// if none does.
  std::string difference_of_structure(const State& other) const;
  /// First field whose values differ, by its path; empty if all are equal bit for bit.
  /// @throws std::invalid_argument if the structures differ
  std::string difference_of_values(const State& other) const;

private:
  void assign_values(const State& other);

  void add_copy(const Field& field);

  std::string _name;
  std::vector<std::pair<Place, std::vector<std::int64_t>>> _numbers;
  std::vector<Field> _fields;
  std::vector<State> _parts;
  std::vector<std::shared_ptr<const void>> _owners;
};
} // namespace dolfinx_impact::state
