// SPDX-License-Identifier: MIT
// What belongs to closest points of a surface.
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/search/closest_point/VertexRing.h>

using dolfinx_impact::search::VertexRing;

TEST_CASE("a ring of facets around a vertex is closed, or the surface ends there")
{
  // Facet i has the far ends i and i + 1 of its edges at the vertex.
  VertexRing ring;
  CHECK_FALSE(ring.open()); // no facet
  for (int i : {2, 0, 3})
  {
    ring.add(10 + i);
    ring.add(10 + (i + 1) % 4);
    CHECK(ring.open());
  }
  ring.add(11);
  ring.add(12);
  CHECK_FALSE(ring.open());
  SECTION("two rings that meet in the vertex only are closed if each is")
  {
    for (int i = 0; i < 3; ++i)
    {
      ring.add(20 + i);
      ring.add(20 + (i + 1) % 3);
      CHECK(ring.open() == (i < 2));
    }
  }
  SECTION("more facets than there is room for are left out")
  {
    for (int i = 0; i < 2 * VertexRing::max_nodes; ++i)
      for (int twice = 0; twice < 2; ++twice)
        ring.add(100 + i);
    CHECK_FALSE(ring.open());
  }
}
