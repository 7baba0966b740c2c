// SPDX-License-Identifier: MIT
#pragma once
// Masks: NumPy's bool is a byte, as the library's std::int8_t.
#include "arrays.h"

namespace dolfinx_impact::bindings
{
typedef nb::ndarray<const bool, nb::c_contig, nb::device::cpu> Mask;
/// An array of any shape.
typedef nb::ndarray<const double, nb::c_contig, nb::device::cpu> Array;

inline std::span<const double> view(const Array& values)
{
  return {values.data(), values.size()};
}

inline std::span<const std::int8_t> view(const Mask& values)
{
  return {reinterpret_cast<const std::int8_t*>(values.data()), values.size()};
}

/// NumPy mask with a copy of a vector.
inline Typed<NumpyArray<bool>> mask(const std::vector<std::int8_t>& values, std::vector<std::size_t> shape)
{
  auto* out = new bool[values.size()];
  std::copy(values.begin(), values.end(), out);
  nb::capsule owner(out, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  return typed<NumpyArray<bool>>(nb::cast(NumpyArray<bool>(out, shape.size(), shape.data(), owner)));
}

inline Typed<NumpyArray<bool>> mask(const std::vector<std::int8_t>& values)
{
  return mask(values, {values.size()});
}

/// Vectors by node, (n, gdim).
inline Typed<NumpyArray<double>> vectors(std::vector<double> values, std::size_t num, int gdim)
{
  return typed<NumpyArray<double>>(nb::cast(take(std::move(values), {num, std::size_t(gdim)})));
}

/// NumPy array of its own.
template <typename T>
Typed<NumpyArray<T>> array(std::vector<T> values)
{
  return typed<NumpyArray<T>>(nb::cast(take(std::move(values))));
}
} // namespace dolfinx_impact::bindings
