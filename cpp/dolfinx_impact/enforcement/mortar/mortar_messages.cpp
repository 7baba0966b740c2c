// SPDX-License-Identifier: MIT
#include "mortar_messages.h"
#include "../../common/gather.h"
#include "../../common/text.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Overlaps below it are round-off of prescribed displacements, of the bodies' size.
constexpr double least_overlap = 1e-9;
/// Between the sides of an edge, whose mean normal is then 30 degrees off both [degrees].
constexpr double sharp = 60.0;

/// The largest of rows of numbers, in the order of their entries; empty without rows.
std::vector<double> largest_row(const std::vector<double>& rows, std::size_t width)
{
  std::vector<double> out;
  for (std::size_t first = 0; first < rows.size(); first += width)
  {
    const std::vector<double> row(&rows[first], &rows[first] + width);
    if (out.empty() || out < row)
      out = row;
  }
  return out;
}

std::string point(const double* x, const MortarGeometry& geometry)
{
  return "(" + common::components({x, std::size_t(geometry.gdim())}) + ")";
}

void append(std::vector<double>& row, const MortarGeometry& geometry, std::size_t i)
{
  row.push_back(double(geometry.numbers()[i]));
  const double* x = &geometry.now().points[i * geometry.gdim()];
  row.insert(row.end(), x, x + geometry.gdim());
}
} // namespace

std::string describe_overlap(const std::string& name, const MortarGeometry& geometry,
                             std::span<const std::int8_t> prescribed, double depth)
{
  const SlaveNodes& n = geometry.now();
  const std::size_t g = geometry.gdim();
  // Of this rank: number of nodes, the smallest gap, its place.
  std::vector<double> mine(2 + g, 0.0);
  for (std::size_t i = 0; i < geometry.num_nodes(); ++i)
  {
    const double gap = prescribed[i] && std::isfinite(n.gap[i]) ? n.gap[i] : 0.0;
    mine[0] += gap < -least_overlap * geometry.size() - depth;
    if (i == 0 || gap < mine[1])
    {
      mine[1] = gap;
      std::copy_n(&n.points[i * g], g, &mine[2]);
    }
  }
  const std::vector<double> all = common::gather(geometry.comm(), mine);
  double count = 0.0;
  std::size_t worst = 0;
  for (std::size_t first = 0; first < all.size(); first += mine.size())
  {
    count += all[first];
    if (all[first + 1] < all[worst + 1])
      worst = first;
  }
  if (count == 0.0)
    return "";
  return name + ": " + common::text("%.0f", count) +
         " slave nodes are prescribed along the normal and lie in the master, the deepest by " +
         common::text("%.3e", -all[worst + 1]) + " at " + common::place({&all[worst + 2], g}) +
         ": contact cannot move them. Where the master is free to give way, exchange slave and master; where it is "
         "prescribed too, the prescribed displacements of the two bodies overlap: change them";
}

std::string describe_violation(const std::string& name, const MortarGeometry& geometry, const Violations& violations)
{
  const std::size_t width = 3 + geometry.gdim();
  std::vector<double> mine; // value, what, number, place
  for (const std::vector<double>* values : {&violations.gap, &violations.slip})
  {
    const auto at = std::ranges::max_element(*values);
    if (at == values->end())
      continue;
    mine.insert(mine.end(), {*at, values == &violations.slip ? 1.0 : 0.0});
    append(mine, geometry, at - values->begin());
  }
  const std::vector<double> found = largest_row(common::gather(geometry.comm(), mine), width);
  if (found.empty())
    return "";
  return name + (found[1] > 0.0 ? ": a slip of a node that sticks" : ": a gap of an active node") + ", number " +
         common::text("%.0f", found[2]) + " at " + point(&found[3], geometry) + ", is " +
         common::text("%.3e", found[0]);
}

std::string describe_sharp_edge(const std::string& name, const MortarGeometry& geometry)
{
  const std::size_t width = 2 + geometry.gdim();
  const SlaveNodes& n = geometry.now();
  const std::vector<double> angles = geometry.edge_angles(), sizes = geometry.facet_sizes();
  std::vector<double> mine; // angle, number, place
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (n.gap[i] < sizes[i] && n.part[i] && angles[i] > sharp)
    {
      mine.push_back(angles[i]);
      append(mine, geometry, i);
    }
  const std::vector<double> all = common::gather(geometry.comm(), mine), found = largest_row(all, width);
  if (found.empty())
    return "";
  return name + ": the slave has an edge of " + common::text("%.0f", found[0]) + " degrees at " +
         std::to_string(all.size() / width) + " of its nodes beside the master (number " +
         common::text("%.0f", found[1]) + " at " + point(&found[2], geometry) +
         "), where the normal is the mean of both sides: leave one side out of its tag, or make a pair of each";
}
} // namespace dolfinx_impact::enforcement
