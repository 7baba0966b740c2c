// SPDX-License-Identifier: MIT
#pragma once
#include "Halo.h"
#include "InternalForce.h"
#include "LinearSums.h"
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Averages at the nodes of a measure m of the cells, for example the logarithm of the volume ratio or the components
/// of the strain: the lumped projection on functions of degree 1,
///
///     average_a = (integral of m N_a) / (integral of N_a).
///
/// Cells of one operator count, of all ranks; a node without such cells has the average zero.
class NodalAverage
{
public:
  /// Collective.
  /// @param[in] measure integral of m times the test function
  /// @param[in] volume integral of the test function, or the sum of its components, over the same cells; evaluated once
  /// @param[in] average function on their space that receives the averages, owned and ghosts
  /// @param[in] displacement name of the displacement in the kernels of `measure`
  /// @param[in] linear is the measure linear in the displacement? Where positions and displacement are read from
  ///   arrays, as in explicit runs, its sums are then a product with a matrix (LinearSums.h).
  /// @throws std::invalid_argument if the three have different spaces
  NodalAverage(std::shared_ptr<InternalForce> measure, const InternalForce& volume, std::shared_ptr<Function> average,
               std::string displacement, bool linear = false);

  /// Compute the averages at the present displacement. Collective.
  /// @pre the displacement has up-to-date ghost values
  void update();
  /// Read the displacement from an array instead of from its function (Batches::read).
  void read(const double* displacement, int stride);
  /// Read the nodes' positions from there (Batches::read_positions).
  void read_positions(const NodePositions* positions);
  /// Where the measure is the strain or the gradient, and positions and displacement are read from arrays: add the
  /// nodal forces of the stress of the averages to an array, without storing the averages. Collective.
  /// @param[in,out] b owned and ghost entries of the displacement's space
  /// @param[in] stride entries of a node, as many as the displacement's array has
  /// @throws std::invalid_argument if they are not
  void add_forces(const MeanStress& stress, std::span<double> b, int stride);
  /// Reciprocals of the nodes' volumes, owned and ghosts; zero where a node has no cells [1/L^3].
  std::span<const double> inverse_volumes() const { return _inverse; }
  /// The function that receives the averages.
  std::shared_ptr<const Function> function() const { return _average; }
  /// Number of averages of a node.
  int block_size() const { return _average->function_space()->dofmap()->index_map_bs(); }

private:
  void add_up(std::span<double> sums);
  void find_shared_nodes();
  const LinearSums* linear_sums();
  int stride() const;

  std::shared_ptr<InternalForce> _measure;
  std::shared_ptr<Function> _average;
  std::string _displacement;
  bool _linear;
  const double* _values = nullptr; ///< of the displacement, where they are read from an array
  int _stride = 0;                 ///< of that array; 0: the space's block size
  const NodePositions* _positions = nullptr;
  std::optional<LinearSums> _sums; ///< at the positions of this version
  std::uint64_t _version = 0;
  std::vector<std::int8_t> _shared;        ///< of each node: has it cells of several ranks?
  std::vector<std::int32_t> _shared_nodes; ///< those nodes
  Halo _halo;
  std::vector<double> _inverse;
};
} // namespace dolfinx_impact::operators
