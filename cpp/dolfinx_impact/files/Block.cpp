// SPDX-License-Identifier: MIT
#include "Block.h"
#include <algorithm>
#include <limits>
#include <stdexcept>

using dolfinx_impact::state::Field;
using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace dolfinx_impact::files
{
namespace
{
template <typename T>
T whole_number(double value, const std::string& field, const std::string& block)
{
  typedef std::numeric_limits<T> Limits;
  // The upper limit of 64 bits is no real number: what is below the power of two fits.
  if (!(value >= double(Limits::min()) && value < double(Limits::max()) + 1.0) || value != double(T(value)))
    throw std::invalid_argument("the " + field + "s in " + block + " are no whole numbers");
  return T(value);
}

void add_blocks_of_parts(const State& state, std::vector<Block>& out)
{
  for (const State& part : state.parts())
  {
    const std::size_t last = part.name().find_last_not_of("0123456789");
    const std::string number = last == std::string::npos ? part.name() : part.name().substr(last + 1);
    for (Place place : {Place::node, Place::facet, Place::cell, Place::rank, Place::all})
    {
      std::vector<const Field*> fields;
      for (const Field& field : part.fields())
        if (field.place == place)
          fields.push_back(&field);
      const bool all_nodes = place == Place::node && part.numbers(place) == nullptr;
      if (place == Place::cell || all_nodes)
        for (const Field* field : fields)
          out.emplace_back(field->name + (all_nodes ? number : ""), place, part, std::vector{field});
      else if (!fields.empty())
        out.emplace_back(part.name(), place, part, fields);
    }
    add_blocks_of_parts(part, out);
  }
}
} // namespace

Block::Block(std::string name, Place place, const State& owner, std::vector<const Field*> fields)
    : _name(std::move(name)), _place(place), _owner(&owner), _fields(std::move(fields))
{
}

std::size_t Block::width() const
{
  std::size_t out = 0;
  for (const Field* field : _fields)
    out += width(*field);
  return out;
}

std::vector<double> Block::values() const
{
  const std::size_t columns = width(), rows = flat() ? 1 : _fields[0]->rows();
  std::vector<double> out(rows * columns);
  std::size_t first = 0;
  for (const Field* field : _fields)
  {
    const std::size_t w = width(*field);
    if (field->size() != rows * w)
      throw std::invalid_argument("state " + _owner->name() + ": " + field->name + " has other rows than " +
                                  _fields[0]->name);
    std::visit(
        [&](auto span)
        {
          for (std::size_t i = 0; i < rows; ++i)
            std::copy_n(span.begin() + std::ptrdiff_t(i * w), w, out.begin() + std::ptrdiff_t(i * columns + first));
        },
        field->values);
    first += w;
  }
  return out;
}

void Block::assign(std::span<const double> values) const
{
  const std::size_t columns = width(), rows = flat() ? 1 : _fields[0]->rows();
  if (values.size() != rows * columns)
    throw std::invalid_argument(_name + " has " + std::to_string(values.size()) + " values, needed are " +
                                std::to_string(rows * columns));
  std::size_t first = 0;
  for (const Field* field : _fields)
  {
    const std::size_t w = width(*field);
    std::visit(
        [&](auto span)
        {
          typedef typename decltype(span)::value_type T;
          for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t j = 0; j < w; ++j)
            {
              const double value = values[i * columns + first + j];
              if constexpr (std::is_floating_point_v<T>)
                span[i * w + j] = value;
              else
                span[i * w + j] = whole_number<T>(value, field->name, _name);
            }
        },
        field->values);
    first += w;
  }
}

Value Block::attribute() const
{
  if (_fields.size() == 1 && _fields[0]->size() == 1 && _fields[0]->name == _name)
    return std::visit(
        [](auto span) -> Value
        {
          if constexpr (std::is_floating_point_v<typename decltype(span)::value_type>)
            return span[0];
          else
            return std::int64_t(span[0]);
        },
        _fields[0]->values);
  std::vector<double> all = values();
  return Numbers{{all.size()}, all};
}

std::vector<Block> blocks(const State& state)
{
  std::vector<Block> out;
  for (const Field& field : state.fields())
    out.emplace_back(field.name, field.place, state, std::vector{&field});
  add_blocks_of_parts(state, out);
  return out;
}
} // namespace dolfinx_impact::files
