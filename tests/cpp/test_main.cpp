// SPDX-License-Identifier: MIT
// Catch2's tests between MPI_Init and MPI_Finalize.
#include <catch2/catch_session.hpp>
#include <mpi.h>

int main(int argc, char* argv[])
{
  MPI_Init(&argc, &argv);
  const int failed = Catch::Session().run(argc, argv);
  MPI_Finalize();
  return failed;
}
