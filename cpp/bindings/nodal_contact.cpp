#include "arrays.h"
#include "dolfinx_impact/enforcement/NodeToSurface.h"
#include <algorithm>
#include <numeric>

using namespace impact::enforcement;
using impact::gap::Rigid;
using impact::operators::Halo;
using impact::surface::Facets;
using impact::surface::FunctionSpace;

namespace
{
using namespace impact::bindings;

NodeToSurfaceOptions options(double friction, double penalty, double kappa, bool balanced, bool kinematic, int sweeps,
                             double search_distance, bool axisymmetric)
{
  return {friction, penalty, kappa, balanced, kinematic, sweeps, search_distance, axisymmetric};
}

/// Arrays over the nodes of the Halo, checked.
template <typename T>
auto* over(const Halo& halo, const T& values, int bs, const char* name)
{
  if (values.size() != std::size_t(halo.num_nodes()) * bs)
    throw std::invalid_argument(std::string(name) + ": " + std::to_string(halo.num_nodes() * bs) +
                                " values are needed, not " + std::to_string(values.size()));
  return values.data();
}

NodalState state(const Halo& halo, int gdim, const Values& u, const Values& du, const Values& inverse_mass, double dt)
{
  return {over(halo, u, gdim, "u"), over(halo, du, gdim, "du"), over(halo, inverse_mass, gdim, "inverse_mass"), dt};
}

template <typename T>
auto rows(const std::vector<T>& values, std::size_t n)
{
  return copy(values, {n, n ? values.size() / n : 0});
}

nb::dict results(const NodeToSurface& self)
{
  const NodalResults& r = self.results();
  const std::size_t n = r.gap.size(), gdim = self.candidates().gdim();
  std::vector<std::int8_t> status(n);
  std::transform(r.status.begin(), r.status.end(), status.begin(), [](ContactStatus s) { return std::int8_t(s); });
  nb::dict out;
  out["status"] = take(std::move(status));
  out["gap"] = copy(r.gap, {n});
  out["normal"] = copy(r.normal, {n, gdim});
  out["pressure"] = copy(r.pressure, {n});
  out["traction"] = copy(r.traction, {n, gdim});
  out["slip"] = copy(r.slip, {n, gdim});
  out["stiffness"] = copy(self.stiffness(), {n});
  return out;
}

nb::dict history(const NodeToSurface& self)
{
  const NodalHistory h = self.history();
  const std::size_t n = h.closed.size(), gdim = self.candidates().gdim();
  nb::dict out;
  out["tangential"] = copy(h.tangential, {n, gdim});
  out["slip"] = copy(h.slip, {n, gdim});
  out["springs"] = copy(h.springs, {n, 5});
  out["closed"] = copy(h.closed, {n});
  out["facet"] = copy(h.facet, {n});
  out["xi"] = copy(h.xi, {n, 2});
  out["taken"] = copy(h.taken, {n});
  out["pulse"] = copy(h.pulse, {n});
  return out;
}

template <typename T>
std::vector<T> entries(const nb::dict& dict, const char* name)
{
  const auto array = nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(dict[name]);
  return {array.data(), array.data() + array.size()};
}

void set_history(NodeToSurface& self, const nb::dict& dict)
{
  self.set_history({entries<double>(dict, "tangential"), entries<double>(dict, "slip"),
                    entries<double>(dict, "springs"), entries<std::int8_t>(dict, "closed"),
                    entries<std::int64_t>(dict, "facet"), entries<double>(dict, "xi"), entries<double>(dict, "taken"),
                    entries<double>(dict, "pulse")});
}

nb::dict counters(const NodeToSurface& self)
{
  const auto& c = self.tracking().counters();
  nb::dict out;
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

nb::dict energies(const ContactEnergy& e)
{
  nb::dict out;
  out["stored"] = e.stored;
  out["friction"] = e.friction;
  out["normal"] = e.normal;
  out["later_friction"] = e.later_friction;
  out["later_normal"] = e.later_normal;
  out["recoverable"] = e.recoverable;
  return out;
}

/// Numbers of nodes are global.
nb::dict springs(NodeToSurface& self, const Halo& halo, const Values& u)
{
  const std::size_t gdim = self.candidates().gdim();
  NodalSprings s = self.springs(over(halo, u, int(gdim), "u"));
  const auto global = [&](const std::vector<std::int32_t>& nodes)
  {
    std::vector<std::int64_t> numbers(nodes.size());
    halo.map().local_to_global(nodes, numbers);
    return numbers;
  };
  const std::size_t n = s.nodes.size(), masters = s.num_masters;
  nb::dict out;
  out["nodes"] = take(global(s.nodes));
  out["masters"] = copy(global(s.masters), {n, masters});
  out["phi"] = copy(s.phi, {n, masters});
  out["normal"] = copy(s.normal, {n, gdim});
  out["stiffness"] = take(std::move(s.stiffness));
  return out;
}

template <typename Master>
void construct(NodeToSurface* self, const FunctionSpace& V, const Facets& slave, const Master& master, double friction,
               double penalty, double kappa, bool balanced, bool kinematic, int sweeps, double search_distance,
               bool axisymmetric)
{
  new (self) NodeToSurface(
      V, slave, master, options(friction, penalty, kappa, balanced, kinematic, sweeps, search_distance, axisymmetric));
}
} // namespace

void impact::bindings::nodal(nb::module_& m)
{
  const NodeToSurfaceOptions d;
  nb::class_<NodalContact>(m, "NodalContact", "Contact as the explicit integrator sees it");
  nb::class_<NodeToSurface, NodalContact>(m, "NodeToSurface",
                                          "Explicit contact of slave nodes with a surface; all arrays are copies")
      .def("__init__", &construct<Facets>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = d.friction, nb::arg("penalty") = d.penalty, nb::arg("kappa") = d.kappa,
           nb::arg("balanced") = d.balanced, nb::arg("kinematic") = d.kinematic, nb::arg("sweeps") = d.sweeps,
           nb::arg("search_distance") = d.search_distance, nb::arg("axisymmetric") = d.axisymmetric)
      .def("__init__", &construct<Rigid>, nb::arg("V"), nb::arg("slave"), nb::arg("master"),
           nb::arg("friction") = d.friction, nb::arg("penalty") = d.penalty, nb::arg("kappa") = d.kappa,
           nb::arg("balanced") = d.balanced, nb::arg("kinematic") = d.kinematic, nb::arg("sweeps") = d.sweeps,
           nb::arg("search_distance") = d.search_distance, nb::arg("axisymmetric") = d.axisymmetric)
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
      .def(
          "number",
          [](NodeToSurface& self, Halo& halo, Values mass)
          {
            std::vector<std::int32_t> same(halo.num_nodes());
            std::iota(same.begin(), same.end(), 0);
            self.needs(halo);
            self.number(halo, same, over(halo, mass, 1, "mass"));
          },
          nb::arg("halo"), nb::arg("mass"), nb::keep_alive<1, 2>(), "Take the numbers of nodes from a Halo. Collective")
      .def(
          "used", [](const NodeToSurface& self, const Halo& halo, Values u, Values du, Values inverse_mass, double dt)
          { return self.used(state(halo, self.candidates().gdim(), u, du, inverse_mass, dt)); }, nb::arg("halo"),
          nb::arg("u"), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("dt"))
      .def(
          "add_forces",
          [](NodeToSurface& self, const Halo& halo, Values u, Values du, Values inverse_mass, double dt,
             MutableValues f, int times)
          {
            const int gdim = self.candidates().gdim();
            const NodalState now = state(halo, gdim, u, du, inverse_mass, dt);
            double* forces = over(halo, f, gdim, "f");
            for (int i = 0; i < times; ++i)
              self.add_forces(now, forces);
          },
          nb::arg("halo"), nb::arg("u"), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("dt"),
          nb::arg("f").noconvert(), nb::arg("times") = 1,
          "Add the forces to f (a view is changed); several times for timing")
      .def(
          "correct",
          [](NodeToSurface& self, const Halo& halo, MutableValues u, Values du, Values inverse_mass, double h,
             double dt, MutableValues f, double share)
          {
            const int gdim = self.candidates().gdim();
            const std::vector<double> rest(u.size(), 0.0);
            self.correct(over(halo, u, gdim, "u"), over(halo, du, gdim, "du"), rest.data(),
                         over(halo, inverse_mass, gdim, "inverse_mass"), h, dt, share, over(halo, f, gdim, "f"));
          },
          nb::arg("halo"), nb::arg("u").noconvert(), nb::arg("du"), nb::arg("inverse_mass"), nb::arg("h"),
          nb::arg("dt"), nb::arg("f").noconvert(), nb::arg("share") = 1.0,
          "Correct u and add the forces to f (views are changed); before the step nothing moved. Collective")
      .def(
          "look", [](NodeToSurface& self, const Halo& halo, Values u)
          { self.look(over(halo, u, self.candidates().gdim(), "u")); }, nb::arg("halo"), nb::arg("u"),
          "Bring the gaps of open nodes up to date")
      .def("springs", &springs, nb::arg("halo"), nb::arg("u"),
           "Springs of given stiffness in a configuration, instead of a step; not those of `other`")
      .def("keep_normals", &NodeToSurface::keep_normals, nb::arg("keep"),
           "For tests of tests: judge facing by the normals of the last search")
      .def("set_obstacle", &NodeToSurface::set_obstacle, nb::arg("displacement"), nb::arg("increment"))
      .def_prop_ro("kinematic", &NodeToSurface::kinematic)
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
          { return take(std::vector<double>(self.force(), self.force() + self.candidates().gdim())); },
          nb::rv_policy::move)
      .def_prop_ro(
          "other", [](NodeToSurface& self) { return self.other(); }, nb::rv_policy::reference_internal)
      .def("results", &results)
      .def("energy", [](const NodeToSurface& self) { return energies(self.energy()); })
      .def(
          "own_energy", [](const NodeToSurface& self) { return energies(self.own_energy()); },
          "Without that of the other direction of balanced contact, which `energy` has")
      .def(
          "set_energy",
          [](NodeToSurface& self, double stored, double friction, double normal, double later_friction,
             double later_normal, double recoverable)
          { self.set_energy({stored, friction, normal, later_friction, later_normal, recoverable}); },
          nb::arg("stored"), nb::arg("friction"), nb::arg("normal"), nb::arg("later_friction") = 0.0,
          nb::arg("later_normal") = 0.0, nb::arg("recoverable") = 0.0)
      .def_prop_ro(
          "passage",
          [](const NodeToSurface& self)
          {
            const auto p = self.passage();
            return nb::make_tuple(p.node, p.facets);
          },
          "Local number (-1: none) of the slave node that went through the master fastest, facets per step")
      .def("counters", &counters)
      .def("history", &history)
      .def("set_history", &set_history, nb::arg("history"));
}
