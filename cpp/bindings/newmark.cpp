// SPDX-License-Identifier: MIT
#include "dolfinx_impact/integrators/newmark/ImplicitStepper.h"
#include "dolfinx_impact/integrators/newmark/MassRedistribution.h"
#include "dolfinx_impact/integrators/newmark/StepControl.h"
#include "dolfinx_impact/integrators/newmark/highest_frequency.h"
#include "masks.h"
#include "petsc_objects.h"
#include <nanobind/stl/function.h>

using namespace dolfinx_impact::integrators;
using dolfinx_impact::solve::Increment;

namespace
{
using namespace dolfinx_impact::bindings;
typedef dolfinx::fem::Function<double> Function;
typedef std::vector<std::array<double, 3>> Places;

std::vector<double> copy_of(const Array& values)
{
  return {values.data(), values.data() + values.size()};
}

/// A vector of an object as an array of NumPy's: a view of its memory, and its values are set by assignment.
template <typename Class>
void field(nb::class_<Class>& c, const char* name, std::vector<double> Class::* member)
{
  c.def_prop_rw(
      name,
      [member](nb::handle self)
      {
        std::vector<double>& values = nb::cast<Class&>(self).*member;
        const std::size_t shape[] = {values.size()};
        return typed<NumpyArray<double>>(nb::cast(NumpyArray<double>(values.data(), 1, shape, self)));
      },
      [member](Class& self, Array values) { self.*member = copy_of(values); });
}

Typed<NumpyArray<double>> rows(const Places& places)
{
  std::vector<double> out;
  for (const auto& place : places)
    out.insert(out.end(), place.begin(), place.end());
  return typed<NumpyArray<double>>(nb::cast(take(std::move(out), {places.size(), 3})));
}

Places places_of(const Array& values)
{
  Places out(values.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i)
    out[i / 3][i % 3] = values.data()[i];
  return out;
}

void bind_scheme(nb::module_& m)
{
  nb::class_<ImplicitScheme>(m, "ImplicitScheme",
                             "Generalised-alpha method by four parameters; docs/implicit/scheme.md")
      .def(
          "__init__", [](ImplicitScheme* self, double beta, double gamma, double alpha_m, double alpha_f)
          { new (self) ImplicitScheme{beta, gamma, alpha_m, alpha_f}; }, nb::arg("beta") = 0.25, nb::arg("gamma") = 0.5,
          nb::arg("alpha_m") = 0.0, nb::arg("alpha_f") = 0.0)
      .def_static("newmark", &ImplicitScheme::newmark, nb::arg("beta"), nb::arg("gamma"), "Newmark's method (1959)")
      .def_static("generalised_alpha", &ImplicitScheme::generalised_alpha, nb::arg("rho_inf"),
                  "Chung and Hulbert (1993), by the spectral radius at infinite frequency")
      .def_static("hht", &ImplicitScheme::hht, nb::arg("alpha"), "Hilber, Hughes and Taylor (1977)")
      .def_ro("beta", &ImplicitScheme::beta)
      .def_ro("gamma", &ImplicitScheme::gamma)
      .def_ro("alpha_m", &ImplicitScheme::alpha_m)
      .def_ro("alpha_f", &ImplicitScheme::alpha_f)
      .def_prop_ro("second_order", &ImplicitScheme::second_order)
      .def("stable_frequency", &ImplicitScheme::stable_frequency,
           "Largest product of frequency and step at which nothing grows; infinite if all are stable")
      .def("spectral_radius", &ImplicitScheme::spectral_radius, nb::arg("product"), nb::arg("damping") = 0.0,
           "Largest absolute eigenvalue of a step of an oscillator")
      .def(
          "amplification",
          [](const ImplicitScheme& self, double product, double damping)
          {
            const auto A = self.amplification(product, damping);
            return take(std::vector<double>(A.begin(), A.end()), {3, 3});
          },
          nb::arg("product"), nb::arg("damping") = 0.0,
          "Matrix (3, 3) of a step of an oscillator: maps (u, h v, h^2 A) at its start to that at its end")
      .def("__str__", &ImplicitScheme::text)
      .def("__repr__", [](const ImplicitScheme& self) { return "ImplicitScheme(" + self.text() + ")"; });
}

void bind_control(nb::module_& m)
{
  nb::class_<StepControl>(m, "StepControl", "Lengths of implicit steps: equal, by a local error, after failures")
      .def(nb::init<double, double, std::optional<double>, std::optional<double>, double>(), nb::arg("largest"),
           nb::arg("smallest"), nb::arg("tolerance") = nb::none(), nb::arg("length") = nb::none(),
           nb::arg("last") = 0.0)
      .def("next", &StepControl::next, nb::arg("time"), nb::arg("goal"), "Length of the next step, time at its end")
      .def("failed", &StepControl::failed, nb::arg("step"), "Halve it; returns whether it is long enough to be tried")
      .def("accepts", &StepControl::accepts, nb::arg("step"), nb::arg("error").none(), "Judge the error of a step")
      .def("choose_next_step", &StepControl::choose_next_step, nb::arg("step"), nb::arg("iterations"),
           nb::arg("error").none(), "Choose the next length after an accepted step")
      .def_prop_ro("largest", &StepControl::largest)
      .def_prop_ro("smallest", &StepControl::smallest)
      .def_prop_ro("tolerance", &StepControl::tolerance)
      .def_prop_ro("last", &StepControl::last)
      .def_prop_rw("length", &StepControl::length, &StepControl::set_length)
      .def_ro_static("many", &StepControl::many)
      .def_ro_static("few", &StepControl::few);
}

void bind_motion(nb::module_& m)
{
  nb::class_<Motion> motion(m, "Motion", "Motion at one time, over owned degrees of freedom");
  motion.def(
      "__init__", [](Motion* self, Array displacement, Array velocity, Array acceleration, Array mean)
      { new (self) Motion{copy_of(displacement), copy_of(velocity), copy_of(acceleration), copy_of(mean)}; },
      nb::arg("displacement"), nb::arg("velocity"), nb::arg("acceleration"), nb::arg("mean"));
  field(motion, "displacement", &Motion::displacement);
  field(motion, "velocity", &Motion::velocity);
  field(motion, "acceleration", &Motion::acceleration);
  field(motion, "mean", &Motion::mean);
  motion.def("state", &Motion::state, nb::arg("block_size"), nb::keep_alive<0, 1>(), "Its arrays as a State");
  nb::class_<Forces> forces(m, "Forces", "Forces at one time, over owned degrees of freedom");
  forces.def(
      "__init__",
      [](Forces* self, Array internal, Array external, Array damping, Array support, Array obstacles)
      {
        new (self)
            Forces{copy_of(internal), copy_of(external), copy_of(damping), copy_of(support), places_of(obstacles)};
      },
      nb::arg("internal"), nb::arg("external"), nb::arg("damping"), nb::arg("support"), nb::arg("obstacles"));
  field(forces, "internal", &Forces::internal);
  field(forces, "external", &Forces::external);
  field(forces, "damping", &Forces::damping);
  field(forces, "support", &Forces::support);
  forces.def_prop_ro("obstacles", [](const Forces& self) { return rows(self.obstacles); });
  nb::class_<Works>(m, "Works", "Works so far, over all ranks")
      .def(
          "__init__", [](Works* self, double internal, double external, double damping)
          { new (self) Works{internal, external, damping}; }, nb::arg("internal") = 0.0, nb::arg("external") = 0.0,
          nb::arg("damping") = 0.0)
      .def_rw("internal", &Works::internal)
      .def_rw("external", &Works::external)
      .def_rw("damping", &Works::damping);
  nb::class_<ImplicitEnergyBalance>(m, "ImplicitEnergyBalance",
                                    "Sums up the works of implicit steps by the trapezoidal rule")
      .def_prop_rw("forces", &ImplicitEnergyBalance::forces, &ImplicitEnergyBalance::set_forces,
                   nb::rv_policy::reference_internal)
      .def_prop_rw("works", &ImplicitEnergyBalance::works, &ImplicitEnergyBalance::set_works, nb::rv_policy::copy);
}

void bind_bodies(nb::module_& m)
{
  nb::class_<MassRedistribution>(m, "MassRedistribution", "Cells that pass the mass of contact nodes on")
      .def(
          "__init__",
          [](MassRedistribution* self, std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> V, Indices facets)
          { new (self) MassRedistribution(std::move(V), {facets.data(), facets.size()}); }, nb::arg("V"),
          nb::arg("facets"), "Collective")
      .def_prop_ro("on_surface", [](const MassRedistribution& self) { return mask(self.on_surface()); })
      .def_prop_ro("massless", [](const MassRedistribution& self) { return mask(self.massless()); })
      .def_prop_ro("cells", [](const MassRedistribution& self) { return array(self.cells()); })
      .def(
          "matrix", [](const MassRedistribution& self, std::int32_t cell, Array M)
          { return take(self.matrix(cell, view(M)), {M.shape(0), M.shape(0)}); }, nb::arg("cell"), nb::arg("M"),
          "Mass matrix of a cell after redistribution")
      .def(
          "lumped", [](const MassRedistribution& self, std::int32_t cell, Array masses)
          { return take(self.lumped(cell, view(masses))); }, nb::arg("cell"), nb::arg("masses"),
          "Lumped masses of a cell after redistribution");
  m.def(
      "highest_frequency",
      [](Mat stiffness, Mat mass, Mask held) { return highest_frequency(stiffness, mass, view(held)); },
      nb::arg("stiffness"), nb::arg("mass"), nb::arg("held"), "Highest angular frequency. Collective");
  nb::class_<Inertia>(m, "Inertia", "Mass matrix, and the degrees of freedom that have no mass")
      .def(
          "__init__",
          [](Inertia* self, Mat matrix, Mask massless)
          {
            const auto mask = view(massless);
            new (self) Inertia(matrix, {mask.begin(), mask.end()});
          },
          nb::arg("matrix"), nb::arg("massless"))
      .def(
          "times", [](const Inertia& self, Array x) { return take(self.times(view(x))); }, nb::arg("x"),
          nb::rv_policy::move, "M x, owned. Collective");
  nb::class_<VelocityForce>(m, "VelocityForce", "Nodal forces that depend on the velocity");
  nb::class_<FunctionVelocityForce, VelocityForce>(m, "FunctionVelocityForce", "Those that are functions")
      .def(
          "__init__",
          [](FunctionVelocityForce* self, nb::typed<nb::callable, NumpyArray<const double>()> forces,
             nb::typed<nb::callable, Matrices(Vec)> tangent, bool linear)
          {
            new (self) FunctionVelocityForce([forces] { return copy_of(nb::cast<Array>(forces())); },
                                             [tangent](Vec factors)
                                             {
                                               const nb::object given = nb::cast(factors, nb::rv_policy::reference);
                                               return matrices(nb::cast<Matrices>(tangent(given)));
                                             },
                                             linear);
          },
          nb::arg("forces"), nb::arg("tangent"), nb::arg("linear"));
}

void bind_stepper(nb::module_& m)
{
  nb::class_<ImplicitStepper>(m, "ImplicitStepper", "Implicit steps, repeated with half the length where one fails")
      .def("update_gaps", &ImplicitStepper::update_gaps, "Gaps of the present displacement. Collective")
      .def("show_motion", &ImplicitStepper::show_motion, "Set velocity and acceleration functions. Collective")
      .def(
          "energies",
          [](ImplicitStepper& self)
          {
            const auto values = self.energies().values();
            return take(std::vector<double>(values.begin(), values.end()));
          },
          nb::rv_policy::move, "Energies in the order of run_history.ENERGIES. Collective")
      .def_prop_ro("time", &ImplicitStepper::time)
      .def_prop_ro("step", &ImplicitStepper::step)
      .def_prop_ro("motion", &ImplicitStepper::motion, nb::rv_policy::reference_internal)
      .def_prop_ro("energy_balance", &ImplicitStepper::energy_balance, nb::rv_policy::reference_internal)
      .def_prop_ro("iterations", &ImplicitStepper::iterations)
      .def_prop_ro("cut_backs", &ImplicitStepper::cut_backs)
      .def_prop_ro("rejected", &ImplicitStepper::rejected);
}
} // namespace

void dolfinx_impact::bindings::newmark(nb::module_& m)
{
  bind_scheme(m);
  bind_control(m);
  bind_motion(m);
  bind_bodies(m);
  bind_stepper(m);
}
