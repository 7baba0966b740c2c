// SPDX-License-Identifier: MIT
#include "SaddlePoint.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
using operators::check;
typedef operators::CooMatrix::Entries Triplets;

namespace
{
/// Part of a condition's square that must be its own beside those of the same node: planes that meet at less than 1e-5
/// are one.
constexpr double least_own = 1e-10;

typedef std::map<std::int64_t, double> SparseRow; ///< by degree of freedom of all ranks

double product_of(const SparseRow& a, const SparseRow& b)
{
  double sum = 0.0;
  for (const auto& [dof, value] : a)
    if (const auto other = b.find(dof); other != b.end())
      sum += value * other->second;
  return sum;
}

/// A condition of a contact's node: along direction d of its frame.
struct Condition
{
  std::size_t contact, i;
  int d;
  bool tied, normal; ///< of a tie; along the normal of a contact
  double known;
};

/// Ends of the ranks' parts of a vector.
std::vector<PetscInt> ends(MPI_Comm comm, std::size_t size)
{
  int num_ranks = 0;
  MPI_Comm_size(comm, &num_ranks);
  std::vector<std::int64_t> all(num_ranks);
  const std::int64_t own = size;
  MPI_Allgather(&own, 1, MPI_INT64_T, all.data(), 1, MPI_INT64_T, comm);
  std::vector<PetscInt> out(num_ranks);
  std::partial_sum(all.begin(), all.end(), out.begin());
  return out;
}

/// A place in one of the two kinds of unknowns among both: `skipped` are the ends of the other kind's parts.
PetscInt moved(PetscInt place, const std::vector<PetscInt>& own_ends, const std::vector<PetscInt>& skipped, bool after)
{
  const std::size_t rank = std::upper_bound(own_ends.begin(), own_ends.end(), place) - own_ends.begin();
  return place + (after ? skipped[rank] : rank > 0 ? skipped[rank - 1] : 0);
}

template <typename F>
void for_each_entry(Mat A, F f)
{
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(A, &begin, &end), "a matrix is read");
  for (PetscInt row = begin; row < end; ++row)
  {
    PetscInt num = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(A, row, &num, &columns, &values), "a matrix is read");
    for (PetscInt k = 0; k < num; ++k)
      f(row, columns[k], values[k]);
    check(MatRestoreRow(A, row, &num, &columns, &values), "a matrix is read");
  }
}

Vec make_vector(MPI_Comm comm, std::size_t size)
{
  Vec v = nullptr;
  check(VecCreate(comm, &v), "a vector is made");
  check(VecSetSizes(v, PetscInt(size), PETSC_DETERMINE), "a vector is made");
  check(VecSetType(v, VECSTANDARD), "a vector is made");
  return v;
}
} // namespace

SaddlePoint::SaddlePoint(MPI_Comm comm, std::size_t num_owned, int gdim, std::vector<std::size_t> sizes)
    : _comm(comm), _num(num_owned), _gdim(gdim), _starts(sizes.size() + 1, 0)
{
  std::partial_sum(sizes.begin(), sizes.end(), _starts.begin() + 1);
  const std::size_t num_forces = _gdim * _starts.back();
  _u_ends = ends(comm, _num);
  _force_ends = ends(comm, num_forces);
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  _first_u = rank > 0 ? _u_ends[rank - 1] : 0;
  _first_force = rank > 0 ? _force_ends[rank - 1] : 0;
  _pinned.assign(_num + num_forces, 1);
  _forces.assign(num_forces, 0.0);
  _known.assign(num_forces, 0.0);
  for (Vec& v : _u)
    v = make_vector(comm, _num);
  for (Vec& v : _f)
    v = make_vector(comm, num_forces);
}

SaddlePoint::~SaddlePoint()
{
  for (Vec& v : _u)
    VecDestroy(&v);
  for (Vec& v : _f)
    VecDestroy(&v);
}

/// Entries of one contact's constrained jumps: slave nodes along q_d, master nodes along m_d.
void SaddlePoint::add(const Constraints& p, std::span<const std::int8_t> constrained, std::size_t start,
                      Triplets& right, Triplets& left) const
{
  const int g = _gdim;
  const auto add_node = [&](std::size_t i, std::int64_t node, const double* directions, const auto& factor)
  {
    for (int a = 0; a < g; ++a)
      for (int d = 0; d < g; ++d)
      {
        if (!constrained[i * g + d])
          continue;
        const PetscInt row = _first_force + PetscInt(g * (start + p.rows[i]) + d), column = PetscInt(g * node + a);
        const double along = directions[a * g + d], lean = d == p.normal[i] ? p.tilt[i * g + a] : 0.0;
        right.add(row, column, _diagonal * (factor(d) * along));
        left.add(row, column, _diagonal * (factor(d) * (along + lean)));
      }
  };
  for (std::size_t i = 0; i < p.size(); ++i)
    add_node(i, _first_u / g + p.nodes[i], &p.frames[i * g * g], [](int) { return 1.0; });
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::int64_t k = p.pointers[i]; k < p.pointers[i + 1]; ++k)
      add_node(i, p.columns[k], &p.over[i * g * g], [&](int d) { return -p.part(k, d); });
}

/// Masks of the conditions that do not follow from others of the same node; sets `redundant`.
std::vector<std::vector<std::int8_t>> SaddlePoint::independent(std::span<const Constraints> parts)
{
  const int g = _gdim;
  std::vector<std::vector<std::int8_t>> out;
  std::map<std::int32_t, std::vector<Condition>> by_node;
  std::map<std::int32_t, int> times;
  _redundant.assign(parts.size(), {});
  for (const Constraints& p : parts)
  {
    out.push_back(p.constrained);
    for (std::int32_t node : p.nodes)
      ++times[node];
  }
  for (std::size_t c = 0; c < parts.size(); ++c)
    for (std::size_t i = 0; i < parts[c].size(); ++i)
      for (int d = 0; d < g && times[parts[c].nodes[i]] > 1; ++d)
        if (parts[c].constrained[i * g + d])
          by_node[parts[c].nodes[i]].push_back(
              {c, i, d, parts[c].tied, !parts[c].tied && d == parts[c].normal[i], parts[c].known[i * g + d]});
  for (auto& [node, conditions] : by_node)
  {
    std::stable_sort(conditions.begin(), conditions.end(),
                     [](const Condition& a, const Condition& b)
                     {
                       if (a.tied != b.tied)
                         return a.tied;
                       return a.normal != b.normal ? a.normal : a.normal && a.known > b.known;
                     });
    std::vector<SparseRow> basis;
    std::vector<std::array<double, 3>> normals; // orthonormal
    for (const Condition& one : conditions)
    {
      const Constraints& p = parts[one.contact];
      std::array<double, 3> direction{};
      for (int a = 0; a < g; ++a)
        direction[a] = p.frames[(one.i * g + a) * g + one.d];
      for (const auto& other : normals)
      {
        const double along = std::inner_product(direction.begin(), direction.end(), other.begin(), 0.0);
        for (int a = 0; a < g; ++a)
          direction[a] -= along * other[a];
      }
      const double left = std::inner_product(direction.begin(), direction.end(), direction.begin(), 0.0);
      if (one.normal && left > least_own)
      {
        for (double& value : direction)
          value /= std::sqrt(left);
        normals.push_back(direction);
      }
      if (!one.normal && !one.tied && left < 0.5) // along the surface, but held by other normals
      {
        out[one.contact][one.i * g + one.d] = 0;
        continue;
      }
      SparseRow row;
      // What is prescribed on this rank is no unknown of a condition.
      const auto enter = [&](std::int64_t dof, double value)
      {
        const std::int64_t local = dof - _first_u;
        if (local < 0 || local >= std::int64_t(_num) || !_pinned[local])
          row[dof] += value;
      };
      for (int a = 0; a < g; ++a)
        enter(_first_u + std::int64_t(g) * node + a, p.frames[(one.i * g + a) * g + one.d]);
      for (std::int64_t k = p.pointers[one.i]; k < p.pointers[one.i + 1]; ++k)
        for (int a = 0; a < g; ++a)
          enter(g * p.columns[k] + a, -p.part(k, one.d) * p.over[(one.i * g + a) * g + one.d]);
      const double whole = product_of(row, row);
      for (const SparseRow& other : basis)
      {
        const double along = product_of(row, other);
        for (const auto& [dof, value] : other)
          row[dof] -= along * value;
      }
      const double own = product_of(row, row);
      if (own > least_own * whole && own > 0.0)
      {
        for (auto& [dof, value] : row)
          value /= std::sqrt(own);
        basis.push_back(std::move(row));
        continue;
      }
      out[one.contact][one.i * g + one.d] = 0;
      if (one.normal)
        _redundant[one.contact].push_back(p.rows[one.i]);
    }
  }
  return out;
}

void SaddlePoint::assign(std::span<const Constraints> parts, std::span<const std::int8_t> pinned,
                         std::span<const double> forces, double diagonal)
{
  if (parts.size() + 1 != _starts.size() || pinned.size() != _num || forces.size() != _forces.size())
    throw std::invalid_argument("a saddle point needs constraints of every contact, a mask of the owned degrees of "
                                "freedom and a force for every direction of the contacts' nodes");
  _diagonal = diagonal;
  std::copy(pinned.begin(), pinned.end(), _pinned.begin());
  std::fill(_pinned.begin() + _num, _pinned.end(), std::int8_t(1));
  std::fill(_known.begin(), _known.end(), 0.0);
  Triplets right, left;
  const auto constrained = independent(parts);
  for (std::size_t c = 0; c < parts.size(); ++c)
  {
    const Constraints& p = parts[c];
    for (std::size_t i = 0; i < p.size(); ++i)
    {
      if (p.gdim != _gdim || _starts[c] + p.rows[i] >= _starts[c + 1] || std::size_t(p.nodes[i] + 1) * _gdim > _num)
        throw std::invalid_argument("constraints are of owned nodes of the contact and of the space");
      for (int d = 0; d < _gdim; ++d)
      {
        const std::size_t at = _gdim * (_starts[c] + p.rows[i]) + d;
        _pinned[_num + at] = !constrained[c][i * _gdim + d];
        _known[at] = constrained[c][i * _gdim + d] ? _diagonal * p.known[i * _gdim + d] : 0.0;
      }
    }
    add(p, constrained[c], _starts[c], right, left);
  }
  for (std::size_t i = 0; i < _forces.size(); ++i)
    _forces[i] = _pinned[_num + i] ? 0.0 : forces[i];
  const PetscInt rows = PetscInt(_forces.size()), columns = PetscInt(_num);
  _right.assign(_comm, rows, columns, 1, std::move(right));
  _left.assign(_comm, rows, columns, 1, std::move(left));
}

/// y = A x without pins.
void SaddlePoint::product(std::span<const Mat> stiffness, std::span<const double> x, std::vector<double>& y)
{
  const auto [increment, force, other] = _u;
  const auto [multipliers, jump] = _f;
  {
    operators::Entries du(increment), df(multipliers);
    std::copy_n(x.begin(), _num, &du[0]);
    std::copy(x.begin() + _num, x.end(), &df[0]);
  }
  check(VecSet(force, 0.0), "a product is taken");
  for (std::size_t i = 0; i < stiffness.size(); ++i)
    check(i == 0 ? MatMult(stiffness[i], increment, force) : MatMultAdd(stiffness[i], increment, force, force),
          "a product is taken");
  check(MatMultTranspose(left(), multipliers, other), "a product is taken");
  check(MatMult(right(), increment, jump), "a product is taken");
  operators::Entries f(force), o(other), j(jump);
  for (std::size_t i = 0; i < _num; ++i)
    y[i] = f[i] - o[i];
  for (std::size_t i = _num; i < y.size(); ++i)
    y[i] = -j[i - _num];
}

void SaddlePoint::mult(std::span<const Mat> stiffness, Vec x, Vec y)
{
  std::vector<double> values(num_unknowns()), out(num_unknowns());
  const PetscScalar* given = nullptr;
  check(VecGetArrayRead(x, &given), "a vector is asked for its entries");
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = _pinned[i] ? 0.0 : given[i];
  check(VecRestoreArrayRead(x, &given), "a vector is asked for its entries");
  product(stiffness, values, out);
  check(VecGetArrayRead(x, &given), "a vector is asked for its entries");
  {
    operators::Entries entries(y);
    for (std::size_t i = 0; i < out.size(); ++i)
      entries[i] = _pinned[i] ? _diagonal * given[i] : out[i];
  }
  check(VecRestoreArrayRead(x, &given), "a vector is asked for its entries");
}

void SaddlePoint::load(std::span<const Mat> stiffness, std::span<const double> residual, Vec values, Vec b)
{
  if (residual.size() != _num)
    throw std::invalid_argument("a residual has an entry for every owned degree of freedom");
  std::vector<double> fixed(num_unknowns(), 0.0), out(num_unknowns());
  const PetscScalar* given = nullptr;
  check(VecGetArrayRead(values, &given), "a vector is asked for its entries");
  for (std::size_t i = 0; i < _num; ++i)
    fixed[i] = _pinned[i] ? given[i] : 0.0;
  check(VecRestoreArrayRead(values, &given), "a vector is asked for its entries");
  std::copy(_forces.begin(), _forces.end(), fixed.begin() + _num);
  product(stiffness, fixed, out);
  operators::Entries entries(b);
  for (std::size_t i = 0; i < out.size(); ++i)
  {
    const bool displacement = i < _num;
    const double free = (displacement ? -residual[i] : -_known[i - _num]) - out[i];
    entries[i] = !_pinned[i] ? free : displacement ? _diagonal * fixed[i] : 0.0;
  }
}

Mat SaddlePoint::assemble(std::span<const Mat> stiffness)
{
  // Unknowns of a rank stand together: displacements move back by the forces of the ranks before, forces by the
  // displacements up to their own rank's.
  const auto place_u = [&](PetscInt dof) { return moved(dof, _u_ends, _force_ends, false); };
  const auto place_f = [&](PetscInt row) { return moved(row, _force_ends, _u_ends, true); };
  Triplets entries;
  for (Mat K : stiffness)
    for_each_entry(K, [&](PetscInt i, PetscInt j, double v) { entries.add(place_u(i), place_u(j), v); });
  for_each_entry(right(), [&](PetscInt i, PetscInt j, double v) { entries.add(place_f(i), place_u(j), -v); });
  for_each_entry(left(), [&](PetscInt i, PetscInt j, double v) { entries.add(place_u(j), place_f(i), -v); });
  const PetscInt first = _first_u + _first_force, num = PetscInt(num_unknowns());
  std::vector<PetscInt> pinned;
  for (PetscInt i = first; i < first + num; ++i)
  {
    entries.add(i, i, 0.0); // a place on the diagonal for every row
    if (_pinned[i - first])
      pinned.push_back(i);
  }
  _matrix.assign(_comm, num, num, 1, std::move(entries));
  Mat A = nullptr;
  check(MatDuplicate(_matrix.matrix(), MAT_COPY_VALUES, &A), "a matrix is copied");
  check(MatZeroRowsColumns(A, PetscInt(pinned.size()), pinned.data(), _diagonal, nullptr, nullptr),
        "unknowns are pinned");
  return A;
}

std::vector<double> SaddlePoint::unknowns(std::span<const double> increments, std::span<const double> forces) const
{
  if (increments.size() != _num || forces.size() != _forces.size())
    throw std::invalid_argument("an increment of every owned degree of freedom and a force of every direction needed");
  std::vector<double> y(increments.begin(), increments.end());
  y.resize(num_unknowns(), 0.0);
  for (std::size_t i = 0; i < _forces.size(); ++i)
    if (!_pinned[_num + i])
      y[_num + i] = forces[i] - _forces[i];
  return y;
}

std::vector<double> SaddlePoint::forces(Vec y) const
{
  std::vector<double> out(_forces);
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(y, &values), "a vector is asked for its entries");
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] += values[_num + i];
  check(VecRestoreArrayRead(y, &values), "a vector is asked for its entries");
  return out;
}
} // namespace dolfinx_impact::enforcement
