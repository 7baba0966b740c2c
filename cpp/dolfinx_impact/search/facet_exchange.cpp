// SPDX-License-Identifier: MIT
#include "facet_exchange.h"
#include "../common/dolfinx_api.h"
#include "BoxTree.h"
#include "boxes.h"
#include <algorithm>
#include <array>
#include <dolfinx/common/MPI.h>
#include <limits>
#include <numeric>

namespace dolfinx_impact::search
{
namespace
{
/// Lower corner, upper corner; upside down when there is nothing.
typedef std::array<double, 6> Box;

Box common_box(const surface::Facets& facets, const std::vector<double>& boxes, double margin)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const int gdim = facets.gdim;
  Box box;
  std::fill_n(box.begin(), gdim, infinity);
  std::fill(box.begin() + gdim, box.end(), -infinity);
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int c = 0; c < gdim; ++c)
    {
      box[c] = std::min(box[c], boxes[2 * gdim * f + c] - margin);
      box[gdim + c] = std::max(box[gdim + c], boxes[2 * gdim * f + gdim + c] + margin);
    }
  return box;
}

bool overlap(int gdim, const Box& a, const Box& b)
{
  for (int c = 0; c < gdim; ++c)
    if (!(a[c] <= b[gdim + c] && b[c] <= a[gdim + c]))
      return false;
  return true;
}

std::vector<int> offsets(const std::vector<int>& counts)
{
  std::vector<int> out(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), out.begin() + 1);
  return out;
}

/// Rows of `width` entries, `counts` of them from and to each neighbour.
template <typename T>
std::vector<T> exchange_rows(MPI_Comm neighbours, const std::vector<T>& send, const std::vector<int>& send_counts,
                             const std::vector<int>& recv_counts, int width)
{
  MPI_Datatype row;
  MPI_Type_contiguous(width, common::mpi_type<T>(), &row);
  MPI_Type_commit(&row);
  const std::vector<int> from = offsets(recv_counts), to = offsets(send_counts);
  std::vector<T> received(std::size_t(from.back()) * width);
  const int error = MPI_Neighbor_alltoallv(send.data(), send_counts.data(), to.data(), row, received.data(),
                                           recv_counts.data(), from.data(), row, neighbours);
  MPI_Type_free(&row);
  dolfinx::MPI::check_error(neighbours, error);
  return received;
}

/// Ranks to send to and to receive from, known to both ends from everybody's boxes.
struct Neighbours
{
  std::vector<int> destinations, sources;
  std::vector<Box> boxes; ///< target boxes of the destinations
  dolfinx::MPI::Comm comm;
};

Neighbours find_neighbours(MPI_Comm comm, int gdim, const Box& mine, const Box& target)
{
  std::array<Box, 2> own{mine, target};
  std::vector<std::array<Box, 2>> all(dolfinx::MPI::size(comm));
  dolfinx::MPI::check_error(comm, MPI_Allgather(own.data(), sizeof(own) / sizeof(double), MPI_DOUBLE, all.data(),
                                                sizeof(own) / sizeof(double), MPI_DOUBLE, comm));
  std::vector<int> destinations, sources;
  std::vector<Box> boxes;
  for (int rank = 0; rank < int(all.size()); ++rank)
  {
    if (overlap(gdim, mine, all[rank][1]))
    {
      destinations.push_back(rank);
      boxes.push_back(all[rank][1]);
    }
    if (overlap(gdim, all[rank][0], target))
      sources.push_back(rank);
  }
  MPI_Comm graph;
  dolfinx::MPI::check_error(comm,
                            MPI_Dist_graph_create_adjacent(comm, int(sources.size()), sources.data(), MPI_UNWEIGHTED,
                                                           int(destinations.size()), destinations.data(),
                                                           MPI_UNWEIGHTED, MPI_INFO_NULL, false, &graph));
  return {destinations, sources, boxes, dolfinx::MPI::Comm(graph, false)};
}

/// Which facets go to each destination, one after the other.
std::vector<std::int32_t> choose(const Neighbours& neighbours, int gdim, const std::vector<double>& boxes,
                                 std::vector<int>& counts)
{
  const BoxTree tree(gdim, boxes);
  std::vector<std::int32_t> chosen, found;
  for (const Box& box : neighbours.boxes)
  {
    tree.overlapping(box.data(), found);
    counts.push_back(int(found.size()));
    chosen.insert(chosen.end(), found.begin(), found.end());
  }
  return chosen;
}

/// Facets to each neighbour, one neighbour's after the other's.
/// @param[in] chosen which; send_counts of them for each destination
/// @returns what the sources send, sorted by id
FacetPackets send(MPI_Comm neighbours, const FacetPackets& mine, const std::vector<std::int32_t>& chosen,
                  std::vector<int> send_counts, std::size_t num_sources)
{
  const surface::Facets& facets = mine.facets;
  const int gdim = facets.gdim, n = facets.displacement.num_nodes(), n_x = facets.geometry.num_nodes() * gdim;
  std::vector<int> recv_counts(num_sources);
  // One entry more than there are neighbours: MPI implementations differ on null pointers.
  send_counts.reserve(send_counts.size() + 1);
  recv_counts.reserve(recv_counts.size() + 1);
  dolfinx::MPI::check_error(
      neighbours, MPI_Neighbor_alltoall(send_counts.data(), 1, MPI_INT, recv_counts.data(), 1, MPI_INT, neighbours));

  // A row of integers per facet: id, orientation, nodes, owners; and one of reals: X, x.
  std::vector<std::int64_t> integers;
  std::vector<double> reals;
  for (std::int32_t f : chosen)
  {
    integers.insert(integers.end(), {facets.id[f], facets.orientation[f]});
    integers.insert(integers.end(), mine.nodes.begin() + f * n, mine.nodes.begin() + (f + 1) * n);
    integers.insert(integers.end(), mine.owners.begin() + f * n, mine.owners.begin() + (f + 1) * n);
    reals.insert(reals.end(), facets.X_of(f), facets.X_of(f) + n_x);
    reals.insert(reals.end(), facets.x_of(f), facets.x_of(f) + n_x);
  }
  const int width = 2 + 2 * n;
  integers = exchange_rows(neighbours, integers, send_counts, recv_counts, width);
  reals = exchange_rows(neighbours, reals, send_counts, recv_counts, 2 * n_x);

  std::vector<std::size_t> order(integers.size() / width);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return integers[a * width] < integers[b * width]; });
  FacetPackets out;
  out.facets.gdim = gdim;
  out.facets.displacement = facets.displacement;
  out.facets.geometry = facets.geometry;
  out.facets.smooth = facets.smooth;
  for (std::size_t r : order)
  {
    const std::int64_t* row = integers.data() + r * width;
    out.facets.id.push_back(row[0]);
    out.facets.orientation.push_back(std::int8_t(row[1]));
    out.nodes.insert(out.nodes.end(), row + 2, row + 2 + n);
    out.owners.insert(out.owners.end(), row + 2 + n, row + 2 + 2 * n);
    const double* positions = reals.data() + 2 * n_x * r;
    out.facets.X.insert(out.facets.X.end(), positions, positions + n_x);
    out.facets.x.insert(out.facets.x.end(), positions + n_x, positions + 2 * n_x);
  }
  return out;
}
} // namespace

FacetPackets pack(const dolfinx::common::IndexMap& nodes, const surface::Facets& facets)
{
  FacetPackets out{facets, std::vector<std::int64_t>(facets.nodes.size()), {}};
  nodes.local_to_global(facets.nodes, out.nodes);
  const int rank = dolfinx::MPI::rank(nodes.comm());
  for (std::int32_t node : facets.nodes)
    out.owners.push_back(node < nodes.size_local() ? rank : nodes.owners()[node - nodes.size_local()]);
  return out;
}

FacetPackets send_to_overlapping(MPI_Comm comm, const FacetPackets& mine, const surface::Facets& targets, double reach)
{
  const int gdim = mine.facets.gdim;
  std::vector<double> boxes, target_boxes;
  bounding_boxes(mine.facets, boxes);
  bounding_boxes(targets, target_boxes);
  const Neighbours neighbours =
      find_neighbours(comm, gdim, common_box(mine.facets, boxes, 0.0), common_box(targets, target_boxes, reach));
  std::vector<int> counts;
  const std::vector<std::int32_t> chosen = choose(neighbours, gdim, boxes, counts);
  return send(neighbours.comm.comm(), mine, chosen, counts, neighbours.sources.size());
}

FacetPackets send_to_owners(MPI_Comm comm, const FacetPackets& mine)
{
  const int n = mine.facets.displacement.num_nodes();
  std::vector<std::pair<int, std::int32_t>> to;
  to.reserve(mine.owners.size());
  for (std::size_t k = 0; k < mine.owners.size(); ++k)
    to.emplace_back(mine.owners[k], std::int32_t(k / n));
  std::sort(to.begin(), to.end());
  to.erase(std::unique(to.begin(), to.end()), to.end());
  std::vector<int> destinations, counts;
  std::vector<std::int32_t> chosen;
  for (const auto& [rank, facet] : to)
  {
    if (destinations.empty() || destinations.back() != rank)
    {
      destinations.push_back(rank);
      counts.push_back(0);
    }
    ++counts.back();
    chosen.push_back(facet);
  }
  std::vector<int> sources = dolfinx::MPI::compute_graph_edges_nbx(comm, destinations);
  std::sort(sources.begin(), sources.end());
  MPI_Comm graph;
  dolfinx::MPI::check_error(comm,
                            MPI_Dist_graph_create_adjacent(comm, int(sources.size()), sources.data(), MPI_UNWEIGHTED,
                                                           int(destinations.size()), destinations.data(),
                                                           MPI_UNWEIGHTED, MPI_INFO_NULL, false, &graph));
  const dolfinx::MPI::Comm neighbours(graph, false);
  return send(neighbours.comm(), mine, chosen, counts, sources.size());
}
} // namespace dolfinx_impact::search
