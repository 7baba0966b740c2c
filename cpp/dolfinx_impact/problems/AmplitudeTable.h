// SPDX-License-Identifier: MIT
#pragma once
#include "FunctionsOfTime.h"
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// What an amplitude is between the times of its table.
enum class Interpolation
{
  linear, ///< straight lines
  smooth  ///< steps r^3 (10 - 15 r + 6 r^2), r from 0 to 1, that begin and end without velocity and acceleration
};

/// What an amplitude is before the first and after the last time of its table.
enum class Outside
{
  hold,  ///< the first or the last value
  refuse ///< an error
};

/// Function of time from a table of times and values: of loads, supports and rigid obstacles.
class AmplitudeTable
{
public:
  struct Options
  {
    Interpolation interpolation = Interpolation::linear;
    Outside before = Outside::hold;
    Outside after = Outside::hold;
    std::string name = "an amplitude table"; ///< for messages
  };

  /// @param[in] times that increase [T]
  /// @param[in] values row by row: one at each time, or two or three components of a vector
  /// @param[in] options how it is interpolated
  /// @throws std::invalid_argument for times that do not increase, another number of values, or a number that is not
  /// finite
  AmplitudeTable(std::vector<double> times, std::vector<double> values, Options options);
  AmplitudeTable(std::vector<double> times, std::vector<double> values)
      : AmplitudeTable(std::move(times), std::move(values), Options())
  {
  }

  /// Read a table from a text file: in each line a time and one, two or three values, between commas, semicolons or
  /// blanks. Empty lines, lines that begin with '#', and one line of titles at the head are left out.
  /// @throws std::invalid_argument for a line that is not of this kind, with its number, and what the constructor
  /// throws
  /// @throws std::runtime_error if the file cannot be read
  static AmplitudeTable from_csv(const std::filesystem::path& file, Options options);
  static AmplitudeTable from_csv(const std::filesystem::path& file) { return from_csv(file, Options()); }

  /// Components of its values, 1, 2 or 3.
  int size() const { return _size; }
  std::span<const double> times() const { return _times; }
  std::span<const double> values() const { return _values; }
  const Options& options() const { return _options; }

  /// @param[in] times any times [T]
  /// @param[out] values (num_times, size)
  /// @throws std::invalid_argument for a time outside, where that is refused, and one that is not a number
  void sample(std::span<const double> times, std::span<double> values) const;
  /// The table as amplitude or motion; two components get a third, which is zero.
  FunctionOfTime function() const;

private:
  void refuse(double time) const;

  std::vector<double> _times, _values;
  Options _options;
  int _size = 1;
};
} // namespace dolfinx_impact::problems
