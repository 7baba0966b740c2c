// SPDX-License-Identifier: MIT
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "Block.h"
#include "Seal.h"
#include "checkpoint.h"
#include "hdf5.h"
#include "nodes.h"
#include "table_names.h"
#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <functional>
#include <stdexcept>
#include <system_error>
#include <unistd.h>

using dolfinx_impact::state::Place;

namespace dolfinx_impact::files
{
namespace
{
/// Rows of this rank of a table.
struct Rows
{
  std::string name;
  std::size_t count = 0;
  std::vector<std::size_t> columns; ///< empty: the table is a vector
  std::vector<double> real;
  std::vector<std::int64_t> whole;
  Kind kind = Kind::real;

  std::span<const std::byte> bytes() const
  {
    return kind == Kind::real ? std::as_bytes(std::span(real)) : std::as_bytes(std::span(whole));
  }
};

Rows real_rows(std::string name, std::size_t count, std::size_t columns, std::vector<double> values)
{
  return {std::move(name), count, {columns}, std::move(values), {}, Kind::real};
}

Rows whole_rows(std::string name, std::size_t count, std::vector<std::size_t> columns,
                std::vector<std::int64_t> numbers)
{
  return {std::move(name), count, std::move(columns), {}, std::move(numbers), Kind::whole};
}

/// Number of rows of a block on this rank.
std::size_t num_rows(const Block& block, const std::vector<double>& values)
{
  return block.place() == Place::rank ? 1 : values.size() / std::max(block.width(), std::size_t(1));
}

void add_block(std::vector<Rows>& out, const Block& block, std::int64_t first_node)
{
  if (block.place() == Place::all)
    return;
  std::vector<double> values = block.values();
  const std::size_t rows = num_rows(block, values);
  if (const std::vector<std::int64_t>* numbers = block.numbers())
  {
    std::vector<std::int64_t> global = *numbers;
    if (block.place() == Place::node)
      for (std::int64_t& number : global)
        number += first_node;
    if (global.size() != rows)
      throw std::invalid_argument("the state " + block.name() + " has " + std::to_string(rows) + " rows for " +
                                  std::to_string(global.size()) + " numbers");
    out.push_back(whole_rows(numbers_table(block), rows, {}, std::move(global)));
  }
  else if (block.place() == Place::facet)
    throw std::invalid_argument("the state " + block.name() + " does not say which facets its rows belong to");
  out.push_back(real_rows(values_table(block), rows, block.width(), std::move(values)));
}

std::vector<Rows> all_rows(const dolfinx::fem::FunctionSpace<double>& V, const std::vector<Block>& blocks)
{
  const auto& map = *V.dofmap()->index_map;
  std::vector<std::int64_t> inputs = input_cells(*V.mesh());
  const std::size_t cells = inputs.size(), gdim = V.mesh()->geometry().dim();
  std::vector<Rows> out;
  out.push_back(whole_rows(input_table, cells, {}, std::move(inputs)));
  out.push_back(whole_rows(nodes_table, cells, {V.dofmap()->map().extent(1)}, cell_nodes(V)));
  out.push_back(real_rows(x_table, map.size_local(), gdim, places(V)));
  for (const Block& block : blocks)
    add_block(out, block, map.local_range()[0]);
  return out;
}

/// Attributes of a file, in their order.
Attributes all_attributes(const dolfinx::fem::FunctionSpace<double>& V, const std::vector<Block>& blocks,
                          const Identity& identity, const Attributes& more)
{
  const auto& topology = *V.mesh()->topology();
  Attributes out{{"format", format},
                 {"ranks", std::int64_t(dolfinx::MPI::size(V.mesh()->comm()))},
                 {"num_cells", topology.index_map(topology.dim())->size_global()},
                 {"num_nodes", V.dofmap()->index_map->size_global()}};
  out.insert(out.end(), identity.attributes.begin(), identity.attributes.end());
  out.insert(out.end(), more.begin(), more.end());
  for (const Block& block : blocks)
    if (block.place() == Place::all)
      out.push_back({block.name(), block.attribute()});
  for (auto a = out.begin(); a != out.end(); ++a)
    if (std::any_of(out.begin(), a, [&](const Attribute& before) { return before.name == a->name; }))
      throw std::invalid_argument("a checkpoint cannot have two attributes of the name " + a->name);
  return out;
}

/// Write all of the data; a disk that becomes full takes a part of it first.
void write_at(int file, std::span<const std::byte> data, std::int64_t offset, const std::string& path)
{
  while (!data.empty())
  {
    const ssize_t count = ::pwrite(file, data.data(), data.size(), offset);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      throw std::system_error(errno, std::generic_category(), path);
    data = data.subspan(count);
    offset += count;
  }
}

/// A file that is open for writing, closed at the end of the scope.
class OpenForWriting
{
public:
  OpenForWriting(const std::filesystem::path& path, int flags) : _path(path), _file(::open(path.c_str(), flags, 0666))
  {
    if (_file < 0)
      throw std::system_error(errno, std::generic_category(), _path);
  }
  ~OpenForWriting() { ::close(_file); }
  OpenForWriting(const OpenForWriting&) = delete;
  OpenForWriting& operator=(const OpenForWriting&) = delete;

  void write(std::span<const std::byte> data, std::int64_t offset) const { write_at(_file, data, offset, _path); }
  /// Room on the disk.
  void reserve(std::int64_t size) const
  {
    if (const int error = ::posix_fallocate(_file, 0, size))
      throw std::system_error(error, std::generic_category(), _path);
  }
  void synchronise() const
  {
    if (::fsync(_file) != 0)
      throw std::system_error(errno, std::generic_category(), _path);
  }

private:
  std::string _path;
  int _file;
};

/// A file that all ranks write together.
class Writer
{
public:
  Writer(MPI_Comm comm, const std::filesystem::path& path, const std::vector<Rows>& rows)
      : _comm(comm), _rank(dolfinx::MPI::rank(comm)), _target(path), _part(path.string() + ".part"), _rows(rows)
  {
    std::vector<std::int64_t> counts;
    for (const Rows& r : rows)
      counts.push_back(std::int64_t(r.count));
    _counts = common::gather(comm, counts);
  }

  /// Collective.
  void run(const Attributes& attributes)
  {
    step([&] { lay_out_file(attributes); });
    _offsets.resize(_rows.size());
    MPI_Bcast(_offsets.data(), int(_offsets.size()), MPI_INT64_T, 0, _comm);
    gather_sections();
    step([&] { prepare(); });
    step([&] { save(); });
    step(
        [&]
        {
          if (_rank == 0)
            std::filesystem::rename(_part, _target);
        });
  }

private:
  /// Call a function, which does not communicate, on all ranks. If it fails on one, nothing is left behind. Collective.
  void step(const std::function<void()>& act)
  {
    try
    {
      common::agree(_comm, act);
    }
    catch (const std::exception& error)
    {
      std::error_code ignored;
      if (_rank == 0)
        std::filesystem::remove(_part, ignored);
      throw common::Failure("the checkpoint " + _target.string() + " could not be written (" + error.what() +
                            "); what was there is untouched");
    }
  }

  void lay_out_file(const Attributes& attributes)
  {
    if (_rank != 0)
      return;
    Tables tables;
    for (std::size_t k = 0; k < _rows.size(); ++k)
    {
      Table table{{0}, _rows[k].kind};
      for (std::size_t i = k; i < _counts.size(); i += _rows.size())
        table.shape[0] += _counts[i];
      table.shape.insert(table.shape.end(), _rows[k].columns.begin(), _rows[k].columns.end());
      if (!tables.emplace(_rows[k].name, table).second)
        throw std::invalid_argument("the state has two fields or parts that are the table " + _rows[k].name);
    }
    _structure = lay_out(attributes, tables);
    for (const Rows& rows : _rows)
      _offsets.push_back(tables.at(rows.name).offset);
  }

  /// Call act(offset in the file, bytes) for each of this rank's tables.
  template <typename Act>
  void for_pieces(Act act) const
  {
    for (std::size_t k = 0; k < _rows.size(); ++k)
    {
      const std::span<const std::byte> bytes = _rows[k].bytes();
      if (bytes.empty())
        continue;
      std::int64_t before = 0;
      for (int r = 0; r < _rank; ++r)
        before += _counts[r * _rows.size() + k];
      act(_offsets[k] + before * std::int64_t(bytes.size() / _rows[k].count), bytes);
    }
  }

  /// Sections of all ranks. Collective.
  void gather_sections()
  {
    std::vector<std::int64_t> packed; // offset, length and checksum, four numbers each
    for_pieces(
        [&](std::int64_t offset, std::span<const std::byte> bytes)
        {
          for (const Section& s : sections(offset, bytes))
          {
            packed.insert(packed.end(), {s.offset, s.length, 0, 0});
            std::ranges::copy(s.sum, reinterpret_cast<std::uint8_t*>(&*(packed.end() - 2)));
          }
        });
    packed = common::gather(_comm, packed);
    for (std::size_t i = 0; i < packed.size(); i += 4)
    {
      Section s{packed[i], packed[i + 1], true};
      std::copy_n(reinterpret_cast<const std::uint8_t*>(&packed[i + 2]), s.sum.size(), s.sum.begin());
      _sections.push_back(s);
    }
  }

  /// Folder, room on the disk, structure and seal.
  void prepare() const
  {
    if (_rank != 0)
      return;
    const std::filesystem::path folder = _target.has_parent_path() ? _target.parent_path() : ".";
    std::filesystem::create_directories(folder);
    const std::vector<std::byte> end =
        seal(_sections, [&](std::int64_t a, std::int64_t b) { return _structure.content(a, b); }, _structure.size());
    const std::uint64_t size = _structure.size() + end.size(), free = std::filesystem::space(folder).available;
    if (free < size)
      throw std::runtime_error("no space left: " + common::text("%.3g", double(size) / 1e6) + " MB are needed, " +
                               common::text("%.3g", double(free) / 1e6) + " MB free");
    const OpenForWriting file(_part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
    file.reserve(std::int64_t(size));
    for (const auto& [number, page] : _structure.pages())
    {
      const std::uint64_t offset = number * FileInMemory::page_size;
      if (offset < _structure.size())
        file.write(std::span(page).first(std::min(page.size(), std::size_t(_structure.size() - offset))),
                   std::int64_t(offset));
    }
    file.write(end, std::int64_t(_structure.size()));
  }

  void save() const
  {
    const OpenForWriting file(_part, O_WRONLY | O_CLOEXEC);
    for_pieces([&](std::int64_t offset, std::span<const std::byte> bytes) { file.write(bytes, offset); });
    file.synchronise();
  }

  MPI_Comm _comm;
  int _rank;
  std::filesystem::path _target, _part;
  const std::vector<Rows>& _rows;
  std::vector<std::int64_t> _counts;  ///< number of rows by rank and table
  FileInMemory _structure;            ///< on rank 0
  std::vector<std::int64_t> _offsets; ///< of the tables
  std::vector<Section> _sections;
};
} // namespace

void write(const std::filesystem::path& path, const dolfinx::fem::FunctionSpace<double>& V, const state::State& state,
           const Identity& identity, const Attributes& more)
{
  const MPI_Comm comm = V.mesh()->comm();
  std::vector<Block> all = blocks(identity.supports);
  std::ranges::move(blocks(state), std::back_inserter(all));
  check_same(comm, all);
  std::vector<Rows> rows;
  Attributes attributes;
  common::agree(comm,
                [&]
                {
                  rows = all_rows(V, all);
                  attributes = all_attributes(V, all, identity, more);
                });
  Writer(comm, path, rows).run(attributes);
}
} // namespace dolfinx_impact::files
