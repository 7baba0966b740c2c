// SPDX-License-Identifier: MIT
// Nodes of kinematic contact in lanes: each one gets what is computed for it alone.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/enforcement/node_to_surface/ClosedBatch.h>
#include <memory>
#include <random>
#include <vector>

using Catch::Approx;
using namespace dolfinx_impact::enforcement;
using dolfinx_impact::search::MasterNode;

namespace
{
constexpr int num_masters_in_all = 20, num_slaves = 12;
constexpr double rounding = 1e-13; // of sums of a few dozen numbers of size one

/// A batch of nodes over facets whose nodes are shared, with what a step of contact gives it.
struct Contact
{
  ClosedRules rules;
  std::vector<MasterNode> masters{num_masters_in_all};
  std::unique_ptr<ClosedBatch> batch = std::make_unique<ClosedBatch>();
  ClosedInput input = {};
  std::vector<double> correction, before;
  double obstacle[3] = {};

  int stride() const { return rules.gdim == 3 ? 4 : 2; }

  Contact(int gdim, int num_masters, bool has_friction, int num)
  {
    std::mt19937 random(11);
    const auto uniform = [&random](double low, double high)
    { return std::uniform_real_distribution<double>(low, high)(random); };
    const bool linear = num_masters == (gdim == 2 ? 2 : 4) || (gdim == 3 && num_masters == 3);
    rules = {gdim, num_masters, has_friction, num_masters > 0, linear};
    for (MasterNode& master : masters)
      for (int c = 0; c < gdim; ++c)
        master.du[c] = uniform(-0.1, 0.1);
    // Neighbours over one square, so that its nodes are shared and facets are not degenerate.
    for (int k = 0; k < num_masters_in_all; ++k)
    {
      const int corner = k % std::max(num_masters, 1);
      const double place[3] = {double(corner % 2) + 0.1 * corner, double(corner / 2), 0.0};
      for (int c = 0; c < gdim; ++c)
        masters[k].x[c] = place[c] + uniform(-0.05, 0.05);
    }
    const int numbers = num_masters_in_all + num_slaves;
    for (std::vector<double>* values : {&correction, &before})
      for (int k = 0; k < numbers * stride(); ++k)
        values->push_back(uniform(-1.0, 1.0));
    for (double& value : obstacle)
      value = num_masters ? 0.0 : uniform(-1.0, 1.0);
    ClosedBatch& b = *batch;
    b.num = num;
    for (int l = 0; l < num; ++l)
    {
      b.node[l] = num_masters_in_all + l;
      b.slave[l] = l;
      b.releases[l] = l % 4 == 1;
      b.overlap[l] = uniform(-0.5, 1.0);
      b.normal_mass[l] = uniform(0.5, 2.0);
      b.isotropic_mass[l] = uniform(0.5, 2.0);
      b.friction[l] = has_friction ? uniform(0.0, 0.5) : 0.0;
      input.along_facet[l] = l % 3 != 0;
      input.orientation[l] = l % 2 ? -1.0 : 1.0;
      for (double& xi : {std::ref(input.xi[0][l]), std::ref(input.xi[1][l])})
        xi = uniform(0.0, 0.5);
      double length = 0.0;
      for (int c = 0; c < gdim; ++c)
      {
        b.normal[c][l] = uniform(-1.0, 1.0);
        length += b.normal[c][l] * b.normal[c][l];
        b.motion[c][l] = uniform(-1.0, 1.0);
        b.force[c][l] = uniform(-1.0, 1.0);
        input.x[c][l] = uniform(0.0, 1.0);
      }
      for (int c = 0; c < gdim; ++c)
        b.normal[c][l] /= std::sqrt(length);
      for (int j = 0; j < num_masters; ++j)
      {
        const int k = num_masters * ((l / 2) % (num_masters_in_all / num_masters)) + j;
        b.masters[j].node[l] = b.masters[j].corner[l] = k;
        b.masters[j].phi[l] = uniform(0.0, 1.0);
      }
    }
    fill_lanes(rules, b, input);
  }

  /// Value at the node of lane l minus that interpolated at its projection.
  std::array<double, 3> relative(const std::vector<double>& values, int l) const
  {
    std::array<double, 3> out{};
    for (int c = 0; c < rules.gdim; ++c)
    {
      out[c] = values[std::size_t(batch->node[l]) * stride() + c];
      for (int j = 0; j < rules.num_masters; ++j)
        out[c] -= batch->masters[j].phi[l] * values[std::size_t(batch->masters[j].node[l]) * stride() + c];
    }
    return out;
  }
  double along_normal(const std::array<double, 3>& v, int l) const
  {
    double sum = 0.0;
    for (int c = 0; c < rules.gdim; ++c)
      sum += batch->normal[c][l] * v[c];
    return sum;
  }
  std::array<double, 3> force(int l) const
  {
    return {batch->force[0][l], batch->force[1][l], rules.gdim == 3 ? batch->force[2][l] : 0.0};
  }
};

/// Calls each(contact) for dimensions, facets, with and without friction, and numbers of lanes in use.
void for_contacts(auto&& each)
{
  for (const auto& [gdim, num_masters] : {std::pair(2, 0), std::pair(2, 2), std::pair(2, 3), std::pair(3, 0),
                                          std::pair(3, 3), std::pair(3, 4), std::pair(3, 6), std::pair(3, 9)})
    for (const bool has_friction : {false, true})
      for (const int num : {1, 3, 6, ClosedBatch::size})
      {
        Contact contact(gdim, num_masters, has_friction, num);
        each(contact);
      }
}
} // namespace

TEST_CASE("closed nodes take motions, normals and moments of their facets")
{
  for_contacts(
      [](Contact& c)
      {
        const ClosedBatch given = *c.batch;
        ClosedBatch& b = *c.batch;
        const int gdim = c.rules.gdim, num = c.rules.num_masters;
        read_masters(c.rules, b, c.input, c.masters.data());
        for (int l = 0; l < b.num; ++l)
        {
          double before[9][3], du[9][3], phi[9], x[3], motion[3], turn[3] = {}, r[27], arms[27];
          for (int j = 0; j < num; ++j)
          {
            phi[j] = b.masters[j].phi[l];
            for (int k = 0; k < gdim; ++k)
            {
              const MasterNode& master = c.masters[b.masters[j].corner[l]];
              du[j][k] = master.du[k];
              before[j][k] = master.x[k] - master.du[k];
            }
          }
          for (int k = 0; k < gdim; ++k)
          {
            x[k] = c.input.x[k][l];
            motion[k] = given.motion[k][l];
            for (int j = 0; j < num; ++j)
              motion[k] -= phi[j] * du[j][k];
            CHECK(b.motion[k][l] == Approx(motion[k]).margin(rounding));
          }
          const auto check_moments = [&]<int D>()
          {
            MomentCorrection correction;
            correction.set<D>(num, [&](int j, int k) { return before[j][k]; }, phi, x, r);
            if (c.rules.has_friction)
              correction.add_rotation<D>(num, r, [&](int j, int k) { return du[j][k]; }, turn);
            const MomentCorrection stored = b.moments(c.rules, l, arms);
            for (int k = 0; k < D; ++k)
            {
              CHECK(stored.e[k] == Approx(correction.e[k]).margin(rounding));
              CHECK(b.turn[k][l] == Approx(turn[k]).margin(rounding));
            }
            for (int k = 0; k < (D == 2 ? 1 : 6); ++k)
              CHECK(stored.inverse[k] == Approx(correction.inverse[k]).margin(rounding));
            for (int k = 0; k < num * D; ++k)
              CHECK(arms[k] == Approx(r[k]).margin(rounding));
          };
          if (num > 0)
            gdim == 2 ? check_moments.operator()<2>() : check_moments.operator()<3>();
          // Along facets the normal is perpendicular to them where the node was; elsewhere it is kept.
          double length = 0.0, along = 0.0;
          const double s = c.input.xi[0][l], t = c.input.xi[1][l];
          for (int k = 0; k < gdim; ++k)
          {
            length += b.normal[k][l] * b.normal[k][l];
            if (!c.rules.linear_facets || c.input.along_facet[l] == 0.0)
              CHECK(b.normal[k][l] == given.normal[k][l]);
            else if (num == 4)
              along += b.normal[k][l] * ((before[1][k] - before[0][k]) * (1 - t) + (before[3][k] - before[2][k]) * t +
                                         (before[2][k] - before[0][k]) * (1 - s) + (before[3][k] - before[1][k]) * s);
            else
              along += b.normal[k][l] * (before[1][k] - before[0][k]);
          }
          CHECK(length == Approx(1.0).margin(rounding));
          CHECK(std::abs(along) < rounding);
        }
      });
}

TEST_CASE("a sweep of closed nodes pushes, sticks and slips")
{
  int stick = 0, slip = 0, open = 0;
  for_contacts(
      [&](Contact& c)
      {
        ClosedBatch& b = *c.batch;
        read_masters(c.rules, b, c.input, c.masters.data());
        for (const bool first : {true, false})
        {
          const ClosedBatch given = b;
          const double h = 0.5, factor = first ? 1.0 : 1.5;
          solve_forces(c.rules, b, c.correction.data(), h, factor, first);
          for (int l = 0; l < b.num; ++l)
          {
            const std::array<double, 3> n = {given.normal[0][l], given.normal[1][l], given.normal[2][l]};
            const std::array<double, 3> moved = first ? std::array<double, 3>{} : c.relative(c.correction, l);
            const double pushed = given.releases[l] > 0.0 ? 0.0
                                                          : factor / h * given.normal_mass[l] *
                                                                (given.overlap[l] - c.along_normal(moved, l));
            double before = 0.0, away = 0.0;
            std::array<double, 3> way{}, t{};
            for (int k = 0; k < c.rules.gdim; ++k)
            {
              before += n[k] * given.force[k][l];
              way[k] = moved[k] + given.motion[k][l] + given.turn[k][l];
              away += n[k] * way[k];
            }
            const double normal = std::max(0.0, before + pushed);
            double squared = 0.0;
            for (int k = 0; k < c.rules.gdim && c.rules.has_friction; ++k)
            {
              t[k] = given.force[k][l] - before * n[k] - factor / h * given.isotropic_mass[l] * (way[k] - away * n[k]);
              squared += t[k] * t[k];
            }
            const double size = std::sqrt(squared), limit = given.friction[l] * normal;
            const double part = size > limit ? limit / size : 1.0;
            for (int k = 0; k < c.rules.gdim; ++k)
              CHECK(b.force[k][l] == Approx(normal * n[k] + part * t[k]).margin(rounding));
            const bool sticks = c.rules.has_friction && size <= limit && normal > 0.0;
            CHECK((b.sticks[l] > 0.0) == sticks);
            ++(normal == 0.0 ? open : sticks ? stick : slip);
          }
        }
      });
  for (const int count : {stick, slip, open}) // each of them occurs
    CHECK(count > 10);
}

TEST_CASE("forces of closed nodes and their reactions are in balance")
{
  for_contacts(
      [](Contact& c)
      {
        ClosedBatch& b = *c.batch;
        const int gdim = c.rules.gdim, num = c.rules.num_masters, stride = c.stride();
        read_masters(c.rules, b, c.input, c.masters.data());
        std::vector<double> forces(c.correction.size(), 0.0), expected = forces;
        for (const bool last : {false, true})
        {
          std::ranges::fill(forces, 0.0);
          add_forces(c.rules, b, forces.data(), last);
        }
        for (int l = 0; l < b.num; ++l)
        {
          double arms[27];
          const std::array<double, 3> f = c.force(l);
          const MomentCorrection moments = b.moments(c.rules, l, arms);
          const auto add = [&](int j, int k, double value)
          {
            expected[std::size_t(b.masters[j].node[l]) * stride + k] += value;
            CHECK(b.masters[j].correction[k][l] == Approx(value).margin(rounding));
          };
          if (num > 0)
            gdim == 2 ? moments.forces<2>(num, arms, f.data(), add) : moments.forces<3>(num, arms, f.data(), add);
          for (int k = 0; k < gdim; ++k)
          {
            expected[std::size_t(b.node[l]) * stride + k] += f[k];
            for (int j = 0; j < num; ++j)
              expected[std::size_t(b.masters[j].node[l]) * stride + k] -= b.masters[j].phi[l] * f[k];
          }
        }
        for (std::size_t k = 0; k < forces.size(); ++k)
          CHECK(forces[k] == Approx(expected[k]).margin(rounding));
      });
}

TEST_CASE("works of closed nodes are those of the forces on all nodes")
{
  for_contacts(
      [](Contact& c)
      {
        ClosedBatch& b = *c.batch;
        const int gdim = c.rules.gdim, num = c.rules.num_masters, stride = c.stride();
        read_masters(c.rules, b, c.input, c.masters.data());
        std::vector<double> forces(c.correction.size(), 0.0);
        add_forces(c.rules, b, forces.data(), true);
        ClosedResult result;
        measure(c.rules, b, c.masters.data(), c.correction.data(), c.before.data(), c.obstacle, result);
        double work = 0.0, expected = 0.0;
        for (int l = 0; l < b.num; ++l)
        {
          const std::array<double, 3> moved = c.relative(c.correction, l);
          CHECK(result.gap[l] == Approx(c.along_normal(moved, l) - b.overlap[l]).margin(rounding));
          CHECK(result.normal[l] == Approx(c.along_normal(c.force(l), l)).margin(rounding));
          double slip = 0.0, later = 0.0;
          for (int k = 0; k < gdim; ++k)
          {
            CHECK(result.tangential[k][l] ==
                  Approx(b.force[k][l] - result.normal[l] * b.normal[k][l]).margin(rounding));
            slip += b.normal[k][l] * result.slip[k][l];
            const double way = moved[k] + b.motion[k][l];
            later += 0.5 * b.force[k][l] * way;
            for (int j = 0; j < num; ++j)
            {
              const int node = b.masters[j].node[l];
              later += 0.5 * b.masters[j].correction[k][l] *
                       (c.masters[b.masters[j].corner[l]].du[k] + c.correction[std::size_t(node) * stride + k]);
            }
            expected -= 0.5 * b.force[k][l] * c.obstacle[k]; // the obstacle takes the reaction
          }
          CHECK(std::abs(slip) < rounding); // it is along the surface
          CHECK(result.later_work[l] + result.later_friction_work[l] == Approx(later).margin(rounding));
          work += result.work[l] + result.friction_work[l];
        }
        for (std::size_t k = 0; k < forces.size(); ++k)
          if (stride == gdim || int(k % 4) < gdim)
            expected += 0.5 * forces[k] * c.before[k];
        CHECK(work == Approx(expected).margin(10 * rounding));
      });
}
