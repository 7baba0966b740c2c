// SPDX-License-Identifier: MIT
#include "TrialSprings.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Springs between the surfaces of a contact.
std::shared_ptr<NodePenalty> springs_of(const surface::FunctionSpace& V, const NodalContact& direction)
{
  const auto* contact = dynamic_cast<const NodeToSurface*>(&direction);
  if (!contact)
    throw std::invalid_argument("springs are tried of contacts that have surfaces (NodeToSurface)");
  const auto* springs = dynamic_cast<const NodePenalty*>(contact);
  NodePenaltyOptions options = springs ? springs->penalty_options() : NodePenaltyOptions{contact->options()};
  const NodeCandidates& surfaces = contact->candidates();
  if (options.adjustment.any()) // where springs are does not depend on it, but on how far surfaces are searched for
    options.search_distance = surfaces.distance();
  options.adjustment = {};
  auto out = contact->obstacle() ? std::make_shared<NodePenalty>(V, surfaces.slave(), *contact->obstacle(), options)
                                 : std::make_shared<NodePenalty>(V, surfaces.slave(), surfaces.master(), options);
  if (springs && !springs->nodal_compliances().slave.empty())
    out->set_nodal_compliances(springs->nodal_compliances());
  return out;
}
} // namespace

TrialSprings::TrialSprings(const surface::FunctionSpace& V, const NodalPair& pair, std::span<const double> u,
                           std::span<const double> mass)
    : _gdim(V.mesh()->geometry().dim())
{
  const auto& own = *V.dofmap()->index_map;
  const std::size_t owned = own.size_local();
  u = u.first(owned * _gdim);
  std::vector<std::int64_t> ghosts(own.ghosts().begin(), own.ghosts().end());
  std::vector<int> owners(own.owners().begin(), own.owners().end());
  std::vector<std::int64_t> known = ghosts;
  std::ranges::sort(known);
  std::vector<std::pair<std::int64_t, int>> found;
  for (const auto& direction : pair.directions())
  {
    NodePenalty& springs = *_directions.emplace_back(springs_of(V, *direction));
    springs.search(u, {});
    for (std::size_t k = 0; k < springs.remote_nodes().size(); ++k)
      if (!std::ranges::binary_search(known, springs.remote_nodes()[k]))
        found.emplace_back(springs.remote_nodes()[k], springs.remote_owners()[k]);
  }
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const auto& [node, owner] : found)
  {
    ghosts.push_back(node);
    owners.push_back(owner);
  }
  _halo = std::make_unique<operators::Halo>(
      std::make_shared<const dolfinx::common::IndexMap>(own.comm(), own.size_local(), ghosts, owners));
  _u.assign(std::size_t(_halo->num_nodes()) * _gdim, 0.0);
  std::ranges::copy(u, _u.begin());
  _halo->forward(_u, _gdim);
  std::vector<double> masses(_halo->num_nodes(), 1.0); // a given stiffness does not need them
  if (!mass.empty())
  {
    std::ranges::copy(mass.first(owned), masses.begin());
    _halo->forward(masses, 1);
  }
  std::vector<std::int32_t> same(_halo->num_nodes());
  std::iota(same.begin(), same.end(), 0);
  for (const auto& direction : _directions)
  {
    direction->required_nodes(*_halo);
    direction->assign_numbers(*_halo, same, masses);
  }
}

std::array<double, 3> TrialSprings::force(double step)
{
  const std::vector<double> rest(_u.size(), 0.0), one(_u.size(), 1.0);
  std::vector<double> forces(_u.size(), 0.0);
  for (const auto& direction : _directions)
    direction->add_forces({_u, rest, one, step}, forces);
  std::array<double, 3> out =
      NodalPair(std::vector<std::shared_ptr<NodalContact>>(_directions.begin(), _directions.end())).force();
  MPI_Allreduce(MPI_IN_PLACE, out.data(), 3, MPI_DOUBLE, MPI_SUM, _halo->map().comm());
  return out;
}

std::int64_t TrialSprings::implausible() const
{
  return std::accumulate(_directions.begin(), _directions.end(), std::int64_t(0),
                         [](std::int64_t sum, const auto& direction) { return sum + direction->implausible(); });
}

void TrialSprings::add_to(Mat matrix) const
{
  // The matrix has no places for them: they get one of their own.
  PetscInt rows = 0, all_rows = 0;
  operators::check(MatGetLocalSize(matrix, &rows, nullptr), "a matrix is asked for its size");
  operators::check(MatGetSize(matrix, &all_rows, nullptr), "a matrix is asked for its size");
  Mat own = nullptr;
  operators::check(MatCreate(_halo->map().comm(), &own), "a matrix of springs is made");
  const std::unique_ptr<std::remove_pointer_t<Mat>, void (*)(Mat)> holder(own, [](Mat m) { MatDestroy(&m); });
  operators::check(MatSetSizes(own, rows, rows, all_rows, all_rows), "a matrix of springs is made");
  operators::check(MatSetType(own, MATAIJ), "a matrix of springs is made");
  operators::check(MatSetUp(own), "a matrix of springs is made");
  std::vector<std::int32_t> nodes;
  std::vector<std::int64_t> numbers;
  std::vector<PetscInt> dofs;
  std::vector<PetscScalar> block;
  std::vector<double> weights;
  for (const auto& direction : _directions)
  {
    const NodalSprings springs = direction->springs_at(_u);
    const std::size_t num = 1 + springs.num_masters;
    const bool sticks = direction->options().has_friction();
    for (std::size_t s = 0; s < springs.nodes.size(); ++s)
    {
      nodes.assign(1, springs.nodes[s]);
      weights.assign(1, 1.0);
      for (std::size_t j = s * (num - 1); j < (s + 1) * (num - 1); ++j)
      {
        nodes.push_back(springs.masters[j]);
        weights.push_back(-springs.phi[j]);
      }
      numbers.resize(num);
      _halo->map().local_to_global(nodes, numbers);
      dofs.clear();
      for (const std::int64_t number : numbers)
        for (int c = 0; c < _gdim; ++c)
          dofs.push_back(PetscInt(number * _gdim + c));
      const double* n = springs.normal.data() + s * _gdim;
      block.clear();
      for (const double row : weights)
        for (int a = 0; a < _gdim; ++a)
          for (const double column : weights)
            for (int b = 0; b < _gdim; ++b)
              block.push_back(springs.stiffness[s] * row * column * (sticks ? double(a == b) : n[a] * n[b]));
      operators::check(MatSetValues(own, PetscInt(dofs.size()), dofs.data(), PetscInt(dofs.size()), dofs.data(),
                                    block.data(), ADD_VALUES),
                       "springs are added to a matrix");
    }
  }
  operators::check(MatAssemblyBegin(own, MAT_FINAL_ASSEMBLY), "a matrix of springs is assembled");
  operators::check(MatAssemblyEnd(own, MAT_FINAL_ASSEMBLY), "a matrix of springs is assembled");
  operators::check(MatAXPY(matrix, 1.0, own, DIFFERENT_NONZERO_PATTERN), "springs are added to a matrix");
}
} // namespace dolfinx_impact::enforcement
