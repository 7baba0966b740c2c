// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <dolfinx/common/MPI.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FiniteElement.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/sparsitybuild.h>
#include <dolfinx/la/SparsityPattern.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/Mesh.h>
#include <functional>
#include <memory>
#include <mpi.h>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

/// The calls of DOLFINx that are spelled otherwise in one of the releases 0.9, 0.10 and 0.11. No other file of the C++
/// library asks which release it is compiled with; what a release has is asked for, where the language allows it.

#if __has_include(<dolfinx/fem/pack.h>)
#define IMPACT_DOLFINX_0_10                                                                                            \
  1 // 0.10 or newer: DOLFINx gives its version as a string only, which the preprocessor cannot read
#else
#define IMPACT_DOLFINX_0_10 0
#endif

namespace dolfinx_impact::common
{
/// MPI's type of numbers of type T.
template <typename T>
MPI_Datatype mpi_type()
{
#if IMPACT_DOLFINX_0_10
  return dolfinx::MPI::mpi_t<T>;
#else
  return dolfinx::MPI::mpi_type<T>();
#endif
}

/// All values of a vector that this process has, ghosts after owned ones; no copy. (`auto x = v.array()` is a view in
/// DOLFINx 0.9 and a copy of the whole vector in later releases.)
template <typename T>
std::span<T> array(dolfinx::la::Vector<T>& v)
{
#if IMPACT_DOLFINX_0_10
  return std::span<T>(v.array());
#else
  return v.mutable_array();
#endif
}

template <typename T>
std::span<const T> array(const dolfinx::la::Vector<T>& v)
{
  return std::span<const T>(v.array());
}

/// Set all values of a vector that this process has, ghosts among them.
template <typename T>
void fill(dolfinx::la::Vector<T>& v, std::type_identity_t<T> value)
{
  std::ranges::fill(array(v), value);
}

/// The element of the geometry of a mesh, which has cells of one type.
template <std::floating_point T>
const dolfinx::fem::CoordinateElement<T>& coordinate_element(const dolfinx::mesh::Mesh<T>& mesh)
{
  if constexpr (requires { mesh.geometry().cmaps(); })
    return mesh.geometry().cmaps().front();
  else
    return mesh.geometry().cmap();
}

/// The nodes of the geometry of each cell, shape (cells, nodes of a cell); a view into the mesh, which has cells of one
/// type.
template <std::floating_point T>
auto geometry_dofmap(const dolfinx::mesh::Mesh<T>& mesh)
{
  if constexpr (requires { mesh.geometry().dofmaps(); })
    return mesh.geometry().dofmaps().front();
  else
    return mesh.geometry().dofmap();
}

/// The shape of the values of functions of a space.
template <std::floating_point T>
std::vector<std::size_t> value_shape(const dolfinx::fem::FunctionSpace<T>& V)
{
  if constexpr (requires { V.value_shape(); })
    return {V.value_shape().begin(), V.value_shape().end()};
  else
    return {V.element()->value_shape().begin(), V.element()->value_shape().end()};
}

/// A subspace as a space of its own, and the degrees of freedom of the whole space that its own ones are. Collective.
template <std::floating_point T>
std::pair<dolfinx::fem::FunctionSpace<T>, std::vector<std::int32_t>> collapse(const dolfinx::fem::FunctionSpace<T>& V)
{
  auto [field, dofs] = V.collapse();
  if constexpr (requires { dofs.front().front(); })
    return {std::move(field), std::move(dofs.front())};
  else
    return {std::move(field), std::move(dofs)};
}

/// Insert into a pattern what integrals over the given cells of one mesh couple. (A template of its pattern, so that
/// the branch which is not taken need not compile.)
template <std::same_as<dolfinx::la::SparsityPattern> Pattern>
void insert_cells(Pattern& pattern, std::span<const std::int32_t> cells, const dolfinx::fem::DofMap& rows,
                  const dolfinx::fem::DofMap& columns)
{
  namespace build = dolfinx::fem::sparsitybuild;
  if constexpr (requires { build::cells(pattern, std::pair(cells, cells), {rows, columns}); })
    build::cells(pattern, std::pair(cells, cells), {rows, columns});
  else
    build::cells(pattern, {cells, cells}, {rows, columns});
}

/// Boundary conditions as DOLFINx's assembly takes them; they must outlive the result.
template <typename T>
auto boundary_conditions(const std::vector<std::shared_ptr<const dolfinx::fem::DirichletBC<T>>>& conditions)
{
#if IMPACT_DOLFINX_0_10
  std::vector<std::reference_wrapper<const dolfinx::fem::DirichletBC<T>>> out;
  for (const auto& condition : conditions)
    out.push_back(*condition);
  return out;
#else
  return conditions;
#endif
}
} // namespace dolfinx_impact::common
