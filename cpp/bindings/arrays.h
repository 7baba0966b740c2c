// SPDX-License-Identifier: MIT
#pragma once
// Arrays in and out: views that are checked, results that own their memory.
#include "module.h"
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::bindings
{
namespace nb = nanobind;
typedef nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Indices;
typedef nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu> Values;
/// An array that is written to. Its argument needs noconvert(): results would go into a copy of another type.
typedef nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu> MutableValues;

inline std::span<const double> view(const Values& values)
{
  return {values.data(), values.size()};
}

/// What a function returns or is given, by the type that annotations say: arrays of NumPy's, and others that may be
/// None.
template <typename T>
using Typed = nb::typed<nb::object, T>;
template <typename T>
using NumpyArray = nb::ndarray<nb::numpy, T>;
/// An array of values of any type.
typedef nb::ndarray<nb::numpy> AnyArray;
/// An object, whose type annotations say from here on.
template <typename T>
Typed<T> typed(const nb::object& value)
{
  return nb::borrow<Typed<T>>(value);
}

/// NumPy array that owns a moved vector.
template <typename T>
auto take(std::vector<T>&& values, std::vector<std::size_t> shape)
{
  auto* moved = new std::vector<T>(std::move(values));
  nb::capsule owner(moved, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(moved->data(), shape.size(), shape.data(), owner);
}

template <typename T>
auto take(std::vector<T>&& values)
{
  const std::size_t size = values.size();
  return take(std::move(values), {size});
}

/// NumPy array with a copy of a vector.
template <typename T>
auto copy(const std::vector<T>& values, std::vector<std::size_t> shape)
{
  return take(std::vector<T>(values), std::move(shape));
}
} // namespace dolfinx_impact::bindings
