// SPDX-License-Identifier: MIT
#include "table_names.h"

using dolfinx_impact::state::Place;

namespace dolfinx_impact::files
{
std::string values_table(const Block& block)
{
  if (block.place() == Place::cell)
    return "cells/values/" + block.name();
  if (block.place() == Place::rank)
    return "ranks/" + block.name();
  if (block.place() == Place::facet)
    return "facets/" + block.name() + "/values";
  return block.numbers() ? "some/" + block.name() + "/values" : "nodes/" + block.name();
}

std::string numbers_table(const Block& block)
{
  return block.place() == Place::facet ? "facets/" + block.name() + "/numbers" : "some/" + block.name() + "/nodes";
}
} // namespace dolfinx_impact::files
