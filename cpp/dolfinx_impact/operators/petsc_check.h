// SPDX-License-Identifier: MIT
#pragma once
#include <petscvec.h>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

// PETSc exports these, but declares them in headers of its own only.
extern "C"
{
  PetscErrorCode PetscObjectStateGet(PetscObject, PetscObjectState*);
  PetscErrorCode PetscObjectDelayedDestroy(PetscObject*);
  PetscErrorCode PetscGarbageCleanup(MPI_Comm);
}

namespace dolfinx_impact::operators
{
/// @throws std::runtime_error for an error that PETSc returned
inline void check(PetscErrorCode error, const char* what)
{
  if (error)
    throw std::runtime_error("PETSc error " + std::to_string(int(error)) + " while " + what);
}

/// Destroy an object that several ranks may let go of at different times: on more than one rank PETSc keeps it until
/// all ranks clean up together.
inline void let_go(PetscObject object)
{
  PetscBool over = PETSC_FALSE;
  if (object && PetscFinalized(&over) == 0 && !over)
    PetscObjectDelayedDestroy(&object);
}

/// A PETSc vector's own entries, to be changed, as long as this lives.
class Entries
{
public:
  explicit Entries(Vec v) : _v(v)
  {
    check(VecGetLocalSize(v, &_size), "a vector is asked for its size");
    check(VecGetArray(v, &_values), "a vector is asked for its entries");
  }
  ~Entries() { VecRestoreArray(_v, &_values); }
  Entries(const Entries&) = delete;
  Entries& operator=(const Entries&) = delete;
  double& operator[](std::size_t i) { return _values[i]; }
  std::size_t size() const { return std::size_t(_size); }
  double* begin() { return _values; }
  double* end() { return _values + _size; }

private:
  Vec _v;
  PetscInt _size = 0;
  double* _values = nullptr;
};

/// A copy of a vector's first own entries.
/// @param[in] num number of entries, at most those that the vector has on this rank
inline std::vector<double> values_of(Vec v, std::size_t num)
{
  const double* values = nullptr;
  check(VecGetArrayRead(v, &values), "a vector is read");
  std::vector<double> out(values, values + num);
  check(VecRestoreArrayRead(v, &values), "a vector is read");
  return out;
}

/// A copy of a vector's own entries.
inline std::vector<double> values_of(Vec v)
{
  PetscInt size = 0;
  check(VecGetLocalSize(v, &size), "a vector is asked for its size");
  return values_of(v, std::size_t(size));
}

/// Subtract forces from a residual.
/// @param[in] forces by owned degree of freedom
/// @throws std::invalid_argument if the residual has another size
inline void subtract(std::span<const double> forces, Vec residual)
{
  Entries entries(residual);
  if (entries.size() != forces.size())
    throw std::invalid_argument("a residual has an entry for every owned degree of freedom of the space");
  for (std::size_t i = 0; i < forces.size(); ++i)
    entries[i] -= forces[i];
}
} // namespace dolfinx_impact::operators
