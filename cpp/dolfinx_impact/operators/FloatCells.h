// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/FloatKernel.h"
#include "lanes.h"
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::operators
{
/// An array that is read at the nodes of cells.
struct NodeValues
{
  const double* values = nullptr;
  int stride = 3; ///< entries per node, 3, or 4 in an array that is aligned
};

/// Where the nodes of cells are.
struct CellPlaces
{
  NodeValues positions;      ///< [L]
  bool as_space = false;     ///< are they by the nodes of the space? Otherwise by the mesh's.
  std::uint64_t version = 0; ///< another number where positions may be others; 0: they are read in every run
};

/// Element forces of cells in float, of a kernel that reads positions and one coefficient with three components:
/// differences to the first node of each cell are taken in double, and what the kernel gives is added in double.
class FloatCells
{
public:
  /// Nodes of the cells, in batches of `width` cells: node i of a lane stands at [(batch*num_nodes + i)*width + lane].
  struct Nodes
  {
    std::span<const std::int32_t> numbers;
    int per_cell = 0;
    int width = 1;
  };

  /// @param[in] kernel in float
  /// @param[in] num_cells cells; in the arrays the last batch is filled up
  /// @param[in] nodes of the space
  /// @param[in] mesh_nodes of the mesh's geometry
  /// @param[in] cell_size a typical length of the cells; lengths are measured in a power of two near it [L]
  FloatCells(const impact_float_kernel& kernel, std::size_t num_cells, const Nodes& nodes, const Nodes& mesh_nodes,
             double cell_size);

  /// Add the element forces. No allocation.
  /// @param[in] places of the nodes
  /// @param[in] u coefficient [L]
  /// @param[in] constants of the kernel
  /// @param[in,out] b with `stride` entries per node
  void run(const CellPlaces& places, const NodeValues& u, const double* constants, double* b, int stride) const;
  int lanes() const { return _lanes; }

private:
  typedef std::vector<float, AlignedAllocator<float>> Buffer;

  void place(const CellPlaces& places) const;

  kernels::FloatFunctions _functions;
  int _lanes, _num_nodes, _num_mesh_nodes;
  std::size_t _num_cells;
  double _scale, _force_scale;
  std::vector<std::int32_t> _nodes, _mesh_nodes; // as Nodes::numbers, in batches of _lanes
  mutable Buffer _A, _w, _x;
  mutable Buffer _places; // differences of positions to the first node, as the kernel's sweep reads them
  mutable std::uint64_t _version = 0;
};

/// Cells in float, or none. A copy has cells of its own, with buffers of their own.
class OptionalFloatCells
{
public:
  OptionalFloatCells() = default;
  OptionalFloatCells(const OptionalFloatCells& other)
      : _cells(other._cells ? std::make_unique<FloatCells>(*other._cells) : nullptr)
  {
  }
  OptionalFloatCells(OptionalFloatCells&&) = default;
  OptionalFloatCells& operator=(OptionalFloatCells other)
  {
    _cells = std::move(other._cells);
    return *this;
  }
  void set(const FloatCells& cells) { _cells = std::make_unique<FloatCells>(cells); }
  explicit operator bool() const { return _cells != nullptr; }
  const FloatCells* operator->() const { return _cells.get(); }

private:
  std::unique_ptr<FloatCells> _cells;
};
} // namespace dolfinx_impact::operators
