// SPDX-License-Identifier: MIT
#include "saved_history.h"
#include <algorithm>
#include <map>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
/// Components of every variable, and points of the cells, of the materials that have the most.
struct Layout
{
  int num_points = 0;
  std::map<std::string, int> components;
  std::vector<std::string> names; ///< in the order in which they come first
};

Layout layout(const Histories& histories)
{
  Layout out;
  for (const auto& history : histories)
  {
    out.num_points = std::max(out.num_points, history->num_points());
    for (std::size_t f = 0; f < history->num_fields(); ++f)
    {
      if (!history->is_history(f))
        continue;
      int& components = out.components[history->name(f)];
      if (components == 0)
        out.names.push_back(history->name(f));
      components = std::max(components, history->num_components(f));
    }
  }
  return out;
}

/// Calls act(entry of a row of all cells, entry of the values of a history) for the entries of one variable.
void each_entry(const PointHistory& history, std::size_t field, int num_points, int components, const auto& act)
{
  std::size_t own = 0;
  for (std::int32_t cell : history.cells())
    for (int q = 0; q < history.num_points(); ++q)
      for (int c = 0; c < history.num_components(field); ++c)
        act((std::size_t(cell) * num_points + q) * components + c, own++);
}
} // namespace

state::State saved_history(const Histories& histories, std::size_t num_cells)
{
  state::State out("material");
  const Layout all = layout(histories);
  for (const std::string& name : all.names)
  {
    const int components = all.components.at(name);
    const std::size_t columns = std::size_t(all.num_points) * components;
    std::vector<double> rows(num_cells * columns, 0.0);
    for (const auto& history : histories)
      for (std::size_t f = 0; f < history->num_fields(); ++f)
        if (history->name(f) == name && history->is_history(f))
        {
          const std::vector<double> values = history->values(f);
          each_entry(*history, f, all.num_points, components,
                     [&](std::size_t row, std::size_t own) { rows[row] = values[own]; });
        }
    out.add_own(name, state::Place::cell, std::move(rows), columns);
  }
  return out;
}

void resume_history(const Histories& histories, const state::State& saved)
{
  const Layout all = layout(histories);
  for (const std::string& name : all.names)
    if (saved.field(name).columns != std::size_t(all.num_points) * all.components.at(name))
      throw std::invalid_argument("'" + name + "' has " + std::to_string(all.num_points) + " points of " +
                                  std::to_string(all.components.at(name)) + " components in a cell here, found " +
                                  std::to_string(saved.field(name).columns) + " values");
  for (const auto& history : histories)
    for (std::size_t f = 0; f < history->num_fields(); ++f)
    {
      if (!history->is_history(f))
        continue;
      const auto rows = saved.values<double>(history->name(f));
      std::vector<double> values(history->cells().size() * history->num_points() * history->num_components(f));
      each_entry(*history, f, all.num_points, all.components.at(history->name(f)),
                 [&](std::size_t row, std::size_t own) { values[own] = rows[row]; });
      history->set_values(f, values);
    }
}
} // namespace dolfinx_impact::operators
