// SPDX-License-Identifier: MIT
#include "casters.h"
#include "dolfinx_impact/problems/RollingProblem.h"
#include "dolfinx_impact/rolling/RollingContact.h"
#include "masks.h"
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>

using namespace dolfinx_impact::rolling;
using dolfinx_impact::enforcement::MortarContact;
using dolfinx_impact::enforcement::MortarOptions;
using dolfinx_impact::gap::Rigid;
using dolfinx_impact::problems::RollingProblem;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;
typedef std::function<void(const std::string&)> Line;
typedef std::shared_ptr<dolfinx::fem::Constant<double>> Rate;

Motion motion(decltype(Motion::kind) kind, Rate rate, const Indices& nodes)
{
  return {std::move(kind), std::move(rate), {nodes.data(), nodes.data() + nodes.size()}};
}

/// Spin of the flow with a number.
const Motion& spin_at(RollingProblem& p, std::size_t number)
{
  const Motion& found = p.flow().motions().at(number);
  if (!found.spin())
    throw std::invalid_argument("the motion is no Spin");
  return found;
}
} // namespace

void dolfinx_impact::bindings::rolling(nb::module_& m)
{
  nb::class_<Motion>(m, "Motion", "Motion of the material of a body through its mesh")
      .def_static(
          "spin", [](std::array<double, 3> point, std::array<double, 3> axis, Rate omega, Indices nodes)
          { return motion(Spin{point, axis}, std::move(omega), nodes); }, nb::arg("point"), nb::arg("axis"),
          nb::arg("omega"), nb::arg("nodes"), "Rotation about a fixed axis")
      .def_static(
          "translation", [](Rate velocity, Indices nodes) { return motion(Translation(), std::move(velocity), nodes); },
          nb::arg("velocity"), nb::arg("nodes"), "Translation with one velocity");
  nb::class_<Flow>(m, "Flow", "How the material of all bodies flows through the mesh")
      .def(nb::init<std::shared_ptr<const FunctionSpace>, std::vector<Motion>>(), nb::arg("V"), nb::arg("motions"))
      .def_rw("lateral", &Flow::lateral, "Speed of the first spinning body along its axis, over the speed [1]")
      .def_rw("turn", &Flow::turn, "Turn of that body about the contact's normal, over the speed [1/L]");
  nb::class_<RollingContact, MortarContact>(m, "RollingContact", "Contact of bodies that flow past each other")
      .def(
          "__init__",
          [](RollingContact* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
             const MortarOptions& options, Mask fixed, std::shared_ptr<Flow> flow)
          {
            new (self) RollingContact(std::move(V), slave, master, options, {view(fixed).begin(), view(fixed).end()},
                                      std::move(flow));
          },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), nb::arg("flow"),
          "Collective")
      .def(
          "__init__",
          [](RollingContact* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             std::shared_ptr<const Rigid> master, const MortarOptions& options, Mask fixed, std::shared_ptr<Flow> flow)
          {
            new (self) RollingContact(std::move(V), slave, std::move(master), options,
                                      {view(fixed).begin(), view(fixed).end()}, std::move(flow));
          },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), nb::arg("flow"),
          "Collective")
      .def_prop_rw(
          "obstacle_velocity", [](const RollingContact& c) { return c.obstacle_velocity(); },
          [](RollingContact& c, std::array<double, 3> velocity) { c.obstacle_velocity() = velocity; },
          "Velocity of the surface of a rigid master [L/T]")
      .def_prop_ro(
          "slip_velocity", [](const RollingContact& c)
          { return vectors(c.slip_velocity(), c.geometry().num_nodes(), c.geometry().gdim()); },
          "Of slave against master, (n, gdim) [L/T]")
      .def_prop_ro("friction_power", &RollingContact::friction_power, "Of all ranks [F L/T]")
      .def("speed", &RollingContact::speed, "Largest speed at the surfaces, of all ranks [L/T]. Collective");
}

void dolfinx_impact::bindings::rolling_problem(nb::module_& m)
{
  using dolfinx_impact::problems::PowerBalance;
  using dolfinx_impact::problems::StaticProblem;
  nb::class_<PowerBalance>(m, "PowerBalance", "Powers of a steady state [F L/T]")
      .def_ro("driving", &PowerBalance::driving)
      .def_ro("friction", &PowerBalance::friction)
      .def_ro("rolling", &PowerBalance::rolling);
  nb::class_<RollingProblem>(m, "RollingProblem", "Bodies through whose meshes the material flows steadily")
      .def(nb::init<std::shared_ptr<StaticProblem>, std::shared_ptr<Flow>>(), nb::arg("equilibrium"), nb::arg("flow"),
           "Collective")
      .def(
          "solve",
          [](RollingProblem& self, int steps, double rtol, double atol, int max_iterations,
             std::optional<int> cut_backs, std::optional<double> torque, Line log, Line progress,
             std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration,
             std::function<void(int, double, double)> begins, std::function<void(double)> accepted)
          {
            auto found = self.solve(
                {steps, rtol, atol, max_iterations, cut_backs},
                {{log, std::move(progress), std::move(iteration)}, {log, std::move(begins), std::move(accepted)}},
                torque);
            return std::pair(std::move(found.steps), std::move(found.warning));
          },
          nb::arg("steps"), nb::arg("rtol"), nb::arg("atol"), nb::arg("max_iterations"), nb::arg("cut_backs").none(),
          nb::arg("torque").none(), nb::arg("log"), nb::arg("progress"), nb::arg("iteration"), nb::arg("begins"),
          nb::arg("accepted"), "Find the steady state: its report and a warning, or an empty text. Collective")
      .def(
          "torque", [](RollingProblem& self, std::size_t motion) { return self.torque(spin_at(self, motion)); },
          nb::arg("motion"), "Torque that drives the body of a Spin [F L]. Collective")
      .def(
          "axle", [](RollingProblem& self, std::size_t motion) { return self.axle(spin_at(self, motion)); },
          nb::arg("motion"), "Displacement of its axis, (3) [L]. Collective")
      .def("power_balance", &RollingProblem::power_balance, "Collective")
      .def("critical_factor", &RollingProblem::critical_factor, nb::arg("W"),
           "Factor on the present rates at which stiffness minus W becomes singular. Collective")
      .def(
          "frequencies",
          [](const RollingProblem& self, Mat G, Mat M, Mat along, int count, double tolerance)
          {
            Frequencies found = self.frequencies({nullptr, G, M, along}, count, tolerance);
            return std::pair(array(std::move(found.values)), found.growing);
          },
          nb::arg("G"), nb::arg("M"), nb::arg("along"), nb::arg("count"), nb::arg("tolerance"),
          "Signed frequencies, sorted by modulus, and the number of modes found that grow. Collective")
      .def_prop_ro("stable_rates", &RollingProblem::stable_rates, "Rates up to which the problem is known to be stable")
      .def(
          "saved_state", [](RollingProblem& self) { return self.state().copy(); },
          "What a solve starts from, values of its own")
      .def(
          "bring_back",
          [](RollingProblem& self, const dolfinx_impact::state::State& saved)
          {
            self.state().assign(saved);
            self.equilibrium().resume();
          },
          nb::arg("saved"), "Be in the state that saved_state has returned. Collective")
      .def("mark_reached", &RollingProblem::mark_reached,
           "Take present rates and loads as those that the last solve has reached");
}
