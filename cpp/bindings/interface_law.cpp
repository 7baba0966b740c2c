// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "casters.h"
#include "dolfinx_impact/enforcement/interface/FrictionLaw.h"
#include "dolfinx_impact/enforcement/interface/InterfaceLaw.h"
#include <algorithm>
#include <map>

using namespace dolfinx_impact::enforcement;

namespace
{
using namespace dolfinx_impact::bindings;
typedef dolfinx::fem::Function<double> Function;

std::vector<InterfaceField> fields_of(const std::map<std::string, std::shared_ptr<const Function>>& given)
{
  std::vector<InterfaceField> out;
  for (const auto& [name, function] : given)
    out.push_back({name, function});
  return out;
}

std::vector<std::pair<std::string, double>> constants_of(const std::map<std::string, double>& given)
{
  return {given.begin(), given.end()};
}

void set(std::vector<double>& target, const Values& source, const std::string& name)
{
  if (source.size() != target.size())
    throw std::invalid_argument(name + ": " + std::to_string(target.size()) + " values are needed, not " +
                                std::to_string(source.size()));
  std::copy_n(source.data(), source.size(), target.begin());
}

const Values& value_of(const std::map<std::string, Values>& given, const std::string& name)
{
  const auto found = given.find(name);
  if (found == given.end())
    throw std::invalid_argument("values of " + name + " are needed");
  return found->second;
}

template <typename Points, typename Law>
void set_fields(Points& points, const Law& law, const std::map<std::string, Values>& given)
{
  for (std::size_t f = 0; f < law.fields().size(); ++f)
  {
    const std::string& name = law.fields()[f].name;
    set(points.slave_fields[f], value_of(given, name + "_slave"), name);
    set(points.master_fields[f], value_of(given, name + "_master"), name);
  }
}

/// What a law returns at points, and the new internal variables.
struct Evaluated
{
  InterfaceTractions tractions;
  InterfaceHistory history;
};

Evaluated evaluate(const InterfaceLaw& law, const std::map<std::string, Values>& given)
{
  const std::size_t num = value_of(given, "gap").size();
  InterfacePoints points = law.make_points(num);
  for (std::size_t q = 0; q < num; ++q)
    points.row[q] = std::int32_t(q);
  set(points.gap, value_of(given, "gap"), "gap");
  set(points.slip, value_of(given, "slip"), "slip");
  set(points.gap_rate, value_of(given, "gap_rate"), "gap_rate");
  set(points.slip_rate, value_of(given, "slip_rate"), "slip_rate");
  set(points.normal, value_of(given, "normal"), "normal");
  set_fields(points, law, given);
  Evaluated out{{}, law.make_history(num)};
  for (InterfaceHistory::Variable& v : out.history.variables)
  {
    set(v.committed, value_of(given, "history " + v.name), v.name);
    if (v.tangential)
      v.turned = v.committed;
  }
  law.evaluate(points, out.history, out.tractions);
  return out;
}

FrictionCoefficients coefficients(const FrictionLaw& law, const std::map<std::string, Values>& given)
{
  FrictionPoints points = law.make_points(value_of(given, "pressure").size());
  set(points.pressure, value_of(given, "pressure"), "pressure");
  set(points.slip_rate, value_of(given, "slip_rate"), "slip_rate");
  set(points.normal, value_of(given, "normal"), "normal");
  set_fields(points, law, given);
  FrictionCoefficients out;
  law.evaluate(points, out);
  return out;
}

auto derivative(const InterfaceDerivative& d)
{
  return copy(d.values, {d.values.size()});
}
} // namespace

namespace dolfinx_impact::bindings
{
void interface_law(nb::module_& m)
{
  nb::class_<InterfaceLaw>(m, "InterfaceLaw", "A law of the interface by a kernel")
      .def(
          "__init__",
          [](InterfaceLaw* self, std::uintptr_t kernel, int gdim, const std::map<std::string, double>& constants,
             const std::map<std::string, std::shared_ptr<const Function>>& fields,
             const std::vector<std::string>& tangential, double reach)
          {
            new (self) InterfaceLaw(reinterpret_cast<const impact_kernel*>(kernel), gdim, constants_of(constants),
                                    fields_of(fields), tangential, reach);
          },
          nb::arg("kernel"), nb::arg("gdim"), nb::arg("constants"), nb::arg("fields"), nb::arg("tangential"),
          nb::arg("reach"))
      .def("set_constant", &InterfaceLaw::set_constant, nb::arg("name"), nb::arg("value"))
      .def_prop_ro("gdim", &InterfaceLaw::gdim)
      .def_prop_ro("reach", &InterfaceLaw::reach)
      .def_prop_ro("has_rates", &InterfaceLaw::has_rates)
      .def_prop_ro("has_shear", &InterfaceLaw::has_shear)
      .def_prop_ro("has_energy", &InterfaceLaw::has_energy)
      .def("evaluate", &evaluate, nb::arg("values"),
           "At points: flat arrays by name: gap, slip, gap_rate, slip_rate, normal, NAME_slave and NAME_master of "
           "fields, 'history NAME' of internal variables");
  nb::class_<FrictionLaw>(m, "FrictionLaw", "A law of friction by a kernel")
      .def(
          "__init__",
          [](FrictionLaw* self, std::uintptr_t kernel, int gdim, const std::map<std::string, double>& constants,
             const std::map<std::string, std::shared_ptr<const Function>>& fields)
          {
            new (self) FrictionLaw(reinterpret_cast<const impact_kernel*>(kernel), gdim, constants_of(constants),
                                   fields_of(fields));
          },
          nb::arg("kernel"), nb::arg("gdim"), nb::arg("constants"), nb::arg("fields"))
      .def("set_constant", &FrictionLaw::set_constant, nb::arg("name"), nb::arg("value"))
      .def_prop_ro("gdim", &FrictionLaw::gdim)
      .def_prop_ro("has_rates", &FrictionLaw::has_rates)
      .def_prop_ro("has_pressure", &FrictionLaw::has_pressure)
      .def("evaluate", &coefficients, nb::arg("values"),
           "At points: flat arrays by name: pressure, slip_rate, normal, NAME_slave and NAME_master of fields");
  nb::class_<FrictionCoefficients>(m, "FrictionCoefficients", "Coefficients of friction at points; flat copies")
      .def_prop_ro(
          "value", [](const FrictionCoefficients& c) { return copy(c.value, {c.value.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "by_pressure", [](const FrictionCoefficients& c) { return copy(c.by_pressure, {c.by_pressure.size()}); },
          nb::rv_policy::move, "Empty: the law does not depend on it")
      .def_prop_ro(
          "by_slip_rate", [](const FrictionCoefficients& c) { return copy(c.by_slip_rate, {c.by_slip_rate.size()}); },
          nb::rv_policy::move, "(n, gdim) flat; empty: the law does not depend on it");
  nb::class_<Evaluated>(m, "InterfaceTractions", "What a law returns at points; flat copies")
      .def_prop_ro(
          "pressure", [](const Evaluated& e) { return copy(e.tractions.pressure, {e.tractions.pressure.size()}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "shear", [](const Evaluated& e) { return copy(e.tractions.shear, {e.tractions.shear.size()}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "energy", [](const Evaluated& e) { return copy(e.tractions.energy, {e.tractions.energy.size()}); },
          nb::rv_policy::move, "Empty where the law does not know it")
      .def_prop_ro(
          "sticks", [](const Evaluated& e) { return copy(e.tractions.sticks, {e.tractions.sticks.size()}); },
          nb::rv_policy::move)
      .def_prop_ro("num_unsolved", [](const Evaluated& e) { return e.tractions.num_unsolved; })
      .def(
          "by",
          [](const Evaluated& e, const std::string& input)
          {
            const InterfaceTractions& t = e.tractions;
            if (input == "gap")
              return derivative(t.by_gap);
            if (input == "slip")
              return derivative(t.by_slip);
            if (input == "gap_rate")
              return derivative(t.by_gap_rate);
            if (input == "slip_rate")
              return derivative(t.by_slip_rate);
            if (input == "normal")
              return derivative(t.by_normal);
            for (std::size_t k = 0; k < e.history.variables.size(); ++k)
              if (input == "history " + e.history.variables[k].name)
                return derivative(t.by_history[k]);
            throw std::invalid_argument("a law has no input " + input);
          },
          nb::arg("input"), "Derivative of pressure and shear by an input, (n, 1 + gdim, size) flat; empty: zero")
      .def(
          "history",
          [](const Evaluated& e, const std::string& name)
          {
            for (const InterfaceHistory::Variable& v : e.history.variables)
              if (v.name == name)
                return copy(v.updated, {v.updated.size()});
            throw std::invalid_argument("the law has no internal variable " + name);
          },
          nb::arg("name"), "New values of an internal variable");
}
} // namespace dolfinx_impact::bindings
