// SPDX-License-Identifier: MIT
#include "failed_run.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/text.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::problems
{
using common::text;

namespace
{
/// Part of the stable step within which a step counts as that long.
constexpr double round_off = 1e-12;

/// A text of one rank, on all.
std::string from_rank(MPI_Comm comm, int root, std::string here)
{
  int size = int(here.size());
  MPI_Bcast(&size, 1, MPI_INT, root, comm);
  here.resize(size);
  MPI_Bcast(here.data(), size, MPI_CHAR, root, comm);
  return here;
}
} // namespace

std::string describe_node(const dolfinx::fem::FunctionSpace<double>& V, std::int32_t node)
{
  const auto& mesh = *V.mesh();
  const auto& topology = *mesh.topology();
  const auto cells = topology.index_map(topology.dim());
  const std::int32_t num = cells->size_local() + cells->num_ghosts();
  std::int32_t cell = 0;
  for (std::int32_t k = 0; k < num; ++k)
    if (const auto dofs = V.dofmap()->cell_dofs(k); std::ranges::find(dofs, node) != dofs.end())
    {
      cell = k;
      break;
    }
  const std::vector<double> all = V.tabulate_dof_coordinates(false);
  const double* x = all.data() + 3 * std::size_t(node);
  std::int64_t number = 0;
  if (!topology.original_cell_index.empty() && !topology.original_cell_index.front().empty())
    number = topology.original_cell_index.front()[cell];
  else // a submesh has no input
    cells->local_to_global(std::span(&cell, 1), std::span(&number, 1));
  std::string out = "cell " + std::to_string(number) + " (number in the mesh's input) at " +
                    common::place({x, std::size_t(mesh.geometry().dim())});
  const auto dofmap = common::geometry_dofmap(mesh);
  double lowest[3], highest[3], nearest = std::numeric_limits<double>::infinity(), size = 0.0;
  std::fill_n(lowest, 3, nearest);
  std::fill_n(highest, 3, -nearest);
  std::int32_t vertex = 0;
  for (std::size_t i = 0; i < dofmap.extent(1); ++i)
  {
    const double* y = mesh.geometry().x().data() + 3 * dofmap(cell, i);
    for (int c = 0; c < 3; ++c)
    {
      lowest[c] = std::min(lowest[c], y[c]);
      highest[c] = std::max(highest[c], y[c]);
    }
    if (const double distance = std::hypot(y[0] - x[0], y[1] - x[1], y[2] - x[2]); distance < nearest)
    {
      nearest = distance;
      vertex = dofmap(cell, i);
    }
  }
  for (int c = 0; c < 3; ++c)
    size = std::max(size, highest[c] - lowest[c]);
  if (nearest < 1e-9 * size)
    out = "node " + std::to_string(mesh.geometry().input_global_indices()[vertex]) + " of " + out;
  return out;
}

std::string gain_message(double gain)
{
  return "it has gained energy without the work of loads or supports: " + text("%.3g", 100.0 * gain) +
         " % of the energies so far. Contact or the steps bring it in: take a smaller step, damping or bulk viscosity, "
         "or check that bodies do not pass through each other; energy_limits=... of advance changes the limits.";
}

std::string released_message(double released, double limit, const std::string& go_on)
{
  return "the residual has given the body an energy of " + text("%.3g", released) +
         ", and it moves ever faster; strained by " + text("%.0f", 100.0 * start_strain) +
         " % in all cells it would store " + text("%.3g", limit) +
         ". Does a term of the residual have the wrong sign? Loads that are part of it belong into loads=. " + go_on;
}

FailedRun::FailedRun(const integrators::CentralDifference& integrator, const dolfinx::fem::FunctionSpace<double>& V,
                     std::span<const std::string> contacts, std::string unsolved, double time, double step,
                     double stable_step)
    : _unsolved(std::move(unsolved)), _time(time), _step(step), _stable_step(stable_step), _gain(integrator.gain().now),
      _gain_limit(integrator.gain_limit()), _released(integrator.released()), _release_limit(integrator.release_limit())
{
  const MPI_Comm comm = V.mesh()->comm();
  if (!(_released > _release_limit))
    _released = 0.0;
  const auto [contact, passage] = integrator.passage();
  std::int32_t node = passage.node;
  // In a run with steps beyond the stable step, passing nodes are an effect of the instability, not its cause.
  _passed = step <= stable_step * (1.0 + round_off) ? common::largest(comm, passage.facets) : 0.0;
  double worst = passage.facets;
  if (!(_passed > 0.0))
  {
    const auto [dof, speed] = integrator.fastest();
    node = dof / V.dofmap()->index_map_bs();
    worst = dof < 0 ? -1.0 : std::isnan(speed) ? std::numeric_limits<double>::infinity() : speed;
  }
  struct
  {
    double value;
    int rank;
  } here{worst, 0}, found{};
  MPI_Comm_rank(comm, &here.rank);
  MPI_Allreduce(&here, &found, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
  const bool mine = here.rank == found.rank;
  _place = from_rank(comm, found.rank, mine && node >= 0 ? describe_node(V, node) : "");
  _contact = from_rank(comm, found.rank, mine && contact >= 0 ? contacts[contact] : "");
  _pressed = !from_rank(comm, found.rank, mine && passage.pressed ? "yes" : "").empty();
}

std::string FailedRun::message_of(const std::string& fault, double back_at) const
{
  return fault + ", at the time " + text("%.6g", _time) + "; the problem is back at the time " + text("%.6g", back_at) +
         ". Take a smaller step, or check the law";
}

std::string FailedRun::message(double back_at, double stable_step) const
{
  const std::string back = "the problem is back at the time " + text("%.6g", back_at);
  if (_passed > 0.0 && _pressed)
    return _contact + ": a node was pressed through the surface that held it back, at the time " + text("%.6g", _time) +
           ": " + _place + ". It is deeper than the cell behind the surface is high, by the factor " +
           text("%.3g", _passed) + "; " + back + ". Take finer cells, whose springs are stiffer, or smaller forces";
  if (_passed > 0.0)
    return _contact + ": a slave node went through the master at the time " + text("%.6g", _time) + ": " + _place +
           ". Contact holds back nodes that come through the surface by up to one facet in a step, this one came by " +
           text("%.3g", _passed) + "; " + back + ". Take steps below " + text("%.3g", 0.9 * _step / _passed) +
           " (now " + text("%.3g", _step) + "), or coarser facets";
  if (!_unsolved.empty())
    return message_of(_unsolved, back_at);
  const double stable = std::min(stable_step, _stable_step);
  if (_released > 0.0 && !(_step > stable * (1.0 + round_off)))
    return released_message(_released, _release_limit, "energy_limits=None of advance lets the run go on") +
           ". It was stopped at the time " + text("%.6g", _time) + "; what moves fastest is in " + _place + "; " + back;
  const bool gained = _gain > _gain_limit;
  return "the run went unstable at the time " + text("%.6g", _time) + ", step " + text("%.6g", _step) +
         " (stable: " + text("%.6g", stable) + "), " +
         (gained ? gain_message(_gain) + " What moves fastest is" : "first") + " in " + _place + "; " + back + "." +
         (gained ? "" : " Take a smaller step, or check loads and contact");
}
} // namespace dolfinx_impact::problems
