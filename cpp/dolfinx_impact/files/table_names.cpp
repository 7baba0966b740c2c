// SPDX-License-Identifier: MIT
#include "table_names.h"
#include "../common/OnAllRanks.h"
#include "../common/gather.h"
#include "checksum.h"
#include <cstring>

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

void check_same(MPI_Comm comm, const std::vector<Block>& blocks)
{
  std::string all;
  for (const Block& block : blocks)
    all += (block.place() == Place::all ? block.name() : values_table(block)) + "," + std::to_string(block.width()) +
           (block.numbers() ? ",some\n" : "\n");
  const Checksum sum = checksum(std::as_bytes(std::span(all)));
  std::vector<std::int64_t> packed(2);
  std::memcpy(packed.data(), sum.data(), sum.size());
  const std::vector<std::int64_t> found = common::gather(comm, packed);
  for (std::size_t r = 1; r < found.size() / 2; ++r)
    if (found[2 * r] != found[0] || found[2 * r + 1] != found[1])
      throw common::Failure("a state has other fields or parts on rank " + std::to_string(r) + " than on rank 0");
}
} // namespace dolfinx_impact::files
