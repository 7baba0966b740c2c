// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/enforcement/ContactTotals.h"
#include <algorithm>
#include <caster_mpi.h>

using namespace dolfinx_impact::enforcement;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> Rows;
typedef nb::ndarray<const std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Marks;

std::span<const double> view(const Rows& rows)
{
  return {rows.data(), rows.size()};
}
} // namespace

void dolfinx_impact::bindings::enforcement(nb::module_& m)
{
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
                {int(gdim), view(x), view(traction), view(slip), states, {weight.data(), num}, {covered.data(), num}});
          },
          nb::arg("comm"), nb::arg("x"), nb::arg("traction"), nb::arg("slip"), nb::arg("status"), nb::arg("weight"),
          nb::arg("covered"), "Sum up a converged increment. Collective");
}
