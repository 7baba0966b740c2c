// SPDX-License-Identifier: MIT
// Catch2's tests between PetscInitialize and PetscFinalize.
#include <catch2/catch_session.hpp>
#include <petscsys.h>

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  const int failed = Catch::Session().run(argc, argv);
  PetscFinalize();
  return failed;
}
