// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/energy.h"
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// Time, energies and contact forces of a run by step, and the drift of the total energy, in a bounded amount of
/// memory: beyond `limit` rows every second one is dropped, and from then on only every second (fourth, ...) is kept.
/// The first row always stays, and rows stay equally spaced.
class RunHistory
{
public:
  /// @param[in] num_contacts three components of force each, in a row
  explicit RunHistory(std::size_t num_contacts) : _row_size(1 + integrators::Energies::size + 3 * num_contacts) {}

  /// Entries of a row: time [T], the Energies in their order [F L], three components of each contact's force [F].
  std::size_t row_size() const { return _row_size; }
  /// Number of rows that are kept.
  std::size_t num_rows() const { return _num_rows; }
  /// A row that is kept.
  std::span<const double> row(std::size_t k) const
  {
    return std::span(_blocks[k / rows_per_block]).subspan(k % rows_per_block * _row_size, _row_size);
  }
  /// One row is kept of this many.
  std::size_t stride() const { return _stride; }
  /// Row that was added last, kept or not; empty before the first.
  std::span<const double> last() const { return _last; }

  /// @param[in] times of the rows [T]
  /// @param[in] steps rows as CentralDifference::run writes them
  /// @throws std::invalid_argument for another number of entries
  void add(std::span<const double> times, std::span<const double> steps);
  /// Forget all rows; the next one is the new reference of the drift.
  void begin_anew();
  /// Forget all rows and go on from a checkpoint.
  /// @param[in] total_start total energy at the start of the run; nothing: there was none [F L]
  /// @param[in] largest sum of absolute values of the energies so far [F L]
  void resume(std::optional<double> total_start, double largest);
  const std::optional<double>& total_start() const { return _total_start; }
  double largest() const { return _largest; }
  /// Change of the total energy since the start over the largest sum of absolute values of the energies [1].
  double drift(const integrators::Energies& energies) const;

  std::size_t limit() const { return _limit; }
  /// Bytes of all rows, with room for further ones.
  std::size_t memory() const;
  /// @throws std::invalid_argument for fewer than two rows
  void set_limit(std::size_t limit);

private:
  /// A table in one piece would take twice as much, and three times while it grows.
  static constexpr std::size_t rows_per_block = 4096;
  void append(double time, const double* step);
  void thin();

  std::size_t _row_size, _limit = 250000; // rows: 26 MB with one contact, on every rank
  std::vector<std::vector<double>> _blocks;
  std::vector<double> _last;
  std::size_t _num_rows = 0;
  std::size_t _count = 0, _stride = 1;
  std::optional<double> _total_start;
  double _largest = 0.0;
};

/// Sum of the energies minus the work of external forces; docs/explicit/energies.md [F L].
double total_energy(const integrators::Energies& energies);
} // namespace dolfinx_impact::problems
