// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/common/machine.h"
#include "hand_written/HandWrittenContact.h"
#include "hand_written/HandWrittenStep.h"
#include "module.h"
#include <dolfinx/fem/Form.h>
#include <dolfinx/fem/utils.h>
#include <memory>

namespace nb = nanobind;
using dolfinx_impact::bindings::Indices;
using dolfinx_impact::bindings::take;
using dolfinx_impact::bindings::Values;
using dolfinx_impact::bindings::view;
using dolfinx_impact::hand_written::HandWrittenContact;
using dolfinx_impact::hand_written::HandWrittenStep;

namespace
{
/// Coefficients of a DOLFINx form packed again and again into the same storage: what a time loop around
/// dolfinx::fem::assemble_vector does at best.
class Packed
{
public:
  explicit Packed(std::shared_ptr<const dolfinx::fem::Form<double>> form)
      : _form(std::move(form)), _storage(dolfinx::fem::allocate_coefficient_storage(*_form))
  {
  }
  void pack() { dolfinx::fem::pack_coefficients(*_form, _storage); }

private:
  std::shared_ptr<const dolfinx::fem::Form<double>> _form;
  std::map<std::pair<dolfinx::fem::IntegralType, int>, std::pair<std::vector<double>, int>> _storage;
};
} // namespace

void dolfinx_impact::bindings::bench(nb::module_& m)
{
  m.def("triad_bandwidth", &common::triad_bandwidth, nb::arg("n") = std::size_t(1) << 24,
        "Bandwidth of one core [B/s], of the memory; of the cache that three arrays of n numbers fit in");
  m.def(
      "peak_flops", &common::peak_flops, nb::arg("lanes") = 0,
      "Double-precision operations of one core [1/s], in vectors of 2, 4 or 8 numbers (0: the best of this processor; "
      "0.0 where it does not have such vectors)");
  nb::class_<Packed>(m, "Packed", "Coefficients of a DOLFINx form, packed into storage that is reused")
      .def(nb::init<std::shared_ptr<const dolfinx::fem::Form<double>>>(), nb::arg("form"))
      .def("pack", &Packed::pack);
  nb::class_<HandWrittenStep>(m, "HandWrittenStep",
                              "Central differences of a linear elastic body, written by hand for one cell and one law")
      .def(
          "__init__",
          [](HandWrittenStep* self, Values x, Indices cells, int nodes_per_cell, double mu, double lambda, Values mass,
             int width, bool one_point)
          {
            new (self) HandWrittenStep(view(x), {cells.data(), cells.size()}, {nodes_per_cell, one_point}, {mu, lambda},
                                       view(mass), width);
          },
          nb::arg("x"), nb::arg("cells"), nb::arg("nodes_per_cell"), nb::arg("mu"), nb::arg("lambda_"), nb::arg("mass"),
          nb::arg("width"), nb::arg("one_point") = false)
      .def(
          "start", [](HandWrittenStep& self, Values u, Values v) { self.start(view(u), view(v)); }, nb::arg("u"),
          nb::arg("v"))
      .def_static("widths", &HandWrittenStep::widths, "Cells at a time that this processor can take")
      .def("run", &HandWrittenStep::run, nb::arg("num_steps"), nb::arg("step"))
      .def("displacement", [](const HandWrittenStep& self) { return take(self.displacement()); }, nb::rv_policy::move);
  nb::class_<HandWrittenContact>(
      m, "HandWrittenContact",
      "Penalty contact of nodes over quadrilaterals, written by hand: nodes stay over their facets")
      .def(
          "__init__",
          [](HandWrittenContact* self, Values x, Indices slaves, Indices facets, double stiffness, double friction)
          {
            new (self) HandWrittenContact(view(x), {slaves.data(), slaves.size()}, {facets.data(), facets.size()},
                                          stiffness, friction);
          },
          nb::arg("x"), nb::arg("slaves"), nb::arg("facets"), nb::arg("stiffness"), nb::arg("friction"))
      .def_static("available", &HandWrittenContact::available, "Has this processor the vectors that it is written for?")
      .def(
          "evaluate", [](HandWrittenContact& self, Values u, Values du, bool cold)
          { return self.evaluate(view(u), view(du), cold); }, nb::arg("u"), nb::arg("du"), nb::arg("cold"),
          "Add the forces of one step; returns the time that it takes [s]")
      .def(
          "gap", [](const HandWrittenContact& self) { return take(self.gap()); }, nb::rv_policy::move)
      .def(
          "forces", [](const HandWrittenContact& self)
          { return take(std::vector<double>(self.forces().begin(), self.forces().end())); }, nb::rv_policy::move);
}
