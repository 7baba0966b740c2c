// SPDX-License-Identifier: MIT
#include "dolfinx_impact/enforcement/mortar/Condensation.h"
#include "dolfinx_impact/enforcement/mortar/CoulombFriction.h"
#include "dolfinx_impact/enforcement/mortar/SaddlePoint.h"
#include "dolfinx_impact/enforcement/mortar/active_set.h"
#include "dolfinx_impact/enforcement/mortar/prescribed_components.h"
#include "dolfinx_impact/gap/FacingShares.h"
#include "masks.h"
#include "petsc_objects.h"
#include <caster_mpi.h>

using namespace dolfinx_impact::enforcement;
using namespace dolfinx_impact::gap;
using dolfinx_impact::search::PairSearch;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Globals;

template <typename T, typename A>
std::vector<T> vector(const A& values)
{
  return std::vector<T>(values.data(), values.data() + values.size());
}

auto vectors(const std::vector<double>& values, std::size_t num)
{
  return copy(values, {num, num > 0 ? values.size() / num : 0});
}

SegmentRule rule(const Array& points, const Array& weights)
{
  return {view(points), view(weights)};
}

nb::tuple as_tuple(const MasterRows& rows)
{
  return nb::make_tuple(copy(rows.pointers, {rows.pointers.size()}), copy(rows.columns, {rows.columns.size()}),
                        copy(rows.values, {rows.values.size()}));
}

void bind_integrals(nb::module_& m)
{
  m.attr("least_share") = least_share;
  nb::class_<MultiplierNodes>(m, "MultiplierNodes", "Owned slave nodes that multipliers may live at; copies")
      .def(
          "__init__",
          [](MultiplierNodes* self, const FunctionSpace& V, const Facets& slave, Array points, Array weights,
             Multipliers basis, bool axisymmetric)
          { new (self) MultiplierNodes(multiplier_nodes(V, slave, rule(points, weights), basis, axisymmetric)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("points"), nb::arg("weights"), nb::arg("basis"),
          nb::arg("axisymmetric") = false, "Collective")
      .def_prop_ro(
          "nodes", [](const MultiplierNodes& n) { return copy(n.nodes, {n.nodes.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "share", [](const MultiplierNodes& n) { return copy(n.share, {n.share.size()}); }, nb::rv_policy::move)
      .def_prop_ro("area", [](const MultiplierNodes& n) { return copy(n.area, {n.area.size()}); }, nb::rv_policy::move);
  nb::class_<MortarIntegrals>(m, "MortarIntegrals", "Mortar integrals of a pair; arrays are by the multiplier nodes")
      .def(
          "__init__",
          [](MortarIntegrals* self, std::shared_ptr<const FunctionSpace> V, std::shared_ptr<PairSearch> search,
             const MultiplierNodes& nodes, Array points, Array weights, Multipliers basis, bool axisymmetric)
          {
            new (self)
                MortarIntegrals(std::move(V), std::move(search), nodes, rule(points, weights), basis, axisymmetric);
          },
          nb::arg("V"), nb::arg("search"), nb::arg("nodes"), nb::arg("points"), nb::arg("weights"), nb::arg("basis"),
          nb::arg("axisymmetric") = false)
      .def(
          "update", [](MortarIntegrals& self, Array u, Array start) { self.update(view(u), view(start)); },
          nb::arg("u"), nb::arg("start"), "Search, segments and integrals at u. Collective")
      .def(
          "update_cover", [](MortarIntegrals& self, Array u, Array start) { self.update_cover(view(u), view(start)); },
          nb::arg("u"), nb::arg("start"), "Search, segments and what is covered at u. Collective")
      .def(
          "integrate", [](MortarIntegrals& self, Mask carriers) { self.integrate(view(carriers)); },
          nb::arg("carriers"), "Integrals where these nodes carry the multipliers. Collective")
      .def(
          "covered", [](const MortarIntegrals& s) { return mask(s.covered(), {s.around.size()}); },
          "Mask of the nodes of which enough is covered")
      .def(
          "sums_at_nodes", [](const MortarIntegrals& s) { return vectors(s.sums_at_nodes(), s.nodes().nodes.size()); },
          "Sums of facet normals, (n, gdim)")
      .def(
          "set_sums", [](MortarIntegrals& self, Array sums) { self.set_sums(view(sums)); }, nb::arg("sums"),
          "Replace the sums of facet normals, (n, gdim). Collective")
      .def_prop_ro(
          "area", [](const MortarIntegrals& s) { return copy(s.area(), {s.area().size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "aside", [](const MortarIntegrals& s) { return take(s.aside()); }, nb::rv_policy::move,
          "Numbers of the facets that took no part, as they lie round a sharp edge")
      .def_rw("least_cover", &MortarIntegrals::least_cover)
      .def_prop_ro(
          "around", [](const MortarIntegrals& s) { return copy(s.around, {s.around.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "weighted_gap", [](const MortarIntegrals& s) { return copy(s.weighted_gap, {s.weighted_gap.size()}); },
          nb::rv_policy::move)
      .def(
          "update_gap", [](MortarIntegrals& self, Mask locked, double symmetry)
          { self.update_gap(view(locked), symmetry); }, nb::arg("locked"), nb::arg("symmetry"),
          "Normals and gaps; locked: components along which normals are not tilted a little")
      .def_prop_ro(
          "participates", [](const MortarIntegrals& s) { return mask(s.participates, {s.participates.size()}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "weight", [](const MortarIntegrals& s) { return copy(s.weight, {s.weight.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "cover", [](const MortarIntegrals& s) { return copy(s.cover, {s.cover.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "normal", [](const MortarIntegrals& s) { return vectors(s.normal, s.nodes().nodes.size()); },
          nb::rv_policy::move)
      .def_prop_ro(
          "gap", [](const MortarIntegrals& s) { return copy(s.gap, {s.gap.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "normal_sums", [](const MortarIntegrals& s) { return copy(s.normal_sums(), {s.normal_sums().size()}); },
          nb::rv_policy::move)
      .def_prop_ro("entries", &MortarIntegrals::entries, nb::rv_policy::reference_internal)
      .def_prop_ro("segments", &MortarIntegrals::segments, nb::rv_policy::reference_internal)
      .def_prop_ro("map", &MortarIntegrals::map)
      .def_prop_ro("M", &MortarIntegrals::M, nb::rv_policy::reference)
      .def("jump_matrix", &MortarIntegrals::jump_matrix, nb::rv_policy::reference, "D - M, kept by this object")
      .def(
          "jump",
          [](const MortarIntegrals& s, Array moved) { return vectors(s.jump(view(moved)), s.nodes().nodes.size()); },
          nb::arg("moved"), "Mean displacement of slave against master. Collective")
      .def(
          "weighted_jump", [](const MortarIntegrals& s, Array moved)
          { return vectors(s.weighted_jump(view(moved)), s.nodes().nodes.size()); }, nb::arg("moved"),
          "The same times the cover. Collective")
      .def(
          "over_master", [](const MortarIntegrals& s, Array values, int block)
          { return vectors(s.over_master(view(values), block), s.nodes().nodes.size()); }, nb::arg("values"),
          nb::arg("block"))
      .def(
          "contact_forces",
          [](const MortarIntegrals& s, Array traction) { return take(s.contact_forces(view(traction))); },
          nb::arg("traction"), "Nodal forces on both bodies, owned entries. Collective")
      .def(
          "master_rows",
          [](const MortarIntegrals& s, Indices rows) { return as_tuple(s.master_rows({rows.data(), rows.size()})); },
          nb::arg("rows"), "Rows of D^-1 M of some nodes: pointers, global nodes, values")
      .def(
          "master_rows", [](const MortarIntegrals& s, Indices rows, Array weights)
          { return as_tuple(s.master_rows({rows.data(), rows.size()}, view(weights))); }, nb::arg("rows"),
          nb::arg("weights"), "Rows of M over the weights of all nodes")
      .def(
          "tangent",
          [](MortarIntegrals& s, Array multiplier, Array traction, Mask active) -> nb::object
          {
            Mat A = s.tangent(view(multiplier), view(traction), view(active));
            return A ? nb::cast(A, nb::rv_policy::reference) : nb::none();
          },
          nb::arg("multiplier"), nb::arg("traction"), nb::arg("active"),
          "Derivative of minus the contact force at given multipliers, kept by this object; None: zero. Collective");
  nb::class_<FacingShares>(m, "FacingShares", "Areas of a slave's nodes that face a rigid obstacle")
      .def(
          "__init__",
          [](FacingShares* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             const MultiplierNodes& nodes, Array points, Array weights, Multipliers basis, bool axisymmetric)
          { new (self) FacingShares(V, slave, nodes, rule(points, weights), basis, axisymmetric); },
          nb::arg("V"), nb::arg("slave"), nb::arg("nodes"), nb::arg("points"), nb::arg("weights"), nb::arg("basis"),
          nb::arg("axisymmetric") = false)
      .def(
          "evaluate", [](FacingShares& self, const Facets& slave, const Rigid& obstacle)
          { return take(self.evaluate(slave, obstacle)); }, nb::arg("slave"), nb::arg("obstacle"),
          "Areas by the multiplier nodes. Collective")
      .def_prop_ro(
          "aside", [](const FacingShares& s) { return copy(s.aside(), {s.aside().size()}); }, nb::rv_policy::move,
          "Numbers of the facets that took no part");
  m.def(
      "springs",
      [](const dolfinx::common::IndexMap& map, int gdim, Indices nodes, nb::tuple rows, Array blocks)
      {
        const MasterRows facing{vector<std::int64_t>(nb::cast<Globals>(rows[0])),
                                vector<std::int64_t>(nb::cast<Globals>(rows[1])),
                                vector<double>(nb::cast<Array>(rows[2]))};
        dolfinx_impact::operators::CooMatrix out;
        assign_springs(map, gdim, {nodes.data(), nodes.size()}, facing, view(blocks), out);
        return nb::cast(out.matrix(), nb::rv_policy::reference);
      },
      nb::arg("map"), nb::arg("gdim"), nb::arg("nodes"), nb::arg("rows"), nb::arg("blocks"),
      "Matrix of springs between nodes and what they face on the master. Collective");
  m.def(
      "coo_matrix",
      [](dolfinx_wrappers::MPICommWrapper comm, std::int64_t num_rows, std::int64_t num_columns, Globals rows,
         Globals columns, Array values)
      {
        if (rows.size() != columns.size() || rows.size() != values.size())
          throw std::invalid_argument("rows, columns and values differ in their number");
        dolfinx_impact::operators::CooMatrix::Entries entries{{rows.data(), rows.data() + rows.size()},
                                                              {columns.data(), columns.data() + columns.size()},
                                                              vector<double>(values)};
        dolfinx_impact::operators::CooMatrix out;
        out.assign(comm.get(), PetscInt(num_rows), PetscInt(num_columns), 1, std::move(entries));
        return nb::cast(out.matrix(), nb::rv_policy::reference);
      },
      nb::arg("comm"), nb::arg("num_rows"), nb::arg("num_columns"), nb::arg("rows"), nb::arg("columns"),
      nb::arg("values"), "Matrix from entries of any rows, global numbers; equal places add up. Collective");
}

void bind_constraints(nb::module_& m)
{
  nb::class_<Constraints>(m, "Constraints", "Constrained slave nodes of one contact; properties are copies")
      .def(
          "__init__",
          [](Constraints* self, Indices rows, Indices nodes, Array frames, Array over, Mask constrained, Array known,
             Array tilt, Indices normal, Globals pointers, Globals columns, Array values)
          {
            const std::size_t num = nodes.size(), gdim = known.ndim() == 2 ? known.shape(1) : 0;
            if (gdim < 2 || gdim > 3 || rows.size() != num || frames.size() != num * gdim * gdim ||
                over.size() != num * gdim * gdim || constrained.size() != num * gdim || known.size() != num * gdim ||
                tilt.size() != num * gdim || normal.size() != num || pointers.size() != num + 1 ||
                columns.size() != values.size())
              throw std::invalid_argument("constraints: arrays of different numbers of nodes");
            new (self) Constraints{int(gdim),
                                   vector<std::int32_t>(rows),
                                   vector<std::int32_t>(nodes),
                                   vector<double>(frames),
                                   vector<double>(over),
                                   {view(constrained).begin(), view(constrained).end()},
                                   vector<double>(known),
                                   vector<double>(tilt),
                                   vector<std::int32_t>(normal),
                                   vector<std::int64_t>(pointers),
                                   vector<std::int64_t>(columns),
                                   vector<double>(values)};
          },
          nb::arg("rows"), nb::arg("nodes"), nb::arg("frames"), nb::arg("over"), nb::arg("constrained"),
          nb::arg("known"), nb::arg("tilt"), nb::arg("normal"), nb::arg("pointers"), nb::arg("columns"),
          nb::arg("values"))
      .def_prop_ro(
          "rows", [](const Constraints& c) { return copy(c.rows, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "nodes", [](const Constraints& c) { return copy(c.nodes, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "frames", [](const Constraints& c)
          { return copy(c.frames, {c.size(), std::size_t(c.gdim), std::size_t(c.gdim)}); }, nb::rv_policy::move)
      .def_prop_ro(
          "over", [](const Constraints& c)
          { return copy(c.over, {c.size(), std::size_t(c.gdim), std::size_t(c.gdim)}); }, nb::rv_policy::move)
      .def_prop_ro(
          "constrained", [](const Constraints& c) { return mask(c.constrained, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "known", [](const Constraints& c) { return copy(c.known, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "tilt", [](const Constraints& c) { return copy(c.tilt, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "normal", [](const Constraints& c) { return copy(c.normal, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "pointers", [](const Constraints& c) { return copy(c.pointers, {c.pointers.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "columns", [](const Constraints& c) { return copy(c.columns, {c.columns.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "values", [](const Constraints& c) { return copy(c.values, {c.values.size()}); }, nb::rv_policy::move);
  m.def(
      "frames_at",
      [](Array normals, Mask fixed)
      {
        const std::size_t num = normals.shape(0), gdim = normals.shape(1);
        NodalFrames f = frames_at(int(gdim), view(normals), view(fixed));
        return nb::make_tuple(take(std::move(f.frames), {num, gdim, gdim}), take(std::move(f.place)),
                              take(std::move(f.length)));
      },
      nb::arg("normals"), nb::arg("fixed"),
      "Frames (n, gdim, gdim), place of the normal direction (n), length of the normal's free part (n)");
}

/// Views of an object's arrays, by the names of NodalMultipliers; they must outlive the call.
struct Nodes
{
  Mask usable, active, sliding;
  Array gap, multiplier, slip, traction, direction, opening, stiffness, lock, roughness;
  NodalMultipliers now;

  Nodes(const nb::dict& d, int gdim, double friction)
      : usable(nb::cast<Mask>(d["usable"])), active(nb::cast<Mask>(d["active"])), sliding(nb::cast<Mask>(d["sliding"])),
        gap(nb::cast<Array>(d["gap"])), multiplier(nb::cast<Array>(d["multiplier"])), slip(nb::cast<Array>(d["slip"])),
        traction(nb::cast<Array>(d["traction"])), direction(nb::cast<Array>(d["direction"])),
        opening(nb::cast<Array>(d["opening"])), stiffness(nb::cast<Array>(d["stiffness"])),
        lock(nb::cast<Array>(d["lock"])), roughness(nb::cast<Array>(d["roughness"])),
        now{gdim,          friction,       view(usable),   view(active),    view(gap),     view(multiplier),
            view(sliding), view(slip),     view(traction), view(direction), view(opening), view(stiffness),
            view(lock),    view(roughness)}
  {
  }
};

/// The same for NodalGeometry.
struct Geometry
{
  Indices nodes, place;
  Array normal, gap, slip, weight, cover, ahead, frame, length;
  Mask fixed;
  NodalFrames frames;
  NodalGeometry now;

  explicit Geometry(const nb::dict& d)
      : nodes(nb::cast<Indices>(d["nodes"])), place(nb::cast<Indices>(d["place"])),
        normal(nb::cast<Array>(d["normal"])), gap(nb::cast<Array>(d["gap"])), slip(nb::cast<Array>(d["slip"])),
        weight(nb::cast<Array>(d["weight"])), cover(nb::cast<Array>(d["cover"])), ahead(nb::cast<Array>(d["ahead"])),
        frame(nb::cast<Array>(d["frames"])), length(nb::cast<Array>(d["length"])), fixed(nb::cast<Mask>(d["fixed"])),
        frames{vector<double>(frame), vector<std::int32_t>(place), vector<double>(length)},
        now{{nodes.data(), nodes.size()},
            view(normal),
            view(gap),
            view(slip),
            view(weight),
            view(cover),
            view(fixed),
            view(ahead),
            frames}
  {
  }
};

void bind_active_set(nb::module_& m)
{
  m.def(
      "update_active_set",
      [](nb::dict state, int gdim, double friction, bool first, double tolerance, double largest)
      {
        const Nodes nodes(state, gdim, friction);
        const std::size_t num = nodes.now.size();
        ActiveSet found = update_active_set(nodes.now, first, tolerance, largest);
        return nb::make_tuple(mask(found.active, {num}), mask(found.sliding, {num}),
                              take(std::move(found.direction), {num, std::size_t(gdim)}));
      },
      nb::arg("state"), nb::arg("gdim"), nb::arg("friction"), nb::arg("first"), nb::arg("tolerance"),
      nb::arg("largest"), "Active and sliding masks and friction's directions; state: arrays of NodalMultipliers");
  m.def(
      "friction_tilt",
      [](nb::dict state, int gdim, double friction)
      {
        const Nodes nodes(state, gdim, friction);
        return take(friction_tilt(nodes.now), {nodes.now.size(), std::size_t(gdim)});
      },
      nb::arg("state"), nb::arg("gdim"), nb::arg("friction"), "Friction traction per pressure");
  m.def(
      "constrain",
      [](nb::dict state, nb::dict geometry, int gdim, double friction, Array tilt, nb::tuple facing)
      {
        const Nodes nodes(state, gdim, friction);
        return constrain(nodes.now, Geometry(geometry).now, view(tilt),
                         {vector<std::int64_t>(nb::cast<Globals>(facing[0])),
                          vector<std::int64_t>(nb::cast<Globals>(facing[1])),
                          vector<double>(nb::cast<Array>(facing[2]))});
      },
      nb::arg("state"), nb::arg("geometry"), nb::arg("gdim"), nb::arg("friction"), nb::arg("tilt"), nb::arg("facing"),
      "Constraints of the active nodes; geometry: arrays of NodalGeometry");
  m.def(
      "evaluate_multipliers",
      [](nb::dict state, nb::dict geometry, int gdim, double friction, Array residual, Array tilt, Array known,
         Array follow)
      {
        const Nodes nodes(state, gdim, friction);
        const std::size_t num = nodes.now.size();
        std::vector<double> multiplier(num), traction(num * gdim, 0.0);
        evaluate_multipliers(nodes.now, Geometry(geometry).now, view(residual), view(tilt), view(known), view(follow),
                             multiplier, traction);
        return nb::make_tuple(take(std::move(multiplier)), take(std::move(traction), {num, std::size_t(gdim)}));
      },
      nb::arg("state"), nb::arg("geometry"), nb::arg("gdim"), nb::arg("friction"), nb::arg("residual"), nb::arg("tilt"),
      nb::arg("known"), nb::arg("follow"), "Multipliers and friction tractions from equilibrium");
  m.def(
      "take_multipliers",
      [](nb::dict state, nb::dict geometry, int gdim, double friction, Array forces, Array tilt, Array known)
      {
        const Nodes nodes(state, gdim, friction);
        const std::size_t num = nodes.now.size();
        std::vector<double> multiplier(num), traction(num * gdim);
        take_multipliers(nodes.now, Geometry(geometry).now, view(forces), view(tilt), view(known), multiplier,
                         traction);
        return nb::make_tuple(take(std::move(multiplier)), take(std::move(traction), {num, std::size_t(gdim)}));
      },
      nb::arg("state"), nb::arg("geometry"), nb::arg("gdim"), nb::arg("friction"), nb::arg("forces"), nb::arg("tilt"),
      nb::arg("known"), "Multipliers and friction tractions from a saddle point's forces");
  m.def(
      "rotate_friction_traction",
      [](nb::dict state, int gdim, double friction, Array normal)
      {
        const Nodes nodes(state, gdim, friction);
        return take(rotate_friction_traction(nodes.now, view(normal)), {nodes.now.size(), std::size_t(gdim)});
      },
      nb::arg("state"), nb::arg("gdim"), nb::arg("friction"), nb::arg("normal"),
      "Friction tractions that follow the surface");
  m.def(
      "violations",
      [](nb::dict state, int gdim, double friction, Array gap)
      {
        Violations found = violations(Nodes(state, gdim, friction).now, view(gap));
        return nb::make_tuple(take(std::move(found.gap)), take(std::move(found.slip)));
      },
      nb::arg("state"), nb::arg("gdim"), nb::arg("friction"), nb::arg("gap"),
      "Gaps of active nodes and slips of those that stick");
  m.def(
      "sticking",
      [](nb::dict state, int gdim, double friction)
      {
        const Nodes nodes(state, gdim, friction);
        std::vector<std::int8_t> out(nodes.now.size());
        for (std::size_t i = 0; i < out.size(); ++i)
          out[i] = sticks(nodes.now, i);
        return mask(out, {out.size()});
      },
      nb::arg("state"), nb::arg("gdim"), nb::arg("friction"), "Mask of the nodes that stick where they are");
}

void bind_linearisation(nb::module_& m)
{
  m.def(
      "tangential",
      [](Array normal, Array vectors)
      {
        const std::size_t num = normal.shape(0), gdim = normal.shape(1);
        return take(tangential(int(gdim), view(normal), view(vectors)), {num, gdim});
      },
      nb::arg("normal"), nb::arg("vectors"), "Parts of vectors along the surface, (n, gdim)");
  m.def(
      "add_jump",
      [](nb::dict geometry, Array jump)
      {
        const Geometry nodes(geometry);
        const std::size_t num = nodes.now.gap.size();
        std::vector<double> gap(num), slip(jump.size());
        add_jump(nodes.now, view(jump), gap, slip);
        return nb::make_tuple(take(std::move(gap)), vectors(slip, num));
      },
      nb::arg("geometry"), nb::arg("jump"), "Gaps and slips of the linearised problem");
  m.def(
      "normal_tractions", [](Mask usable, nb::dict geometry, Array forces)
      { return take(normal_tractions(view(usable), Geometry(geometry).now, view(forces))); }, nb::arg("usable"),
      nb::arg("geometry"), nb::arg("forces"), "What multipliers gain by nodal forces, without friction, (n)");
  m.def(
      "add_linearisation_error",
      [](nb::dict state, nb::dict geometry, int gdim, double friction, Array gap, Array slip)
      {
        const Nodes nodes(state, gdim, friction);
        const Geometry at(geometry);
        std::vector<double> gap_at(at.now.gap.begin(), at.now.gap.end()),
            slip_at(at.now.slip.begin(), at.now.slip.end());
        add_linearisation_error(nodes.now, at.now, view(gap), view(slip), gap_at, slip_at);
        return nb::make_tuple(take(std::move(gap_at)), vectors(slip_at, nodes.now.size()));
      },
      nb::arg("state"), nb::arg("geometry"), nb::arg("gdim"), nb::arg("friction"), nb::arg("gap"), nb::arg("slip"),
      "Gaps and slips to linearise about, with a second-order correction");
  const auto prescribed = [](const Mask& fixed, const Array& driven, int gdim, double tolerance)
  { return PrescribedComponents{gdim, view(fixed), view(driven), tolerance}; };
  m.def(
      "remaining_motion",
      [prescribed](Mask fixed, Array driven, int gdim, Indices nodes, Array u, Array start)
      {
        return take(
            remaining_motion(prescribed(fixed, driven, gdim, 0.0), {nodes.data(), nodes.size()}, view(u), view(start)),
            {nodes.size(), std::size_t(gdim)});
      },
      nb::arg("fixed"), nb::arg("driven"), nb::arg("gdim"), nb::arg("nodes"), nb::arg("u"), nb::arg("start"),
      "What prescribed components of nodes have yet to move, (n, gdim)");
  m.def(
      "locked_components",
      [prescribed](Mask fixed, Array driven, int gdim, Indices nodes, std::array<double, 3> motion, double tolerance)
      {
        return mask(locked_components(prescribed(fixed, driven, gdim, tolerance), {nodes.data(), nodes.size()}, motion),
                    {nodes.size(), std::size_t(gdim)});
      },
      nb::arg("fixed"), nb::arg("driven"), nb::arg("gdim"), nb::arg("nodes"), nb::arg("motion"), nb::arg("tolerance"),
      "Prescribed components that move as a rigid master does, (n, gdim)");
  m.def(
      "locked_components",
      [prescribed](Mask fixed, Array driven, int gdim, const MortarIntegrals& integrals, Array x, double size,
                   double tolerance)
      {
        return mask(locked_components(prescribed(fixed, driven, gdim, tolerance), integrals, view(x), size),
                    {integrals.nodes().nodes.size(), std::size_t(gdim)});
      },
      nb::arg("fixed"), nb::arg("driven"), nb::arg("gdim"), nb::arg("integrals"), nb::arg("x"), nb::arg("size"),
      nb::arg("tolerance"), "Prescribed components that the master is prescribed to move along as well. Collective");
}

void bind_friction(nb::module_& m)
{
  nb::class_<CoulombFriction>(m, "CoulombFriction", "Friction tractions that no equilibrium of a node tells")
      .def(nb::init<int, std::size_t>(), nb::arg("gdim"), nb::arg("num_nodes"))
      .def_prop_rw(
          "imposed", [](const CoulombFriction& f) { return copy(f.imposed, {f.num_nodes(), std::size_t(f.gdim())}); },
          [](CoulombFriction& f, Array values)
          {
            if (values.size() != f.imposed.size())
              throw std::invalid_argument("imposed: a traction of every node is needed");
            f.imposed = vector<double>(values);
          },
          nb::rv_policy::move, "Tractions along prescribed directions, (n, gdim), a copy")
      .def(
          "update_directions", [](CoulombFriction& f, Mask usable, nb::dict geometry, Mask locked)
          { f.update_directions(view(usable), Geometry(geometry).now, view(locked)); }, nb::arg("usable"),
          nb::arg("geometry"), nb::arg("locked"), "A new state to linearise about")
      .def(
          "set_edges", [](CoulombFriction& f, Array projectors) { f.set_edges(vector<double>(projectors)); },
          nb::arg("projectors"), "Directions that another contact of a node holds, (n, gdim, gdim), or empty")
      .def_prop_ro(
          "locked", [](const CoulombFriction& f)
          { return copy(f.locked(), {f.num_nodes(), std::size_t(f.gdim()), std::size_t(f.gdim())}); },
          nb::rv_policy::move, "Projectors on locked directions, (n, gdim, gdim), a copy")
      .def_prop_ro(
          "prescribed", [](const CoulombFriction& f)
          { return take(f.prescribed(), {f.num_nodes(), std::size_t(f.gdim()), std::size_t(f.gdim())}); },
          nb::rv_policy::move, "Projectors on locked and driven directions together, (n, gdim, gdim)")
      .def(
          "update_imposed",
          [](CoulombFriction& f, nb::dict state, double friction, Mask was_stuck, Array traction_n)
          {
            return mask(f.update_imposed(Nodes(state, f.gdim(), friction).now, view(was_stuck), view(traction_n)),
                        {f.num_nodes()});
          },
          nb::arg("state"), nb::arg("friction"), nb::arg("was_stuck"), nb::arg("traction_n"),
          "Imposed tractions after changes of the active set; mask of nodes whose kept traction is another one")
      .def(
          "update_springs",
          [](CoulombFriction& f, nb::dict state, nb::dict geometry, double friction, Array slave_stiffness,
             Array master_stiffness)
          {
            CoulombFriction::Springs s = f.update_springs(Nodes(state, f.gdim(), friction).now, Geometry(geometry).now,
                                                          view(slave_stiffness), view(master_stiffness));
            const std::size_t num = s.rows.size(), gdim = f.gdim();
            return nb::make_tuple(take(std::move(s.rows)), take(std::move(s.blocks), {num, gdim, gdim}),
                                  take(std::move(s.traction), {f.num_nodes(), gdim}));
          },
          nb::arg("state"), nb::arg("geometry"), nb::arg("friction"), nb::arg("slave_stiffness"),
          nb::arg("master_stiffness"), "Numbers of nodes with springs, their blocks, tractions of all nodes")
      .def_prop_ro("has_springs", &CoulombFriction::has_springs)
      .def(
          "raise_imposed", [](CoulombFriction& f, nb::dict state, double friction)
          { f.raise_imposed(Nodes(state, f.gdim(), friction).now); }, nb::arg("state"), nb::arg("friction"),
          "After a linear solution: slips along driven directions raise the imposed tractions")
      .def(
          "known_tractions",
          [](const CoulombFriction& f, nb::dict state, double friction)
          {
            return take(f.known_tractions(Nodes(state, f.gdim(), friction).now),
                        {f.num_nodes(), std::size_t(f.gdim())});
          },
          nb::arg("state"), nb::arg("friction"), "Tractions of springs and imposed ones, (n, gdim)");
}

void bind_condensation(nb::module_& m)
{
  nb::class_<Condensation>(m, "Condensation", "Unknowns and equations of constrained nodes exchanged: T_L^T K T")
      .def(
          "__init__",
          [](Condensation* self, dolfinx_wrappers::MPICommWrapper comm, std::size_t num_owned, std::int64_t first,
             int gdim, std::vector<Constraints> parts)
          { new (self) Condensation(comm.get(), num_owned, first, gdim, std::move(parts)); },
          nb::arg("comm"), nb::arg("num_owned"), nb::arg("first"), nb::arg("gdim"), nb::arg("parts"))
      .def_prop_ro("right", &Condensation::right, nb::rv_policy::reference)
      .def_prop_ro("left", &Condensation::left, nb::rv_policy::reference)
      .def_prop_ro("symmetric", &Condensation::symmetric)
      .def_prop_ro(
          "known", [](Condensation& c)
          { return nb::ndarray<nb::numpy, double, nb::ndim<1>>(c.known.data(), {c.known.size()}, nb::find(c)); },
          nb::rv_policy::reference, "Known increments, a view")
      .def_prop_ro(
          "pinned", [](const Condensation& c) { return mask(c.pinned(), {c.pinned().size()}); }, nb::rv_policy::move)
      .def(
          "residual", [](const Condensation& c, Array values) { return take(c.residual(view(values))); },
          nb::arg("values"), "T_L^T times a nodal residual, zero at pinned unknowns. Collective")
      .def(
          "unknowns", [](const Condensation& c, Array increments) { return take(c.unknowns(view(increments))); },
          nb::arg("increments"), "Unknowns that stand for displacement increments")
      .def(
          "increment", [](const Condensation& c, Vec y) { return take(c.increment(y)); }, nb::arg("y"),
          "Displacement increments T y + known. Collective")
      .def("condense", &Condensation::condense, nb::arg("K"), nb::rv_policy::take_ownership, "T_L^T K T. Collective");
}

void bind_saddle_point(nb::module_& m)
{
  nb::class_<SaddlePoint>(m, "SaddlePoint", "Displacements and multipliers as unknowns; `stiffness`: list of matrices")
      .def(
          "__init__",
          [](SaddlePoint* self, dolfinx_wrappers::MPICommWrapper comm, std::size_t num_owned, int gdim,
             std::vector<std::size_t> sizes) { new (self) SaddlePoint(comm.get(), num_owned, gdim, std::move(sizes)); },
          nb::arg("comm"), nb::arg("num_owned"), nb::arg("gdim"), nb::arg("sizes"), "Collective")
      .def(
          "assign",
          [](SaddlePoint& s, const std::vector<Constraints>& parts, Mask pinned, Array forces, double diagonal)
          { s.assign(parts, view(pinned), view(forces), diagonal); }, nb::arg("parts"), nb::arg("pinned"),
          nb::arg("forces"), nb::arg("diagonal"), "A new linear problem. Collective")
      .def_prop_ro(
          "pinned", [](const SaddlePoint& s) { return mask(s.pinned(), {s.pinned().size()}); }, nb::rv_policy::move,
          "Mask of the pinned unknowns, a copy")
      .def_prop_ro(
          "redundant",
          [](const SaddlePoint& s)
          {
            nb::list out;
            for (const auto& rows : s.redundant())
              out.append(copy(rows, {rows.size()}));
            return out;
          },
          "Numbers of the nodes whose normal condition was left out, by contact")
      .def_prop_ro("right", &SaddlePoint::right, nb::rv_policy::reference, "C, kept by this object")
      .def_prop_ro("left", &SaddlePoint::left, nb::rv_policy::reference, "C_L, kept by this object")
      .def(
          "mult", [](SaddlePoint& s, nb::list stiffness, Vec x, Vec y) { s.mult(matrices(stiffness), x, y); },
          nb::arg("stiffness"), nb::arg("x"), nb::arg("y"), "y = A x. Collective")
      .def(
          "load", [](SaddlePoint& s, nb::list stiffness, Array residual, Vec values, Vec b)
          { s.load(matrices(stiffness), view(residual), values, b); }, nb::arg("stiffness"), nb::arg("residual"),
          nb::arg("values"), nb::arg("b"), "Right-hand side. Collective")
      .def(
          "assemble", [](SaddlePoint& s, nb::list stiffness) { return s.assemble(matrices(stiffness)); },
          nb::arg("stiffness"), nb::rv_policy::take_ownership, "A as a matrix of its own. Collective")
      .def(
          "unknowns", [](const SaddlePoint& s, Array increments, Array forces)
          { return take(s.unknowns(view(increments), view(forces))); }, nb::arg("increments"), nb::arg("forces"),
          "Unknowns that stand for displacement increments and the multipliers' forces")
      .def(
          "forces", [](const SaddlePoint& s, Vec y) { return take(s.forces(y)); }, nb::arg("y"),
          "The multipliers' forces that unknowns stand for");
}
} // namespace

void dolfinx_impact::bindings::multipliers(nb::module_& m)
{
  bind_integrals(m);
  bind_constraints(m);
  bind_active_set(m);
  bind_linearisation(m);
  bind_friction(m);
  bind_condensation(m);
  bind_saddle_point(m);
}
