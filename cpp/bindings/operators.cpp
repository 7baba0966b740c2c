// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/operators/AveragedNeoHookean.h"
#include "dolfinx_impact/operators/CellBounds.h"
#include "dolfinx_impact/operators/CellMatrix.h"
#include "dolfinx_impact/operators/Halo.h"
#include "dolfinx_impact/operators/InternalForce.h"
#include "dolfinx_impact/operators/KernelTangent.h"
#include "dolfinx_impact/operators/LinearSums.h"
#include "dolfinx_impact/operators/NodalAverage.h"
#include "dolfinx_impact/operators/RigidBodyModes.h"
#include "dolfinx_impact/operators/frequency.h"
#include "dolfinx_impact/operators/largest_rotation.h"
#include "dolfinx_impact/operators/lump.h"
#include "dolfinx_impact/operators/nodal_averages.h"
#include "dolfinx_impact/operators/resultant.h"
#include "masks.h"
#include "petsc_objects.h"
#include <dolfinx/la/Vector.h>

namespace nb = nanobind;
using namespace dolfinx_impact::operators;

namespace
{
typedef nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Indices;
typedef nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu> Values;
typedef nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu> Vector;

Integral integral(std::uintptr_t kernel, const Indices& entities, const Values& constants,
                  std::shared_ptr<PointHistory> history)
{
  return {reinterpret_cast<const impact_kernel*>(kernel),
          {entities.data(), entities.data() + entities.size()},
          {constants.data(), constants.data() + constants.size()},
          std::move(history)};
}

void bind_tangent(nb::module_& m)
{
  nb::class_<CellValues::Source>(m, "Source", "Where a coefficient comes from: a function, a history, or neither")
      .def(
          "__init__", [](CellValues::Source* self, std::shared_ptr<const Function> function, std::string field)
          { new (self) CellValues::Source{std::move(function), std::move(field)}; },
          nb::arg("function").none() = nb::none(), nb::arg("field") = "");
  nb::class_<KernelTangent>(m, "KernelTangent", "Matrix of kernels and of a form of DOLFINx, made once")
      .def(
          "__init__",
          [](KernelTangent* self, std::shared_ptr<const FunctionSpace> rows,
             std::shared_ptr<const FunctionSpace> columns, const std::vector<Integral>& integrals,
             const std::vector<std::vector<CellValues::Source>>& sources,
             std::shared_ptr<const dolfinx::fem::Form<double>> other)
          {
            std::vector<KernelTangent::Named> named;
            for (std::size_t i = 0; i < integrals.size(); ++i)
              named.push_back({integrals[i], sources.at(i)});
            new (self) KernelTangent({std::move(rows), std::move(columns)}, named, std::move(other));
          },
          nb::arg("test"), nb::arg("trial"), nb::arg("integrals"), nb::arg("sources"), nb::arg("other").none(),
          "sources: of the coefficients of each integral, in the kernel's order. Collective")
      .def("assemble", &KernelTangent::assemble, nb::arg("bcs"), "Rows and columns of bcs are zeroed. Collective")
      .def(
          "add_average",
          [](KernelTangent& self, std::shared_ptr<NodalAverage> average, std::shared_ptr<KernelTangent> force,
             std::shared_ptr<KernelTangent> measure)
          { self.add_average({std::move(average), std::move(force), std::move(measure)}); },
          nb::arg("average"), nb::arg("force"), nb::arg("measure"),
          "Add the derivative by averages at the nodes: force (by average) times measure (by displacement). Collective")
      .def("set_constants",
           [](KernelTangent& self, std::size_t i, Values c) { self.set_constants(i, {c.data(), c.size()}); })
      .def_prop_ro("matrix", &KernelTangent::matrix, nb::rv_policy::reference);
}

void bind_history(nb::module_& m)
{
  nb::class_<PointHistory>(m, "PointHistory", "Internal variables at the points of the cells of one integral")
      .def_prop_ro(
          "cells",
          [](const PointHistory& self)
          {
            return dolfinx_impact::bindings::take(std::vector<std::int32_t>(self.cells().begin(), self.cells().end()));
          },
          nb::rv_policy::move)
      .def_prop_ro("num_points", &PointHistory::num_points)
      .def_prop_ro("names",
                   [](const PointHistory& self)
                   {
                     std::vector<std::string> names;
                     for (std::size_t i = 0; i < self.num_fields(); ++i)
                       names.push_back(self.name(i));
                     return names;
                   })
      .def("num_components",
           [](const PointHistory& self, const std::string& name) { return self.num_components(self.find(name)); })
      .def("is_history",
           [](const PointHistory& self, const std::string& name) { return self.is_history(self.find(name)); })
      .def(
          "values", [](const PointHistory& self, const std::string& name, bool trial)
          { return dolfinx_impact::bindings::take(self.values(self.find(name), trial)); }, nb::arg("name"),
          nb::arg("trial") = false, nb::rv_policy::move,
          "Flat array of shape (num_cells, num_points, num_components), in the order of `cells`")
      .def(
          "set_values", [](PointHistory& self, const std::string& name, Values values)
          { self.set_values(self.find(name), {values.data(), values.size()}); }, nb::arg("name"), nb::arg("values"),
          "Replace committed values; the last evaluation is forgotten")
      .def("set_in_place", &PointHistory::set_in_place, nb::arg("in_place"))
      .def_prop_ro("in_place", &PointHistory::in_place)
      .def("store_snapshot", &PointHistory::store_snapshot)
      .def("restore_snapshot", &PointHistory::restore_snapshot)
      .def("commit", &PointHistory::commit)
      .def("revert", &PointHistory::revert)
      .def_prop_ro("memory", &PointHistory::memory, "Bytes of all values");
}

/// The array of a Halo with bs values per node, checked.
std::span<double> nodal(const Halo& halo, const Vector& values, int bs)
{
  if (bs < 1 || bs > Halo::max_bs || values.size() != std::size_t(halo.num_nodes()) * bs)
    throw std::invalid_argument("a Halo of " + std::to_string(halo.num_nodes()) + " nodes takes 1 to " +
                                std::to_string(Halo::max_bs) + " values for each, found " +
                                std::to_string(values.size()) + " values with bs = " + std::to_string(bs));
  return {values.data(), values.size()};
}

void bind_halo(nb::module_& m)
{
  nb::class_<Halo>(m, "Halo", "Exchange of nodal values between ranks: owned nodes of an IndexMap, then its ghosts")
      .def(
          "__init__",
          [](Halo* self, std::shared_ptr<const dolfinx::common::IndexMap> map,
             std::optional<nb::ndarray<const std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>> used)
          {
            new (self)
                Halo(std::move(map), used ? std::span(used->data(), used->size()) : std::span<const std::int8_t>());
          },
          nb::arg("index_map"), nb::arg("used").none() = nb::none(),
          "used: nonzero for each ghost that takes part in exchanges; None: all. Collective")
      .def_prop_ro("traffic",
                   [](const Halo& self) { return std::pair(self.traffic().messages, self.traffic().values); })
      .def_prop_ro("num_owned", &Halo::num_owned)
      .def_prop_ro("num_nodes", &Halo::num_nodes)
      .def(
          "forward", [](Halo& self, Vector values, int bs) { self.forward(nodal(self, values, bs), bs); },
          nb::arg("values").noconvert(), nb::arg("bs"), "Owned values to their ghosts (a view is changed). Collective")
      .def(
          "reverse", [](Halo& self, Vector values, int bs) { self.reverse(nodal(self, values, bs), bs); },
          nb::arg("values").noconvert(), nb::arg("bs"),
          "Ghost values added to their owners' (a view is changed). Collective");
}
} // namespace

void dolfinx_impact::bindings::operators(nb::module_& m)
{
  bind_halo(m);
  bind_history(m);
  nb::class_<Integral>(m, "Integral", "A kernel, where it acts and its constants (copied)")
      .def(
          "__init__",
          [](Integral* self, std::uintptr_t kernel, Indices entities, Values constants,
             std::shared_ptr<PointHistory> history)
          { new (self) Integral(integral(kernel, entities, constants, std::move(history))); },
          nb::arg("kernel"), nb::arg("entities"), nb::arg("constants"), nb::arg("history").none() = nb::none(),
          "history: internal variables of another operator on the same cells, to read only");
  nb::enum_<MeanLaw>(m, "MeanLaw", "Laws of the stress of means at nodes")
      .value("linear_elastic", MeanLaw::linear_elastic)
      .value("neo_hookean", MeanLaw::neo_hookean);
  nb::class_<MeanStress>(m, "MeanStress", "Stress of the mean strain or gradient of a node: its law and moduli")
      .def(
          "__init__", [](MeanStress* self, MeanLaw law, double lambda, double mu)
          { new (self) MeanStress{law, lambda, mu}; }, nb::arg("law"), nb::arg("lmbda"), nb::arg("mu"));
  nb::class_<InternalForce>(m, "InternalForce_float64",
                            "Matrix-free vector of a form of rank 1, value of a form of rank 0")
      .def(
          "__init__",
          [](InternalForce* self, std::shared_ptr<const Mesh> mesh, std::shared_ptr<const FunctionSpace> V,
             std::vector<Integral> integrals, std::map<std::string, std::shared_ptr<const Function>> coefficients,
             int width) { new (self) InternalForce(mesh, V, integrals, coefficients, width); },
          nb::arg("mesh"), nb::arg("test").none(), nb::arg("integrals"), nb::arg("coefficients"), nb::arg("width") = 0)
      .def(
          "assemble", [](const InternalForce& self, Vector b) { self.assemble({b.data(), b.size()}); },
          nb::arg("b").noconvert(), "Add this rank's contributions to b (a view is changed)")
      .def(
          "apply", [](const InternalForce& self, dolfinx::la::Vector<double>& b) { self.apply(b); }, nb::arg("b"),
          "b = f, ghosts exchanged")
      .def("value", &InternalForce::value)
      .def("set_constants",
           [](InternalForce& self, std::size_t i, Values c) { self.set_constants(i, {c.data(), c.size()}); })
      .def("history", &InternalForce::history, nb::arg("integral"), "Internal variables of an integral, or None")
      .def("set_in_place", &InternalForce::set_in_place, nb::arg("in_place"))
      .def("set_mixed", &InternalForce::set_mixed, "Compute element vectors in float from now on")
      .def("sum", &InternalForce::sum, nb::arg("name"), "Of this rank's cells, in the last evaluation")
      .def("store_snapshot", &InternalForce::store_snapshot)
      .def("restore_snapshot", &InternalForce::restore_snapshot)
      .def("commit", &InternalForce::commit)
      .def("revert", &InternalForce::revert)
      .def("has_history", &InternalForce::has_history)
      .def(
          "failures",
          [](const InternalForce& self)
          {
            const PointFailures f = self.failures();
            return std::tuple(f.count, f.cell, f.point, f.residual, f.unknowns);
          },
          "Points not solved in the last evaluation on this rank: number, then cell, point, relative residual and "
          "unknowns of the first")
      .def("fault", &InternalForce::fault, "Which local equations were not solved in the last evaluation. Collective")
      .def("width", &InternalForce::width, nb::arg("integral") = 0)
      .def("swept", &InternalForce::swept, nb::arg("integral"),
           "Did the last evaluation of an integral gather, compute and scatter in one function?")
      .def(
          "repeat",
          [](const InternalForce& self, Vector b, int times)
          {
            for (int i = 0; i < times; ++i)
              self.assemble({b.data(), b.size()});
          },
          nb::arg("b").noconvert(), nb::arg("times"), "Assemble several times in a row (for timing)")
      .def(
          "add_average",
          [](InternalForce& self, std::shared_ptr<NodalAverage> average, std::string displacement,
             std::optional<MeanStress> stress)
          { self.add_average(std::move(average), std::move(displacement), stress); },
          nb::arg("average"), nb::arg("displacement"), nb::arg("stress").none() = nb::none(),
          "Compute averages at the nodes before every evaluation, then collective. stress: of averages that no kernel "
          "reads")
      .def("add_together", &InternalForce::add_together, nb::arg("forces"),
           "Forces of kernels and averages that are added together from now on, where they can be")
      .def_prop_ro("flops", &InternalForce::flops);
  nb::class_<NodalAverage>(m, "NodalAverage", "Averages at the nodes of a measure of the cells around them")
      .def(
          "__init__",
          [](NodalAverage* self, std::shared_ptr<InternalForce> measure, const InternalForce& volume,
             std::shared_ptr<Function> average, std::string displacement, bool linear)
          { new (self) NodalAverage(std::move(measure), volume, std::move(average), std::move(displacement), linear); },
          nb::arg("measure"), nb::arg("volume"), nb::arg("average"), nb::arg("displacement"), nb::arg("linear"),
          "displacement: its name in the kernels of measure. linear: is the measure linear in it? Collective")
      .def("update", &NodalAverage::update, "At the present displacement. Collective");
  nb::class_<AveragedNeoHookean>(m, "AveragedNeoHookean", "Forces of averaged strains of neo-Hookean tetrahedra")
      .def(
          "__init__",
          [](AveragedNeoHookean* self, std::vector<std::size_t> integrals, std::shared_ptr<const Function> log_mean,
             std::shared_ptr<const NodalAverage> gradients, std::shared_ptr<const FunctionSpace> V,
             std::string displacement, double lambda, double nodes_mu, double cells_mu)
          {
            new (self) AveragedNeoHookean(std::move(integrals), std::move(log_mean), std::move(gradients), std::move(V),
                                          std::move(displacement), {lambda, nodes_mu, cells_mu});
          },
          nb::arg("integrals"), nb::arg("log_mean"), nb::arg("gradients"), nb::arg("space"), nb::arg("displacement"),
          nb::arg("lmbda"), nb::arg("nodes_mu"), nb::arg("cells_mu"),
          "integrals: numbers of those over the material's cells. gradients: as added to the operator. displacement: "
          "its name in the operator's kernels. Collective");
  bind_tangent(m);
  m.def(
      "largest_rotation",
      [](Values x, Indices x_nodes, Values x_derivatives, Values u, Indices u_nodes, Values u_derivatives,
         Indices cells, int gdim, double beyond)
      {
        const CellRotation found = largest_rotation(
            {{x.data(), x.size()}, 3, {x_nodes.data(), x_nodes.size()}, {x_derivatives.data(), x_derivatives.size()}},
            {{u.data(), u.size()},
             gdim,
             {u_nodes.data(), u_nodes.size()},
             {u_derivatives.data(), u_derivatives.size()}},
            {cells.data(), cells.size()}, gdim, beyond);
        return std::pair(found.angle, found.cell);
      },
      nb::arg("x"), nb::arg("x_nodes"), nb::arg("x_derivatives"), nb::arg("u"), nb::arg("u_nodes"),
      nb::arg("u_derivatives"), nb::arg("cells"), nb::arg("gdim"), nb::arg("beyond"),
      "Angle and cell of the largest rotation beyond an angle at the point of the derivatives [rad]; 0, -1: none");
  m.def(
      "nodal_averages",
      [](const FunctionSpace& V, Values points, Values weights, Values values)
      {
        return bindings::take(nodal_averages(V, {points.data(), points.size()}, {weights.data(), weights.size()},
                                             {values.data(), values.size()}));
      },
      nb::arg("V"), nb::arg("points"), nb::arg("weights"), nb::arg("values"), nb::rv_policy::move,
      "Averages at the nodes of values at quadrature points, at owned nodes. Collective");
  m.def(
      "resultant",
      [](const FunctionSpace& V, Values u, Values forces, Indices dofs, std::array<double, 3> point)
      {
        const Resultant r =
            resultant(V, {u.data(), u.size()}, {forces.data(), forces.size()}, {dofs.data(), dofs.size()}, point);
        return std::pair(r.force, r.moment);
      },
      nb::arg("V"), nb::arg("u"), nb::arg("forces"), nb::arg("dofs"), nb::arg("point"),
      "Force and moment of nodal forces, of all ranks. Collective");
  m.def(
      "cell_masses_hrz", [](const Integral& mass, const FunctionSpace& V, const Coefficients& coefficients)
      { return bindings::take(cell_masses_hrz(mass, V, coefficients)); }, nb::arg("mass"), nb::arg("V"),
      nb::arg("coefficients"), nb::rv_policy::move, "HRZ-lumped mass by cell and local degree of freedom");
  m.def(
      "cell_masses_nodal",
      [](const Integral& nodal, const Integral& row_sum, const FunctionSpace& V, const Coefficients& coefficients)
      { return bindings::take(cell_masses_nodal(nodal, row_sum, V, coefficients)); }, nb::arg("nodal"),
      nb::arg("row_sum"), nb::arg("V"), nb::arg("coefficients"), nb::rv_policy::move,
      "Lumped mass of a nodal rule by cell and local degree of freedom");
  nb::class_<CellBounds>(m, "CellBounds", "Bounds of the eigenvalues of cell matrices over the cells' masses")
      .def(
          "__init__",
          [](CellBounds* self, std::shared_ptr<const FunctionSpace> V,
             const std::vector<std::tuple<Integral, Coefficients, bool>>& parts)
          {
            std::vector<CellBounds::Part> all;
            for (const auto& [integral, coefficients, varies] : parts)
              all.push_back({integral, coefficients, varies});
            new (self) CellBounds(std::move(V), std::move(all));
          },
          nb::arg("V"), nb::arg("parts"), "parts: integral, functions by name, does it read any?")
      .def(
          "set_constants", [](CellBounds& self, std::size_t i, Values c)
          { self.set_constants(i, {c.data(), c.size()}); }, nb::arg("part"), nb::arg("constants"))
      .def_prop_ro("joins_cells", &CellBounds::joins_cells)
      .def(
          "spectra",
          [](CellBounds& self, Values masses, const std::optional<bindings::Mask>& only, bool facets)
          {
            std::optional<std::span<const std::int8_t>> chosen;
            if (only)
              chosen = bindings::view(*only);
            auto found = self.spectra({masses.data(), masses.size()}, chosen, facets);
            const std::size_t num = found.size() / 3;
            return bindings::take(std::move(found), {num, 3});
          },
          nb::arg("masses"), nb::arg("only").none(), nb::arg("facets"), nb::rv_policy::move,
          "Lower bound, upper bound and norm of the skew part by owned cell. Collective");
  m.def(
      "nodes_of_bodies", [](const dolfinx::fem::FunctionSpace<double>& V, Indices nodes)
      { return bindings::take(nodes_of_bodies(V, {nodes.data(), nodes.size()})); }, nb::arg("V"), nb::arg("nodes"),
      nb::rv_policy::move, "Nodes of the bodies that some nodes of any rank belong to, owned and ghosts. Collective");
}
