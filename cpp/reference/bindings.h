// SPDX-License-Identifier: MIT
#pragma once
#include "contact_rigid.h"
#include "solve.h"
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <tuple>

namespace impact_reference
{
using Integers = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;

/// indptr, indices, data of a matrix as arrays.
inline std::tuple<Integers, Integers, Vector> arrays(const Csr& m)
{
  const auto integers = [](const std::vector<std::int64_t>& v)
  { return Integers(Eigen::Map<const Integers>(v.data(), v.size())); };
  return {integers(m.indptr), integers(m.indices), Eigen::Map<const Vector>(m.data.data(), m.data.size())};
}

/// Matrix of arrays.
inline Csr csr(const Integers& indptr, const Integers& indices, const Vector& data)
{
  return {indptr.size() - 1,
          {indptr.data(), indptr.data() + indptr.size()},
          {indices.data(), indices.data() + indices.size()},
          {data.data(), data.data() + data.size()}};
}

/// Shape, point, direction, radius of a rigid master and what it turns about; places come with every call.
struct Obstacle
{
  std::string shape;
  Vector point, direction;
  double radius;
  Vector pivot;
};
/// @throws std::invalid_argument for wrong sizes, zero directions and radii
Rigid rigid(const Obstacle& o, int gdim);

void bind_elements(nanobind::module_& m);
void bind_model(nanobind::module_& m);
void bind_contact(nanobind::module_& m);
void bind_explicit(nanobind::module_& m);
void bind_newmark(nanobind::module_& m);
void bind_plasticity(nanobind::module_& m);
void bind_rolling(nanobind::module_& m);
} // namespace impact_reference
