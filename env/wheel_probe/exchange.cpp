// SPDX-License-Identifier: MIT
// Functions that take objects from DOLFINx's Python module, petsc4py and mpi4py, and call the libraries behind them.
#include <basix/finite-element.h>
#include <boost/uuid/uuid.hpp>
#include <dolfinx/common/log.h>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Form.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/MeshTags.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_wrappers/caster_mpi.h>
#include <dolfinx_wrappers/caster_petsc.h>
#include <map>
#include <mpi.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <petscmat.h>
#include <petscvec.h>
#include <slepceps.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace nb = nanobind;
using dolfinx::mesh::Mesh;

// Boost 1.86 gave this type another alignment; it is a member of dolfinx::fem::FunctionSpace.
static_assert(sizeof(boost::uuids::uuid) == 16 and alignof(boost::uuids::uuid) == 1);

namespace
{
void check(PetscErrorCode error)
{
  if (error != PETSC_SUCCESS)
    throw std::runtime_error("PETSc error " + std::to_string(error));
}

template <typename T>
void compare(std::map<std::string, std::pair<std::size_t, std::size_t>>& sizes, const char* name)
{
  const nb::handle type = nb::type<T>();
  if (not type.is_valid())
    throw std::runtime_error(std::string(name) + " is not known to nanobind here");
  sizes[name] = {sizeof(T), nb::type_size(type)};
}
} // namespace

NB_MODULE(_exchange, m)
{
  m.def(
      "count_entities",
      [](const Mesh<double>& mesh, int dim)
      {
        auto topology = std::const_pointer_cast<dolfinx::mesh::Topology>(mesh.topology());
        topology->create_entities(dim);
        topology->create_connectivity(dim, topology->dim());
        const std::int64_t owned = topology->index_map(dim)->size_local();
        std::int64_t all = 0;
        MPI_Allreduce(&owned, &all, 1, MPI_INT64_T, MPI_SUM, mesh.comm());
        return std::pair(all, topology->index_map(dim)->size_global());
      },
      nb::arg("mesh"), nb::arg("dim"), "Owned entities summed by MPI here, and DOLFINx's own count.");

  m.def(
      "assemble",
      [](const dolfinx::fem::Form<double>& form)
      {
        const auto& space = *form.function_spaces().at(0);
        dolfinx::la::Vector<double> b(space.dofmap()->index_map, space.dofmap()->index_map_bs());
        dolfinx::fem::assemble_vector(b.array(), form);
        b.scatter_rev(std::plus<double>());
        return dolfinx::la::norm(b);
      },
      nb::arg("form"), "Euclidean norm of the assembled vector.");

  m.def(
      "assemble_matrix",
      [](const dolfinx::fem::Form<double>& form)
      {
        Mat A = dolfinx::fem::petsc::create_matrix(form, std::nullopt);
        dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(A, ADD_VALUES), form, {});
        check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
        check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
        return A;
      },
      nb::rv_policy::take_ownership, nb::arg("form"), "A matrix of PETSc, made here, that Python owns.");

  m.def(
      "multiply",
      [](Mat A, Vec x, Vec y)
      {
        check(MatMult(A, x, y));
        PetscReal norm = 0;
        check(VecNorm(y, NORM_2, &norm));
        return norm;
      },
      nb::arg("A"), nb::arg("x"), nb::arg("y"), "Norm of y = A x.");

  m.def(
      "same_mesh", [](std::shared_ptr<Mesh<double>> mesh) { return mesh; }, nb::arg("mesh"),
      "The mesh itself: nanobind finds the Python object that belongs to it.");

  m.def(
      "rectangle",
      [](const dolfinx_wrappers::MPICommWrapper& comm, int n)
      {
        return std::make_shared<Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
            comm.get(), {{{0, 0}, {1, 1}}}, {n, n}, dolfinx::mesh::CellType::triangle));
      },
      nb::arg("comm"), nb::arg("n"), "A mesh made here.");

  m.def("update_ghosts", [](dolfinx::fem::Function<double>& u) { u.x()->scatter_fwd(); }, nb::arg("u"));

  m.def(
      "largest_eigenvalue",
      [](Mat A)
      {
        PetscBool ready = PETSC_FALSE;
        check(SlepcInitialized(&ready));
        if (not ready)
          check(SlepcInitializeNoArguments());
        EPS eps = nullptr;
        MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(A));
        check(EPSCreate(comm, &eps));
        check(EPSSetOperators(eps, A, nullptr));
        check(EPSSetProblemType(eps, EPS_HEP));
        check(EPSSetWhichEigenpairs(eps, EPS_LARGEST_REAL));
        check(EPSSolve(eps));
        PetscScalar value = 0;
        check(EPSGetEigenvalue(eps, 0, &value, nullptr));
        check(EPSDestroy(&eps));
        return value;
      },
      nb::arg("A"));

  m.def(
      "tabulate_at_origin",
      []
      {
        const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::triangle, 2,
                                                           basix::element::lagrange_variant::gll_warped,
                                                           basix::element::dpc_variant::unset, false);
        const std::vector<double> origin{0, 0};
        return element.tabulate(0, std::span(origin), {1, 2}).first;
      },
      "Shape functions of the triangle of degree 2 at the origin, from libbasix.");

  m.def("log_level", [] { return static_cast<int>(spdlog::get_level()); }, "The level that dolfinx.log has set.");

  m.def(
      "finalize_twice",
      [](const Mesh<double>& mesh)
      {
        // Thrown inside libdolfinx.
        const auto map = mesh.topology()->index_map(0);
        dolfinx::la::SparsityPattern pattern(mesh.comm(), {map, map}, {1, 1});
        pattern.finalize();
        pattern.finalize();
      },
      nb::arg("mesh"));

  m.def(
      "petsc",
      []
      {
        size_t index = 0, scalar = 0;
        check(PetscDataTypeGetSize(PETSC_INT, &index));
        check(PetscDataTypeGetSize(PETSC_SCALAR, &scalar));
        PetscInt major = 0, minor = 0, patch = 0;
        check(PetscGetVersionNumber(&major, &minor, &patch, nullptr));
        return std::map<std::string, std::pair<std::size_t, std::size_t>>{
            {"PetscInt", {sizeof(PetscInt), index}},
            {"PetscScalar", {sizeof(PetscScalar), scalar}},
            {"version", {100 * PETSC_VERSION_MAJOR + PETSC_VERSION_MINOR, 100 * major + minor}},
            {"patch", {PETSC_VERSION_SUBMINOR, patch}}};
      },
      "Of the headers, and of the library that is loaded.");

  m.def(
      "sizes",
      []
      {
        std::map<std::string, std::pair<std::size_t, std::size_t>> sizes;
        compare<Mesh<double>>(sizes, "Mesh");
        compare<dolfinx::mesh::Topology>(sizes, "Topology");
        compare<dolfinx::mesh::Geometry<double>>(sizes, "Geometry");
        compare<dolfinx::mesh::MeshTags<std::int32_t>>(sizes, "MeshTags");
        compare<dolfinx::common::IndexMap>(sizes, "IndexMap");
        compare<dolfinx::fem::CoordinateElement<double>>(sizes, "CoordinateElement");
        compare<dolfinx::fem::DirichletBC<double>>(sizes, "DirichletBC");
        compare<dolfinx::fem::DofMap>(sizes, "DofMap");
        compare<dolfinx::fem::FiniteElement<double>>(sizes, "FiniteElement");
        compare<dolfinx::fem::Form<double>>(sizes, "Form");
        compare<dolfinx::fem::Function<double>>(sizes, "Function");
        compare<dolfinx::fem::FunctionSpace<double>>(sizes, "FunctionSpace");
        compare<dolfinx::la::SparsityPattern>(sizes, "SparsityPattern");
        compare<dolfinx::la::Vector<double>>(sizes, "Vector");
        return sizes;
      },
      "Bytes of each class: by the headers here, and as DOLFINx's module has registered it.");
}
