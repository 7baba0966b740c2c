// SPDX-License-Identifier: MIT
#include "checkpoint.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "material_state.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace dolfinx_impact::problems
{
namespace
{
std::size_t num_owned_cells(const dolfinx::fem::FunctionSpace<double>& V)
{
  const auto& topology = *V.mesh()->topology();
  return topology.index_map(topology.dim())->size_local();
}

std::string contact_part(std::size_t k)
{
  return "contact" + std::to_string(k);
}

/// Internal variables and contacts.
void add_bodies(State& out, const solve::EquilibriumProblem& equilibrium)
{
  out.add(material_state(equilibrium.body->histories(), num_owned_cells(equilibrium.space())));
  for (std::size_t k = 0; k < equilibrium.contacts.size(); ++k)
    out.add(std::move(equilibrium.contacts[k]->saved_state().rename(contact_part(k))));
}

/// Set displacement, internal variables and contacts. Collective.
void resume_bodies(const solve::EquilibriumProblem& equilibrium, std::span<const double> displacement,
                   const State& saved)
{
  const std::span<double> u = equilibrium.u->x()->mutable_array();
  std::ranges::copy(displacement, u.begin());
  equilibrium.u->x()->scatter_fwd();
  set_material(equilibrium.body->histories(), saved.part("material"));
  for (std::size_t k = 0; k < equilibrium.contacts.size(); ++k)
    equilibrium.contacts[k]->resume(saved.part(contact_part(k)), u);
}

/// Whether a load of a static problem is nodal forces; otherwise it is the same numbers on all ranks. Collective.
bool is_nodal(const solve::EquilibriumProblem& equilibrium, std::size_t size)
{
  const std::size_t owned = equilibrium.num_owned(), all = equilibrium.fixed.size();
  int nodal = size == owned || size == all;
  MPI_Allreduce(MPI_IN_PLACE, &nodal, 1, MPI_INT, MPI_MIN, equilibrium.space().mesh()->comm());
  return nodal != 0;
}

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
                               {"degree of the geometry", std::int64_t(mesh.geometry().cmap().degree())},
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
void check_numbers(const std::filesystem::path& path, const State& saved, bool infinite)
{
  for (const state::Field& field : saved.fields())
    if (field.place == Place::all)
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

State saved_state(StaticProblem& problem)
{
  const solve::EquilibriumProblem& equilibrium = *problem.equilibrium();
  const State now = problem.state();
  const std::size_t bs = equilibrium.space().dofmap()->index_map_bs();
  State out("static problem");
  for (const state::Field& field : now.fields())
  {
    const std::span<const double> values = std::get<std::span<double>>(field.values);
    if (field.place != Place::rank)
      out.add_own(field.name, field.place, std::vector<double>(values.begin(), values.end()), field.columns);
    else if (is_nodal(equilibrium, values.size()))
      out.add_own(field.name, Place::node,
                  std::vector<double>(values.begin(), values.begin() + std::ptrdiff_t(equilibrium.num_owned())), bs);
    else
      out.add_own(field.name, Place::all, std::vector<double>(values.begin(), values.end()));
  }
  add_bodies(out, equilibrium);
  return out;
}

void resume(StaticProblem& problem, const State& saved)
{
  State now = problem.state();
  for (const state::Field& field : now.fields()) // nodal loads may have ghosts, which are not read
    std::ranges::copy(saved.values<double>(field.name), std::get<std::span<double>>(field.values).begin());
  resume_bodies(*problem.equilibrium(), saved.values<double>("displacement"), saved);
  problem.resume();
  problem.forget();
}

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
}

// --- implicit problems ---

State saved_state(NewmarkProblem& problem)
{
  const State now = problem.state();
  State out(now.name());
  for (const state::Field& field : now.fields())
    out.add_copies(now, std::array{field.name});
  for (const char* name : {"motion", "account"})
    out.add(now.part(name).copy());
  add_bodies(out, problem.equilibrium());
  return out;
}

void resume(NewmarkProblem& problem, const State& saved)
{
  State now = problem.state();
  now.assign_common(saved);
  for (const char* name : {"motion", "account"})
    State(now.part(name)).assign(saved.part(name));
  resume_bodies(problem.equilibrium(), saved.part("motion").values<double>("displacement"), saved);
  problem.resume();
}

void save(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity)
{
  files::write(path, problem.equilibrium().space(), saved_state(problem), identity_of(problem, "implicit", identity));
}

void restore(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity)
{
  const files::Saved saved = files::read(path, problem.equilibrium().space(), saved_state(problem),
                                         identity_of(problem, "implicit", identity));
  check_numbers(path, saved.state, false);
  check_time(path, saved.state);
  resume(problem, saved.state);
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
