// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "casters.h"
#include "dolfinx_impact/enforcement/ContactTotals.h"
#include "dolfinx_impact/enforcement/StaticContact.h"
#include <algorithm>

using namespace dolfinx_impact::enforcement;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> Rows;
typedef nb::ndarray<const std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Marks;

std::span<const double> flat(const Rows& rows)
{
  return {rows.data(), rows.size()};
}

auto numbers(const std::vector<ContactStatus>& status)
{
  std::vector<std::int8_t> out(status.size());
  std::transform(status.begin(), status.end(), out.begin(), [](ContactStatus s) { return std::int8_t(s); });
  return take(std::move(out));
}

void bind_static_contact(nb::module_& m)
{
  nb::class_<StaticContact>(m, "StaticContact", "A contact of one pair in equilibrium; arrays are flat copies")
      .def_prop_ro("name", &StaticContact::name)
      .def_prop_ro("fault", &StaticContact::fault)
      .def("check_parameters", &StaticContact::check_parameters)
      .def("set_time_step", &StaticContact::set_time_step, nb::arg("dt"), "Of the increments that follow; 0: none [T]")
      .def(
          "begin_step",
          [](StaticContact& c, Values u, const std::optional<std::array<double, 3>>& displacement,
             const std::optional<Values>& target)
          { c.begin_step(view(u), displacement, target ? view(*target) : std::span<const double>()); },
          nb::arg("u"), nb::arg("displacement").none(), nb::arg("target") = nb::none())
      .def_prop_ro("displacement", &StaticContact::displacement)
      .def("set_rotation", &StaticContact::set_rotation, nb::arg("rotation"),
           "Rotation of a rigid master at the end of the next increment, row by row")
      .def_prop_ro("rotation", &StaticContact::rotation, "Of a rigid master that can turn, row by row; else None")
      .def("state", &StaticContact::state, nb::keep_alive<0, 1>(), "What an increment starts from; views")
      .def("accept_step", &StaticContact::accept_step)
      .def("augment", &StaticContact::augment)
      .def("prescribed_overlap", &StaticContact::prescribed_overlap)
      .def("passed_through", &StaticContact::passed_through)
      .def(
          "update_gap", [](StaticContact& c, Values u) { c.update_gap(view(u)); }, nb::arg("u"))
      .def("update_active_set", &StaticContact::update_active_set, nb::arg("first"), nb::arg("last").none())
      .def("contact_forces", [](const StaticContact& c) { return take(c.contact_forces()); })
      .def("add_residual", &StaticContact::add_residual, nb::arg("b"))
      .def("update_nodal_stiffness", &StaticContact::update_nodal_stiffness, nb::arg("K"))
      .def(
          "tangent",
          [](StaticContact& c)
          {
            Mat tangent = c.tangent();
            return typed<std::optional<Mat>>(tangent ? nb::cast(tangent, nb::rv_policy::reference) : nb::none());
          },
          "PETSc matrix, kept by this object; None: zero. Collective")
      .def("set_convex", &StaticContact::set_convex, nb::arg("convex"))
      .def_prop_ro("symmetric", &StaticContact::symmetric)
      .def_prop_ro("num_active", &StaticContact::num_active)
      .def("violation", &StaticContact::violation)
      .def("round_off", &StaticContact::round_off)
      .def("largest_violation", &StaticContact::largest_violation)
      .def("mesh_advice", &StaticContact::mesh_advice)
      .def("smallest_gap", &StaticContact::smallest_gap)
      .def("saved_state", &StaticContact::saved_state, "What a checkpoint holds of the last converged state")
      .def(
          "resume", [](StaticContact& c, const dolfinx_impact::state::State& saved, Values u)
          { c.resume(saved, view(u)); }, nb::arg("saved"), nb::arg("u"), "Continue from a checkpoint. Collective")
      .def("forget", &StaticContact::forget)
      .def(
          "rigid_body_products",
          [](const StaticContact& c, const dolfinx_impact::operators::RigidBodyModes& modes)
          {
            const std::size_t num = modes.num_modes();
            return take(c.rigid_body_products(modes), {num, num});
          },
          nb::arg("modes"))
      .def("close_nearest", &StaticContact::close_nearest)
      .def("closing_forces", [](const StaticContact& c) { return take(c.closing_forces()); })
      .def_prop_ro(
          "points", [](const StaticContact& c) { return take(c.points()); }, nb::rv_policy::move)
      .def_prop_ro(
          "gap", [](const StaticContact& c) { return take(c.gap()); }, nb::rv_policy::move)
      .def_prop_ro(
          "normal", [](const StaticContact& c) { return take(c.normal()); }, nb::rv_policy::move)
      .def_prop_ro(
          "pressure", [](const StaticContact& c) { return take(c.pressure()); }, nb::rv_policy::move)
      .def_prop_ro(
          "traction", [](const StaticContact& c) { return take(c.traction()); }, nb::rv_policy::move)
      .def_prop_ro(
          "slip", [](const StaticContact& c) { return take(c.slip()); }, nb::rv_policy::move)
      .def_prop_ro(
          "status", [](const StaticContact& c) { return numbers(c.status()); }, nb::rv_policy::move)
      .def_prop_ro(
          "weight", [](const StaticContact& c) { return take(c.weight()); }, nb::rv_policy::move)
      .def("covered", [](const StaticContact& c) { return take(c.covered()); })
      .def("stored_energy", &StaticContact::stored_energy, "Energy of the springs of a penalty. Collective");
}
} // namespace

void dolfinx_impact::bindings::enforcement(nb::module_& m)
{
  bind_static_contact(m);
  nb::class_<MultiplierContact, StaticContact>(m, "MultiplierContact", "One whose normal tractions are unknowns");
  nb::class_<ContactTotals>(m, "ContactTotals", "Totals of a contact over all ranks; force and moment have 3 entries")
      .def(nb::init<>())
      .def_rw("known", &ContactTotals::known)
      .def_rw("force", &ContactTotals::force)
      .def_rw("moment", &ContactTotals::moment)
      .def_rw("area", &ContactTotals::area)
      .def_rw("dissipated", &ContactTotals::dissipated)
      .def_prop_rw(
          "slip", [](const ContactTotals& t) { return copy(t.slip, {t.slip.size()}); }, [](ContactTotals& t, Values v)
          { t.slip.assign(v.data(), v.data() + v.size()); }, nb::rv_policy::move, "Slips whose work is counted")
      .def(
          "update",
          [](ContactTotals& t, dolfinx_wrappers::MPICommWrapper comm, Rows x, Rows traction, Rows slip, Marks status,
             Values weight, Values covered)
          {
            const std::size_t num = x.shape(0), gdim = x.shape(1);
            for (const Rows* rows : {&traction, &slip})
              if (rows->shape(0) != num || rows->shape(1) != gdim)
                throw std::invalid_argument("tractions and slips have the shape of the positions");
            if (status.size() != num || weight.size() != num || covered.size() != num)
              throw std::invalid_argument("totals need status, area and covered part of every point");
            std::vector<ContactStatus> states(num);
            std::transform(status.data(), status.data() + num, states.begin(),
                           [](std::int8_t s) { return ContactStatus(s); });
            t.update(
                comm.get(),
                {int(gdim), flat(x), flat(traction), flat(slip), states, {weight.data(), num}, {covered.data(), num}});
          },
          nb::arg("comm"), nb::arg("x"), nb::arg("traction"), nb::arg("slip"), nb::arg("status"), nb::arg("weight"),
          nb::arg("covered"), "Sum up a converged increment. Collective");
}
