// SPDX-License-Identifier: MIT
// Springs of many nodes at once: each node gets what it would get alone, to the last bit.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/enforcement/node_to_surface/SpringBatch.h>
#include <memory>
#include <random>
#include <vector>

using Catch::Approx;
using namespace dolfinx_impact::enforcement;

namespace
{
/// Nodes over facets of size one, some in contact, some open, some oblique.
std::unique_ptr<SpringBatch> nodes_over_facets(int gdim, int num_masters, double friction)
{
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high)
  { return std::uniform_real_distribution<double>(low, high)(random); };
  auto out = std::make_unique<SpringBatch>();
  SpringBatch& b = *out;
  b.gdim = gdim;
  b.num_masters = num_masters;
  b.friction = friction;
  b.corrects_moments = num_masters > 0;
  b.num = SpringBatch::size;
  for (int l = 0; l < b.num; ++l)
  {
    b.begins[l] = l % 3 == 0;
    b.oblique[l] = l % 5 == 0;
    b.beside[l] = l % 7 == 0;
    b.gap[l] = uniform(-0.02, 0.01);
    b.set_spring(l, l % 3 ? Spring{uniform(0.0, 2.0), 0.01, uniform(-0.02, 0.0), uniform(-1e-3, 1e-3), 0.0} : Spring{});
    b.per_area[l] = uniform(0.5, 2.0);
    b.compliance[l] = num_masters ? 0.007 : 0.004;
    b.area_compliance[l] = num_masters ? 0.002 : 0.0;
    const double angle = uniform(-0.1, 0.1);
    const double normal[3] = {std::sin(angle), gdim == 2 ? std::cos(angle) : 0.0, gdim == 3 ? std::cos(angle) : 0.0};
    for (int c = 0; c < gdim; ++c)
    {
      b.normal[c][l] = normal[c];
      b.x[c][l] = uniform(0.2, 0.4);
      b.motion[c][l] = uniform(-0.01, 0.01);
      b.tangential[c][l] = l % 3 ? uniform(-0.2, 0.2) : 0.0;
    }
    for (int j = 0; j < num_masters; ++j)
    {
      b.phi[j][l] = 1.0 / num_masters;
      for (int c = 0; c < gdim; ++c)
      {
        b.X[j][c][l] = uniform(-0.1, 0.1) + (c == 0 ? j % 2 : c == 1 ? j / 2 : 0);
        b.du[j][c][l] = uniform(-0.01, 0.01);
      }
    }
  }
  return out;
}

/// Copy the input of a lane to lane 0 of a batch of its own.
SpringBatch alone(const SpringBatch& b, int l)
{
  SpringBatch out = b;
  out.num = 1;
  const auto copy = [l](double* values) { values[0] = values[l]; };
  for (double* values :
       {out.gap, out.beside, out.oblique, out.begins, out.per_area, out.compliance, out.area_compliance, out.force,
        out.spring_compliance, out.spring_gap, out.surplus, out.tangential_surplus})
    copy(values);
  for (auto* values : {&out.normal, &out.x, &out.motion, &out.tangential})
    for (int c = 0; c < 3; ++c)
      copy((*values)[c]);
  for (int j = 0; j < SpringBatch::most; ++j)
  {
    copy(out.phi[j]);
    for (int c = 0; c < 3; ++c)
    {
      copy(out.X[j][c]);
      copy(out.du[j][c]);
    }
  }
  return out;
}
} // namespace

TEST_CASE("springs of many nodes are those of each node alone")
{
  for (const auto& [gdim, num_masters] : {std::pair(2, 0), std::pair(2, 2), std::pair(2, 3), std::pair(3, 0),
                                          std::pair(3, 3), std::pair(3, 4), std::pair(3, 9)})
    for (double friction : {0.0, 0.3})
    {
      const auto given = nodes_over_facets(gdim, num_masters, friction);
      SpringBatch together = *given;
      evaluate(together);
      int closed = 0;
      for (int l = 0; l < together.num; ++l)
      {
        SpringBatch one = alone(*given, l);
        evaluate(one);
        CHECK(one.overlap[0] == together.overlap[l]);
        CHECK(one.change[0] == together.change[l]);
        if (!(together.overlap[l] > 0.0))
          continue;
        ++closed;
        CHECK(one.force[0] == together.force[l]);
        CHECK(one.surplus[0] == together.surplus[l]);
        CHECK(one.stored[0] == together.stored[l]);
        CHECK(one.corrected[0] == together.corrected[l]);
        double squared = 0.0, along = 0.0;
        for (int c = 0; c < gdim; ++c)
        {
          CHECK(one.total[c][0] == together.total[c][l]);
          const double tangential = together.total[c][l] - together.force[l] * together.normal[c][l];
          squared += tangential * tangential;
          along += together.total[c][l] * together.normal[c][l];
          for (int j = 0; j < num_masters && together.corrected[l] > 0.0; ++j)
            CHECK(one.correction[j][c][0] == together.correction[j][c][l]);
        }
        // No tension, and Coulomb's cone; the tolerances are some times the rounding of forces of size one.
        CHECK(together.force[l] >= 0.0);
        CHECK(std::sqrt(squared) <= friction * together.force[l] + 1e-14);
        CHECK(along == Approx(together.force[l]).margin(1e-14));
      }
      CHECK(closed > 3);
      CHECK(closed < together.num);
    }
}

TEST_CASE("the force of a spring that is pressed is stiffness times overlap")
{
  auto b = nodes_over_facets(3, 4, 0.0);
  b->num = 1;
  b->begins[0] = b->oblique[0] = b->beside[0] = 0.0;
  const double compliance = 0.004 + 0.003 + 0.002 * b->per_area[0]; // slave and master in series
  const double gap = -0.01;
  b->gap[0] = gap;
  for (int c = 0; c < 3; ++c)
  {
    b->motion[c][0] = 0.0;
    for (int j = 0; j < 4; ++j)
      b->du[j][c][0] = 0.0;
  }
  b->set_spring(0, {-gap / compliance, compliance, gap, 0.0, 0.0});
  evaluate(*b);
  CHECK(b->overlap[0] == 0.01);
  CHECK(b->force[0] == Approx(0.01 / compliance).epsilon(1e-14));
  CHECK(b->stored[0] == Approx(0.5 * 0.01 * 0.01 / compliance).epsilon(1e-13));
  CHECK(b->normal_loss[0] == Approx(0.0).margin(1e-15));
}

TEST_CASE("motions and compliances of many nodes follow from the nodes of their facets")
{
  using dolfinx_impact::search::MasterNode;
  std::mt19937 random(3);
  const auto uniform = [&] { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); };
  std::vector<MasterNode> masters(20);
  for (MasterNode& master : masters)
  {
    for (int c = 0; c < 3; ++c)
    {
      master.x[c] = uniform();
      master.du[c] = uniform();
    }
    master.compliance = 2.0 + uniform();
    master.area_compliance = 2.0 + uniform();
  }
  for (const auto& [gdim, num_masters] :
       {std::pair(2, 2), std::pair(2, 3), std::pair(3, 3), std::pair(3, 4), std::pair(3, 9)})
    for (int num : {1, 4, 7, SpringBatch::size})
    {
      const auto given = nodes_over_facets(gdim, num_masters, 0.3);
      given->num = num;
      for (int l = 0; l < num; ++l)
        for (int j = 0; j < num_masters; ++j)
        {
          given->phi[j][l] = uniform();
          given->corners[j][l] = (7 * l + 3 * j) % 20;
        }
      SpringBatch b = *given;
      read_masters(b, masters.data());
      for (int l = 0; l < num; ++l)
      {
        double compliance = given->compliance[l], area_compliance = given->area_compliance[l], motion[3];
        for (int c = 0; c < gdim; ++c)
          motion[c] = given->motion[c][l];
        for (int j = 0; j < num_masters; ++j)
        {
          const MasterNode& master = masters[given->corners[j][l]];
          const double phi = given->phi[j][l];
          compliance += std::abs(phi) * master.compliance;
          area_compliance += std::abs(phi) * master.area_compliance;
          for (int c = 0; c < gdim; ++c)
          {
            motion[c] -= phi * master.du[c];
            CHECK(b.X[j][c][l] == master.x[c]);
            CHECK(b.du[j][c][l] == master.du[c]);
          }
        }
        // Each lane does what is done here, in the same order: the same to the last bit.
        CHECK(b.compliance[l] == compliance);
        CHECK(b.area_compliance[l] == area_compliance);
        for (int c = 0; c < gdim; ++c)
          CHECK(b.motion[c][l] == motion[c]);
      }
    }
}

TEST_CASE("nodes of facets get the reactions of the nodes that are closed")
{
  std::mt19937 random(5);
  const auto uniform = [&] { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); };
  for (const auto& [gdim, num_masters] : {std::pair(2, 2), std::pair(3, 3), std::pair(3, 4), std::pair(3, 8)})
    for (int num : {1, 6, SpringBatch::size})
    {
      const auto b = nodes_over_facets(gdim, num_masters, 0.0);
      b->num = num;
      std::vector<NodalSum> sums(10), expected(10);
      for (int l = 0; l < num; ++l)
      {
        b->overlap[l] = l % 3 == 1 ? 0.0 : 1.0;
        b->corrected[l] = l % 2;
        for (int c = 0; c < gdim; ++c)
          b->total[c][l] = uniform();
        for (int j = 0; j < num_masters; ++j)
        {
          b->phi[j][l] = uniform();
          b->corners[j][l] = (2 * l + j) % 10; // neighbours share nodes
          for (int c = 0; c < gdim; ++c)
          {
            b->correction[j][c][l] = uniform();
            if (b->overlap[l] > 0.0)
              expected[b->corners[j][l]].force[c] +=
                  (b->corrected[l] > 0.0 ? b->correction[j][c][l] : 0.0) - b->phi[j][l] * b->total[c][l];
          }
        }
      }
      add_reactions(*b, sums.data());
      for (int node = 0; node < 10; ++node)
        for (int c = 0; c < gdim; ++c) // sums of a dozen numbers of size one
          CHECK(sums[node].force[c] == Approx(expected[node].force[c]).margin(1e-14));
    }
}
