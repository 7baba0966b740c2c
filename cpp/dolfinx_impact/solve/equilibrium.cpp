// SPDX-License-Identifier: MIT
#include "equilibrium.h"
#include "../common/text.h"
#include "../operators/body_size.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::solve
{
namespace
{
// Round-off of a nodal contact force, in units of the largest relative error of a sum: it is the sum of some ten terms
// (facets around a node times shape functions), on the slave's side and on the master's.
constexpr double sums_of_force = 32;
// Gaps below this part of the bodies' size are none: a contact without force may open by round-off.
constexpr double open = 1e-10;

/// A node and what is missing there; the largest of all ranks is found by MPI's MAXLOC.
struct Worst
{
  double missing = -1.0;
  int rank = 0;
};
} // namespace

std::optional<Imbalance> out_of_balance(const EquilibriumProblem& problem, std::span<const double> bodies,
                                        double tolerance)
{
  if (problem.contacts.empty())
    return {}; // the residual of the bodies is what Newton's method has made small
  const MPI_Comm comm = problem.comm();
  const int gdim = problem.space().mesh()->geometry().dim();
  const std::size_t owned = problem.num_owned();
  std::vector<double> left(bodies.begin(), bodies.end()), sums{0.0};
  double largest = 0.0;
  for (double f : bodies)
    largest = std::max(largest, std::abs(f));
  for (const auto& contact : problem.contacts)
  {
    const std::vector<double> forces = contact->contact_forces();
    sums.push_back(0.0);
    for (std::size_t i = 0; i < owned; ++i)
    {
      left[i] -= forces[i];
      sums.back() += forces[i] * forces[i];
      largest = std::max(largest, std::abs(forces[i]));
    }
  }
  for (std::size_t i = 0; i < owned; ++i)
  {
    left[i] = problem.fixed[i] ? 0.0 : left[i];
    sums[0] += left[i] * left[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  double sizes = 0.0;
  for (std::size_t k = 1; k < sums.size(); ++k)
    sizes += std::sqrt(sums[k]);
  const double norm = std::sqrt(sums[0]);
  const double allowed = tolerance + sums_of_force * std::numeric_limits<double>::epsilon() * sizes;
  if (norm <= allowed) // a norm that is not a number is none
    return {};
  // The node where most is missing; what is not a number is most of all.
  Worst worst;
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::array<double, 3> place{};
  const std::vector<double> x = problem.space().tabulate_dof_coordinates(false);
  for (std::size_t i = 0; i < owned / gdim; ++i)
  {
    double squares = 0.0;
    for (int c = 0; c < gdim; ++c)
      squares += left[i * gdim + c] * left[i * gdim + c];
    const double length = std::isfinite(squares) ? std::sqrt(squares) : std::numeric_limits<double>::infinity();
    if (length > worst.missing)
    {
      worst = {length, rank};
      std::copy_n(x.data() + 3 * i, 3, place.begin());
    }
  }
  worst.rank = rank;
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
  MPI_Bcast(place.data(), 3, MPI_DOUBLE, worst.rank, comm);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
  std::string names;
  for (const auto& contact : problem.contacts)
    names += (names.empty() ? "" : ", ") + contact->name();
  return Imbalance{norm, "the forces that the contacts report do not balance those of the bodies: " +
                             common::text("%.3e", worst.missing) + " is missing at the node " + "(" +
                             common::components({place.data(), std::size_t(gdim)}) +
                             "), where the largest nodal force is " + common::text("%.3e", largest) +
                             "; the norm of what is missing is " + common::text("%.3e", norm) + ", its tolerance " +
                             common::text("%.3e", allowed) + " (contacts: " + names + ")"};
}

std::vector<std::string> open_contacts(const EquilibriumProblem& problem, std::span<const std::int8_t> closed)
{
  std::vector<std::string> found;
  for (std::size_t k = 0; k < closed.size(); ++k)
  {
    const enforcement::StaticContact& contact = *problem.contacts[k];
    if (!closed[k] || contact.num_active() > 0)
      continue;
    const double gap = contact.smallest_gap();
    if (gap > open * operators::body_size(*problem.space().mesh()))
      found.push_back(contact.name() + ": smallest gap " + common::text("%.3e", gap));
  }
  return found;
}
} // namespace dolfinx_impact::solve
