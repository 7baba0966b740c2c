// SPDX-License-Identifier: MIT
// Matrices that are filled by contact: kept while their places last.
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/operators/CooMatrix.h>
#include <dolfinx_impact/operators/NodalMatrix.h>
#include <dolfinx_impact/solve/column_products.h>

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

TEST_CASE("columns are multiplied by a sum of matrices as vectors are, one by one")
{
  CooMatrix A, B;
  CooMatrix::Entries of_A, of_B;
  for (PetscInt i = 0; i < 4; ++i)
  {
    of_A.add(i, i, 1.0 + double(i));
    of_A.add(i, (i + 1) % 4, 0.5);
    of_B.add(0, i, 0.25);
  }
  A.assign(MPI_COMM_SELF, 4, 4, 1, of_A);
  B.assign(MPI_COMM_SELF, 4, 4, 1, of_B);
  const std::vector<Mat> both{A.matrix(), B.matrix()};
  // Five columns: one more than PETSc multiplies at a time.
  std::vector<double> columns(20);
  for (std::size_t i = 0; i < columns.size(); ++i)
    columns[i] = double(i % 7) - 2.0;
  const std::vector<double> found = dolfinx_impact::solve::column_products(both, 5, columns);
  for (std::size_t k = 0; k < 5; ++k)
    for (std::size_t i = 0; i < 4; ++i)
    {
      const double* const x = &columns[4 * k];
      double expected = (1.0 + double(i)) * x[i] + 0.5 * x[(i + 1) % 4];
      if (i == 0)
        expected += 0.25 * (x[0] + x[1] + x[2] + x[3]);
      CHECK(found[4 * k + i] == expected);
    }
}
