// SPDX-License-Identifier: MIT
#include "material_state.h"
#include <algorithm>
#include <map>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Call act(history, field) for each internal variable.
void for_variables(const Histories& histories, const auto& act)
{
  for (const auto& history : histories)
    for (std::size_t field = 0; field < history->num_fields(); ++field)
      if (history->is_history(field))
        act(*history, field);
}

/// Numbers of points and components of a row. Materials may have a variable at fewer points, or with fewer components.
struct Widths
{
  explicit Widths(const Histories& histories)
  {
    for (const auto& history : histories)
      points = std::max(points, std::size_t(history->num_points()));
    for_variables(histories,
                  [&](const operators::PointHistory& history, std::size_t field)
                  {
                    std::size_t& most = components[history.name(field)];
                    most = std::max(most, std::size_t(history.num_components(field)));
                  });
  }

  std::size_t points = 0;
  std::map<std::string, std::size_t> components; ///< by name
};
} // namespace

state::State material_state(const Histories& histories, std::size_t num_cells)
{
  const Widths widths(histories);
  std::map<std::string, std::vector<double>> rows;
  for (const auto& [name, components] : widths.components)
    rows[name].resize(num_cells * widths.points * components);
  std::vector<double> values;
  for_variables(histories,
                [&](const operators::PointHistory& history, std::size_t field)
                {
                  const std::size_t components = history.num_components(field);
                  const std::size_t stride = widths.components.at(history.name(field)), points = history.num_points();
                  values.resize(points * components);
                  for (std::size_t i = 0; i < history.cells().size(); ++i)
                  {
                    const std::size_t cell = history.cells()[i];
                    if (cell >= num_cells)
                      continue;
                    history.copy_cell(field, i, values.data());
                    double* row = rows.at(history.name(field)).data() + cell * widths.points * stride;
                    for (std::size_t q = 0; q < points; ++q)
                      std::copy_n(values.data() + q * components, components, row + q * stride);
                  }
                });
  state::State out("material");
  for (auto& [name, all] : rows)
    out.add_own(name, state::Place::cell, std::move(all), widths.points * widths.components.at(name));
  return out;
}

void set_material(const Histories& histories, const state::State& saved)
{
  const Widths widths(histories);
  for_variables(histories,
                [&](operators::PointHistory& history, std::size_t field)
                {
                  const std::size_t components = history.num_components(field);
                  const std::size_t stride = widths.components.at(history.name(field)), points = history.num_points();
                  const state::Field& f = saved.field(history.name(field));
                  const std::size_t width = widths.points * stride;
                  if (f.columns != width)
                    throw std::invalid_argument("the state has " + f.name + " at another number of points");
                  const std::span<const double> from = saved.values<double>(f.name);
                  std::vector<double> values(history.cells().size() * points * components);
                  for (std::size_t i = 0; i < history.cells().size(); ++i)
                    for (std::size_t q = 0; q < points; ++q)
                      std::ranges::copy(from.subspan(history.cells()[i] * width + q * stride, components),
                                        values.begin() + std::ptrdiff_t((i * points + q) * components));
                  history.set_values(field, values);
                });
}
} // namespace dolfinx_impact::problems
