// SPDX-License-Identifier: MIT
#include "RigidBodyInTime.h"
#include "../common/gather.h"
#include "../enforcement/node_to_surface/NodeLaw.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace dolfinx_impact::problems
{
namespace
{
/// How much softer springs are beside those to other rigid bodies, which have a two-hundredth of their limit: with a
/// hundredth of the areas as the weight of these in Gershgorin's bound.
constexpr double beside = 1.01;

/// Largest arm about the centre that a contact force can have.
double largest_arm(MPI_Comm comm, const enforcement::NodeToSurface& contact)
{
  const gap::Rigid& obstacle = *contact.obstacle();
  const int gdim = obstacle.gdim;
  if (obstacle.kind == gap::Rigid::Kind::sphere || (obstacle.kind == gap::Rigid::Kind::cylinder && gdim == 2))
  {
    // Normal forces pass through the middle of a ball, friction acts on its surface, and a law may have it.
    const bool friction =
        contact.options().has_friction() || dynamic_cast<const enforcement::NodeLaw*>(&contact) != nullptr;
    double square = 0.0;
    for (int c = 0; c < gdim; ++c)
      square += std::pow(obstacle.point[c] - obstacle.centre[c], 2);
    return std::sqrt(square) + (friction ? std::abs(obstacle.radius) : 0.0);
  }
  double square = 0.0;
  const std::vector<double>& X = contact.candidates().X();
  for (std::size_t i = 0; i < X.size(); i += gdim)
  {
    double sum = 0.0;
    for (int c = 0; c < gdim; ++c)
      sum += std::pow(X[i + c] - obstacle.centre[c] - obstacle.displacement[c], 2);
    square = std::max(square, sum);
  }
  return std::sqrt(common::largest(comm, square));
}
} // namespace

void meet(RigidBodyInTime& slave, integrators::RigidContactOptions options, std::shared_ptr<RigidBodyInTime> master)
{
  // The body has its contact, which therefore does not own the body; `meetings` owns the other one.
  const auto borrowed = [](integrators::RigidBody* body)
  { return std::shared_ptr<integrators::RigidBody>(std::shared_ptr<void>(), body); };
  auto contact = std::make_shared<integrators::RigidContact>(std::move(options), borrowed(&slave.body),
                                                             borrowed(master ? &master->body : nullptr));
  slave.meetings.push_back({std::move(contact), std::move(master)});
}

void set_mobility(MPI_Comm comm, const integrators::RigidBody& body,
                  std::span<const enforcement::NodalPair* const> contacts, bool meets)
{
  std::vector<enforcement::NodeToSurface*> springs;
  for (const enforcement::NodalPair* contact : contacts)
  {
    auto* const found = dynamic_cast<enforcement::NodeToSurface*>(contact->directions().front().get());
    if (!found || !found->obstacle())
      throw std::invalid_argument("contact with a rigid body acts by springs, with the body as the master");
    springs.push_back(found);
  }
  double area = 0.0, arm = 0.0;
  for (const enforcement::NodeToSurface* contact : springs)
  {
    const std::vector<double>& areas = contact->candidates().areas();
    area += std::accumulate(areas.begin(), areas.end(), 0.0);
    if (body.rotates())
      arm = std::max(arm, largest_arm(comm, *contact));
  }
  area = common::sum(comm, area);
  for (enforcement::NodeToSurface* contact : springs)
    contact->set_mobility((meets ? beside : 1.0) * area * body.mobility(arm));
}
} // namespace dolfinx_impact::problems
