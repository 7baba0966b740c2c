// SPDX-License-Identifier: MIT
#include "State.h"
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace dolfinx_impact::state
{
namespace
{
template <typename Things>
std::string names_of(const Things& things, std::string (*name)(const typename Things::value_type&))
{
  std::string out;
  for (const auto& thing : things)
    out += (out.empty() ? "" : ", ") + name(thing);
  return out.empty() ? "none" : out;
}

std::span<const std::byte> bytes(const View& values)
{
  return std::visit([](auto span) { return std::as_bytes(span); }, values);
}

const char* type_name(const View& values)
{
  static constexpr const char* names[] = {"float64", "int8", "int32", "int64"};
  return names[values.index()];
}

/// All by which two fields may differ but their values.
std::string description(const Field& f)
{
  return f.name + " (" + to_string(f.place) + ", " + type_name(f.values) + ", " + std::to_string(f.rows()) + " x " +
         std::to_string(f.columns) + ")";
}

void assign_field(const Field& to, const Field& from)
{
  std::visit(
      [&](auto values)
      {
        const auto others = std::get<decltype(values)>(from.values);
        std::copy(others.begin(), others.end(), values.begin());
      },
      to.values);
}
} // namespace

std::string to_string(Place place)
{
  switch (place)
  {
  case Place::node:
    return "node";
  case Place::facet:
    return "facet";
  case Place::cell:
    return "cell";
  case Place::rank:
    return "rank";
  case Place::all:
    return "all";
  }
  throw std::invalid_argument("state: a place that is none");
}

std::size_t Field::size() const
{
  return std::visit([](auto span) { return span.size(); }, values);
}

State& State::add(std::string name, Place place, View values, std::size_t columns)
{
  Field field{std::move(name), place, columns, values};
  if (std::ranges::any_of(_fields, [&](const Field& f) { return f.name == field.name; }))
    throw std::invalid_argument("state " + _name + ": the field " + field.name + " exists");
  if (columns == 0 || field.size() % columns != 0)
    throw std::invalid_argument("state " + _name + ": " + field.name + " has " + std::to_string(field.size()) +
                                " entries, which are no rows of " + std::to_string(columns));
  _fields.push_back(std::move(field));
  return *this;
}

State& State::add(State part)
{
  if (std::ranges::any_of(_parts, [&](const State& p) { return p._name == part._name; }))
    throw std::invalid_argument("state " + _name + ": the part " + part._name + " exists");
  _parts.push_back(std::move(part));
  return *this;
}

State& State::at(Place place, std::vector<std::int64_t> numbers)
{
  std::erase_if(_numbers, [place](const auto& known) { return known.first == place; });
  _numbers.emplace_back(place, std::move(numbers));
  return *this;
}

State& State::rename(std::string name)
{
  _name = std::move(name);
  return *this;
}

const std::vector<std::int64_t>* State::numbers(Place place) const
{
  for (const auto& [known, numbers] : _numbers)
    if (known == place)
      return &numbers;
  return nullptr;
}

const Field& State::field(const std::string& name) const
{
  const auto at = std::ranges::find(_fields, name, &Field::name);
  if (at == _fields.end())
    throw std::out_of_range("state " + _name + " has no field " + name + ", but " +
                            names_of(_fields, +[](const Field& f) { return f.name; }));
  return *at;
}

const State& State::part(const std::string& name) const
{
  const auto at = std::ranges::find(_parts, name, &State::_name);
  if (at == _parts.end())
    throw std::out_of_range("state " + _name + " has no part " + name + ", but " +
                            names_of(_parts, +[](const State& p) { return p._name; }));
  return *at;
}

void State::add_copy(const Field& field)
{
  std::visit(
      [&](auto span)
      {
        typedef typename decltype(span)::value_type T;
        add_own(field.name, field.place, std::vector<T>(span.begin(), span.end()), field.columns);
      },
      field.values);
}

State State::copy_of(std::span<const std::string> names) const
{
  State out(_name);
  out._numbers = _numbers;
  return out.add_copies(*this, names);
}

State& State::add_copies(const State& other, std::span<const std::string> names)
{
  for (const std::string& name : names)
    add_copy(other.field(name));
  return *this;
}

State State::copy() const
{
  State out(_name);
  out._numbers = _numbers;
  for (const Field& field : _fields)
    out.add_copy(field);
  for (const State& part : _parts)
    out._parts.push_back(part.copy());
  return out;
}

std::string State::difference_of_structure(const State& other) const
{
  if (_fields.size() != other._fields.size() || _parts.size() != other._parts.size())
    return "state " + _name + " has " + std::to_string(_fields.size()) + " fields and " +
           std::to_string(_parts.size()) + " parts, the other one " + std::to_string(other._fields.size()) + " and " +
           std::to_string(other._parts.size());
  for (std::size_t i = 0; i < _fields.size(); ++i)
  {
    const Field &a = _fields[i], &b = other._fields[i];
    if (description(a) != description(b))
      return "state " + _name + " has the field " + description(a) + ", the other one " + description(b);
  }
  if (_numbers != other._numbers)
    return "state " + _name + " has rows of other nodes or facets than the other one";
  for (std::size_t i = 0; i < _parts.size(); ++i)
  {
    if (_parts[i]._name != other._parts[i]._name)
      return "state " + _name + " has the part " + _parts[i]._name + ", the other one " + other._parts[i]._name;
    if (std::string found = _parts[i].difference_of_structure(other._parts[i]); !found.empty())
      return found;
  }
  return "";
}

std::string State::difference_of_values(const State& other) const
{
  if (const std::string found = difference_of_structure(other); !found.empty())
    throw std::invalid_argument(found);
  for (std::size_t i = 0; i < _fields.size(); ++i)
    if (!std::ranges::equal(bytes(_fields[i].values), bytes(other._fields[i].values)))
      return _fields[i].name;
  for (std::size_t i = 0; i < _parts.size(); ++i)
    if (const std::string found = _parts[i].difference_of_values(other._parts[i]); !found.empty())
      return _parts[i]._name + "/" + found;
  return "";
}

void State::assign(const State& other)
{
  if (const std::string found = difference_of_structure(other); !found.empty())
    throw std::invalid_argument(found);
  assign_values(other);
}

void State::assign_common(const State& other)
{
  std::vector<std::pair<const Field*, const Field*>> common;
  for (const Field& mine : _fields)
    if (const auto at = std::ranges::find(other._fields, mine.name, &Field::name); at != other._fields.end())
    {
      if (description(mine) != description(*at))
        throw std::invalid_argument("state " + _name + " has the field " + description(mine) + ", the other one " +
                                    description(*at));
      common.emplace_back(&mine, &*at);
    }
  for (const auto& [to, from] : common)
    assign_field(*to, *from);
}

void State::assign_values(const State& other)
{
  for (std::size_t i = 0; i < _fields.size(); ++i)
    assign_field(_fields[i], other._fields[i]);
  for (std::size_t i = 0; i < _parts.size(); ++i)
    _parts[i].assign_values(other._parts[i]);
}
} // namespace dolfinx_impact::state
