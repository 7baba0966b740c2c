// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/Kernel.h"
#include "gather.h"
#include <cstdint>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// Second stage: kernels applied over the cells of a mesh.
namespace dolfinx_impact::operators
{
using Mesh = dolfinx::mesh::Mesh<double>;
using FunctionSpace = dolfinx::fem::FunctionSpace<double>;
using Function = dolfinx::fem::Function<double>;

/// One integral of an operator: a kernel, where it acts, and the values of its constants.
struct Integral
{
  const impact_kernel* kernel = nullptr;
  /// Local cells; for facet integrals pairs (cell, local facet).
  std::vector<std::int32_t> entities;
  /// Packed constants, kernel->size_c of them.
  std::vector<double> constants;
};

/// Cells of one integral in batches of `width`, with the node numbers every array of the kernel is gathered from. The
/// last batch of a group repeats its last cell in the lanes that are left over; `used` says how many lanes count.
class Batches
{
public:
  /// Node numbers of one array: dofs[(batch*num_nodes + node)*width + lane].
  struct Array
  {
    int num_nodes = 0;
    int block_size = 1;
    std::vector<std::int32_t> dofs;
    bool as_test = false; ///< the test space's numbers: `dofs` is empty
    gather_function gather = nullptr;
    std::string name;                         ///< of a coefficient
    std::shared_ptr<const Function> function; ///< of a coefficient
    const double* values = nullptr;           ///< read instead of the function's
    int offset = 0;                           ///< first entry in w
  };

  /// @param[in] integral kernel, entities and constants
  /// @param[in] mesh that the entities belong to
  /// @param[in] test test space (null for a kernel of rank 0)
  /// @param[in] coefficients by the kernel's names
  /// @param[in] width cells per kernel call; 0: the machine's default
  /// @throws std::runtime_error if the kernel is not for this mesh or these spaces
  /// @throws std::invalid_argument if a coefficient or constant is missing or an entity is out of range
  Batches(const Integral& integral, std::shared_ptr<const Mesh> mesh, const std::shared_ptr<const FunctionSpace>& test,
          const std::map<std::string, std::shared_ptr<const Function>>& coefficients, int width);

  /// Apply the kernel to all batches and add the element vectors to b (rank 1), or return the sum of the element values
  /// (rank 0). No allocation.
  /// @param[in,out] b array over owned and ghost degrees of freedom of the test space; null for rank 0
  double run(double* b) const;

  const impact_kernel& kernel() const { return *_kernel; }
  int width() const { return _width; }
  std::size_t num_cells() const { return _num_entities; }
  void set_constants(std::span<const double> c);
  /// Read a coefficient from here (numbered as the function's array) instead of from the function; null: from the
  /// function again. Kernels without it are left as they are.
  void read(const std::string& name, const double* values);
  /// Has the kernel a coefficient of this name?
  bool has(const std::string& name) const;

private:
  void add_group(std::span<const std::int32_t> cells, int facet);

  const impact_kernel* _kernel;
  impact_tabulate _tabulate;
  std::shared_ptr<const Mesh> _mesh;
  int _width;
  std::size_t _num_entities = 0;
  std::shared_ptr<const FunctionSpace> _test_space;
  std::vector<int> _used, _facet; // per batch
  Array _x, _test;
  scatter_function _scatter = nullptr;
  clear_function _clear = nullptr;
  std::vector<Array> _coefficients;
  std::vector<double> _constants;
  mutable std::vector<double> _buffer; // A, w and x of one batch, aligned by hand
};
} // namespace dolfinx_impact::operators
