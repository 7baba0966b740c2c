
TEST_CASE("a run goes on from a state that was saved as it went on before, in the same problem and in another one")
{
  Square one("neo_hooke", 0.1), two("neo_hooke", 0.1);
  problems::ExplicitProblem problem(one.u, one.v, one.body()), other(two.u, two.v, two.body());
  const double step = problem.stable_step();
  problem.advance(10.0 * step);
  const state::State saved = problems::saved_state(problem);
  CHECK(saved.values<std::int64_t>("step")[0] == problem.step());
  CHECK(problems::empty_state(other).difference_of_structure(saved).empty());
  problem.advance(25.0 * step);
  const std::vector<double> end(one.u->x()->array().begin(), one.u->x()->array().end());
  const std::int64_t steps = problem.step();
  problems::RunObserver nobody;
  for (auto* from : {&problem, &other})
  {
    problems::resume(*from, saved, std::nullopt, nobody);
    CHECK(from->time() == 10.0 * step);
    from->advance(25.0 * step);
    CHECK(from->step() == steps);
    CHECK(std::ranges::equal(from->displacement()->x()->array(), end));
  }
  Square third("linear_elastic");
  problems::ExplicitProblem another(third.u, third.v, third.body());
  CHECK_FALSE(problems::empty_state(another).difference_of_structure(saved).empty());
}
