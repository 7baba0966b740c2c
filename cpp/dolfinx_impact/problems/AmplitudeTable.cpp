// SPDX-License-Identifier: MIT
#include "AmplitudeTable.h"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Numbers of a line, between commas, semicolons or blanks; nothing if something else stands there.
std::optional<std::vector<double>> numbers_of(const std::string& line)
{
  std::vector<double> numbers;
  const char *at = line.data(), *end = at + line.size();
  const auto between = [](char c) { return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r'; };
  while ((at = std::find_if_not(at, end, between)) != end)
  {
    const char* word_end = std::find_if(at, end, between);
    if (*at == '+') // from_chars takes none
      ++at;
    double number = 0.0;
    const auto [rest, error] = std::from_chars(at, word_end, number);
    if (error != std::errc() || rest != word_end)
      return std::nullopt;
    numbers.push_back(number);
    at = word_end;
  }
  return numbers;
}

[[noreturn]] void fail(const std::string& text)
{
  throw std::invalid_argument(text);
}
} // namespace

AmplitudeTable::AmplitudeTable(std::vector<double> times, std::vector<double> values, Options options)
    : _times(std::move(times)), _values(std::move(values)), _options(std::move(options))
{
  const auto finite = [](double x) { return std::isfinite(x); };
  if (_times.empty() || _values.size() % _times.size() != 0)
    fail(_options.name + ": a table needs increasing times and as many values");
  _size = int(_values.size() / _times.size());
  if (_size < 1 || _size > 3)
    fail(_options.name + ": a table has one, two or three values at each time, found " + std::to_string(_size));
  if (!std::ranges::all_of(_times, finite) || !std::ranges::all_of(_values, finite))
    fail(_options.name + ": a table needs finite numbers");
  if (const auto bad = std::ranges::adjacent_find(_times, std::greater_equal<>()); bad != _times.end())
  {
    std::ostringstream text;
    text << _options.name << ": the times of a table increase, but " << bad[1] << " follows " << bad[0];
    fail(text.str());
  }
}

AmplitudeTable AmplitudeTable::from_csv(const std::filesystem::path& file, Options options)
{
  std::ifstream stream(file);
  if (!stream)
    throw std::runtime_error("the table " + file.string() + " cannot be read: is there such a file?");
  std::vector<double> times, values;
  std::size_t columns = 0, number = 0;
  bool titles = false;
  for (std::string line; std::getline(stream, line);)
  {
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#')
      continue;
    const auto row = numbers_of(line);
    if (!row && times.empty() && !titles)
    {
      titles = true;
      continue;
    }
    if (!row || row->size() < 2 || row->size() > 4 || (columns != 0 && row->size() != columns))
      fail("line " + std::to_string(number) + " of the table " + file.string() +
           " is no row of a time and one to three values, in each line as many: " + line.substr(0, 60));
    columns = row->size();
    times.push_back(row->front());
    values.insert(values.end(), row->begin() + 1, row->end());
  }
  if (times.empty())
    fail("the table " + file.string() + " has no row of numbers");
  return AmplitudeTable(std::move(times), std::move(values), std::move(options));
}

void AmplitudeTable::refuse(double time) const
{
  std::ostringstream text;
  text << _options.name << " is asked for the time " << time << ", but goes from " << _times.front() << " to "
       << _times.back() << ": let it hold its values outside, or make it longer (explicit runs look one step ahead)";
  fail(text.str());
}

void AmplitudeTable::sample(std::span<const double> times, std::span<double> values) const
{
  for (std::size_t k = 0; k < times.size(); ++k)
  {
    const double t = times[k];
    if (std::isnan(t) || (t < _times.front() && _options.before == Outside::refuse) ||
        (t > _times.back() && _options.after == Outside::refuse))
      refuse(t);
    const std::size_t next = std::ranges::upper_bound(_times, t) - _times.begin();
    const std::size_t last = _times.size() - 1;
    const std::size_t left = next == 0 ? 0 : next - 1, right = std::min(next, last);
    double r = left == right ? 0.0 : (t - _times[left]) / (_times[right] - _times[left]);
    if (_options.interpolation == Interpolation::smooth)
      r *= r * r * (10.0 - r * (15.0 - 6.0 * r));
    for (int c = 0; c < _size; ++c)
    {
      const double a = _values[left * _size + c], b = _values[right * _size + c];
      values[k * _size + c] = a + r * (b - a);
    }
  }
}

FunctionOfTime AmplitudeTable::function() const
{
  const int size = _size == 2 ? 3 : _size;
  return FunctionOfTime(
      [table = *this, size](std::span<const double> times, std::span<double> values)
      {
        std::vector<double> rows(times.size() * table._size);
        table.sample(times, rows);
        std::ranges::fill(values, 0.0);
        for (std::size_t k = 0; k < times.size(); ++k)
          std::copy_n(rows.begin() + k * table._size, table._size, values.begin() + k * size);
      },
      size, _options.name);
}
} // namespace dolfinx_impact::problems
