// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/Kernel.h"
#include "FloatCells.h"
#include "NodePositions.h"
#include "PointHistory.h"
#include "gather.h"
#include <cstdint>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <functional>
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
/// Functions by the names that kernels have for them.
using Coefficients = std::map<std::string, std::shared_ptr<const Function>>;

/// One integral of an operator: a kernel, where it acts, and the values of its constants.
struct Integral
{
  const impact_kernel* kernel = nullptr;
  /// Local cells; for exterior facets pairs (cell, local facet); for interior facets triples (cell "+", cell "-", what
  /// the kernel takes as its entity).
  std::vector<std::int32_t> entities;
  /// Packed constants, kernel->size_c of them.
  std::vector<double> constants;
  /// Internal variables to read, those of another operator on the same cells: they are left as they are. Null: a kernel
  /// with outputs makes its own.
  std::shared_ptr<PointHistory> history = nullptr;
};

/// Points whose local equations were not solved in the last evaluation, and what is known of the first.
struct PointFailures
{
  std::size_t count = 0;
  std::int32_t cell = -1; ///< local number of the first one's cell
  int point = -1;         ///< of the quadrature rule
  double residual = 0.0;  ///< largest residual there, relative to the residual's scale
  std::vector<double> unknowns;
};

/// Cells or facets of one integral in batches of `width`, with the node numbers every array of the kernel is gathered
/// from. The last batch of a group repeats its last cell in the lanes that are left over; `used` says how many lanes
/// count.
class Batches
{
public:
  /// Node numbers of one array: dofs[(batch*num_nodes + node)*width + lane].
  struct Array
  {
    int num_nodes = 0;
    int block_size = 1;
    int stride = 1; ///< entries per node of the values
    std::vector<std::int32_t> dofs;
    bool as_test = false; ///< of the same numbers as the test space: `dofs` is empty
    gather_function gather = nullptr;
    std::string name;                         ///< of a coefficient
    std::shared_ptr<const Function> function; ///< of a coefficient
    const double* values = nullptr;           ///< read instead of the function's
    int offset = 0;                           ///< first entry in w
    int field = -1;                           ///< of the history that is read; -1: nodes are gathered
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
  /// @param[in] stride entries per node of b: the space's block size or padded_stride of it, aligned (lanes.h)
  double run(double* b, int stride) const;

  const impact_kernel& kernel() const { return *_kernel; }
  int width() const { return _width; }
  std::size_t num_cells() const { return _num_entities; }
  void set_constants(std::span<const double> c);
  /// Read a coefficient from here (numbered as the function's array) instead of from the function; null: from the
  /// function again. Kernels without it are left as they are.
  /// @param[in] stride entries per node of the array, as for `run`; 0: the space's block size
  void read(const std::string& name, const double* values, int stride);
  /// Read the positions of nodes from here, if they are by the mesh's nodes or by those of the test space; null: from
  /// the mesh again.
  void read_positions(const NodePositions* positions);
  /// Compute the element vectors in float from now on (FloatCells.h).
  /// @throws std::invalid_argument if there is no kernel in float for them
  void set_mixed();
  int block_size() const { return _test.block_size; } ///< of the test space
  /// Internal variables; null for a kernel without outputs.
  const std::shared_ptr<PointHistory>& history() const { return _history; }
  /// Does a run store outputs in the history? Not where it is another operator's.
  bool stores() const { return _stores; }
  /// Did the last run gather, compute and scatter in one function, the kernel's sweep?
  bool swept() const { return _swept; }
  /// Of the last run.
  const PointFailures& failures() const { return _failures; }
  /// Sum of a name over the cells of the last run; 0 if the kernel has none.
  double sum(const std::string& name) const;
  /// Numbers of the test space's nodes that a run adds to, some of them several times.
  std::span<const std::int32_t> test_nodes() const { return _test.dofs; }
  /// Has the kernel a coefficient of this name?
  bool has(const std::string& name) const;

  /// Node numbers of an array in all batches: numbers[(batch * num_nodes + node) * width + lane].
  struct Nodes
  {
    std::span<const std::int32_t> numbers;
    int num_nodes;
    int block_size;
  };
  Nodes nodes_of_test() const { return {_test.dofs, _test.num_nodes, _test.block_size}; }
  /// @throws std::invalid_argument if the kernel has no coefficient of this name at nodes
  Nodes nodes_of(const std::string& name) const;
  /// Has the kernel this coefficient, at nodes with the numbers of the test space's?
  bool has_nodes_of_test(const Function& function) const;
  /// Positions by the numbers of the test space's nodes, four entries for each; null where they are read otherwise.
  const double* padded_positions() const { return _x.as_test ? _x.values : nullptr; }
  /// Values of a coefficient by these numbers, padded_stride entries for each; null where they are read otherwise.
  const double* padded_values(const std::string& name) const;
  /// What each cell adds for values of a coefficient in which its kernel is linear, the others being zero: nodes of the
  /// rows, nodes of the columns, and the matrix, rows first.
  using MatrixOfCell = std::function<void(std::span<const std::int32_t> rows, std::span<const std::int32_t> columns,
                                          std::span<const double> A)>;
  /// @param[in] name of that coefficient, of a kernel of rank 1 without internal variables
  /// @throws std::invalid_argument for another kernel
  void each_matrix(const std::string& name, const MatrixOfCell& work) const;

private:
  void add_group(std::span<const std::int32_t> cells, int facet);
  void check_cell(std::int32_t cell) const;
  void set_history(const Integral& integral);
  void load_history(std::size_t batch, double* w) const;
  void prefetch_history(std::size_t batch) const;
  void store_outputs(std::size_t batch, const double* A) const;
  void add_sums(std::size_t batch, const double* A) const;
  void record_failures(std::size_t batch, const double* A) const;
  void store_results(std::size_t batch, const double* A) const;
  bool run_kernel_sweep(std::size_t num_batches, double* b) const;
  std::size_t run_whole_batches(double* b, int stride, double* A, double* w, double* x) const;

  const impact_kernel* _kernel;
  impact_tabulate _tabulate;
  std::shared_ptr<const Mesh> _mesh;
  int _width;
  int _sides; ///< cells that one entity has
  std::size_t _num_entities = 0;
  std::shared_ptr<const FunctionSpace> _test_space;
  std::vector<int> _used, _facet; // per batch; the kernel's entity
  Array _x, _test;
  scatter_function _scatter = nullptr, _padded_scatter = nullptr;
  sweep_function _sweep = nullptr;           ///< over padded arrays, for kernels that it is right for; null for others
  impact_sweep _kernel_sweep = nullptr;      ///< the kernel's own, before that, where all arrays have the same nodes
  const NodePositions* _positions = nullptr; ///< where _x is read from; null: the mesh
  OptionalFloatCells _float_cells;           ///< none: all is computed in double
  std::vector<Array> _coefficients;
  std::size_t _at_nodes = 0; ///< the first one that is gathered from nodes
  std::vector<double> _constants;
  std::shared_ptr<PointHistory> _history;
  mutable std::vector<double*> _places; ///< of the outputs that a sweep overwrites
  bool _stores = false;                 ///< are outputs written to the history?
  mutable std::vector<double> _sums;    ///< in the kernel's order
  mutable PointFailures _failures;
  mutable bool _swept = false;
  mutable std::vector<double> _buffer; // A, w and x of one batch, aligned by hand
};
} // namespace dolfinx_impact::operators
