// SPDX-License-Identifier: MIT
#include "petsc_communicators.h"
#include "petsc_check.h"
#include <algorithm>
#include <dolfinx/common/IndexMap.h>
#include <dolfinx/fem/DofMap.h>
#include <memory>
#include <petscsys.h>
#include <vector>

namespace dolfinx_impact::operators
{
namespace
{
typedef std::weak_ptr<const dolfinx::common::IndexMap> Owner;

/// A copy, and whose communicator it is of.
struct Kept
{
  Owner owner;
  MPI_Comm copy;
};

/// @param[in] owner lives as long as the communicator
void keep(const std::shared_ptr<const dolfinx::common::IndexMap>& owner, MPI_Comm comm)
{
  static auto& kept = *new std::vector<Kept>; // PETSc and MPI may end before static objects do
  std::erase_if(kept,
                [](Kept& k)
                {
                  if (k.owner.expired())
                    check(PetscCommDestroy(&k.copy), "a communicator is given back");
                  return k.owner.expired();
                });
  if (std::ranges::any_of(kept, [&](const Kept& k) { return k.owner.lock() == owner; }))
    return;
  MPI_Comm copy = MPI_COMM_NULL;
  check(PetscCommDuplicate(comm, &copy, nullptr), "a communicator is copied");
  kept.push_back({owner, copy});
}
} // namespace

void keep_petsc_communicators(const dolfinx::fem::FunctionSpace<double>& V)
{
  // Maps of indices are made in C++ and live as long as what has them; a mesh may be one of Python's.
  const auto& mesh = *V.mesh();
  keep(mesh.geometry().index_map(), mesh.comm());
  keep(V.dofmap()->index_map, V.dofmap()->index_map->comm());
}
} // namespace dolfinx_impact::operators
