// SPDX-License-Identifier: MIT
#pragma once
#include <memory>
#include <petscmat.h>
#include <type_traits>

namespace dolfinx_impact::operators
{
struct Destroy
{
  void operator()(Mat m) const { MatDestroy(&m); }
  void operator()(Vec v) const { VecDestroy(&v); }
};

/// A matrix of PETSc's that is destroyed with its owner, on all ranks together.
typedef std::unique_ptr<std::remove_pointer_t<Mat>, Destroy> OwnedMatrix;
/// A vector of PETSc's that is destroyed with its owner, on all ranks together.
typedef std::unique_ptr<std::remove_pointer_t<Vec>, Destroy> OwnedVector;
} // namespace dolfinx_impact::operators
