// SPDX-License-Identifier: MIT
#include "GeneralContact.h"
#include "bindings.h"
#include "contact_explicit.h"
#include <array>

namespace nb = nanobind;

namespace impact_reference
{
namespace
{
using Obstacles = std::vector<std::tuple<std::string, Vector, Vector, double, Vector>>;

// What both kinds of contact are made of; master has no facets if there is an obstacle. A search distance that is not a
// number stands for the default one. Normals of a smooth master at the vertices of its facets, or none.
NodePairs node_pairs(const Model& model, const Cells& slave, const Cells& master, const Obstacles& obstacle,
                     double distance, const Vector& mass, const Matrix& displacement, const Matrix& normals)
{
  std::optional<double> search_distance;
  if (not std::isnan(distance))
    search_distance = distance;
  if (distance <= 0)
    throw std::invalid_argument("the search distance must be positive");
  if (obstacle.empty())
  {
    Surface other = surface(model, master, "master");
    if (normals.rows() > 0)
      smooth(other, master, normals);
    return {model, surface(model, slave, "slave"), std::move(other), {}, search_distance, mass, displacement};
  }
  const auto& [shape, point, direction, radius, pivot] = obstacle[0];
  if (displacement.cols() != model.gdim() or not displacement.allFinite())
    throw std::invalid_argument("the obstacle's displacements must be finite, a row per time level");
  return {model,
          surface(model, slave, "slave"),
          {},
          rigid({shape, point, direction, radius, pivot}, model.gdim()),
          search_distance,
          mass,
          displacement};
}

// Layers, clearance and limit of gaps that are adjusted; what is not a number is not given.
void adjust(NodePairs& pairs, const std::array<double, 3>& gaps, double distance)
{
  const auto given = [](double value) { return std::isnan(value) ? std::optional<double>() : value; };
  if (gaps[0] != 0 or given(gaps[1]) or given(gaps[2]))
    pairs.adjust_gaps(gaps[0], given(gaps[1]), given(gaps[2]), std::isnan(distance));
}

void check_friction(double friction)
{
  if (not(friction >= 0) or not std::isfinite(friction))
    throw std::invalid_argument("the friction coefficient must not be negative");
}
} // namespace

void bind_explicit(nb::module_& m)
{
  using P = const Matrix&;
  using V = const Vector&;
  using Dofs = const std::vector<std::int64_t>&;

  nb::class_<RigidBall>(m, "RigidBall")
      .def("__init__",
           [](RigidBall* self, int gdim, double radius, V centre, double mass, double inertia, V velocity, V spin,
              V force)
           {
             const auto three = [](V v)
             {
               Vec<double> out;
               for (int c = 0; c < v.size() and c < 3; ++c)
                 out[c] = v(c);
               return out;
             };
             new (self)
                 RigidBall(gdim, radius, three(centre), mass, inertia, three(velocity), three(spin), three(force));
           });
  nb::class_<ExplicitContact>(m, "ExplicitContact").def_prop_ro("nodes", &ExplicitContact::nodes);
  nb::class_<NodalPenalty, ExplicitContact>(m, "NodalPenalty")
      .def(
          "__init__",
          [](NodalPenalty* self, const Model& model, const Cells& slave, const Cells& master, const Obstacles& obstacle,
             double search_distance, V mass, P displacement, P slave_normals, P master_normals,
             const std::array<double, 3>& gaps, double friction, double penalty, bool balanced, P points, V weights,
             P mass_points, V mass_weights, const std::string& lumping, const std::vector<PlasticBody*>& plastic,
             const std::vector<std::shared_ptr<RigidBall>>& ball, double stiffness_step, P angles)
          {
            check_friction(friction);
            if (not(penalty >= 0) or not std::isfinite(penalty))
              throw std::invalid_argument("the penalty must be positive");
            if (balanced and not obstacle.empty())
              throw std::invalid_argument("a balanced pair needs a deformable master: leave out balanced");
            std::vector<NodePairs> pairs{
                node_pairs(model, slave, master, obstacle, search_distance, mass, displacement, master_normals)};
            pairs[0].set_angles(angles);
            if (not ball.empty())
              pairs[0].set_ball(ball[0]);
            if (balanced)
              pairs.push_back(
                  node_pairs(model, master, slave, obstacle, search_distance, mass, displacement, slave_normals));
            for (NodePairs& one : pairs)
              adjust(one, gaps, search_distance);
            if (penalty == 0)
            {
              const Sampler sampler = model.sampler({points, weights});
              const auto stiffness = [&](std::int64_t cell) -> Matrix
              {
                return plastic.empty()
                           ? impact_reference::stiffness(sampler, model.cell_points(cell), model.material(cell), cell)
                           : plastic[0]->stiffness_at_rest(cell);
              };
              const auto of = [&](const Cells& facets, const std::string& name)
              {
                return nodal_stiffness(model, surface(model, facets, name), stiffness, {mass_points, mass_weights},
                                       lumping);
              };
              const NodalStiffness low = of(slave, "slave");
              const NodalStiffness high = obstacle.empty() ? of(master, "master") : NodalStiffness{};
              pairs[0].set_stiffness(low, high);
              if (balanced)
                pairs[1].set_stiffness(high, low);
            }
            new (self) NodalPenalty(std::move(pairs), friction, penalty, stiffness_step);
          },
          nb::keep_alive<1, 2>())
      .def("added_frequency", &NodalPenalty::added_frequency)
      .def("springs", [](const NodalPenalty& s, V u) { return csr(s.springs(u), u.size()); });
  nb::class_<NodalKinematic, ExplicitContact>(m, "NodalKinematic")
      .def(
          "__init__",
          [](NodalKinematic* self, const Model& model, const Cells& slave, const Cells& master,
             const Obstacles& obstacle, double search_distance, V mass, P displacement, P, P master_normals,
             const std::array<double, 3>& gaps, double friction, int sweeps)
          {
            check_friction(friction);
            if (sweeps < 1)
              throw std::invalid_argument("kinematic contact needs at least one sweep");
            NodePairs pairs =
                node_pairs(model, slave, master, obstacle, search_distance, mass, displacement, master_normals);
            adjust(pairs, gaps, search_distance);
            new (self) NodalKinematic(std::move(pairs), friction, sweeps);
          },
          nb::keep_alive<1, 2>());
  nb::class_<GeneralContact, ExplicitContact>(m, "GeneralContact")
      .def(
          "__init__",
          [](GeneralContact* self, const Model& model, const Cells& outside, V mass, double friction, P points,
             V weights, P mass_points, V mass_weights, const std::string& lumping)
          {
            check_friction(friction);
            const Sampler sampler = model.sampler({points, weights});
            const auto stiffness = [&](std::int64_t cell) -> Matrix
            { return impact_reference::stiffness(sampler, model.cell_points(cell), model.material(cell), cell); };
            const Surface all = surface(model, outside, "outside");
            new (self)
                GeneralContact(model, all, nodal_stiffness(model, all, stiffness, {mass_points, mass_weights}, lumping),
                               mass, friction);
          },
          nb::keep_alive<1, 2>());
  nb::class_<ContactHistories>(m, "ContactHistories")
      .def_ro("total", &ContactHistories::total)
      .def_ro("force", &ContactHistories::force)
      .def_ro("gap", &ContactHistories::gap)
      .def_ro("traction", &ContactHistories::traction)
      .def_ro("slip", &ContactHistories::slip)
      .def_ro("status", &ContactHistories::status);
  nb::class_<ExplicitHistory>(m, "ExplicitHistory")
      .def_ro("time", &ExplicitHistory::time)
      .def_ro("u", &ExplicitHistory::u)
      .def_ro("v", &ExplicitHistory::v)
      .def_ro("a", &ExplicitHistory::a)
      .def_ro("half", &ExplicitHistory::half)
      .def_ro("support", &ExplicitHistory::support)
      .def_ro("energies", &ExplicitHistory::energies)
      .def_ro("contacts", &ExplicitHistory::contacts)
      .def_ro("equivalent", &ExplicitHistory::equivalent)
      .def_ro("plastic", &ExplicitHistory::plastic)
      .def_ro("back_stress", &ExplicitHistory::back_stress);

  m.def("run_explicit",
        [](const Model& model, P points, V weights, P mass_points, V mass_weights, const std::string& lumping, V steps,
           V u0, V v0, Dofs fixed, P values, P loads, P amplitudes, double alpha, double beta, bool classical,
           double b1, double b2, int every, const std::vector<ExplicitContact*>& contacts,
           const std::vector<PlasticBody*>& plastic)
        {
          return run_explicit(model, {{points, weights},
                                      {mass_points, mass_weights},
                                      lumping,
                                      steps,
                                      u0,
                                      v0,
                                      fixed,
                                      values,
                                      loads,
                                      amplitudes,
                                      alpha,
                                      beta,
                                      classical,
                                      b1,
                                      b2,
                                      every,
                                      contacts,
                                      plastic.empty() ? nullptr : plastic[0]});
        });
  m.def("viscous_force", [](const Model& s, P points, V weights, V u, V v, double b1, double b2)
        { return s.viscous_force({points, weights}, u, v, b1, b2); });
  m.def("cell_frequency",
        [](const Model& s, P points, V weights, P mass_points, V mass_weights, const std::string& lumping)
        { return s.cell_frequency({points, weights}, {mass_points, mass_weights}, lumping); });
  m.def("passage", &Model::passage);
  m.def("highest_frequency",
        [](const Integers& indptr, const Integers& indices, V data, const std::vector<Csr*>& springs, V mass,
           Dofs fixed) { return highest_frequency(csr(indptr, indices, data), springs, mass, fixed); });
}
} // namespace impact_reference
