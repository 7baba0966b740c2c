// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/enforcement/general/GeneralContact.h"
#include "dolfinx_impact/enforcement/node_to_surface/KinematicStep.h"
#include "dolfinx_impact/enforcement/node_to_surface/NodalPair.h"
#include "dolfinx_impact/enforcement/node_to_surface/NodeLaw.h"
#include <algorithm>
#include <array>
#include <numeric>

using namespace dolfinx_impact::enforcement;
using dolfinx_impact::gap::GapAdjustment;
using dolfinx_impact::gap::Rigid;
using dolfinx_impact::operators::Halo;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;

/// Arrays over the nodes of the Halo, checked.
template <typename T>
auto over(const Halo& halo, const T& values, int bs, const char* name)
{
  if (values.size() != std::size_t(halo.num_nodes()) * bs)
    throw std::invalid_argument(std::string(name) + ": " + std::to_string(halo.num_nodes() * bs) +
                                " values are needed, not " + std::to_string(values.size()));
  return std::span(values.data(), values.size());
}

NodalState nodal_state(const Halo& halo, int gdim, const Values& u, const Values& du, const Values& inverse_mass,
                       double dt)
{
  return {over(halo, u, gdim, "u"), over(halo, du, gdim, "du"), over(halo, inverse_mass, gdim, "inverse_mass"), dt};
}

template <typename T>
auto rows(const std::vector<T>& values, std::size_t n)
{
  return copy(values, {n, n ? values.size() / n : 0});
}

/// Arrays by node, by their names.
typedef nb::typed<nb::dict, std::string, AnyArray> Results;

Results results(const NodeToSurface& self)
{
  const NodalResults& r = self.results();
  const std::size_t n = r.gap.size(), gdim = self.candidates().gdim();
  std::vector<std::int8_t> status(n);
  std::transform(r.status.begin(), r.status.end(), status.begin(), [](ContactStatus s) { return std::int8_t(s); });
  Results out;
  out["status"] = take(std::move(status));
  out["gap"] = copy(r.gap, {n});
  out["normal"] = copy(r.normal, {n, gdim});
  out["pressure"] = copy(r.pressure, {n});
  out["traction"] = copy(r.traction, {n, gdim});
  out["slip"] = copy(r.slip, {n, gdim});
  const auto* springs = dynamic_cast<const NodePenalty*>(&self);
  out["stiffness"] = springs ? copy(springs->stiffness(), {n}) : take(std::vector<double>(n, 0.0));
  return out;
}

nb::typed<nb::dict, std::string, std::int64_t> counters(const NodeToSurface& self)
{
  const auto& c = self.tracker().counters();
  nb::typed<nb::dict, std::string, std::int64_t> out;
  out["steps"] = c.steps;
  out["nodes"] = c.nodes;
  out["queries"] = c.queries;
  out["projections"] = c.projections;
  out["refits"] = c.refits;
  out["normals"] = c.normals;
  out["renewals"] = c.renewals;
  out["searches"] = self.candidates().searches();
  out["implausible"] = self.implausible();
  return out;
}

nb::typed<nb::dict, std::string, double> energies(const ContactEnergy& e)
{
  nb::typed<nb::dict, std::string, double> out;
  out["stored"] = e.stored;
  out["friction"] = e.friction;
  out["normal"] = e.normal;
  out["later_friction"] = e.later_friction;
  out["later_normal"] = e.later_normal;
  out["recoverable"] = e.recoverable;
  return out;
}

template <typename Master>
void construct_penalty(NodePenalty* self, const FunctionSpace& V, const Facets& slave, const Master& master,
                       double friction, double penalty, double kappa, double share, double search_distance,
                       bool axisymmetric, bool by_step, std::string name, const GapAdjustment& adjustment)
{
  new (self) NodePenalty(
      V, slave, master,
      {{friction, search_distance, axisymmetric, std::move(name), adjustment}, penalty, kappa, share, by_step});
}

template <typename Master>
void construct_law(NodeLaw* self, const FunctionSpace& V, const Facets& slave, const Master& master,
                   std::shared_ptr<const InterfaceLaw> law, double friction, double search_distance, bool axisymmetric,
                   std::string name, const GapAdjustment& adjustment)
{
  new (self)
      NodeLaw(V, slave, master, std::move(law), {friction, search_distance, axisymmetric, std::move(name), adjustment});
}

template <typename Master>
void construct_kinematic(KinematicContact* self, const FunctionSpace& V, const Facets& slave, const Master& master,
                         double friction, int sweeps, double search_distance, bool axisymmetric, std::string name,
                         const GapAdjustment& adjustment, std::shared_ptr<const FrictionLaw> law)
{
  new (self) KinematicContact(
      V, slave, master,
      {{friction, search_distance, axisymmetric, std::move(name), adjustment, std::move(law)}, sweeps});
}
} // namespace

void dolfinx_impact::bindings::nodal(nb::module_& m)
{
  nb::class_<NodalContact>(m, "NodalContact", "Contact as the explicit integrator sees it")
      .def("saved_state", &NodalContact::saved_state, "What the next step starts from, values of its own")
      .def("resume", &NodalContact::resume, nb::arg("saved"), "Go on from what saved_state has returned")
      .def("reset", &NodalContact::reset, "All nodes become open, energies and histories those of the start");
  nb::class_<NodeToSurface, NodalContact>(m, "NodeToSurface",
                                          "Slave nodes against a surface, step after step; all arrays are copies")
      .def(
          "search", [](NodeToSurface& self, Values u, Values du)
          { self.search({u.data(), u.size()}, {du.data(), du.size()}); }, nb::arg("u"), nb::arg("du"),
          "Find candidates; u: displacements of owned nodes, du: what they move in a step, or empty. Collective")
      .def_prop_ro(
          "remote_nodes",
          [](const NodeToSurface& self)
          {
            const auto nodes = self.remote_nodes();
            return take(std::vector<std::int64_t>(nodes.begin(), nodes.end()));
          },
          nb::rv_policy::move)
      .def_prop_ro(
          "remote_owners",
          [](const NodeToSurface& self)
          {
            const auto owners = self.remote_owners();
            return take(std::vector<std::int32_t>(owners.begin(), owners.end()));
          },
          nb::rv_policy::move)
      .def_prop_ro("facet_length", &NodeToSurface::facet_length)
      .def(
          "assign_numbers",
          [](NodeToSurface& self, Halo& halo, Values mass)
          {
            std::vector<std::int32_t> same(halo.num_nodes());
            std::iota(same.begin(), same.end(), 0);
            self.required_nodes(halo);
            self.assign_numbers(halo, same, over(halo, mass, 1, "mass"));
          },
          nb::arg("halo"), nb::arg("mass"), nb::keep_alive<1, 2>(), "Take the numbers of nodes from a Halo. Collective")
      .def(
          "increment_used",
          [](const NodeToSurface& self, const Halo& halo, Values u, Values du, Values inverse_mass, double dt)
          { return self.increment_used(nodal_state(halo, self.candidates().gdim(), u, du, inverse_mass, dt)); },
          nb::arg("halo"), nb::arg("u"), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("dt"))
      .def(
          "update_gaps", [](NodeToSurface& self, const Halo& halo, Values u)
          { self.update_gaps(over(halo, u, self.candidates().gdim(), "u")); }, nb::arg("halo"), nb::arg("u"),
          "Bring the gaps of open nodes up to date")
      .def("keep_normals", &NodeToSurface::keep_normals, nb::arg("keep"),
           "For tests of tests: judge facing by the normals of the last search")
      .def(
          "set_obstacle", [](NodeToSurface& self, std::array<double, 3> displacement, std::array<double, 3> increment)
          { self.set_obstacle({.displacement = displacement, .increment = increment}); }, nb::arg("displacement"),
          nb::arg("increment"))
      .def_prop_ro(
          "nodes",
          [](const NodeToSurface& self)
          {
            const auto nodes = self.candidates().nodes();
            return take(std::vector<std::int32_t>(nodes.begin(), nodes.end()));
          },
          nb::rv_policy::move)
      .def_prop_ro(
          "X", [](const NodeToSurface& self) { return rows(self.candidates().X(), self.candidates().nodes().size()); },
          nb::rv_policy::move)
      .def_prop_ro(
          "areas", [](const NodeToSurface& self)
          { return copy(self.candidates().areas(), {self.candidates().nodes().size()}); }, nb::rv_policy::move)
      .def_prop_ro("search_distance", [](const NodeToSurface& self) { return self.candidates().distance(); })
      .def_prop_ro(
          "force", [](const NodeToSurface& self)
          { return take(std::vector<double>(self.force().begin(), self.force().begin() + self.candidates().gdim())); },
          nb::rv_policy::move)
      .def("results", &results)
      .def("energy", [](const NodeToSurface& self) { return energies(self.energy()); })
      .def_prop_ro(
          "passage",
          [](const NodeToSurface& self)
          {
            const auto p = self.passage();
            return std::pair(p.node, p.facets);
          },
          "Local number (-1: none) of the slave node that went through the master fastest, facets per step")
      .def("counters", &counters)
      .def_prop_ro(
          "initial", [](const NodeToSurface& self) { return self.initial(); },
          "Penetrations in the reference configuration, where gaps are adjusted");

  const NodePenaltyOptions p;
  nb::class_<NodePenalty, NodeToSurface>(m, "NodePenalty", "Springs between slave nodes and the master")
      .def("__init__", &construct_penalty<Facets>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = p.friction, nb::arg("penalty") = p.penalty, nb::arg("kappa") = p.kappa,
           nb::arg("share") = p.share, nb::arg("search_distance") = p.search_distance,
           nb::arg("axisymmetric") = p.axisymmetric, nb::arg("by_step") = p.by_step, nb::arg("name") = p.name,
           nb::arg("adjustment") = p.adjustment)
      .def("__init__", &construct_penalty<Rigid>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = p.friction, nb::arg("penalty") = p.penalty, nb::arg("kappa") = p.kappa,
           nb::arg("share") = p.share, nb::arg("search_distance") = p.search_distance,
           nb::arg("axisymmetric") = p.axisymmetric, nb::arg("by_step") = p.by_step, nb::arg("name") = p.name,
           nb::arg("adjustment") = p.adjustment)
      .def(
          "add_forces",
          [](NodePenalty& self, const Halo& halo, Values u, Values du, Values inverse_mass, double dt, MutableValues f,
             int times)
          {
            const int gdim = self.candidates().gdim();
            const NodalState now = nodal_state(halo, gdim, u, du, inverse_mass, dt);
            const std::span<double> forces = over(halo, f, gdim, "f");
            for (int i = 0; i < times; ++i)
              self.add_forces(now, forces);
          },
          nb::arg("halo"), nb::arg("u"), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("dt"),
          nb::arg("f").noconvert(), nb::arg("times") = 1,
          "Add the forces to f (a view is changed); several times for timing");

  nb::class_<NodeLaw, NodeToSurface>(m, "NodeLaw", "A law of the interface at slave nodes")
      .def("__init__", &construct_law<Facets>, nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("law"),
           nb::arg("friction") = p.friction, nb::arg("search_distance") = p.search_distance,
           nb::arg("axisymmetric") = p.axisymmetric, nb::arg("name") = p.name, nb::arg("adjustment") = p.adjustment)
      .def("__init__", &construct_law<Rigid>, nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("law"),
           nb::arg("friction") = p.friction, nb::arg("search_distance") = p.search_distance,
           nb::arg("axisymmetric") = p.axisymmetric, nb::arg("name") = p.name, nb::arg("adjustment") = p.adjustment);

  const KinematicContactOptions k;
  nb::class_<KinematicContact, NodeToSurface>(m, "KinematicContact", "Forces that correct a predicted step")
      .def("__init__", &construct_kinematic<Facets>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = k.friction, nb::arg("sweeps") = k.sweeps,
           nb::arg("search_distance") = k.search_distance, nb::arg("axisymmetric") = k.axisymmetric,
           nb::arg("name") = k.name, nb::arg("adjustment") = k.adjustment, nb::arg("friction_law").none() = nb::none())
      .def("__init__", &construct_kinematic<Rigid>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = k.friction, nb::arg("sweeps") = k.sweeps,
           nb::arg("search_distance") = k.search_distance, nb::arg("axisymmetric") = k.axisymmetric,
           nb::arg("name") = k.name, nb::arg("adjustment") = k.adjustment, nb::arg("friction_law").none() = nb::none())
      .def(
          "correct",
          [](KinematicContact& self, Halo& halo, MutableValues u, Values du, Values inverse_mass, double h, double dt,
             MutableValues f, double share)
          {
            const int gdim = self.candidates().gdim();
            const std::vector<double> rest(u.size(), 0.0);
            const PredictedStep step{
                over(halo, du, gdim, "du"), rest, over(halo, inverse_mass, gdim, "inverse_mass"), h, dt, share};
            dolfinx_impact::enforcement::KinematicStep all;
            all.add(&self);
            std::vector<std::int32_t> numbers(halo.num_nodes());
            std::iota(numbers.begin(), numbers.end(), 0);
            all.assign_numbers(halo, halo, numbers);
            all.correct(step, over(halo, u, gdim, "u"), over(halo, f, gdim, "f"));
          },
          nb::arg("halo"), nb::arg("u").noconvert(), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("h"),
          nb::arg("dt"), nb::arg("f").noconvert(), nb::arg("share") = 1.0,
          "Correct u and add the forces to f (views are changed); before the step nothing moved. Collective");

  nb::class_<GeneralContact, NodalContact>(m, "GeneralContact",
                                           "All facets of a surface against each other; all arrays are copies")
      .def(
          "__init__",
          [](GeneralContact* self, const FunctionSpace& V, const Facets& facets, double friction,
             const std::vector<std::pair<Facets, Facets>>& named, bool axisymmetric)
          {
            std::vector<NamedPair> pairs;
            for (const auto& [slave, master] : named)
              pairs.push_back({slave, master});
            new (self) GeneralContact(V, facets, {friction, axisymmetric}, pairs);
          },
          nb::arg("V"), nb::arg("facets"), nb::arg("friction") = 0.0,
          nb::arg("named") = std::vector<std::pair<Facets, Facets>>(), nb::arg("axisymmetric") = false,
          "named: pairs of surfaces that other contacts push apart. Collective")
      .def_prop_ro(
          "nodes",
          [](const GeneralContact& self)
          {
            const auto nodes = self.candidates().nodes();
            return take(std::vector<std::int32_t>(nodes.begin(), nodes.end()));
          },
          nb::rv_policy::move)
      .def_prop_ro(
          "X", [](const GeneralContact& self) { return rows(self.candidates().X(), self.candidates().nodes().size()); },
          nb::rv_policy::move)
      .def_prop_ro(
          "areas", [](const GeneralContact& self)
          { return copy(self.candidates().areas(), {self.candidates().nodes().size()}); }, nb::rv_policy::move)
      .def("normals", [](const GeneralContact& self) { return rows(self.normals(), self.candidates().nodes().size()); })
      .def(
          "nodal_forces", [](const GeneralContact& self)
          { return rows(self.nodal_forces(), self.candidates().nodes().size()); }, "Collective")
      .def("results",
           [](const GeneralContact& self)
           {
             const GeneralResults& r = self.results();
             const std::size_t n = r.gap.size();
             std::vector<std::int8_t> status(n);
             std::transform(r.status.begin(), r.status.end(), status.begin(),
                            [](ContactStatus s) { return std::int8_t(s); });
             Results out;
             out["status"] = take(std::move(status));
             out["gap"] = copy(r.gap, {n});
             out["slip"] = copy(r.slip, {n, std::size_t(self.candidates().gdim())});
             return out;
           })
      .def_prop_ro("deepest", &GeneralContact::deepest)
      .def_prop_ro("num_springs", &GeneralContact::num_springs, "Springs of nodes, and of crossed edges, on this rank")
      .def_prop_ro("num_candidates", &GeneralContact::num_candidates,
                   "Listed pairs of nodes and facets, and of edges, on this rank")
      .def_prop_ro("searches", [](const GeneralContact& self) { return self.candidates().searches(); })
      .def("energy", [](const GeneralContact& self) { return energies(self.energy()); });

  nb::class_<NodalPair>(m, "NodalPair", "Contact of a pair in an explicit problem: one direction, or both (balanced)")
      .def(nb::init<std::vector<std::shared_ptr<NodalContact>>>(), nb::arg("directions"),
           "The first direction has the slave of the pair, a second one has both surfaces exchanged")
      .def_prop_ro("directions",
                   [](const NodalPair& self)
                   {
                     nb::typed<nb::list, NodalContact> out;
                     for (const auto& contact : self.directions())
                       out.append(contact);
                     return out;
                   })
      .def_prop_ro(
          "force",
          [](const NodalPair& self)
          {
            const std::array<double, 3> force = self.force();
            return take(std::vector<double>(force.begin(), force.end()));
          },
          nb::rv_policy::move, "Three components of the force on the slave in the last step, of this rank")
      .def("energy", [](const NodalPair& self) { return energies(self.energy()); });

  m.def(
      "balanced_penalty",
      [](const FunctionSpace& V, const Facets& slave, const Facets& master, double friction, double penalty,
         double kappa, double search_distance, bool axisymmetric, bool by_step, std::string name,
         const GapAdjustment& adjustment)
      {
        return balanced_penalty(
            V, slave, master,
            {{friction, search_distance, axisymmetric, std::move(name), adjustment}, penalty, kappa, 1.0, by_step});
      },
      nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("friction") = p.friction,
      nb::arg("penalty") = p.penalty, nb::arg("kappa") = p.kappa, nb::arg("search_distance") = p.search_distance,
      nb::arg("axisymmetric") = p.axisymmetric, nb::arg("by_step") = p.by_step, nb::arg("name") = p.name,
      nb::arg("adjustment") = p.adjustment,
      "Both directions of contact by penalty, each with half of the stiffness. Collective");
}
