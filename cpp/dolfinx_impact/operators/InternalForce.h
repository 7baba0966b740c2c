// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include "LinearSums.h"
#include <dolfinx/la/Vector.h>
#include <optional>

namespace dolfinx_impact::operators
{
class AveragedNeoHookean;
class NodalAverage;

/// A vector f(u) of a form of rank 1, computed cell by cell without a matrix, several cells at once; or, for a form of
/// rank 0, its value. Materials that differ by cell tag are integrals of their own.
class InternalForce
{
public:
  /// @param[in] mesh of all integrals
  /// @param[in] test space of the result; null for a form of rank 0
  /// @param[in] integrals kernels with the entities they act on
  /// @param[in] coefficients by name; their values are read anew at every call
  /// @param[in] width cells per kernel call: 1, 4, 8, or 0 for the machine's default
  /// @throws std::runtime_error if a kernel is not for this mesh or these spaces (kernels/check.h)
  /// @throws std::invalid_argument if a coefficient or constant is missing
  InternalForce(const std::shared_ptr<const Mesh>& mesh, std::shared_ptr<const FunctionSpace> test,
                const std::vector<Integral>& integrals,
                const std::map<std::string, std::shared_ptr<const Function>>& coefficients, int width = 0);

  /// Add the contributions of this rank's cells to b, as dolfinx::fem::assemble_vector does.
  /// @pre coefficients have up-to-date ghost values
  /// @param[in,out] b owned and ghost entries of the test space
  void assemble(std::span<double> b) const;
  /// The same for an array with padded_stride(bs) entries per node, aligned (lanes.h).
  void assemble_padded(std::span<double> b) const;

  /// b = f, complete: ghost contributions are sent to their owners and the ghosts of b are refreshed.
  /// @pre coefficients have up-to-date ghost values
  void apply(dolfinx::la::Vector<double>& b) const;

  /// Value of a form of rank 0 over this rank's cells; sum over ranks for the total.
  double value() const;

  /// Replace the constants of integral i.
  void set_constants(std::size_t i, std::span<const double> c) { _batches.at(i).set_constants(c); }

  /// Read a coefficient from an array instead of from its function, in all integrals (Batches::read), and in averages
  /// if it is their displacement.
  void read(const std::string& name, const double* values, int stride = 0);
  /// Read the nodes' positions from there (Batches::read_positions), also in averages.
  void read_positions(const NodePositions* positions);

  /// Compute the element vectors of all integrals in float from now on (FloatCells.h).
  /// @throws std::invalid_argument if a kernel does not exist in float
  void set_mixed()
  {
    for (Batches& batches : _batches)
      batches.set_mixed();
  }

  /// Compute averages at the nodes, which kernels read, before every evaluation; assemble and value are then
  /// collective.
  /// @param[in] average what is computed
  /// @param[in] displacement name that this operator's kernels have for the displacement of the averages
  /// @param[in] stress of averages that no kernel reads: its forces are added (NodalAverage::add_forces). Null: kernels
  ///   read the averages
  void add_average(std::shared_ptr<NodalAverage> average, std::string displacement,
                   const std::optional<MeanStress>& stress = std::nullopt);
  /// Forces of kernels and averages that are added together from now on, where they can be.
  void add_together(std::shared_ptr<AveragedNeoHookean> forces) { _together.push_back(std::move(forces)); }

  /// Space of the result; null for a form of rank 0.
  const std::shared_ptr<const FunctionSpace>& test_space() const { return _test; }
  /// Degrees of freedom of the test space that this rank's cells contribute to, in increasing order.
  std::vector<std::int32_t> reached_dofs() const;
  /// Has any integral a coefficient of this name?
  bool has(const std::string& name) const
  {
    for (const Batches& batches : _batches)
      if (batches.has(name))
        return true;
    return false;
  }

  /// Internal variables of integral i; null if its kernel has none.
  const std::shared_ptr<PointHistory>& history(std::size_t i) const { return _batches.at(i).history(); }
  /// End of a step: the internal variables of the last evaluation become those that the next one starts from. Of an
  /// operator that reads another one's, they are left to that one.
  void commit();
  /// Forget the internal variables of the last evaluation.
  void revert();
  /// Evaluations overwrite committed values, or no longer (PointHistory::set_in_place).
  void set_in_place(bool in_place);
  /// Keep a copy of the internal variables, in place only; go back to it.
  void store_snapshot();
  void restore_snapshot();
  /// Sum of a name over this rank's cells in the last evaluation; 0 if no kernel has it.
  double sum(const std::string& name) const;
  /// Points of all integrals whose local equations were not solved in the last evaluation on this rank.
  PointFailures failures() const;
  /// A sentence about the points of all ranks whose local equations were not solved in the last evaluation: their
  /// number, and what is known of the first; empty if all were. Collective where kernels have local equations.
  std::string fault() const;
  /// Number of those points.
  std::size_t num_failures() const;
  /// Has any integral internal variables of its own?
  bool has_history() const;

  /// The integrals in batches of cells.
  std::span<const Batches> batches() const { return _batches; }
  /// Cells per kernel call of integral i.
  int width(std::size_t i = 0) const { return _batches.at(i).width(); }
  /// Did the last evaluation of integral i gather, compute and scatter in one function (kernels/sweep.h)?
  bool swept(std::size_t i) const { return _batches.at(i).swept(); }
  std::size_t num_integrals() const { return _batches.size(); }

  /// Floating-point operations of one application on this rank.
  double flops() const;

private:
  void assemble(std::span<double> b, bool padded) const;
  /// Call a function with the internal variables of each integral that keeps them.
  void each_history(auto&& work);
  void update_averages(int stride) const;
  bool is_together(const auto& part, int stride) const;

  std::shared_ptr<const Mesh> _mesh;
  std::shared_ptr<const FunctionSpace> _test;
  std::vector<Batches> _batches;
  /// Averages, with the name of their displacement.
  struct Averaged
  {
    std::string displacement;
    std::shared_ptr<NodalAverage> average;
    std::optional<MeanStress> stress;
  };
  std::vector<Averaged> _averages;
  std::vector<std::shared_ptr<AveragedNeoHookean>> _together;
};
} // namespace dolfinx_impact::operators
