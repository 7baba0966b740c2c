// SPDX-License-Identifier: MIT
#include "force_on_master.h"
#include "../operators/resultant.h"
#include <cstdint>
#include <numeric>
#include <vector>

namespace dolfinx_impact::solve
{
MasterForce force_on_master(const EquilibriumProblem& problem, std::span<const std::size_t> contacts,
                            const gap::Vector3& point)
{
  std::vector<double> forces(problem.num_owned(), 0.0);
  for (std::size_t k : contacts)
  {
    const std::vector<double> nodal = problem.contacts[k]->contact_forces();
    for (std::size_t i = 0; i < forces.size(); ++i)
      forces[i] -= nodal[i];
  }
  std::vector<std::int32_t> dofs(forces.size());
  std::iota(dofs.begin(), dofs.end(), 0);
  const std::span<const double> u = problem.u->x()->array();
  const operators::Resultant found = operators::resultant(problem.space(), u.first(forces.size()), forces, dofs, point);
  MasterForce out{found.force, found.moment};
  // Sums over ranks may be rounded differently on each of them.
  MPI_Bcast(out.force.data(), 3, MPI_DOUBLE, 0, problem.comm());
  MPI_Bcast(out.torque.data(), 3, MPI_DOUBLE, 0, problem.comm());
  return out;
}

gap::Vector3 centre_of_master(const enforcement::StaticContact& contact)
{
  gap::Vector3 out = contact.centre();
  const auto moved = contact.displacement().value_or(gap::Vector3{});
  for (int c = 0; c < 3; ++c)
    out[c] += moved[c];
  return out;
}
} // namespace dolfinx_impact::solve
