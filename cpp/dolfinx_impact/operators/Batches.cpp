// SPDX-License-Identifier: MIT
#include "Batches.h"
#include "../common/dolfinx_api.h"
#include "../kernels/KernelTable.h"
#include "../kernels/check.h"
#include "lanes.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/mesh/cell_types.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
/// Are the values the solution of the local equations (UNKNOWN of forms/inelastic.py)?
bool is_local_unknown(const impact_output& output)
{
  return std::strcmp(output.name, "local_unknown") == 0;
}

/// Have the cells of a mesh the same node numbers in both spaces?
bool same_nodes(const FunctionSpace& a, const FunctionSpace& b)
{
  if (a.dofmap() == b.dofmap())
    return true;
  if (a.mesh() != b.mesh())
    return false;
  const auto& cells = *a.mesh()->topology()->index_map(a.mesh()->topology()->dim());
  for (std::int32_t c = 0; c < cells.size_local() + cells.num_ghosts(); ++c)
    if (!std::ranges::equal(a.dofmap()->cell_dofs(c), b.dofmap()->cell_dofs(c)))
      return false;
  return true;
}

/// Values of a coefficient, as sweeps read them; null: they lie otherwise. Scalars need no padding.
const double* swept_values(const Batches::Array& a)
{
  if (a.stride != padded_stride(a.block_size))
    return nullptr;
  return a.block_size == 1 && !a.values ? a.function->x()->array().data() : a.values;
}

/// Node numbers of padded entities, lane by lane: those of the `sides` cells of each, one cell after the other.
template <typename Dofs>
void number_nodes(const Dofs& dofs_of, std::span<const std::int32_t> cells, int sides, int width, int num_nodes,
                  std::vector<std::int32_t>& out)
{
  const std::size_t start = out.size();
  out.resize(start + cells.size() / sides * num_nodes);
  const int per_cell = num_nodes / sides;
  for (std::size_t k = 0; k < cells.size(); ++k)
  {
    auto dofs = dofs_of(cells[k]);
    const std::size_t entity = k / sides, side = k % sides, batch = entity / width, lane = entity % width;
    for (int i = 0; i < per_cell; ++i)
      out[start + (batch * num_nodes + side * per_cell + i) * width + lane] = dofs[i];
  }
}
} // namespace

Batches::Batches(const Integral& integral, std::shared_ptr<const Mesh> mesh,
                 const std::shared_ptr<const FunctionSpace>& test,
                 const std::map<std::string, std::shared_ptr<const Function>>& coefficients, int width)
    : _kernel(integral.kernel), _mesh(std::move(mesh))
{
  const impact_kernel& k = *_kernel;
  kernels::check_mesh(k, *_mesh);
  if (k.rank > 1)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is of rank " + std::to_string(k.rank) +
                                "; this operator takes energies (rank 0) and vectors (rank 1)");
  if ((k.rank == 1) != bool(test))
    throw std::invalid_argument(std::string("kernel ") + k.name + " of rank " + std::to_string(k.rank) +
                                (k.rank ? " needs a test space" : " takes no test space"));
  // History lies in the order of batches: who shares it takes batches of the same width.
  _width = kernels::width(k, width == 0 && integral.history ? integral.history->width() : width);
  _tabulate = kernels::tabulate(k, _width);
  set_constants(integral.constants);
  const std::string type = k.integral_type;
  _sides = type == "interior_facet" ? 2 : 1;

  _x.num_nodes = _sides * common::geometry_dofmap(*_mesh).extent(1);
  _x.block_size = 3;
  _x.gather = gather(_width, 3, 3);
  if (test)
  {
    kernels::check_space(k, k.arguments[0], *test, "test space");
    if (test->mesh() != _mesh)
      throw std::invalid_argument(std::string("kernel ") + k.name + ": the test space is on another mesh");
    _test.block_size = test->dofmap()->bs();
    _test.num_nodes = k.shape[0] / _test.block_size;
    _test_space = test;
    _scatter = scatter(_width, _test.block_size, _test.block_size);
    _padded_scatter = scatter(_width, _test.block_size, padded_stride(_test.block_size));
  }
  set_history(integral);
  for (int i = 0; i < k.num_coefficients; ++i)
  {
    const impact_coefficient& c = k.coefficients[i];
    const impact_output* output =
        std::find_if(k.outputs, k.outputs + k.num_outputs, [i](const impact_output& o) { return o.coefficient == i; });
    if (output != k.outputs + k.num_outputs)
    {
      Array a;
      a.name = c.name;
      a.offset = c.offset;
      a.field = int(_history->find(output->name));
      _coefficients.push_back(std::move(a));
      continue;
    }
    auto found = coefficients.find(c.name);
    if (found == coefficients.end() || !found->second)
      throw std::invalid_argument(std::string("kernel ") + k.name + " needs a coefficient named '" + c.name + "'");
    const auto& V = found->second->function_space();
    kernels::check_space(k, c.element, *V, std::string("coefficient ") + c.name);
    if (V->mesh() != _mesh)
      throw std::invalid_argument(std::string("kernel ") + k.name + ": coefficient " + c.name + " is on another mesh");
    Array a;
    a.block_size = V->dofmap()->bs();
    a.num_nodes = _sides * c.element.num_dofs / a.block_size;
    a.stride = a.block_size;
    a.gather = gather(_width, a.block_size, a.block_size);
    a.name = c.name;
    a.function = found->second;
    a.offset = c.offset;
    a.as_test = test && same_nodes(*V, *test);
    _coefficients.push_back(std::move(a));
  }
  if ((!_history || _stores) &&
      std::ranges::all_of(_coefficients, [](const Array& a) { return a.field >= 0 || a.as_test; }))
    _kernel_sweep = kernels::sweep(k, _width);

  const auto gathered = [](const Array& a) { return a.field < 0; };
  _at_nodes = std::size_t(std::ranges::find_if(_coefficients, gathered) - _coefficients.begin());
  if (type == "cell" && k.rank == 1 && std::ranges::count_if(_coefficients, gathered) == 1 &&
      _coefficients[_at_nodes].as_test && _coefficients[_at_nodes].block_size == _test.block_size)
    _sweep = sweep(_width, _test.block_size, padded_stride(_test.block_size));

  const std::vector<std::int32_t>& entities = integral.entities;
  if (type == "interior_facet")
  {
    if (entities.size() % 3)
      throw std::invalid_argument("integrals over interior facets take triples (cell, cell, entity)");
    std::map<int, std::vector<std::int32_t>> groups; // all lanes of a batch share the local facets and permutations
    for (std::size_t i = 0; i < entities.size(); i += 3)
    {
      check_cell(entities[i]);
      check_cell(entities[i + 1]);
      std::vector<std::int32_t>& cells = groups[entities[i + 2]];
      cells.insert(cells.end(), {entities[i], entities[i + 1]});
    }
    for (const auto& [entity, cells] : groups)
      add_group(cells, entity);
  }
  else if (type != "exterior_facet")
  {
    for (const std::int32_t cell : entities)
      check_cell(cell);
    add_group(entities, 0);
  }
  else
  {
    if (entities.size() % 2)
      throw std::invalid_argument("facet integrals take pairs (cell, local facet)");
    const int tdim = _mesh->topology()->dim();
    const int num_facets = dolfinx::mesh::cell_num_entities(common::coordinate_element(*_mesh).cell_shape(), tdim - 1);
    std::vector<std::vector<std::int32_t>> by_facet(num_facets); // all lanes of a batch share the local facet
    for (std::size_t i = 0; i < entities.size(); i += 2)
    {
      const std::int32_t f = entities[i + 1];
      check_cell(entities[i]);
      if (f < 0 || f >= num_facets)
        throw std::invalid_argument("local facet " + std::to_string(f) + " does not exist");
      by_facet[f].push_back(entities[i]);
    }
    for (int f = 0; f < num_facets; ++f)
      add_group(by_facet[f], f);
  }

  const std::size_t entries = whole_lines(std::size_t(k.size_A) * _width) +
                              whole_lines(std::size_t(k.size_w) * _width) +
                              whole_lines(std::size_t(3) * _x.num_nodes * _width);
  _buffer.resize((_sweep ? 2 : 1) * entries + 8);
}

void Batches::set_history(const Integral& integral)
{
  const impact_kernel& k = *_kernel;
  _failures.unknowns.resize(k.local_unknowns);
  _sums.resize(k.num_sums);
  if (k.num_outputs == 0 && k.local_unknowns == 0)
  {
    if (integral.history)
      throw std::invalid_argument(std::string("kernel ") + k.name + " has no outputs: it reads no history");
    return;
  }
  _history = integral.history;
  _stores = !_history;
  if (_stores)
  {
    _history = std::make_shared<PointHistory>(k, integral.entities, _width);
    _places.resize(k.num_outputs);
    return;
  }
  const PointHistory& h = *_history;
  if (!std::ranges::equal(h.cells(), integral.entities) || h.width() != _width || h.num_points() != k.num_points)
    throw std::invalid_argument(std::string("kernel ") + k.name +
                                ": the history that is shared has other cells, another number of points or another "
                                "width: use the same form's cells, quadrature rule and width");
  for (int i = 0; i < k.num_outputs; ++i)
    if (k.outputs[i].coefficient >= 0)
      if (const std::size_t f = h.find(k.outputs[i].name);
          !h.is_history(f) || h.num_components(f) != k.outputs[i].num_components)
        throw std::invalid_argument(std::string("kernel ") + k.name + ": '" + k.outputs[i].name +
                                    "' of the shared history is another quantity");
}

void Batches::load_history(std::size_t batch, double* w) const
{
  for (const Array& a : _coefficients)
    if (a.field >= 0)
      std::copy_n(_history->committed(a.field, batch), _history->batch_size(a.field),
                  w + std::size_t(a.offset) * _width);
  if (batch + 1 < _used.size())
    prefetch_history(batch + 1); // arrives while the kernel computes
}

void Batches::prefetch_history(std::size_t batch) const
{
  for (const Array& a : _coefficients)
    if (a.field >= 0)
    {
      const double* values = _history->committed(a.field, batch);
      for (std::size_t i = 0; i < _history->batch_size(a.field); i += alignment / sizeof(double))
        __builtin_prefetch(values + i, 1);
    }
}

void Batches::store_outputs(std::size_t batch, const double* A) const
{
  for (int i = 0; i < _kernel->num_outputs; ++i)
  {
    // Solutions of the local equations are for tangents, which explicit problems do not make.
    if (_history->in_place() and _kernel->outputs[i].coefficient < 0 and is_local_unknown(_kernel->outputs[i]))
      continue;
    const double* values = A + std::size_t(_kernel->outputs[i].offset) * _width;
    const std::size_t size = _history->batch_size(i);
    double* place = _history->trial(i, batch);
    // In place, the history of cells that do not flow is there already: what is not written need not go to memory.
    if (!_history->in_place() || std::memcmp(place, values, size * sizeof(double)) != 0)
      std::copy_n(values, size, place);
  }
}

void Batches::add_sums(std::size_t batch, const double* A) const
{
  for (int i = 0; i < _kernel->num_sums; ++i)
    for (int lane = 0; lane < _used[batch]; ++lane)
      _sums[i] += A[std::size_t(_kernel->sums[i].offset) * _width + lane];
}

double Batches::sum(const std::string& name) const
{
  double total = 0.0;
  for (int i = 0; i < _kernel->num_sums; ++i)
    if (_kernel->sums[i].name == name)
      total += _sums[i];
  return total;
}

void Batches::record_failures(std::size_t batch, const double* A) const
{
  const int n = _kernel->local_unknowns;
  const double* report = A + std::size_t(_kernel->size_A - 3 - n) * _width;
  for (int lane = 0; lane < _used[batch]; ++lane)
  {
    if (!(report[lane] > 0.0))
      continue;
    if (_failures.count == 0)
    {
      _failures.cell = _history->cells()[batch * _width + lane];
      _failures.point = int(report[_width + lane]);
      _failures.residual = report[2 * _width + lane];
      for (int i = 0; i < n; ++i)
        _failures.unknowns[i] = report[(3 + i) * _width + lane];
    }
    _failures.count += std::size_t(report[lane]);
  }
}

void Batches::check_cell(std::int32_t cell) const
{
  const auto map = _mesh->topology()->index_map(_mesh->topology()->dim());
  const std::int32_t num_cells = map->size_local() + map->num_ghosts();
  if (cell < 0 || cell >= num_cells)
    throw std::invalid_argument(std::string("kernel ") + _kernel->name + ": cell " + std::to_string(cell) +
                                " is not on this rank, which has cells 0 to " + std::to_string(num_cells - 1));
}

void Batches::add_group(std::span<const std::int32_t> cells, int facet)
{
  if (cells.empty())
    return;
  const std::size_t num = cells.size() / _sides, batches = (num + _width - 1) / _width;
  _num_entities += num;
  std::vector<std::int32_t> padded(cells.begin(), cells.end());
  padded.reserve(batches * _width * _sides);
  while (padded.size() < batches * _width * _sides)
    padded.push_back(padded[padded.size() - _sides]);
  for (std::size_t k = 0; k < batches; ++k)
  {
    _used.push_back(std::min<std::size_t>(_width, num - k * _width));
    _facet.push_back(facet);
  }
  auto x_dofmap = common::geometry_dofmap(*_mesh);
  number_nodes([&](std::int32_t c) { return &x_dofmap(c, 0); }, padded, _sides, _width, _x.num_nodes, _x.dofs);
  if (_test_space)
  {
    const auto& map = *_test_space->dofmap();
    number_nodes([&](std::int32_t c) { return map.cell_dofs(c); }, padded, _sides, _width, _test.num_nodes, _test.dofs);
  }
  for (Array& a : _coefficients)
  {
    if (a.as_test || a.field >= 0)
      continue;
    auto& map = *a.function->function_space()->dofmap();
    number_nodes([&](std::int32_t c) { return map.cell_dofs(c); }, padded, _sides, _width, a.num_nodes, a.dofs);
  }
}

void Batches::set_constants(std::span<const double> c)
{
  if (int(c.size()) != _kernel->size_c)
    throw std::invalid_argument(std::string("kernel ") + _kernel->name + " takes " + std::to_string(_kernel->size_c) +
                                " values of constants, found " + std::to_string(c.size()));
  _constants.assign(c.begin(), c.end());
}

void Batches::read(const std::string& name, const double* values, int stride)
{
  for (Array& a : _coefficients)
    if (a.name == name && a.field < 0)
    {
      a.values = values;
      a.stride = values && stride > 0 ? stride : a.block_size;
      a.gather = gather(_width, a.block_size, a.stride);
    }
}

void Batches::read_positions(const NodePositions* positions)
{
  // Where each facet has the nodes of two cells, those of the second come after all of the first one's.
  const bool by_test = positions && positions->space() && _test_space &&
                       same_nodes(*positions->space(), *_test_space) &&
                       (_sides == 1 || _x.num_nodes == _test.num_nodes);
  const bool readable = positions && (by_test || !positions->space());
  _x.as_test = by_test;
  _x.values = readable ? positions->values().data() : nullptr;
  _positions = readable ? positions : nullptr;
  _x.gather = gather(_width, 3, readable ? 4 : 3);
}

void Batches::set_mixed()
{
  const impact_float_kernel* kernel = kernels::find_float(*_kernel);
  if (!kernel)
    throw std::invalid_argument(std::string("kernel ") + _kernel->name + " does not exist in float: precision=" +
                                "'mixed' is for LinearElastic and NeoHookean with integration='full' or 'reduced' on " +
                                "straight hexahedra and tetrahedra");
  if (!_coefficients[0].as_test)
    throw std::invalid_argument(std::string("kernel ") + _kernel->name + " in float reads and tests with one space");
  if (_num_entities == 0)
    return; // all the same: nothing is computed
  // The largest extent of the first cell, of a mesh whose cells are of a size: only the order of magnitude counts.
  const std::span<const double> x = _mesh->geometry().x();
  double size = 0.0;
  for (int i = 1; i < _x.num_nodes; ++i)
    for (int k = 0; k < 3; ++k)
      size = std::max(size, std::abs(x[3 * _x.dofs[i * _width] + k] - x[3 * _x.dofs[0] + k]));
  const FloatCells::Nodes nodes{_test.dofs, _test.num_nodes, _width}, mesh_nodes{_x.dofs, _x.num_nodes, _width};
  _float_cells.set(FloatCells(*kernel, _num_entities, nodes, mesh_nodes, size));
}

bool Batches::has(const std::string& name) const
{
  return std::ranges::any_of(_coefficients, [&](const Array& a) { return a.name == name; });
}

bool Batches::has_nodes_of_test(const Function& function) const
{
  return std::ranges::any_of(_coefficients, [&](const Array& a) { return a.function.get() == &function && a.as_test; });
}

const double* Batches::padded_values(const std::string& name) const
{
  for (const Array& a : _coefficients)
    if (a.name == name && a.field < 0 && a.as_test && a.stride == padded_stride(a.block_size))
      return a.values;
  return nullptr;
}

Batches::Nodes Batches::nodes_of(const std::string& name) const
{
  for (const Array& a : _coefficients)
    if (a.name == name && a.field < 0)
      return {a.as_test ? _test.dofs : a.dofs, a.num_nodes, a.block_size};
  throw std::invalid_argument(std::string("kernel ") + _kernel->name + " has no coefficient '" + name + "' at nodes");
}

void Batches::each_matrix(const std::string& name, const MatrixOfCell& work) const
{
  const Nodes columns = nodes_of(name);
  if (_kernel->rank != 1 || _history || _sides != 1)
    throw std::invalid_argument(std::string("kernel ") + _kernel->name +
                                " has no matrix of a cell: it is of rank 1, over cells, without internal variables");
  const Array& of = *std::ranges::find(_coefficients, name, &Array::name);
  const std::size_t W = std::size_t(_width), size_A = std::size_t(_kernel->shape[0]);
  const std::size_t num_columns = std::size_t(columns.num_nodes) * columns.block_size;
  double* A = aligned(_buffer.data());
  double* w = A + whole_lines(std::size_t(_kernel->size_A) * W);
  double* x = w + whole_lines(std::size_t(_kernel->size_w) * W);
  std::vector<double> matrices(W * size_A * num_columns);
  std::vector<std::int32_t> rows_of_cell(_test.num_nodes), columns_of_cell(columns.num_nodes);
  for (std::size_t batch = 0; batch < _used.size(); ++batch)
  {
    const std::vector<std::int32_t>& x_nodes = _x.as_test ? _test.dofs : _x.dofs;
    _x.gather(_x.values ? _x.values : _mesh->geometry().x().data(), x_nodes.data() + batch * _x.num_nodes * W,
              _x.num_nodes, x);
    for (std::size_t k = 0; k < num_columns; ++k)
    {
      std::fill_n(w, std::size_t(_kernel->size_w) * W, 0.0);
      std::fill_n(w + (of.offset + k) * W, W, 1.0);
      std::fill_n(A, size_A * W, 0.0);
      _tabulate(A, w, _constants.data(), x, _facet[batch]);
      for (std::size_t i = 0; i < size_A; ++i)
        for (std::size_t l = 0; l < W; ++l)
          matrices[(l * size_A + i) * num_columns + k] = A[i * W + l];
    }
    for (int l = 0; l < _used[batch]; ++l)
    {
      for (int i = 0; i < _test.num_nodes; ++i)
        rows_of_cell[i] = _test.dofs[(batch * _test.num_nodes + i) * W + l];
      for (int j = 0; j < columns.num_nodes; ++j)
        columns_of_cell[j] = columns.numbers[(batch * columns.num_nodes + j) * W + l];
      work(rows_of_cell, columns_of_cell, std::span(matrices).subspan(l * size_A * num_columns, size_A * num_columns));
    }
  }
  std::fill_n(A, size_A * W, 0.0);
}

/// What a kernel has written of a batch beside the element tensor.
void Batches::store_results(std::size_t batch, const double* A) const
{
  if (_stores)
    store_outputs(batch, A);
  add_sums(batch, A);
  if (_kernel->local_unknowns > 0)
    record_failures(batch, A);
}

bool Batches::run_kernel_sweep(std::size_t num_batches, double* b) const
{
  if (!_kernel_sweep || !_x.as_test || (_history && !_history->in_place()))
    return false;
  const auto report = [](const void* owner, unsigned long long batch, const double* A)
  { static_cast<const Batches*>(owner)->record_failures(batch, A); };
  impact_cells cells{num_batches, _test.dofs.data(), _constants.data(), _x.values,    nullptr, b,
                     nullptr,     _places.data(),    nullptr,           _sums.data(), report,  this};
  for (int i = 0; i < int(_places.size()); ++i)
    _places[i] = _history->is_history(i) ? _history->overwritten(i) : nullptr;
  if (_history)
    cells.has_history = _history->batches_with_history();
  for (const Array& a : _coefficients)
  {
    if (a.field >= 0)
      continue;
    const double*& place = a.block_size == 1 ? cells.scalars : cells.values;
    place = swept_values(a);
    if (!place)
      return false;
  }
  _kernel_sweep(&cells);
  _swept = true;
  return true;
}

/// @returns number of batches that it has run
std::size_t Batches::run_whole_batches(double* b, int stride, double* A, double* w, double* x) const
{
  if (_used.empty() || !_x.values || stride != padded_stride(_test.block_size))
    return 0;
  const std::size_t num_batches = _used.size() - (_used.back() < _width ? 1 : 0);
  if (num_batches == 0 || run_kernel_sweep(num_batches, b))
    return num_batches;
  if (!_sweep || !swept_values(_coefficients[_at_nodes]))
    return 0;
  Sweep s;
  s.tabulate = _tabulate;
  s.num_batches = num_batches;
  s.position_nodes = (_x.as_test ? _test : _x).dofs.data();
  s.num_position_nodes = _x.num_nodes;
  s.positions_per_batch = std::size_t((_x.as_test ? _test : _x).num_nodes) * _width;
  s.nodes = _test.dofs.data();
  s.num_nodes = _test.num_nodes;
  s.constants = _constants.data();
  s.positions = _x.values;
  s.values = _coefficients[_at_nodes].values;
  s.b = b;
  s.A = A;
  const std::size_t behind = (_buffer.size() - 8) / 2; // the second half of the buffer is like the first one
  for (int half = 0; half < 2; ++half)
  {
    s.all_w[half] = w + half * behind;
    s.w[half] = s.all_w[half] + std::size_t(_coefficients[_at_nodes].offset) * _width;
    s.x[half] = x + half * behind;
  }
  s.owner = this;
  if (_history)
    s.load = [](const void* owner, std::size_t batch, double* to)
    { static_cast<const Batches*>(owner)->load_history(batch, to); };
  if (_history || _kernel->num_sums > 0)
    s.store = [](const void* owner, std::size_t batch, const double* from)
    { static_cast<const Batches*>(owner)->store_results(batch, from); };
  _sweep(s);
  return num_batches;
}

double Batches::run(double* b, int stride) const
{
  const impact_kernel& k = *_kernel;
  if (_float_cells)
  {
    const Array& a = _coefficients[0];
    const NodeValues positions{_x.values ? _x.values : _mesh->geometry().x().data(), _x.values ? 4 : 3};
    _float_cells->run({positions, _x.as_test, _positions ? _positions->version() : 0},
                      {a.values ? a.values : a.function->x()->array().data(), a.stride}, _constants.data(), b, stride);
    return 0.0;
  }
  const std::size_t size_A = std::size_t(k.shape[0]) * _width;
  double* A = aligned(_buffer.data());
  double* w = A + whole_lines(std::size_t(k.size_A) * _width);
  double* x = w + whole_lines(std::size_t(k.size_w) * _width);
  const double* nodes = _x.values ? _x.values : _mesh->geometry().x().data();
  const scatter_function scatter = stride == _test.block_size ? _scatter : _padded_scatter;
  double sum = 0.0;
  std::fill_n(A, size_A, 0.0); // and again by what reads it
  _failures.count = 0;
  _swept = false;
  std::ranges::fill(_sums, 0.0);
  for (std::size_t batch = run_whole_batches(b, stride, A, w, x); batch < _used.size(); ++batch)
  {
    const std::int32_t* x_nodes = _x.as_test ? _test.dofs.data() + batch * _test.num_nodes * _width
                                             : _x.dofs.data() + batch * _x.num_nodes * _width;
    _x.gather(nodes, x_nodes, _x.num_nodes, x);
    for (const Array& a : _coefficients)
    {
      if (a.field >= 0)
        continue;
      a.gather(a.values ? a.values : a.function->x()->array().data(),
               (a.as_test ? _test.dofs : a.dofs).data() + batch * a.num_nodes * _width, a.num_nodes,
               w + std::size_t(a.offset) * _width);
    }
    if (_history)
      load_history(batch, w);
    _tabulate(A, w, _constants.data(), x, _facet[batch]);
    if (k.rank == 1)
      scatter(A, _test.dofs.data() + batch * _test.num_nodes * _width, _test.num_nodes, _used[batch], b);
    else
    {
      for (int l = 0; l < _used[batch]; ++l)
        sum += A[l];
      std::fill_n(A, size_A, 0.0);
    }
    store_results(batch, A);
  }
  if (_stores)
    _history->set_evaluated();
  return sum;
}
} // namespace dolfinx_impact::operators
