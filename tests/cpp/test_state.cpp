// SPDX-License-Identifier: MIT
// A tree of named arrays: views, copies, and what is refused.
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/state/State.h>
#include <stdexcept>
#include <vector>

using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace
{
/// What an object with a part looks like.
struct Owner
{
  std::vector<double> velocity{1.0, 2.0, 3.0, 4.0};
  std::vector<std::int8_t> active{0, 1};
  double time = 0.5;

  State state()
  {
    State part("contact");
    part.add("active", Place::node, active);
    State out("problem");
    out.add("velocity", Place::node, velocity, 2).add("time", Place::all, time).add(std::move(part));
    return out;
  }
};
} // namespace

TEST_CASE("a copy of a state brings its owner back")
{
  Owner owner;
  const State saved = owner.state().copy();
  owner.velocity[3] = -1.0;
  owner.active[0] = 1;
  CHECK(owner.state().difference_of_values(saved) == "velocity");
  owner.velocity[3] = 4.0;
  CHECK(owner.state().difference_of_values(saved) == "contact/active");
  owner.time = 2.0;
  owner.state().assign(saved);
  CHECK(owner.time == 0.5);
  CHECK(owner.active == std::vector<std::int8_t>{0, 1});
  CHECK(owner.state().difference_of_values(saved).empty());
}

TEST_CASE("a state takes no values of another structure")
{
  Owner owner, other;
  other.velocity.resize(6);
  owner.time = 7.0;
  CHECK_THROWS_AS(owner.state().assign(other.state()), std::invalid_argument);
  CHECK(owner.time == 7.0);
  CHECK(owner.velocity.size() == 4);
  State renamed("problem");
  CHECK_FALSE(owner.state().difference_of_structure(renamed).empty());
}

TEST_CASE("a state has every name once, and whole rows")
{
  Owner owner;
  State state = owner.state();
  CHECK_THROWS_AS(state.add("time", Place::all, owner.time), std::invalid_argument);
  CHECK_THROWS_AS(state.add(State("contact")), std::invalid_argument);
  CHECK_THROWS_AS(state.add("odd", Place::node, owner.velocity, 3), std::invalid_argument);
  CHECK_THROWS_AS(state.field("nothing"), std::out_of_range);
  CHECK_THROWS_AS(state.part("nothing"), std::out_of_range);
  CHECK(state.field("velocity").rows() == 2);
}

TEST_CASE("a state takes some fields of another one, and rows are of the same nodes")
{
  Owner owner;
  State mine = owner.state(), other("other");
  other.add_own("velocity", Place::node, std::vector<double>{4.0, 3.0, 2.0, 1.0}, 2);
  other.add_own("more", Place::all, std::vector<double>{9.0});
  mine.assign_common(other);
  CHECK(owner.velocity == std::vector<double>{4.0, 3.0, 2.0, 1.0});
  CHECK(owner.time == 0.5);
  other.add_own("time", Place::all, std::vector<std::int64_t>{7});
  other.values<double>("velocity")[0] = 8.0;
  CHECK_THROWS_AS(mine.assign_common(other), std::invalid_argument);
  CHECK(owner.velocity[0] == 4.0);

  static const std::string names[] = {"time"};
  State some = mine.copy_of(names);
  owner.time = 1.5;
  CHECK(some.fields().size() == 1);
  CHECK(some.values<double>("time")[0] == 0.5);
  CHECK(mine.numbers(Place::node) == nullptr);
  mine.at(Place::node, {3, 5});
  const State copied = mine.copy();
  REQUIRE(copied.numbers(Place::node) != nullptr);
  CHECK(*copied.numbers(Place::node) == std::vector<std::int64_t>{3, 5});
  mine.at(Place::node, {3, 4});
  CHECK_FALSE(mine.difference_of_structure(copied).empty());
}
