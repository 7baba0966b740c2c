// SPDX-License-Identifier: MIT
#include "checkpoint.h"
#include "../common/OnAllRanks.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace dolfinx_impact::problems
{
namespace
{
/// Mask of prescribed components at the nodes that have some.
State supports_of(const dolfinx::fem::FunctionSpace<double>& V, std::span<const std::int8_t> mask)
{
  const std::size_t bs = V.dofmap()->index_map_bs(), num = V.dofmap()->index_map->size_local();
  std::vector<std::int64_t> nodes;
  std::vector<std::int8_t> rows;
  for (std::size_t node = 0; node < num; ++node)
  {
    const auto row = mask.subspan(node * bs, bs);
    if (std::ranges::none_of(row, [](std::int8_t fixed) { return fixed != 0; }))
      continue;
    nodes.push_back(std::int64_t(node));
    for (std::int8_t fixed : row)
      rows.push_back(fixed != 0);
  }
  State part("supports"), out("identity");
  part.at(Place::node, std::move(nodes));
  part.add_own("fixed", Place::node, std::move(rows), bs);
  out.add(std::move(part));
  return out;
}

files::Identity identity_of(const std::string& kind, const dolfinx::fem::FunctionSpace<double>& V,
                            std::span<const std::int8_t> mask, const files::Attributes& more)
{
  const auto& mesh = *V.mesh();
  files::Attributes attributes{{"problem", kind},
                               {"cell", dolfinx::mesh::to_string(mesh.topology()->cell_type())},
                               {"degree of the geometry", std::int64_t(common::coordinate_element(mesh).degree())},
                               {"components", std::int64_t(V.dofmap()->index_map_bs())}};
  attributes.insert(attributes.end(), more.begin(), more.end());
  return {std::move(attributes), supports_of(V, mask)};
}

files::Identity identity_of(const StaticProblem& problem, const files::Attributes& more)
{
  const auto& equilibrium = *problem.equilibrium();
  return identity_of("static", equilibrium.space(), equilibrium.fixed, more);
}

files::Identity identity_of(const TransientProblem& problem, const std::string& kind, const files::Attributes& more)
{
  return identity_of(kind, *problem.displacement()->function_space(), problem.supports().mask(), more);
}

/// Refuse numbers that no run has. All ranks have read the same ones.
/// @param[in] infinite whether infinite ones may be there
void check_numbers(const std::filesystem::path& path, const State& saved, bool infinite)
{
  for (const state::Field& field : saved.fields())
    if (field.place == Place::all &&
        !field.name.starts_with("step ")) // lengths of steps: no number where there is none
      if (const auto* values = std::get_if<std::span<double>>(&field.values))
        for (double value : *values)
          if (std::isnan(value) || (!infinite && std::isinf(value)))
            throw common::BadValue(path.string() + " is of no run: " + field.name + " is no number");
  for (const State& part : saved.parts())
    check_numbers(path, part, infinite);
}

void check_time(const std::filesystem::path& path, const State& saved)
{
  const double time = saved.values<double>("time")[0];
  const std::int64_t step = saved.values<std::int64_t>("step")[0];
  if (!(time >= 0.0 && std::isfinite(time)) || step < 0 || (step > 0) != (time > 0.0))
    throw common::BadValue(path.string() + " is of no run: its time is " + std::to_string(time) + ", its step " +
                           std::to_string(step));
}

const files::ReadOptions explicit_options{{"schedule"}, {"common"}, {"common"}};
} // namespace

// --- static problems ---

void save(const std::filesystem::path& path, StaticProblem& problem, const files::Attributes& identity)
{
  files::write(path, problem.equilibrium()->space(), saved_state(problem), identity_of(problem, identity));
  problem.forget(); // a problem that is restored has nothing of it, and goes on alike
}

void restore(const std::filesystem::path& path, StaticProblem& problem, const files::Attributes& identity)
{
  const files::Saved saved =
      files::read(path, problem.equilibrium()->space(), saved_state(problem), identity_of(problem, identity));
  check_numbers(path, saved.state, false);
  resume(problem, saved.state);
  problem.forget();
}

// --- implicit problems ---

void save(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity)
{
  files::write(path, problem.equilibrium()->space(), saved_state(problem), identity_of(problem, "implicit", identity));
  problem.forget();
}

void restore(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity)
{
  const files::Saved saved = files::read(path, problem.equilibrium()->space(), saved_state(problem),
                                         identity_of(problem, "implicit", identity));
  check_numbers(path, saved.state, false);
  check_time(path, saved.state);
  resume(problem, saved.state);
  problem.forget();
}

// --- explicit problems ---

void save(const std::filesystem::path& path, ExplicitProblem& problem, const files::Attributes& identity)
{
  std::vector<double> steps;
  if (const auto& schedule = problem.stepper().schedule())
    steps = {schedule->begin, schedule->until, double(schedule->first), double(schedule->last),
             double(schedule->automatic)};
  files::write(path, *problem.displacement()->function_space(), saved_state(problem),
               identity_of(problem, "explicit", identity), {{"schedule", files::Numbers{{steps.size()}, steps}}});
}

void restore(const std::filesystem::path& path, ExplicitProblem& problem, const files::Attributes& identity)
{
  const files::Saved saved = files::read(path, *problem.displacement()->function_space(), empty_state(problem),
                                         identity_of(problem, "explicit", identity), explicit_options);
  check_numbers(path, saved.state, true);
  check_time(path, saved.state);
  const auto found = std::ranges::find(saved.attributes, "schedule", &files::Attribute::name);
  const auto* steps = std::get_if<files::Numbers>(&found->value);
  if (!steps || (!steps->values.empty() && steps->values.size() != 5))
    throw common::BadValue(path.string() + " is of no run: schedule is " + files::to_string(found->value));
  std::optional<integrators::StepSchedule> schedule;
  if (const std::vector<double>& s = steps->values; !s.empty())
  {
    schedule = {s[0], s[1], std::int64_t(s[2]), std::int64_t(s[3]), s[4] != 0.0};
    const std::int64_t step = saved.state.values<std::int64_t>("step")[0];
    if (!(s[0] >= 0.0 && s[0] < s[1]) || !(0.0 <= s[2] && s[2] < s[3]) || step < s[2] || step > s[3])
      throw common::BadValue(path.string() + " is of no run: schedule is " + files::to_string(found->value));
  }
  resume(problem, saved.state, schedule);
}
} // namespace dolfinx_impact::problems
