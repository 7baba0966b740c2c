// SPDX-License-Identifier: MIT
#include "dolfinx_impact/enforcement/penalty/penalty.h"
#include "arrays.h"
#include "casters.h"
#include "dolfinx_impact/enforcement/penalty/QuadraturePenalty.h"
#include <algorithm>

using namespace dolfinx_impact::enforcement;
using dolfinx_impact::gap::Points;
using dolfinx_impact::gap::Rigid;
using dolfinx_impact::search::SurfaceSearch;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> Rows;

/// Copy of an enumeration's vector as int8.
template <typename T>
auto numbers(const std::vector<T>& values)
{
  std::vector<std::int8_t> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), [](T v) { return std::int8_t(v); });
  return take(std::move(out));
}

void set(std::vector<double>& target, const Values& source, const char* name)
{
  if (source.size() != target.size())
    throw std::invalid_argument(std::string(name) + ": " + std::to_string(target.size()) + " values are needed, not " +
                                std::to_string(source.size()));
  std::copy_n(source.data(), source.size(), target.begin());
}

void bind_points(nb::module_& m)
{
  nb::class_<Points>(m, "Points", "Slave quadrature points and their gaps; properties are copies")
      .def(
          "__init__",
          [](Points* self, const Facets& slave, Rows points, Values weights, bool axisymmetric)
          {
            if (points.shape(0) != weights.size() || points.shape(1) != std::size_t(slave.geometry.tdim()))
              throw std::invalid_argument("a rule: points of shape (number, dimension of the facet), as many weights");
            new (self) Points(dolfinx_impact::gap::make_points(slave, {points.data(), points.size()},
                                                               {weights.data(), weights.size()}, axisymmetric));
          },
          nb::arg("slave"), nb::arg("points"), nb::arg("weights"), nb::arg("axisymmetric") = false)
      .def(
          "update", [](Points& self, const Facets& slave, const SurfaceSearch& master, double reach, bool keep)
          { dolfinx_impact::gap::update(self, slave, master, reach, keep); }, nb::arg("slave"), nb::arg("master"),
          nb::arg("reach"), nb::arg("keep") = false,
          "Gaps against a deformable master; keep: points over a common edge stay on their facet")
      .def(
          "update_rigid", [](Points& self, const Facets& slave, const Rigid& master)
          { dolfinx_impact::gap::update(self, slave, master); }, nb::arg("slave"), nb::arg("master"))
      .def_prop_ro("size", &Points::size)
      .def_prop_rw(
          "margin", [](const Points& p) { return copy(p.margin, {p.size()}); },
          [](Points& p, Values v) { set(p.margin, v, "margin"); }, nb::rv_policy::move,
          "How far beside a facet that they keep points may be, in reference coordinates")
      .def_prop_ro("gdim", [](const Points& p) { return p.gdim; })
      .def_prop_ro("per_facet", [](const Points& p) { return p.per_facet; })
      .def_prop_ro(
          "facet", [](const Points& p) { return copy(p.facet, {p.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "xi", [](const Points& p) { return copy(p.xi, {p.size(), 2}); }, nb::rv_policy::move)
      .def_prop_ro(
          "weight", [](const Points& p) { return copy(p.weight, {p.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "x", [](const Points& p) { return copy(p.x, {p.size(), std::size_t(p.gdim)}); }, nb::rv_policy::move)
      .def_prop_ro(
          "status", [](const Points& p) { return numbers(p.status); }, nb::rv_policy::move)
      .def_prop_rw(
          "master", [](const Points& p) { return copy(p.master, {p.size()}); },
          [](Points& p, nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> facets)
          {
            if (facets.size() != p.size())
              throw std::invalid_argument("master: " + std::to_string(p.size()) + " facets are needed, not " +
                                          std::to_string(facets.size()));
            std::copy_n(facets.data(), facets.size(), p.master.begin());
          },
          nb::rv_policy::move, "Facet of the master of each point, which an update with `keep` begins from")
      .def_prop_ro(
          "master_xi", [](const Points& p) { return copy(p.master_xi, {p.size(), 2}); }, nb::rv_policy::move)
      .def_prop_ro(
          "gap", [](const Points& p) { return copy(p.gap, {p.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "normal", [](const Points& p) { return copy(p.normal, {p.size(), std::size_t(p.gdim)}); },
          nb::rv_policy::move);
}

void bind_state(nb::module_& m)
{
  nb::class_<PenaltyHistory>(m, "PenaltyHistory", "What points remember; flat arrays, properties are copies")
      .def_prop_rw(
          "multiplier", [](const PenaltyHistory& h) { return copy(h.multiplier, {h.multiplier.size()}); },
          [](PenaltyHistory& h, Values v) { set(h.multiplier, v, "multiplier"); }, nb::rv_policy::move)
      .def_prop_rw(
          "traction", [](const PenaltyHistory& h) { return copy(h.traction, {h.traction.size()}); },
          [](PenaltyHistory& h, Values v) { set(h.traction, v, "traction"); }, nb::rv_policy::move)
      .def_prop_rw(
          "slip", [](const PenaltyHistory& h) { return copy(h.slip, {h.slip.size()}); },
          [](PenaltyHistory& h, Values v) { set(h.slip, v, "slip"); }, nb::rv_policy::move)
      .def_prop_rw(
          "gap", [](const PenaltyHistory& h) { return copy(h.gap, {h.gap.size()}); }, [](PenaltyHistory& h, Values v)
          { set(h.gap, v, "gap"); }, nb::rv_policy::move, "Of points that were open; of others not positive")
      .def_prop_rw(
          "offset", [](const PenaltyHistory& h) { return copy(h.offset, {h.offset.size()}); },
          [](PenaltyHistory& h, Values v) { set(h.offset, v, "offset"); }, nb::rv_policy::move, "Added to the gaps");
  const auto vectors = [](const PenaltyState& s, const std::vector<double>& v)
  {
    const std::size_t num = s.pressure.size();
    return copy(v, {num, num > 0 ? v.size() / num : 0});
  };
  nb::class_<PenaltyState>(m, "PenaltyState", "Points in one state of displacements; properties are copies")
      .def_prop_ro(
          "status", [](const PenaltyState& s) { return numbers(s.status); }, nb::rv_policy::move,
          "0 open, 1 stick, 2 slip")
      .def_prop_ro(
          "pressure", [](const PenaltyState& s) { return copy(s.pressure, {s.pressure.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "tangential", [vectors](const PenaltyState& s) { return vectors(s, s.tangential); }, nb::rv_policy::move)
      .def_prop_ro(
          "traction", [vectors](const PenaltyState& s) { return vectors(s, s.traction); }, nb::rv_policy::move)
      .def_prop_ro("slip", [vectors](const PenaltyState& s) { return vectors(s, s.slip); }, nb::rv_policy::move);
}
PenaltyForces::Setup setup(std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Rows& points,
                           const Values& weights, bool axisymmetric)
{
  if (points.shape(0) != weights.size() || points.shape(1) != std::size_t(slave.geometry.tdim()))
    throw std::invalid_argument("a rule: points of shape (number, dimension of the facet), as many weights");
  return {std::move(V), slave, {points.data(), points.size()}, view(weights), axisymmetric};
}

void bind_forces(nb::module_& m)
{
  const auto reference = nb::rv_policy::reference_internal;
  nb::class_<PenaltyParameters>(m, "PenaltyParameters", "Penalties [F/L^3], friction [1], touch [F/L^2]")
      .def_rw("normal", &PenaltyParameters::normal)
      .def_rw("tangential", &PenaltyParameters::tangential)
      .def_rw("friction", &PenaltyParameters::friction)
      .def_rw("touch", &PenaltyParameters::touch);
  nb::class_<PenaltyForces>(m, "PenaltyForces", "Gaps, tractions, forces and tangent of one pair")
      .def(
          "__init__",
          [](PenaltyForces* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
             Rows points, Values weights, bool axisymmetric, double search_distance)
          {
            new (self)
                PenaltyForces(setup(std::move(V), slave, points, weights, axisymmetric), master, search_distance);
          },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("points"), nb::arg("weights"),
          nb::arg("axisymmetric") = false, nb::arg("search_distance") = 0.0)
      .def(
          "__init__",
          [](PenaltyForces* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             std::shared_ptr<Rigid> master, Rows points, Values weights, bool axisymmetric)
          { new (self) PenaltyForces(setup(std::move(V), slave, points, weights, axisymmetric), std::move(master)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("points"), nb::arg("weights"),
          nb::arg("axisymmetric") = false)
      .def_prop_ro(
          "parameters", [](PenaltyForces& p) -> PenaltyParameters& { return p.parameters; }, reference)
      .def_prop_ro(
          "history", [](PenaltyForces& p) -> PenaltyHistory& { return p.history; }, reference)
      .def_prop_ro(
          "points", [](PenaltyForces& p) -> Points& { return p.points(); }, reference)
      .def_prop_ro("state", &PenaltyForces::state, reference)
      .def_prop_ro("map", &PenaltyForces::map)
      .def_prop_ro(
          "search", [](PenaltyForces& p) { return p.search(); }, reference)
      .def(
          "share_of",
          [](const PenaltyForces& p, std::size_t q)
          {
            if (q >= p.points().size())
              throw nb::index_error();
            return p.share_of(q);
          },
          nb::arg("q"), "Part of the penalties that a point has, in general contact that of the softer body")
      .def("energy", &PenaltyForces::energy, "Energy of the springs, this rank's part")
      .def(
          "update_gap", [](PenaltyForces& p, Values u, Values start, bool stay)
          { p.update_gap(view(u), view(start), stay); }, nb::arg("u"), nb::arg("start"), nb::arg("stay"))
      .def(
          "evaluate", [](PenaltyForces& p, Values increment, std::array<double, 3> rigid)
          { p.evaluate(view(increment), {.displacement = rigid}); }, nb::arg("increment"), nb::arg("rigid"))
      .def("evaluate", [](PenaltyForces& p) { p.evaluate(); })
      .def("forget", &PenaltyForces::forget, "Forget candidates and the places of the tangent")
      .def("accept_step", &PenaltyForces::accept_step)
      .def("add_residual", &PenaltyForces::add_residual, nb::arg("b"))
      .def("contact_forces", [](const PenaltyForces& p) { return take(p.contact_forces()); })
      .def("closing_forces", [](const PenaltyForces& p) { return take(p.closing_forces()); })
      .def("tangent", &PenaltyForces::tangent, nb::arg("convex") = false, nb::rv_policy::reference,
           "PETSc matrix, kept by this object");
}

void bind_parts(nb::module_& m)
{
  nb::class_<FacetKeeper>(m, "FacetKeeper", "Keeps points from alternating between facets")
      .def(
          "__init__", [](FacetKeeper* self, dolfinx_wrappers::MPICommWrapper comm)
          { new (self) FacetKeeper(comm.get()); }, nb::arg("comm"))
      .def_ro_static("margin", &FacetKeeper::margin)
      .def_ro_static("widest", &FacetKeeper::widest)
      .def_prop_ro("stay", &FacetKeeper::stay)
      .def(
          "begin", [](FacetKeeper& k, MutableValues margins) { k.begin({margins.data(), margins.size()}); },
          nb::arg("margins").noconvert())
      .def(
          "watch",
          [](FacetKeeper& k, Indices facets, bool kept, MutableValues margins)
          {
            if (margins.size() != facets.size())
              throw std::invalid_argument("a margin is needed for every point");
            return k.watch({facets.data(), facets.size()}, kept, {margins.data(), margins.size()});
          },
          nb::arg("facets"), nb::arg("kept"), nb::arg("margins").noconvert())
      .def("leave", &FacetKeeper::leave);
  nb::class_<Uzawa>(m, "Uzawa", "Multipliers at the corners of the slave's facets")
      .def_prop_ro(
          "multiplier", [](const Uzawa& u) { return copy(u.multiplier, {u.multiplier.size()}); }, nb::rv_policy::move)
      .def_prop_ro("rounds", &Uzawa::rounds);
  nb::class_<PenaltyOptions>(m, "PenaltyOptions", "Parameters of penalty contact at quadrature points")
      .def(nb::init<>())
      .def_rw("penalty", &PenaltyOptions::penalty)
      .def_rw("tangential", &PenaltyOptions::tangential)
      .def_rw("friction", &PenaltyOptions::friction)
      .def_rw("augmented", &PenaltyOptions::augmented)
      .def_rw("tolerance", &PenaltyOptions::tolerance)
      .def_rw("max_augmentations", &PenaltyOptions::max_augmentations)
      .def_rw("quadrature_degree", &PenaltyOptions::quadrature_degree)
      .def_rw("search_distance", &PenaltyOptions::search_distance)
      .def_rw("adjustment", &PenaltyOptions::adjustment)
      .def_rw("axisymmetric", &PenaltyOptions::axisymmetric)
      .def_rw("law", &PenaltyOptions::law, nb::arg("law").none(),
              "A law of the interface instead; None: there is none");
}

/// The tangent that a function of Python's assembles; its result lives until the next call.
typedef nb::typed<nb::callable, Mat()> Assemble;

QuadraturePenalty::TangentFunction tangent_of(Assemble assemble)
{
  return [assemble = std::move(assemble), kept = std::make_shared<nb::object>()]
  {
    *kept = assemble();
    nb::detail::make_caster<Mat> matrix;
    if (!matrix.from_python(*kept, 0, nullptr))
      throw nb::type_error("the tangent of the bodies must be a matrix of PETSc");
    return matrix.value;
  };
}

void bind_contact(nb::module_& m)
{
  const auto reference = nb::rv_policy::reference_internal;
  nb::class_<QuadraturePenalty, StaticContact>(m, "QuadraturePenalty", "Penalty contact of one pair in increments")
      .def(
          "__init__",
          [](QuadraturePenalty* self, std::string name, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             const Facets& master, const PenaltyOptions& options, Assemble bodies)
          {
            new (self)
                QuadraturePenalty(std::move(name), std::move(V), slave, master, options, tangent_of(std::move(bodies)));
          },
          nb::arg("name"), nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("bodies"))
      .def(
          "__init__",
          [](QuadraturePenalty* self, std::string name, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             const Rigid& master, const PenaltyOptions& options, Assemble bodies)
          {
            new (self)
                QuadraturePenalty(std::move(name), std::move(V), slave, master, options, tangent_of(std::move(bodies)));
          },
          nb::arg("name"), nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("bodies"))
      .def(
          "__init__",
          [](QuadraturePenalty* self, std::string name, std::shared_ptr<const FunctionSpace> V, const Facets& facets,
             const std::vector<std::pair<Facets, Facets>>& named, const PenaltyOptions& options, Assemble bodies)
          {
            std::vector<dolfinx_impact::search::NamedPair> pairs;
            for (const auto& [slave, master] : named)
              pairs.push_back({slave, master});
            new (self)
                QuadraturePenalty(std::move(name), std::move(V), facets, pairs, options, tangent_of(std::move(bodies)));
          },
          nb::arg("name"), nb::arg("V"), nb::arg("facets"), nb::arg("named"), nb::arg("options"), nb::arg("bodies"),
          "General contact of a surface with itself")
      .def_prop_ro("deepest", &QuadraturePenalty::deepest, "Deepest penetration of all ranks. Collective")
      .def_prop_ro("penalty", &QuadraturePenalty::penalty)
      .def_prop_ro("tangential", &QuadraturePenalty::tangential)
      .def_prop_ro("convex", &QuadraturePenalty::convex)
      .def_prop_ro("has_begun", &QuadraturePenalty::has_begun)
      .def_prop_ro("closes_nearest", &QuadraturePenalty::closes_nearest)
      .def_prop_ro("initial", &QuadraturePenalty::initial, reference)
      .def_prop_ro("totals", &QuadraturePenalty::totals, reference)
      .def_prop_ro("forces", &QuadraturePenalty::forces, reference)
      .def_prop_ro("uzawa", &QuadraturePenalty::uzawa, reference)
      .def(
          "nodal_means",
          [](const QuadraturePenalty& p, nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> values)
          {
            auto [nodes, means] = p.nodal_means({values.data(), values.size()}, values.shape(1));
            const std::size_t num = nodes.size();
            return std::pair(take(std::move(nodes)), take(std::move(means), {num, values.shape(1)}));
          },
          nb::arg("values"), "Owned nodes and means of point values there");
}
} // namespace

void dolfinx_impact::bindings::penalty(nb::module_& m)
{
  bind_points(m);
  bind_state(m);
  bind_forces(m);
  bind_parts(m);
  bind_contact(m);
}
