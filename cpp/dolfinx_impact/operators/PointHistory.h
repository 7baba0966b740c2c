// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/Kernel.h"
#include "../state/State.h"
#include "lanes.h"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Internal variables at the quadrature points of the cells of one integral: values of the last completed step
/// ("committed") and those of the last evaluation ("trial"), an array for each name.
///
/// A kernel reads committed values and writes trial values, so that an evaluation never changes what the next one
/// starts from. `commit` ends a step. Arrays have the order of the batches, which a kernel reads without gathering:
/// values[((batch * num_points + point) * num_components + component) * width + lane].
///
/// In place, outputs are written over the values that were read, and every evaluation ends a step: for explicit time
/// stepping. The second array then holds a snapshot, the state that a failed run goes back to.
class PointHistory
{
public:
  /// @param[in] kernel with outputs or local unknowns
  /// @param[in] cells of the integral, in the order of the batches
  /// @param[in] width cells per batch; lanes that are left over in the last batch repeat its last cell
  /// @throws std::invalid_argument if the kernel has neither
  PointHistory(const impact_kernel& kernel, std::span<const std::int32_t> cells, int width);

  /// The values of the last evaluation become the committed ones. Without an evaluation since the last commit, nothing
  /// changes.
  void commit();
  /// Forget the last evaluation.
  void revert() { _evaluated = _knows_history = false; }

  /// Evaluations overwrite committed values from now on, or no longer. A trial evaluation or snapshot is forgotten.
  void set_in_place(bool in_place);
  bool in_place() const { return _in_place; }
  /// Keep a copy of the present values.
  /// @throws std::logic_error unless in place
  void store_snapshot();
  /// Go back to the values of the last snapshot.
  /// @throws std::logic_error unless in place, or without a snapshot
  void restore_snapshot();

  std::span<const std::int32_t> cells() const { return _cells; }
  int num_points() const { return _num_points; }
  int width() const { return _width; }
  std::size_t num_fields() const { return _fields.size(); }
  const std::string& name(std::size_t field) const { return _fields.at(field).name; }
  int num_components(std::size_t field) const { return _fields.at(field).num_components; }
  /// Is the field read by the kernel? Others are results only: they have one array, of the last evaluation.
  bool is_history(std::size_t field) const { return _fields.at(field).is_history; }
  /// Number of the field of a name.
  /// @throws std::invalid_argument if there is none; the message lists the names
  std::size_t find(const std::string& name) const;

  /// Values in the order of the cells, shape (num_cells, num_points, num_components).
  /// @param[in] field
  /// @param[in] trial of the last evaluation instead of the last commit
  std::vector<double> values(std::size_t field, bool trial = false) const;
  /// Values of one cell, shape (num_points, num_components): committed ones, of results the last evaluation's.
  /// @param[in] cell number in `cells`
  void copy_cell(std::size_t field, std::size_t cell, double* out) const;
  /// Replace committed values, and forget the last evaluation.
  /// @param[in] values shape (num_cells, num_points, num_components)
  /// @throws std::invalid_argument for another size, or values that are not finite
  void set_values(std::size_t field, std::span<const double> values);

  /// Bytes of all values.
  std::size_t memory() const;
  /// Committed values of this rank in the order of the batches: copied, they can be gone back to. Setting them forgets
  /// the last evaluation once `revert` is called.
  state::State state(const std::string& name);

  /// Committed values of a batch, as a kernel reads them.
  const double* committed(std::size_t field, std::size_t batch) const
  {
    return _fields[field].committed.data() + batch * _fields[field].batch_size;
  }
  /// Committed values of all batches, for kernels that work in place: they overwrite them, and set the flags of
  /// `batches_with_history`.
  double* overwritten(std::size_t field) { return _fields[field].committed.data(); }
  /// Of each batch whether a committed value may be other than +0.
  unsigned char* batches_with_history();
  /// Place of the trial values of a batch.
  double* trial(std::size_t field, std::size_t batch)
  {
    Field& f = _fields[field];
    _has_history[batch] = 1;
    return (f.is_history && !_in_place ? f.trial : f.committed).data() + batch * f.batch_size;
  }
  /// Entries of a batch: num_points * num_components * width.
  std::size_t batch_size(std::size_t field) const { return _fields[field].batch_size; }
  /// All batches have been evaluated.
  void set_evaluated() { _evaluated = !_in_place; }

private:
  struct Field
  {
    std::string name;
    int num_components;
    bool is_history;
    std::size_t batch_size;
    AlignedVector committed, trial; // kernels that work in place read whole vectors
  };

  std::size_t entry(const Field& f, std::size_t cell, int point, int component) const;

  std::vector<std::int32_t> _cells;
  int _num_points, _width;
  std::size_t _num_batches;
  std::vector<Field> _fields;
  std::vector<unsigned char> _has_history; ///< of each batch
  bool _knows_history = false;             ///< has nothing but kernels changed committed values since it was found?
  bool _in_place = false, _has_snapshot = false;
  bool _evaluated = false; ///< are the trial values those of an evaluation since the last commit?
};
} // namespace dolfinx_impact::operators
