// SPDX-License-Identifier: MIT
#include "LinearSystem.h"
#include "../operators/CooMatrix.h"
#include "../operators/petsc_check.h"
#include <algorithm>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::solve
{
namespace
{
std::uint64_t next_id()
{
  static std::uint64_t count = 0;
  return ++count;
}
} // namespace

LinearSystem::LinearSystem(Mat K, std::span<const Mat> extra) : _stiffness{K}, _id(next_id())
{
  _stiffness.insert(_stiffness.end(), extra.begin(), extra.end());
}

// --- condensed ------------------------------------------------------------------------------------------------------

CondensedSystem::CondensedSystem(Mat K, std::span<const Mat> extra, bool symmetric,
                                 std::shared_ptr<enforcement::Condensation> condensation,
                                 std::vector<std::int8_t> pinned, double diagonal)
    : LinearSystem(K, extra), _condensation(std::move(condensation)),
      _symmetric(symmetric && (!_condensation || _condensation->symmetric())), _pinned(std::move(pinned)),
      _diagonal(diagonal)
{
  for (std::size_t i = 0; i < _pinned.size(); ++i)
    if (_pinned[i])
      _pinned_rows.push_back(PetscInt(i));
  for (Vec* v : {&_free, &_moved, &_force})
    *v = create_vector();
}

CondensedSystem::~CondensedSystem()
{
  for (Vec* v : {&_free, &_moved, &_force})
    VecDestroy(v);
}

Vec CondensedSystem::create_vector() const
{
  Vec v = nullptr;
  check(MatCreateVecs(K(), &v, nullptr), "a vector is made");
  return v;
}

void CondensedSystem::multiply_stiffness(Vec x, Vec y) const
{
  check(MatMult(K(), x, y), "a matrix is multiplied");
  for (std::size_t i = 1; i < _stiffness.size(); ++i)
    check(MatMultAdd(_stiffness[i], x, y, y), "a matrix is multiplied");
}

void CondensedSystem::mult(Vec x, Vec y)
{
  check(VecCopy(x, _free), "a vector is copied");
  {
    Entries free(_free);
    for (PetscInt i : _pinned_rows)
      free[i] = 0.0;
  }
  if (!_condensation)
    multiply_stiffness(_free, y);
  else
  {
    check(MatMult(_condensation->right(), _free, _moved), "a matrix is multiplied");
    multiply_stiffness(_moved, _force);
    check(MatMultTranspose(_condensation->left(), _force, y), "a matrix is multiplied");
  }
  const double* given = nullptr;
  check(VecGetArrayRead(x, &given), "a vector is read");
  {
    Entries out(y);
    for (PetscInt i : _pinned_rows)
      out[i] = _diagonal * given[i];
  }
  check(VecRestoreArrayRead(x, &given), "a vector is read");
}

void CondensedSystem::load(std::span<const double> residual, Vec values, Vec b)
{
  const std::vector<double> given = operators::values_of(values, _pinned.size());
  check(VecSet(_free, 0.0), "a vector is set");
  {
    Entries pinned(_free);
    for (PetscInt i : _pinned_rows)
      pinned[i] = given[i];
  }
  const std::vector<double> moved = displacements(_free);
  {
    Entries to(_moved);
    std::ranges::copy(moved, &to[0]);
  }
  multiply_stiffness(_moved, _force);
  {
    Entries force(_force);
    for (std::size_t i = 0; i < force.size(); ++i)
      force[i] = -residual[i] - force[i];
  }
  if (_condensation)
    check(MatMultTranspose(_condensation->left(), _force, b), "a matrix is multiplied");
  else
    check(VecCopy(_force, b), "a vector is copied");
  Entries out(b);
  for (PetscInt i : _pinned_rows)
    out[i] = _diagonal * given[i];
}

std::vector<double> CondensedSystem::displacements(Vec y)
{
  return _condensation ? _condensation->increment(y) : operators::values_of(y, _pinned.size());
}

std::vector<double> CondensedSystem::forces(Vec b) const
{
  std::vector<double> out = operators::values_of(b, _pinned.size());
  for (PetscInt i : _pinned_rows)
    out[i] = 0.0;
  return _condensation ? _condensation->forces(out) : out;
}

void CondensedSystem::set_unknowns(std::span<const double> increments, Vec b, Vec y) const
{
  std::vector<double> found(increments.begin(), increments.end());
  if (_condensation)
    found = _condensation->unknowns(increments);
  const double* given = nullptr;
  check(VecGetArrayRead(b, &given), "a vector is read");
  for (PetscInt i : _pinned_rows)
    found[i] = given[i] / _diagonal;
  check(VecRestoreArrayRead(b, &given), "a vector is read");
  Entries out(y);
  std::ranges::copy(found, &out[0]);
}

Mat CondensedSystem::columns(std::span<const PetscInt> unknowns) const
{
  const MPI_Comm comm = PetscObjectComm(PetscObject(K()));
  PetscInt num = PetscInt(unknowns.size()), end = 0, first = 0;
  MPI_Scan(&num, &end, 1, MPIU_INT, MPI_SUM, comm);
  check(MatGetOwnershipRange(K(), &first, nullptr), "a matrix is asked for its rows");
  operators::CooMatrix::Entries ones;
  for (PetscInt k = 0; k < num; ++k)
    ones.add(first + unknowns[k], end - num + k, 1.0);
  operators::CooMatrix selection;
  selection.assign(comm, PetscInt(_pinned.size()), num, 1, std::move(ones));
  const auto product = [](Mat A, Mat B)
  {
    Mat out = nullptr;
    check(MatMatMult(A, B, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &out), "columns of a matrix are found");
    return out;
  };
  Mat moved = _condensation ? product(_condensation->right(), selection.matrix()) : selection.matrix();
  Mat out = product(K(), moved);
  for (std::size_t i = 1; i < _stiffness.size(); ++i)
  {
    Mat part = product(_stiffness[i], moved);
    check(MatAXPY(out, 1.0, part, DIFFERENT_NONZERO_PATTERN), "matrices are added");
    check(MatDestroy(&part), "a matrix is destroyed");
  }
  if (_condensation)
  {
    Mat forces = out;
    check(MatTransposeMatMult(_condensation->left(), forces, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &out),
          "columns of a matrix are condensed");
    check(MatDestroy(&forces), "a matrix is destroyed");
    check(MatDestroy(&moved), "a matrix is destroyed");
  }
  check(MatProductClear(out), "a product is forgotten"); // it keeps its factors
  std::vector<PetscInt> rows(_pinned_rows);
  for (PetscInt& row : rows)
    row += first;
  check(MatZeroRows(out, PetscInt(rows.size()), rows.data(), 0.0, nullptr, nullptr), "rows of a matrix are pinned");
  return out;
}

Mat CondensedSystem::assemble()
{
  Mat total = K();
  const bool own = _stiffness.size() > 1 || !_condensation;
  if (own)
    check(MatDuplicate(K(), MAT_COPY_VALUES, &total), "a matrix is copied");
  for (std::size_t i = 1; i < _stiffness.size(); ++i)
    check(MatAXPY(total, 1.0, _stiffness[i], DIFFERENT_NONZERO_PATTERN), "matrices are added");
  Mat A = total;
  if (_condensation)
  {
    A = _condensation->condense(total);
    if (own)
      check(MatDestroy(&total), "a matrix is destroyed");
  }
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr), "a matrix is asked for its rows");
  std::vector<PetscInt> rows(_pinned_rows);
  for (PetscInt& row : rows)
    row += first;
  check(MatZeroRowsColumns(A, PetscInt(rows.size()), rows.data(), _diagonal, nullptr, nullptr),
        "rows of a matrix are pinned");
  return A;
}

// --- perturbed ------------------------------------------------------------------------------------------------------

PerturbedSystem::PerturbedSystem(Mat K, std::span<const Mat> extra, std::vector<std::int8_t> pinned, double diagonal)
    : CondensedSystem(K, extra, false, nullptr, std::move(pinned), diagonal)
{
}

Mat PerturbedSystem::assemble()
{
  CondensedSystem bare(K(), {}, true, nullptr, {pinned().begin(), pinned().end()}, diagonal());
  Mat A = bare.assemble();
  check(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE), "a matrix is marked as symmetric");
  return A;
}

// --- saddle point ---------------------------------------------------------------------------------------------------

SaddlePointSystem::SaddlePointSystem(Mat K, std::span<const Mat> extra, enforcement::SaddlePoint& rows)
    : LinearSystem(K, extra), _rows(rows)
{
}

std::vector<double> SaddlePointSystem::displacements(Vec y)
{
  return operators::values_of(y, _rows.num_displacements());
}

Vec SaddlePointSystem::create_vector() const
{
  Vec v = nullptr;
  check(VecCreateMPI(PetscObjectComm(PetscObject(K())), PetscInt(_rows.num_unknowns()), PETSC_DETERMINE, &v),
        "a vector is made");
  return v;
}
} // namespace dolfinx_impact::solve
