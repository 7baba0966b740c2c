// SPDX-License-Identifier: MIT
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "Block.h"
#include "Damaged.h"
#include "Seal.h"
#include "checkpoint.h"
#include "hdf5.h"
#include "nodes.h"
#include "table_names.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>

using dolfinx_impact::state::Place;

namespace dolfinx_impact::files
{
namespace
{
/// Relative tolerance of sums over nodes and of coordinates: round-off is less, another mesh differs by more.
constexpr double same = 1e-9;

std::string shape_text(const std::vector<std::size_t>& shape)
{
  std::string out;
  for (std::size_t size : shape)
    out += (out.empty() ? "" : ", ") + std::to_string(size);
  return "(" + out + ")";
}

const char* kind_text(Kind kind)
{
  return kind == Kind::real ? "float64" : kind == Kind::whole ? "int64" : "that is neither float64 nor int64";
}

/// Rows that a file has for some nodes or facets, of all ranks.
struct SomeRows
{
  std::vector<std::int64_t> numbers;
  std::vector<std::size_t> order; ///< of the numbers
  std::vector<double> values;
};

class Reader
{
public:
  Reader(const std::filesystem::path& path, const dolfinx::fem::FunctionSpace<double>& V, const Identity& identity,
         const ReadOptions& options)
      : _path(path.string()), _V(V), _comm(V.mesh()->comm()), _identity(identity), _options(options)
  {
  }

  /// Read and check a whole file. Collective.
  Saved run(const state::State& like)
  {
    Saved out{like.copy(), {}};
    const state::State supports = _identity.supports.copy();
    const std::vector<Block> of_state = blocks(out.state), of_identity = blocks(supports);
    check_same(_comm, of_identity);
    check_same(_comm, of_state);
    guarded([&] { open(); });
    common::agree(_comm, [&] { compare(of_state); });
    check_same_file();
    guarded([&] { read_cells(); });
    _then = nodes_then(_V, _cell_nodes);
    std::vector<std::vector<double>> rows;
    guarded(
        [&]
        {
          check_places();
          for (const Block& block : of_identity)
            read_block(block);
          for (const Block& block : of_state)
            read_block(block);
          check_tables(of_identity, of_state);
        });
    check_supports(of_identity);
    for (const Block& block : of_state)
      rows.push_back(rows_here(block));
    common::agree(_comm, [&] { assign(of_state, rows); });
    out.attributes = std::move(_structure.attributes);
    return out;
  }

private:
  /// Call a function, which does not communicate; if it fails on one rank the file cannot be read. Collective.
  void guarded(const std::function<void()>& act)
  {
    try
    {
      common::agree(_comm, act);
    }
    catch (const std::exception& error)
    {
      throw common::Failure("the checkpoint " + _path + " cannot be read (" + error.what() + ")");
    }
  }

  /// Read the attributes, and the places and types of the tables.
  void open()
  {
    try
    {
      _file = std::make_unique<SealedFile>(_path);
    }
    catch (const Damaged&)
    {
      check_format_before_seals();
      throw;
    }
    _structure = read_structure(_path);
  }

  /// Of a file from before files had seals, say that.
  void check_format_before_seals() const
  {
    Structure found;
    try
    {
      found = read_structure(_path);
    }
    catch (const std::exception&) // it is no HDF5 file, or damaged: what the caller says
    {
      return;
    }
    const Value* there = found.attribute("format");
    if (there && !equal(Value(format), *there, 0.0))
      throw Damaged("it has format " + to_string(*there) + ", this version reads " + std::to_string(format));
  }

  /// Refuse another format, mesh or problem, and a file that lacks attributes.
  void compare(const std::vector<Block>& wanted) const
  {
    const auto& topology = *_V.mesh()->topology();
    const Value* there = _structure.attribute("format");
    if (!there || !equal(Value(format), *there, 0.0))
      throw common::BadValue(_path + " has format " + (there ? to_string(*there) : "none") + ", this version reads " +
                             std::to_string(format));
    const std::string mesh = "it is of another mesh";
    compare({"num_cells", topology.index_map(topology.dim())->size_global(), mesh});
    compare({"num_nodes", _V.dofmap()->index_map->size_global(), mesh});
    for (const Attribute& a : _identity.attributes)
      compare(a);
    std::vector<std::string> names{"ranks"};
    names.insert(names.end(), _options.more.begin(), _options.more.end());
    for (const Block& block : wanted)
      if (block.place() == Place::all)
        names.push_back(block.name());
    std::string missing;
    for (const std::string& name : names)
      if (!_structure.attribute(name))
        missing += (missing.empty() ? "" : ", ") + name;
    if (!missing.empty())
      throw common::BadValue(_path + " lacks " + missing);
  }

  void compare(const Attribute& here) const
  {
    const Value* found = _structure.attribute(here.name);
    if (found && equal(here.value, *found, same))
      return;
    const std::string there = found ? to_string(*found) : "none";
    const std::string advice = here.advice.empty() ? "" : "; " + here.advice;
    if (std::holds_alternative<Numbers>(here.value))
      throw common::BadValue(_path + " is of another problem: " + here.name + " differ" + advice);
    throw common::BadValue(_path + " is of another problem: " + here.name + " is " + there + ", here " +
                           to_string(here.value) + advice);
  }

  /// Refuse a name that leads to another file on another rank. Collective.
  void check_same_file() const
  {
    std::vector<std::int64_t> mark(2);
    std::memcpy(mark.data(), _file->mark().data(), sizeof(Checksum));
    const std::vector<std::int64_t> all = common::gather(_comm, mark);
    for (std::size_t r = 1; r < all.size() / 2; ++r)
      if (all[2 * r] != all[0] || all[2 * r + 1] != all[1])
        throw common::Failure("the checkpoint " + _path + " on rank " + std::to_string(r) +
                              " is another file than that on rank 0");
  }

  /// A table with the type and shape that it must have.
  /// @param[in] columns number of columns; nothing: it must be a vector
  /// @param[in] rows number of rows; nothing: any number
  const Table& table(const std::string& name, Kind kind, std::optional<std::size_t> columns,
                     std::optional<std::size_t> rows) const
  {
    const auto found = _structure.tables.find(name);
    if (found == _structure.tables.end())
      throw Damaged("the table " + name + " is missing");
    const Table& t = found->second;
    const bool right = t.kind == kind && t.shape.size() == (columns ? 2 : 1) && (!columns || t.shape[1] == *columns) &&
                       (!rows || t.shape[0] == *rows);
    if (!right)
      throw Damaged("the table " + name + " has shape " + shape_text(t.shape) + " and type " + kind_text(t.kind) +
                    ": it is that of another problem");
    return t;
  }

  /// Rows [low, high) of a table, verified.
  template <typename T>
  std::vector<T> read_rows(const std::string& name, const Table& t, std::size_t low, std::size_t high) const
  {
    const std::size_t width = t.shape.size() > 1 ? t.shape[1] : 1;
    const std::size_t count = (high - low) * width;
    std::vector<T> out(count);
    if (count == 0)
      return out;
    const std::vector<std::byte> bytes =
        _file->read("the table " + name, t.offset < 0 ? -1 : t.offset + std::int64_t(low * width * sizeof(T)),
                    std::int64_t(count * sizeof(T)));
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }

  std::vector<std::int64_t> read_numbers(const std::string& name) const
  {
    const Table& t = table(name, Kind::whole, {}, {});
    return read_rows<std::int64_t>(name, t, 0, t.shape[0]);
  }

  /// @param[in] infinite whether infinite values are numbers
  std::vector<double> read_values(const std::string& name, std::size_t columns, std::size_t rows, std::size_t low,
                                  std::size_t high, bool infinite) const
  {
    std::vector<double> out = read_rows<double>(name, table(name, Kind::real, columns, rows), low, high);
    if (std::ranges::any_of(out, [infinite](double v) { return infinite ? std::isnan(v) : !std::isfinite(v); }))
      throw Damaged("the table " + name + " has values that are no numbers");
    return out;
  }

  /// Read the numbers that the nodes of this rank's owned cells have in the file.
  void read_cells()
  {
    const std::size_t num_cells = _V.mesh()->topology()->index_map(_V.mesh()->topology()->dim())->size_global();
    const std::int64_t num_nodes = _V.dofmap()->index_map->size_global();
    const std::size_t width = _V.dofmap()->map().extent(1);
    const std::vector<std::int64_t> inputs =
        read_rows<std::int64_t>(input_table, table(input_table, Kind::whole, {}, num_cells), 0, num_cells);
    const std::vector<std::int64_t> nodes =
        read_rows<std::int64_t>(nodes_table, table(nodes_table, Kind::whole, width, num_cells), 0, num_cells);
    std::vector<std::int64_t> row_of(num_cells, -1); // by number in the input
    for (std::size_t row = 0; row < num_cells; ++row)
    {
      if (inputs[row] < 0 || inputs[row] >= std::int64_t(num_cells) || row_of[inputs[row]] >= 0)
        throw Damaged(std::string("the table ") + input_table + " does not have every cell once");
      row_of[inputs[row]] = std::int64_t(row);
    }
    if (std::ranges::any_of(nodes, [num_nodes](std::int64_t n) { return n < 0 || n >= num_nodes; }))
      throw Damaged(std::string("the table ") + nodes_table + " has nodes that do not exist");
    for (std::int64_t cell : input_cells(*_V.mesh()))
    {
      if (cell < 0 || cell >= std::int64_t(num_cells))
        throw Damaged("cells of the mesh have other numbers in its input");
      _cell_rows.push_back(row_of[cell]);
      const auto first = nodes.begin() + row_of[cell] * std::int64_t(width);
      _cell_nodes.insert(_cell_nodes.end(), first, first + std::int64_t(width));
    }
  }

  /// Rows of a table of all nodes, or all cells, that belong to this rank.
  std::vector<double> read_own(const std::string& name, std::size_t columns, std::size_t num,
                               const std::vector<std::int64_t>& wanted, bool infinite) const
  {
    std::size_t low = 0, high = 0;
    if (!wanted.empty())
    {
      const auto [least, most] = std::ranges::minmax(wanted);
      low = std::size_t(least);
      high = std::size_t(most) + 1;
    }
    const std::vector<double> all = read_values(name, columns, num, low, high, infinite);
    std::vector<double> out(wanted.size() * columns);
    for (std::size_t i = 0; i < wanted.size(); ++i)
      std::copy_n(all.begin() + std::ptrdiff_t((wanted[i] - std::int64_t(low)) * columns), columns,
                  out.begin() + std::ptrdiff_t(i * columns));
    return out;
  }

  /// Nodes of the file lie where those of the mesh do.
  void check_places() const
  {
    const std::vector<double> x = places(_V);
    const std::size_t num = _V.dofmap()->index_map->size_global();
    const std::vector<double> there = read_own(x_table, _V.mesh()->geometry().dim(), num, _then.numbers, false);
    double size = 0.0;
    for (double value : x)
      size = std::max(size, std::abs(value));
    const bool near =
        std::ranges::equal(x, there, [limit = same * size](double a, double b) { return std::abs(a - b) <= limit; });
    if (!near || !_then.agreed)
      throw Damaged("its nodes lie elsewhere: it is of another mesh, or its cells are numbered anew");
  }

  static std::string without_digits(const std::string& name)
  {
    return name.substr(0, name.find_last_not_of("0123456789") + 1);
  }

  /// Is this a table at some nodes that files of earlier versions lack, and this one, too?
  bool lacks(const Block& block) const
  {
    return block.place() == Place::node && block.numbers() &&
           std::ranges::count(_options.later, without_digits(block.name())) > 0 &&
           !_structure.tables.contains(values_table(block));
  }

  void read_block(const Block& block)
  {
    if (block.place() == Place::all)
      return;
    const std::string name = values_table(block);
    const bool infinite = std::ranges::count(_options.infinite, without_digits(block.name())) > 0;
    const std::size_t columns = block.width();
    if (lacks(block))
      return;
    if (block.numbers())
      _some.emplace(name, read_some(block, infinite));
    else if (block.place() == Place::node)
      _own.emplace(name, read_own(name, columns, _V.dofmap()->index_map->size_global(), _then.numbers, infinite));
    else if (block.place() == Place::cell)
      _own.emplace(name, read_own(name, columns,
                                  _V.mesh()->topology()->index_map(_V.mesh()->topology()->dim())->size_global(),
                                  _cell_rows, infinite));
    else if (block.place() == Place::rank)
      _own.emplace(name, rank_values(block, infinite));
    else
      throw std::invalid_argument("the state " + block.name() + " does not say which facets its rows belong to");
  }

  SomeRows read_some(const Block& block, bool infinite) const
  {
    const std::string name = numbers_table(block);
    const std::int64_t num_nodes = _V.dofmap()->index_map->size_global();
    SomeRows out{read_numbers(name), {}, {}};
    out.order.resize(out.numbers.size());
    std::iota(out.order.begin(), out.order.end(), std::size_t(0));
    const auto by_number = [&](std::size_t i) { return out.numbers[i]; };
    std::ranges::sort(out.order, {}, by_number);
    if (std::ranges::adjacent_find(out.order, {}, by_number) != out.order.end())
      throw Damaged("the table " + name + " has " + (block.place() == Place::node ? "nodes" : "facets") + " twice");
    if (block.place() == Place::node &&
        std::ranges::any_of(out.numbers, [num_nodes](std::int64_t n) { return n < 0 || n >= num_nodes; }))
      throw Damaged("the table " + name + " has nodes that do not exist");
    out.values = read_values(values_table(block), block.width(), out.numbers.size(), 0, out.numbers.size(), infinite);
    return out;
  }

  /// The vector that this rank wrote, if the number of ranks is that of the file. Otherwise, for entries that add up,
  /// their sums on rank 0 and zeros elsewhere.
  std::vector<double> rank_values(const Block& block, bool infinite) const
  {
    const std::size_t columns = block.width();
    const std::int64_t* then = std::get_if<std::int64_t>(_structure.attribute("ranks"));
    if (!then || *then < 1)
      throw Damaged("its number of ranks is " + to_string(*_structure.attribute("ranks")));
    const std::size_t ranks = std::size_t(*then), rank = dolfinx::MPI::rank(_comm);
    const std::vector<double> all = read_values(values_table(block), columns, ranks, 0, ranks, infinite);
    const auto row = [&](std::size_t r)
    {
      return std::vector<double>(all.begin() + std::ptrdiff_t(r * columns),
                                 all.begin() + std::ptrdiff_t((r + 1) * columns));
    };
    if (*then == dolfinx::MPI::size(_comm))
      return row(rank);
    if (std::ranges::count(_options.equal, block.name()) > 0)
      return row(0);
    std::vector<double> out(columns, 0.0);
    for (std::size_t i = 0; rank == 0 && i < all.size(); ++i)
      out[i % columns] += all[i];
    return out;
  }

  /// Refuse tables that nothing has asked for.
  void check_tables(const std::vector<Block>& of_identity, const std::vector<Block>& of_state) const
  {
    std::set<std::string> known{input_table, nodes_table, x_table};
    for (const std::vector<Block>* some : {&of_identity, &of_state})
      for (const Block& block : *some)
        if (block.place() != Place::all)
        {
          known.insert(values_table(block));
          if (block.numbers())
            known.insert(numbers_table(block));
        }
    std::string unknown;
    for (const auto& [name, table] : _structure.tables)
      if (!known.contains(name))
        unknown += (unknown.empty() ? "" : ", ") + name;
    if (!unknown.empty())
      throw Damaged("it has tables that the problem does not know: " + unknown);
  }

  /// Values at nodes or facets of this rank, if the file has values at those of all ranks and no others. Collective.
  std::vector<double> rows_of(const Block& block) const
  {
    const SomeRows& some = _some.at(values_table(block));
    const std::size_t columns = block.width();
    std::vector<double> out;
    long long missing = 0;
    for (std::int64_t number : *block.numbers())
    {
      const std::int64_t wanted = block.place() == Place::node ? _then.numbers[number] : number;
      const auto at = std::ranges::lower_bound(some.order, wanted, {}, [&](std::size_t i) { return some.numbers[i]; });
      if (at == some.order.end() || some.numbers[*at] != wanted)
        ++missing;
      else
        out.insert(out.end(), some.values.begin() + std::ptrdiff_t(*at * columns),
                   some.values.begin() + std::ptrdiff_t((*at + 1) * columns));
    }
    const long long here = common::sum(_comm, static_cast<long long>(block.numbers()->size()));
    missing = common::sum(_comm, missing);
    const char* what = block.place() == Place::node ? " nodes" : " facets";
    if (missing > 0 || here != static_cast<long long>(some.numbers.size()))
      throw common::BadValue(_path + " is of another problem: " + block.name() + " has " +
                             std::to_string(some.numbers.size()) + what + ", here " + std::to_string(here) +
                             ", of which " + std::to_string(missing) + " are others");
    return out;
  }

  /// What the file has for a block on this rank. Collective.
  std::vector<double> rows_here(const Block& block) const
  {
    if (block.place() == Place::all)
      return {}; // see assign
    if (lacks(block))
      return std::vector<double>(block.numbers()->size() * block.width(), 0.0);
    return block.numbers() ? rows_of(block) : _own.at(values_table(block));
  }

  /// Supports have the values of the file. Collective.
  void check_supports(const std::vector<Block>& of_identity) const
  {
    for (const Block& block : of_identity)
    {
      const std::vector<double> found = rows_here(block), wanted = block.values();
      common::agree(_comm,
                    [&]
                    {
                      const auto other = std::ranges::mismatch(found, wanted);
                      if (other.in1 == found.end() && other.in2 == wanted.end())
                        return;
                      const std::size_t row = std::size_t(other.in1 - found.begin()) / block.width();
                      const std::size_t gdim = _V.mesh()->geometry().dim();
                      const std::vector<double> x = places(_V);
                      throw common::BadValue(_path + " is of another problem: " + block.name() + " differ" +
                                             (block.numbers()
                                                  ? ", the first at " + common::place(std::span(x).subspan(
                                                                            (*block.numbers())[row] * gdim, gdim))
                                                  : ""));
                    });
    }
  }

  /// Numbers of an attribute.
  std::vector<double> attribute_values(const Block& block) const
  {
    const Value& value = *_structure.attribute(block.name());
    std::vector<double> out;
    if (const std::int64_t* number = std::get_if<std::int64_t>(&value))
      out = {double(*number)};
    else if (const double* number = std::get_if<double>(&value))
      out = {*number};
    else if (const Numbers* numbers = std::get_if<Numbers>(&value); numbers && numbers->shape.size() <= 1)
      out = numbers->values;
    if (out.size() != block.width() || (out.empty() && !std::holds_alternative<Numbers>(value)))
      throw std::invalid_argument(block.name() + " is " + to_string(value));
    return out;
  }

  void assign(const std::vector<Block>& of_state, const std::vector<std::vector<double>>& rows) const
  {
    try
    {
      for (std::size_t k = 0; k < of_state.size(); ++k)
        of_state[k].assign(of_state[k].place() == Place::all ? attribute_values(of_state[k]) : rows[k]);
    }
    catch (const std::invalid_argument& error)
    {
      throw common::BadValue(_path + " is of no run: " + error.what());
    }
  }

  std::string _path;
  const dolfinx::fem::FunctionSpace<double>& _V;
  MPI_Comm _comm;
  const Identity& _identity;
  const ReadOptions& _options;
  std::unique_ptr<SealedFile> _file;
  Structure _structure;
  std::vector<std::int64_t> _cell_rows;  ///< rows of this rank's owned cells
  std::vector<std::int64_t> _cell_nodes; ///< numbers in the file of their nodes
  NodesThen _then;
  std::map<std::string, std::vector<double>> _own; ///< by name of the table
  std::map<std::string, SomeRows> _some;           ///< by name of the table
};
} // namespace

Saved read(const std::filesystem::path& path, const dolfinx::fem::FunctionSpace<double>& V, const state::State& like,
           const Identity& identity, const ReadOptions& options)
{
  return Reader(path, V, identity, options).run(like);
}
} // namespace dolfinx_impact::files
