// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "casters.h"
#include "dolfinx_impact/gap/InitialPenetration.h"
#include "dolfinx_impact/gap/crossing.h"
#include "dolfinx_impact/gap/obstacle_side.h"

using namespace dolfinx_impact::gap;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Marks;

void check_points(std::size_t size, std::size_t wanted, const char* what)
{
  if (size != wanted)
    throw std::invalid_argument(std::string(what) + ": " + std::to_string(wanted) + " entries are needed, not " +
                                std::to_string(size));
}

void bind_crossing(nb::module_& m)
{
  m.def(
      "through_obstacle",
      [](const Rigid& obstacle, Values start, Values end, Values offset, double tolerance)
      {
        check_points(start.size(), offset.size() * obstacle.gdim, "start");
        check_points(end.size(), offset.size() * obstacle.gdim, "end");
        return take(through_obstacle(obstacle, view(start), view(end), view(offset), tolerance));
      },
      nb::arg("obstacle"), nb::arg("start"), nb::arg("end"), nb::arg("offset"), nb::arg("tolerance"),
      "Marks of points that are open on the far side of a rigid obstacle, through which their paths lead");
  m.def(
      "through_master",
      [](dolfinx_wrappers::MPICommWrapper comm, Marks suspects, Values sizes,
         const nb::typed<nb::callable, NumpyArray<const double>(double)>& gap_at)
      {
        check_points(sizes.size(), suspects.size(), "sizes");
        const auto gaps = [&](double part)
        {
          const auto gap = nb::cast<Values>(gap_at(part));
          check_points(gap.size(), suspects.size(), "gaps");
          return std::vector<double>(gap.data(), gap.data() + gap.size());
        };
        return take(through_master(comm.get(), {suspects.data(), suspects.size()}, view(sizes), gaps));
      },
      nb::arg("comm"), nb::arg("suspects"), nb::arg("sizes"), nb::arg("gap_at"),
      "Marks of points that have passed through a deformable master");
}
} // namespace

void dolfinx_impact::bindings::gap(nb::module_& m)
{
  nb::class_<GapAdjustment>(m, "GapAdjustment", "How gaps differ from the distances of meshed surfaces")
      .def(
          "__init__",
          [](GapAdjustment* self, double offset, std::optional<double> clearance, std::optional<double> adjust)
          { new (self) GapAdjustment{offset, clearance, adjust}; }, nb::kw_only(), nb::arg("offset") = 0.0,
          nb::arg("clearance") = nb::none(), nb::arg("adjust") = nb::none())
      .def_ro("offset", &GapAdjustment::offset)
      .def_ro("clearance", &GapAdjustment::clearance)
      .def_ro("adjust", &GapAdjustment::adjust);
  nb::class_<InitialPenetration>(m, "InitialPenetration", "Penetrations in the reference configuration")
      .def_prop_ro("num_points", &InitialPenetration::num_points)
      .def_prop_ro("depth", &InitialPenetration::depth)
      .def_prop_ro("where", &InitialPenetration::where)
      .def_prop_ro("num_adjusted", &InitialPenetration::num_adjusted)
      .def_prop_ro("largest_adjustment", &InitialPenetration::largest_adjustment)
      .def_prop_ro("where_adjusted", &InitialPenetration::where_adjusted)
      .def_prop_ro(
          "offset", [](const InitialPenetration& p) { return copy(p.offset(), {p.offset().size()}); },
          nb::rv_policy::move)
      .def_prop_ro("warning", &InitialPenetration::warning);
  m.def("check_side", &check_side, nb::arg("name"), nb::arg("V"), nb::arg("slave"), nb::arg("obstacle"),
        "Refuse a rigid obstacle whose surface does not face the slave. Collective");
  bind_crossing(m);
}
