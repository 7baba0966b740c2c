// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/problems/AmplitudeTable.h"

namespace nb = nanobind;

namespace
{
using dolfinx_impact::bindings::take;
using dolfinx_impact::bindings::Values;
using dolfinx_impact::bindings::view;
using dolfinx_impact::problems::AmplitudeTable;
using dolfinx_impact::problems::Interpolation;
using dolfinx_impact::problems::Outside;

AmplitudeTable::Options amplitude_options(bool smooth, bool refuse_before, bool refuse_after, std::string name)
{
  return {smooth ? Interpolation::smooth : Interpolation::linear, refuse_before ? Outside::refuse : Outside::hold,
          refuse_after ? Outside::refuse : Outside::hold, std::move(name)};
}
} // namespace

namespace dolfinx_impact::bindings
{
void amplitudes(nb::module_& m)
{
  nb::class_<AmplitudeTable>(m, "AmplitudeTable", "Function of time from a table of times and values")
      .def(
          "__init__",
          [](AmplitudeTable* self, const Values& times, const Values& values, bool smooth, bool refuse_before,
             bool refuse_after, std::string name)
          {
            const auto t = view(times), v = view(values);
            new (self) AmplitudeTable({t.begin(), t.end()}, {v.begin(), v.end()},
                                      amplitude_options(smooth, refuse_before, refuse_after, std::move(name)));
          },
          nb::arg("times"), nb::arg("values"), nb::arg("smooth"), nb::arg("refuse_before"), nb::arg("refuse_after"),
          nb::arg("name"))
      .def_static(
          "from_csv",
          [](const std::string& file, bool smooth, bool refuse_before, bool refuse_after, std::string name)
          {
            return AmplitudeTable::from_csv(file,
                                            amplitude_options(smooth, refuse_before, refuse_after, std::move(name)));
          },
          nb::arg("file"), nb::arg("smooth"), nb::arg("refuse_before"), nb::arg("refuse_after"), nb::arg("name"))
      .def_prop_ro("size", &AmplitudeTable::size)
      .def_prop_ro(
          "times", [](const AmplitudeTable& self)
          { return take(std::vector<double>(self.times().begin(), self.times().end())); }, nb::rv_policy::move)
      .def_prop_ro(
          "values",
          [](const AmplitudeTable& self)
          {
            return take(std::vector<double>(self.values().begin(), self.values().end()),
                        {self.times().size(), std::size_t(self.size())});
          },
          nb::rv_policy::move)
      .def(
          "sample",
          [](const AmplitudeTable& self, const Values& times)
          {
            std::vector<double> out(times.size() * self.size());
            self.sample(view(times), out);
            return take(std::move(out), {times.size(), std::size_t(self.size())});
          },
          nb::arg("times"), nb::rv_policy::move);
}
} // namespace dolfinx_impact::bindings
