// SPDX-License-Identifier: MIT
#include "Halo.h"
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
constexpr int count_tag = 1, index_tag = 2, forward_tag = 3, reverse_tag = 4;

void check(MPI_Comm comm, int error)
{
  dolfinx::MPI::check_error(comm, error);
}

/// Ghosts that are used, ordered by owner, those of one owner in the map's order.
std::vector<std::int32_t> by_owner(const dolfinx::common::IndexMap& map, std::span<const std::int8_t> used)
{
  const auto owners = map.owners();
  if (!used.empty() && used.size() != owners.size())
    throw std::invalid_argument("a Halo of " + std::to_string(owners.size()) + " ghosts was told of " +
                                std::to_string(used.size()) + " which of them are used");
  std::vector<std::int32_t> order;
  for (std::size_t g = 0; g < owners.size(); ++g)
    if (used.empty() || used[g])
      order.push_back(std::int32_t(g));
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) { return owners[a] < owners[b]; });
  return order;
}
} // namespace

Halo::Halo(std::shared_ptr<const dolfinx::common::IndexMap> map, std::span<const std::int8_t> used)
    : _map(std::move(map)), _comm(_map->comm())
{
  const MPI_Comm comm = _comm.comm();
  const std::vector<std::int32_t> order = by_owner(*_map, used);
  const auto sources = _map->src(), destinations = _map->dest();
  // Owners hear from every neighbour how many of their nodes it has, and which.
  std::vector<int> ghost_counts(sources.size()), owned_counts(destinations.size());
  for (std::size_t i = 0; i < sources.size(); ++i)
    ghost_counts[i] =
        int(std::ranges::count_if(order, [&](std::int32_t g) { return _map->owners()[g] == sources[i]; }));
  std::vector<MPI_Request> requests;
  const auto finish = [&]
  {
    check(comm, MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
    requests.clear();
  };
  for (std::size_t i = 0; i < destinations.size(); ++i)
    check(comm, MPI_Irecv(&owned_counts[i], 1, MPI_INT, destinations[i], count_tag, comm, &requests.emplace_back()));
  for (std::size_t i = 0; i < sources.size(); ++i)
    check(comm, MPI_Isend(&ghost_counts[i], 1, MPI_INT, sources[i], count_tag, comm, &requests.emplace_back()));
  finish();
  std::vector<std::int64_t> wanted(order.size());
  std::transform(order.begin(), order.end(), wanted.begin(), [&](std::int32_t g) { return _map->ghosts()[g]; });
  std::vector<std::int64_t> asked(std::accumulate(owned_counts.begin(), owned_counts.end(), 0));
  for (std::size_t i = 0, at = 0; i < destinations.size(); at += owned_counts[i++])
    check(comm, MPI_Irecv(asked.data() + at, owned_counts[i], MPI_INT64_T, destinations[i], index_tag, comm,
                          &requests.emplace_back()));
  for (std::size_t i = 0, at = 0; i < sources.size(); at += ghost_counts[i++])
    check(comm, MPI_Isend(wanted.data() + at, ghost_counts[i], MPI_INT64_T, sources[i], index_tag, comm,
                          &requests.emplace_back()));
  finish();
  for (std::int64_t node : asked)
    _owned.push_back(std::int32_t(node - _map->local_range()[0]));
  for (std::int32_t g : order)
    _ghosts.push_back(_map->size_local() + g);

  const auto messages = [](const std::vector<int>& counts)
  { return std::ranges::count_if(counts, [](int count) { return count > 0; }); };
  _forward.count = messages(owned_counts);
  _reverse.count = messages(ghost_counts);
  for (Messages* direction : {&_forward, &_reverse})
  {
    const bool forward = direction == &_forward;
    direction->sent.resize((forward ? _owned : _ghosts).size() * max_bs);
    direction->received.resize((forward ? _ghosts : _owned).size() * max_bs);
  }
  const auto each_message = [](const auto& ranks, const std::vector<int>& counts, int bs, auto prepare)
  {
    for (std::size_t i = 0, at = 0; i < ranks.size(); at += counts[i++])
      if (counts[i] > 0) // the neighbour knows that as well
        prepare(at * bs, counts[i] * bs, ranks[i]);
  };
  const auto send = [&](Messages& direction, int bs, const auto& ranks, const std::vector<int>& counts, int tag)
  {
    each_message(ranks, counts, bs,
                 [&](std::size_t at, int size, int rank)
                 {
                   check(comm, MPI_Send_init(direction.sent.data() + at, size, MPI_DOUBLE, rank, tag, comm,
                                             &direction.sends[bs].emplace_back()));
                 });
  };
  const auto receive = [&](Messages& direction, int bs, const auto& ranks, const std::vector<int>& counts, int tag)
  {
    each_message(ranks, counts, bs,
                 [&](std::size_t at, int size, int rank)
                 {
                   check(comm, MPI_Recv_init(direction.received.data() + at, size, MPI_DOUBLE, rank, tag, comm,
                                             &direction.receives[bs].emplace_back()));
                 });
  };
  for (int bs = 1; bs <= max_bs; ++bs)
  {
    receive(_forward, bs, sources, ghost_counts, forward_tag);
    send(_forward, bs, destinations, owned_counts, forward_tag);
    receive(_reverse, bs, destinations, owned_counts, reverse_tag);
    send(_reverse, bs, sources, ghost_counts, reverse_tag);
  }
}

Halo::~Halo()
{
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized)
    return;
  for (Messages* messages : {&_forward, &_reverse})
  {
    auto& last = messages->sends[messages->on_their_way]; // none has 0 values per node
    if (!last.empty())
      MPI_Waitall(int(last.size()), last.data(), MPI_STATUSES_IGNORE);
    for (auto* all : {&messages->sends, &messages->receives})
      for (auto& requests : *all)
        for (MPI_Request& request : requests)
          MPI_Request_free(&request);
  }
}

void Halo::begin(Messages& messages, std::span<const std::int32_t> nodes, std::span<const double> values, int bs,
                 int stride)
{
  const std::size_t s = checked_stride(values, bs, stride);
  wait(messages.sends[messages.on_their_way]);
  const auto start = [this](std::vector<MPI_Request>& requests)
  {
    if (!requests.empty()) // no null pointers: MPI implementations differ on them
      check(_comm.comm(), MPI_Startall(int(requests.size()), requests.data()));
  };
  start(messages.receives[bs]);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    std::copy_n(values.data() + nodes[i] * s, bs, messages.sent.data() + i * bs);
  start(messages.sends[bs]);
  messages.on_their_way = bs;
  _traffic += {messages.count, std::int64_t(nodes.size()) * bs};
}

void Halo::wait(std::vector<MPI_Request>& requests)
{
  if (requests.empty())
    return;
  const double begin = MPI_Wtime();
  check(_comm.comm(), MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  _traffic.waited += MPI_Wtime() - begin;
}

int Halo::checked_stride([[maybe_unused]] std::span<const double> values, int bs, int stride) const
{
  if (bs < 1 || bs > max_bs)
    throw std::invalid_argument("a Halo exchanges 1 to " + std::to_string(max_bs) + " values per node, not " +
                                std::to_string(bs));
  const int found = stride > 0 ? stride : bs;
  assert(found >= bs && values.size() >= std::size_t(num_nodes()) * found);
  return found;
}

void Halo::forward_begin(std::span<const double> values, int bs, int stride)
{
  begin(_forward, _owned, values, bs, stride);
}

void Halo::forward_end(std::span<double> values, int bs, int stride)
{
  const std::size_t s = checked_stride(values, bs, stride);
  wait(_forward.receives[bs]);
  for (std::size_t i = 0; i < _ghosts.size(); ++i)
    std::copy_n(_forward.received.data() + i * bs, bs, values.data() + _ghosts[i] * s);
}

void Halo::reverse_begin(std::span<const double> values, int bs, int stride)
{
  begin(_reverse, _ghosts, values, bs, stride);
}

void Halo::reverse_end(std::span<double> values, int bs, int stride)
{
  const std::size_t s = checked_stride(values, bs, stride);
  wait(_reverse.receives[bs]);
  for (std::size_t i = 0; i < _owned.size(); ++i)
    for (int c = 0; c < bs; ++c)
      values[_owned[i] * s + c] += _reverse.received[i * bs + c];
}
} // namespace dolfinx_impact::operators
