// SPDX-License-Identifier: MIT
#include "BodyResponse.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <unordered_map>

namespace dolfinx_impact::rolling
{
namespace
{
using operators::check;
using operators::OwnedMatrix;
using operators::OwnedVector;

constexpr PetscInt block = 96; ///< right sides that are solved together
/// Iterations with factors of an earlier matrix before new ones are made.
constexpr int patience = 12;
constexpr const char* prefix = "impact_bodies_";
/// K is symmetric; the directions of contact forces are found to round-off.
const solve::LinearSolver::Options options{
    {"pc_type", "cholesky"}, {"mat_mumps_icntl_14", "50"}, {"ksp_rtol", "1e-13"}, {"ksp_max_it", "200"}};

solve::LinearSolverLimits limits()
{
  solve::LinearSolverLimits out;
  out.patience = patience;
  return out;
}

/// Dense matrix over the ranks, with all columns on each.
OwnedMatrix dense(MPI_Comm comm, PetscInt rows, PetscInt columns)
{
  Mat made = nullptr;
  check(MatCreateDense(comm, rows, PETSC_DECIDE, PETSC_DETERMINE, columns, nullptr, &made), "a matrix is made");
  return OwnedMatrix(made);
}

/// Entries of a dense matrix, column after column, as long as this lives.
class DenseEntries
{
public:
  explicit DenseEntries(Mat m) : _m(m)
  {
    check(MatDenseGetLDA(m, &_rows), "a matrix is asked for its rows");
    check(MatDenseGetArray(m, &_values), "a matrix is asked for its entries");
  }
  ~DenseEntries() { MatDenseRestoreArray(_m, &_values); }
  DenseEntries(const DenseEntries&) = delete;
  DenseEntries& operator=(const DenseEntries&) = delete;
  double& operator()(PetscInt i, PetscInt j) { return _values[j * _rows + i]; }

private:
  Mat _m;
  PetscInt _rows = 0;
  double* _values = nullptr;
};

/// A matrix of jumps of a contact times displacement fields, over the cover: [node*gdim*fields + c*fields + field].
/// Collective.
/// @param[in] moved displacements, a column for each field
std::vector<double> relative(const RollingContact& c, Mat matrix, Mat moved, PetscInt num)
{
  const auto& geometry = c.geometry();
  const PetscInt g = geometry.gdim(), nodes = c.geometry().map()->size_local();
  const OwnedMatrix fields = dense(geometry.comm(), nodes, g * num);
  {
    DenseEntries from(moved), to(fields.get());
    for (PetscInt j = 0; j < num; ++j)
      for (PetscInt a = 0; a < g; ++a)
        for (PetscInt i = 0; i < nodes; ++i)
          to(i, a * num + j) = from(i * g + a, j);
  }
  check(MatAssemblyBegin(fields.get(), MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  check(MatAssemblyEnd(fields.get(), MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  Mat made = nullptr;
  check(MatMatMult(matrix, fields.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &made), "matrices are multiplied");
  const OwnedMatrix product(made);
  DenseEntries values(made);
  std::vector<double> out(geometry.num_nodes() * g * num, 0.0);
  for (std::size_t i = 0; i < geometry.num_nodes(); ++i)
    if (geometry.now().participates[i])
      for (PetscInt k = 0; k < g * num; ++k)
        out[i * g * num + k] = values(geometry.nodes()[i], k) / geometry.now().cover[i];
  return out;
}
/// An entry of this rank's rows in one of the columns that are wanted.
struct Entry
{
  PetscInt column; ///< its place among those that are wanted
  PetscInt row;    ///< local
  double value;
};

/// Entries of some columns of a matrix in rows that are not pinned, column after column.
std::vector<Entry> wanted_entries(Mat matrix, std::span<const PetscInt> wanted, std::span<const std::int8_t> pinned)
{
  std::unordered_map<PetscInt, PetscInt> places;
  for (std::size_t k = 0; k < wanted.size(); ++k)
    places.emplace(wanted[k], PetscInt(k));
  std::vector<Entry> out;
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(matrix, &begin, &end), "a matrix is asked for its rows");
  for (PetscInt row = begin; row < end; ++row)
  {
    if (pinned[row - begin])
      continue;
    PetscInt count = 0;
    const PetscInt* at = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix, row, &count, &at, &values), "a row is read");
    for (PetscInt k = 0; k < count; ++k)
      if (const auto place = places.find(at[k]); place != places.end())
        out.push_back({place->second, row - begin, values[k]});
    check(MatRestoreRow(matrix, row, &count, &at, &values), "a row is read");
  }
  std::ranges::stable_sort(out, {}, &Entry::column);
  return out;
}
} // namespace

BodyResponse::BodyResponse(const surface::FunctionSpace& V, std::vector<std::int8_t> fixed)
    : _pinned(std::move(fixed)), _solver(V, options, prefix, false, limits())
{
  for (std::size_t i = 0; i < _pinned.size(); ++i)
    if (_pinned[i])
      _fixed.push_back(std::int32_t(i));
}

void BodyResponse::update(Mat K, const std::vector<Mat>& extra)
{
  _system = std::make_unique<solve::PerturbedSystem>(K, extra, _pinned, 1.0);
  if (!_solver.factors())
    _solver.set_up(*_system);
}

BodyResponse::Solution BodyResponse::solve(std::vector<double> load, std::span<const double> jump)
{
  const OwnedVector b(_system->create_vector()), x(_system->create_vector());
  if (!jump.empty())
  {
    operators::Entries values(x.get());
    for (std::size_t k = 0; k < _fixed.size(); ++k)
      values[_fixed[k]] = jump[k];
  }
  for (double& f : load)
    f = -f;
  _system->load(load, x.get(), b.get());
  std::string fault = _solver.solve(*_system, b.get(), x.get());
  return {_system->displacements(x.get()), std::move(fault)};
}

Compliance BodyResponse::compliance(const ContactOperators& operators, const Candidates& candidates)
{
  const MPI_Comm comm = operators.contacts().front()->geometry().comm();
  Mat factors = _solver.factors();
  const std::vector<PetscInt> wanted = operators.columns(candidates);
  const PetscInt num_owned = PetscInt(_pinned.size()), g = operators.gdim();
  const std::size_t total = wanted.size();
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  Compliance out; // with columns as they are found; on rank 0
  if (rank == 0)
  {
    out.jump.resize(total * total);
    out.velocity.resize(total * total);
  }
  const std::vector<Entry> entries = wanted_entries(operators.forces(), wanted, _pinned);
  auto next = entries.begin();
  for (std::size_t first = 0; first < total; first += block)
  {
    const PetscInt num = PetscInt(std::min(total - first, std::size_t(block)));
    const OwnedMatrix load = dense(comm, num_owned, num);
    {
      DenseEntries right(load.get());
      for (; next != entries.end() && next->column < PetscInt(first) + num; ++next)
        right(next->row, next->column - PetscInt(first)) = next->value;
    }
    check(MatAssemblyBegin(load.get(), MAT_FINAL_ASSEMBLY), "a matrix is assembled");
    check(MatAssemblyEnd(load.get(), MAT_FINAL_ASSEMBLY), "a matrix is assembled");
    const OwnedMatrix moved = dense(comm, num_owned, num);
    check(MatMatSolve(factors, load.get(), moved.get()), "factors are used");
    for (bool velocity : {false, true})
    {
      Candidates::ByContact parts;
      for (const RollingContact* c : operators.contacts())
        parts.push_back(relative(*c, velocity ? c->velocity_jump() : c->jump(), moved.get(), num));
      const std::vector<double> found = candidates.gather(parts, int(g * num));
      std::vector<double>& to = velocity ? out.velocity : out.jump;
      for (std::size_t row = 0; row < found.size() / num; ++row) // node and component
        std::copy_n(&found[row * num], num, &to[row * total + first]);
    }
  }
  return out;
}
} // namespace dolfinx_impact::rolling
