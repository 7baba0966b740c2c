// SPDX-License-Identifier: MIT
// Matrices that are filled by contact: kept while their places last.
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/operators/CooMatrix.h>
#include <dolfinx_impact/operators/NodalMatrix.h>

using namespace dolfinx_impact::operators;

namespace
{
double entry(Mat A, PetscInt i, PetscInt j)
{
  double value = 0.0;
  MatGetValue(A, i, j, &value);
  return value;
}
} // namespace

TEST_CASE("a nodal matrix is kept while blocks have a place in it")
{
  const auto map = std::make_shared<const dolfinx::common::IndexMap>(MPI_COMM_SELF, 3);
  const std::vector<std::int32_t> first{0, 1}, second{1, 2};
  const std::vector<double> block(16, 1.0);
  NodalMatrix A;
  NodalMatrix::Couplings one, other;
  one.add(10, first, first);
  other.add(11, second, second);
  A.reset(map, 2, one);
  A.add(first, first, block);
  A.finish();
  CHECK(entry(A.matrix(), 0, 3) == 1.0);
  CHECK(entry(A.matrix(), 4, 4) == 0.0);
  CHECK(A.num_created() == 1);
  A.reset(map, 2, one);
  A.finish();
  CHECK(A.num_created() == 1);
  CHECK(entry(A.matrix(), 0, 3) == 0.0);
  A.reset(map, 2, other);
  A.add(second, second, block);
  A.finish();
  CHECK(A.num_created() == 2);
  CHECK(entry(A.matrix(), 2, 5) == 1.0);
  // The old places are there still.
  A.reset(map, 2, one);
  A.add(first, first, block);
  A.finish();
  CHECK(A.num_created() == 2);
  CHECK(entry(A.matrix(), 0, 3) == 1.0);
  CHECK(entry(A.matrix(), 2, 5) == 0.0);
}

TEST_CASE("entries at one place add up, and the matrix is kept while the places stay")
{
  CooMatrix A;
  CooMatrix::Entries entries;
  entries.add(0, 1, 1.0);
  entries.add(0, 1, 2.0);
  A.assign(MPI_COMM_SELF, 2, 3, 1, entries);
  const Mat made = A.matrix();
  CHECK(entry(made, 0, 1) == 3.0);
  entries.values = {5.0, 7.0};
  A.assign(MPI_COMM_SELF, 2, 3, 1, entries);
  CHECK(A.matrix() == made);
  CHECK(entry(A.matrix(), 0, 1) == 12.0);
  entries.add(1, 2, 4.0);
  A.assign(MPI_COMM_SELF, 2, 3, 1, entries);
  CHECK(entry(A.matrix(), 1, 2) == 4.0);
}
