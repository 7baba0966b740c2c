// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cassert>
#include <cstdint>
#include <dolfinx/common/IndexMap.h>
#include <dolfinx/common/MPI.h>
#include <memory>
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Exchange of nodal values between a rank and its neighbours, without allocation: arrays values[node*bs + c] over the
/// nodes of an IndexMap, owned first, then ghosts. One message per neighbour and direction, by persistent requests;
/// none to a neighbour with nothing to exchange. One exchange of a direction at a time: begin and end of one before the
/// begin of the next.
///
/// The end of an exchange waits for what this rank receives. What it has sent is waited for before the next exchange of
/// that direction: MPI may tell a sender that a long message has arrived only once the neighbour is in MPI, too, and a
/// rank that waits for that is no faster than the slowest of its neighbours in every exchange.
class Halo
{
public:
  static constexpr int max_bs = 12; ///< as many components as gather.h has code for

  /// Collective.
  /// @param[in] map nodes
  /// @param[in] used nonzero for each ghost of the map that takes part in exchanges, for example without the layers of
  ///   ghosts that a mesh came with; values of the others are left as they are. Empty: all do
  /// @throws std::invalid_argument for another number of ghosts
  explicit Halo(std::shared_ptr<const dolfinx::common::IndexMap> map, std::span<const std::int8_t> used = {});
  ~Halo();
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  const dolfinx::common::IndexMap& map() const { return *_map; }
  const std::shared_ptr<const dolfinx::common::IndexMap>& shared_map() const { return _map; }
  std::int32_t num_owned() const { return _map->size_local(); }
  /// Ghosts that take part in exchanges.
  std::int32_t num_exchanged_ghosts() const { return std::int32_t(_ghosts.size()); }
  /// Owned nodes that neighbours have as ghosts, those of one neighbour after those of another.
  std::span<const std::int32_t> sent_nodes() const { return _owned; }
  /// Owned nodes and ghosts.
  std::int32_t num_nodes() const { return _map->size_local() + _map->num_ghosts(); }

  /// Send owned values to the ranks that have them as ghosts. Collective; between begin and end owned values may be
  /// read.
  /// @param[in] values [node*stride + c] over num_nodes() nodes
  /// @param[in] bs values per node that are sent, 1 to max_bs
  /// @param[in] stride entries per node; 0: bs
  /// @throws std::invalid_argument for another bs
  void forward_begin(std::span<const double> values, int bs, int stride = 0);
  void forward_end(std::span<double> values, int bs, int stride = 0);
  void forward(std::span<double> values, int bs, int stride = 0)
  {
    forward_begin(values, bs, stride);
    forward_end(values, bs, stride);
  }
  /// Add ghost values to those of their owners; ghosts keep theirs. Collective; between begin and end owned values may
  /// be written. Arguments and errors as of forward_begin.
  void reverse_begin(std::span<const double> values, int bs, int stride = 0);
  void reverse_end(std::span<double> values, int bs, int stride = 0);
  void reverse(std::span<double> values, int bs, int stride = 0)
  {
    reverse_begin(values, bs, stride);
    reverse_end(values, bs, stride);
  }

  /// What this rank has sent so far.
  struct Traffic
  {
    std::int64_t messages = 0, values = 0; ///< a value is a double
    double waited = 0.0;                   ///< for messages of the neighbours [s]
    Traffic& operator+=(const Traffic& other)
    {
      messages += other.messages;
      values += other.values;
      waited += other.waited;
      return *this;
    }
  };
  const Traffic& traffic() const { return _traffic; }

private:
  /// Messages of a direction, forward or reverse, by values per node.
  struct Messages
  {
    std::vector<double> sent, received; ///< buffers
    std::array<std::vector<MPI_Request>, max_bs + 1> sends, receives;
    std::int64_t count = 0; ///< of those that this rank sends in an exchange
    int on_their_way = 0;   ///< values per node of sends that were not waited for; 0: none
  };

  int checked_stride(std::span<const double> values, int bs, int stride) const;
  /// Pack values of nodes that others have, and send them.
  void begin(Messages& messages, std::span<const std::int32_t> nodes, std::span<const double> values, int bs,
             int stride);
  void wait(std::vector<MPI_Request>& requests);

  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  dolfinx::MPI::Comm _comm;                  ///< a duplicate, so that other messages cannot interfere
  std::vector<std::int32_t> _owned, _ghosts; ///< nodes in the order of the messages, neighbour after neighbour
  Messages _forward, _reverse;
  Traffic _traffic;
};
} // namespace dolfinx_impact::operators
