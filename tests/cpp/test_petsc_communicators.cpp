// SPDX-License-Identifier: MIT
// PETSc's own communicators of a space.
#include <basix/finite-element.h>
#include <catch2/catch_test_macros.hpp>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/operators/petsc_communicators.h>
#include <memory>
#include <petscsys.h>

TEST_CASE("PETSc's communicators of a space outlive its objects", "[petsc]")
{
  /// The tag of a message that PETSc gives an object on a communicator, which is its last one: they count down from the
  /// first as long as PETSc's copy of the communicator lives.
  const auto tag = [](MPI_Comm comm)
  {
    MPI_Comm copy = MPI_COMM_NULL;
    PetscMPIInt found = 0;
    PetscCommDuplicate(comm, &copy, &found);
    PetscCommDestroy(&copy);
    return found;
  };
  const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {1, 1}, dolfinx::mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  const auto V = std::make_shared<dolfinx::fem::FunctionSpace<double>>(
      dolfinx_impact::common::create_functionspace(mesh, element, {2}));
  const MPI_Comm of_dofs = V->dofmap()->index_map->comm(), of_mesh = V->mesh()->comm();
  CHECK(tag(of_dofs) == tag(of_dofs)); // each copy is a new one
  dolfinx_impact::operators::keep_petsc_communicators(*V);
  dolfinx_impact::operators::keep_petsc_communicators(*V); // once is enough
  for (MPI_Comm comm : {of_dofs, of_mesh})
  {
    const PetscMPIInt first = tag(comm);
    CHECK(tag(comm) == first - 1);
    CHECK(tag(comm) == first - 2);
  }
}
