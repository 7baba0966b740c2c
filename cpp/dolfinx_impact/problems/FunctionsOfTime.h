// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <concepts>
#include <functional>
#include <mpi.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A function of time: one number, or three components of a vector.
class FunctionOfTime
{
public:
  /// Values at times, (num_times, size) row by row.
  typedef std::function<void(std::span<const double> times, std::span<double> values)> Sampler;

  /// @param[in] f function of the time [T] that returns a number, or std::array<double, 3>
  template <std::invocable<double> F>
  FunctionOfTime(F f, std::string name = "a function of time")
  {
    constexpr bool scalar = std::convertible_to<std::invoke_result_t<F, double>, double>;
    _size = scalar ? 1 : 3;
    _name = std::move(name);
    _sample = [f = std::move(f)](std::span<const double> times, std::span<double> values)
    {
      for (std::size_t k = 0; k < times.size(); ++k)
        if constexpr (scalar)
          values[k] = f(times[k]);
        else
        {
          const std::array<double, 3> row = f(times[k]);
          std::copy(row.begin(), row.end(), values.begin() + 3 * k);
        }
    };
  }
  /// @param[in] sample all times at once
  /// @param[in] size components of its values, 1 or 3
  /// @param[in] name for messages
  FunctionOfTime(Sampler sample, int size, std::string name)
      : _sample(std::move(sample)), _size(size), _name(std::move(name))
  {
  }

  int size() const { return _size; }
  const std::string& name() const { return _name; }
  /// @param[out] values (num_times, size)
  /// @throws std::invalid_argument for a value that is not finite
  void sample(std::span<const double> times, std::span<double> values) const;
  /// Value of a function with one component.
  double at(double time) const;

private:
  Sampler _sample;
  int _size = 1;
  std::string _name;
};

/// Functions of time of a problem as columns of one table: those of loads, supports and rigid masters. A number has one
/// column, a vector three.
class FunctionsOfTime
{
public:
  /// @returns its first column
  int add(FunctionOfTime function);
  int num_columns() const { return _num_columns; }
  const std::vector<FunctionOfTime>& functions() const { return _functions; }
  /// Sample all functions. A rank may fail alone.
  /// @returns values (num_times, num_columns)
  /// @throws std::invalid_argument for values that are not finite
  std::vector<double> table(std::span<const double> times) const;
  /// The same where all ranks sample; an exception on one is one on all. Collective.
  std::vector<double> table_on_all_ranks(MPI_Comm comm, std::span<const double> times) const;

  /// Returns the table in place of the functions; is called on all ranks, and throws on all alike.
  typedef std::function<std::vector<double>(std::span<const double> times)> Source;
  /// Let somebody else sample all functions, who may know the problem that has these; empty: nobody.
  void set_source(Source source) { _source = std::move(source); }

private:
  std::vector<FunctionOfTime> _functions;
  int _num_columns = 0;
  Source _source;
};
} // namespace dolfinx_impact::problems
