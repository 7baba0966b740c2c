// SPDX-License-Identifier: MIT
#include "RunState.h"

using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace dolfinx_impact::integrators
{
namespace
{
void add_works(State& out, const std::string& name, RunState::Term& term)
{
  out.add(name + "_done", Place::rank, term.work.done);
  out.add(name + "_before", Place::rank, term.work.before);
  out.add(name + "_position", Place::rank, term.position);
}
} // namespace

RunState::RunState(std::size_t num_owned, std::size_t num_terms, std::size_t num_contacts, std::size_t num_bodies)
    : u(num_owned, 0.0), v(u), r(u), terms(num_terms, {u, {}, 0.0}), springs{u, {}, 0.0}, kinematic(u),
      obstacles(num_contacts), bodies(num_bodies)
{
}

State RunState::state(std::size_t bs)
{
  State works("works");
  works.add("residual", Place::rank, energies.residual_work).add("loads", Place::rank, energies.load_work);
  works.add("supports", Place::rank, energies.support_work).add("mass_damping", Place::rank, energies.damped);
  works.add("elastic", Place::rank, energies.elastic).add("obstacles", Place::rank, obstacle_work);
  add_works(works, "springs", springs);
  State common("common");
  common.add("reference", Place::rank, energies.reference).add("lowest", Place::rank, energies.lowest);
  common.add("largest", Place::rank, energies.largest).add("release_share", Place::rank, energies.release_share);
  common.add("release_limit", Place::rank, energies.release_limit).add("last_step", Place::rank, last_step);
  common.add("contact_step", Place::rank, contact_step).add("unwatched", Place::rank, unwatched);
  State out("integrator");
  out.add("u", Place::node, u, bs).add("v", Place::node, v, bs).add("r", Place::node, r, bs);
  out.add("springs", Place::node, springs.force, bs).add("kinematic", Place::node, kinematic, bs);
  for (std::size_t k = 0; k < terms.size(); ++k)
  {
    const std::string name = "term" + std::to_string(k);
    out.add(name, Place::node, terms[k].force, bs);
    add_works(works, name, terms[k]);
  }
  for (std::size_t k = 0; k < obstacles.size(); ++k)
    for (int c = 0; c < 3; ++c)
    {
      const std::string end = std::to_string(k) + "_" + "xyz"[c];
      common.add("obstacle" + end, Place::rank, obstacles[k].displacement[c]);
      common.add("obstacle_increment" + end, Place::rank, obstacles[k].increment[c]);
      common.add("obstacle_increment_before" + end, Place::rank, obstacles[k].increment_before[c]);
      if (!obstacles[k].rotates)
        continue;
      common.add("obstacle_angle" + end, Place::rank, obstacles[k].angle[c]);
      for (int d = 0; d < 3; ++d)
        common.add("obstacle_turn" + end + "xyz"[d], Place::rank, obstacles[k].turn[3 * c + d]);
    }
  out.add(std::move(works)).add(std::move(common));
  for (std::size_t k = 0; k < bodies.size(); ++k)
    out.add(bodies[k].state("body" + std::to_string(k)));
  return out;
}
} // namespace dolfinx_impact::integrators
