// SPDX-License-Identifier: MIT
#include "PlasticBody.h"
#include "bindings.h"

namespace nb = nanobind;

namespace impact_reference
{
namespace
{
using P = const Matrix&;
using V = const Vector&;

// Histories as arrays; tensors are rows of 9 values.
using Histories = std::tuple<Matrix, Vector, Matrix, Matrix, Vector, Vector>;

Tensor tensor(P rows, Eigen::Index row)
{
  Tensor a;
  for (int i = 0; i < 9; ++i)
    a(i / 3, i % 3) = rows(row, i);
  return a;
}

void set(Matrix& rows, Eigen::Index row, const Tensor& a)
{
  for (int i = 0; i < 9; ++i)
    rows(row, i) = a(i / 3, i % 3);
}

Histories arrays_of(const std::vector<J2History>& history)
{
  const auto n = Eigen::Index(history.size());
  Histories out{Matrix(n, 9), Vector(n), Matrix(n, 9), Matrix(n, 9), Vector(n), Vector(n)};
  auto& [plastic, equivalent, back_stress, stress, work, thickness] = out;
  for (Eigen::Index p = 0; p < n; ++p)
  {
    set(plastic, p, history[p].plastic);
    equivalent(p) = history[p].equivalent;
    set(back_stress, p, history[p].back_stress);
    set(stress, p, history[p].stress);
    work(p) = history[p].work;
    thickness(p) = history[p].thickness;
  }
  return out;
}

std::vector<J2History> histories(const Histories& from)
{
  const auto& [plastic, equivalent, back_stress, stress, work, thickness] = from;
  const Eigen::Index n = equivalent.size();
  for (const Matrix* rows : {&plastic, &back_stress, &stress})
    if (rows->rows() != n or rows->cols() != 9 or not rows->allFinite())
      throw std::invalid_argument("a history needs finite tensors, one for each of its " + std::to_string(n) +
                                  " points");
  if (work.size() != n or not equivalent.allFinite() or not work.allFinite() or
      (n > 0 and not(equivalent.minCoeff() >= 0)))
    throw std::invalid_argument("a history needs an equivalent plastic strain that is not negative and a work, one for "
                                "each of its " +
                                std::to_string(n) + " points");
  if (thickness.size() != n or not thickness.allFinite() or (n > 0 and not(thickness.minCoeff() > 0)))
    throw std::invalid_argument("a history needs stretches across the plane that are positive, one for each of its " +
                                std::to_string(n) + " points");
  std::vector<J2History> out;
  out.reserve(n);
  for (Eigen::Index p = 0; p < n; ++p)
    out.push_back(
        {tensor(plastic, p), equivalent(p), tensor(back_stress, p), tensor(stress, p), work(p), thickness(p)});
  return out;
}
} // namespace

void bind_plasticity(nb::module_& m)
{
  nb::class_<J2Parameters>(m, "J2Parameters")
      .def("__init__",
           [](J2Parameters* self, double E, double nu, double yield_stress, double hardening, double saturation_stress,
              double saturation_rate, const std::vector<double>& table_strain, const std::vector<double>& table_stress,
              double kinematic, double recall)
           {
             const J2Parameters p{E,
                                  nu,
                                  yield_stress,
                                  hardening,
                                  saturation_stress,
                                  saturation_rate,
                                  table_strain,
                                  table_stress,
                                  kinematic,
                                  recall};
             check(p);
             new (self) J2Parameters(p);
           })
      .def("yield_stress",
           [](const J2Parameters& p, V a)
           {
             const J2 law(p);
             return Vector(a.unaryExpr([&](double x) { return law.yield_stress(x); }));
           });

  m.def("j2_virgin", [](int n, const std::string& strain)
        { return arrays_of(std::vector<J2History>(n, J2::virgin(plastic_strain(strain)))); });

  // Stress, tangent (rows of 81), new history, elastic energy, dissipation of points.
  m.def("j2_points",
        [](const J2Parameters& parameters, const std::string& strain, const std::string& hypothesis_name, P gradients,
           const Histories& given, bool with_tangent)
        {
          const J2 law(parameters);
          const std::vector<J2History> history = histories(given);
          const Eigen::Index n = gradients.rows();
          if (gradients.cols() != 9 or n != Eigen::Index(history.size()) or not gradients.allFinite())
            throw std::invalid_argument("there are " + std::to_string(history.size()) +
                                        " points, which need as many finite strains, 3 x 3");
          Matrix stress(n, 9), tangent(with_tangent ? n : 0, 81);
          Vector energy(n), dissipation(n);
          std::vector<J2History> next;
          for (Eigen::Index p = 0; p < n; ++p)
          {
            const J2Answer a = law.answer(plastic_strain(strain), hypothesis(hypothesis_name), tensor(gradients, p),
                                          history[p], with_tangent);
            set(stress, p, a.stress);
            for (int i = 0; with_tangent and i < 81; ++i)
              tangent(p, i) = a.tangent(i / 9, i % 9);
            energy(p) = a.energy;
            dissipation(p) = a.dissipation;
            next.push_back(a.history);
          }
          return std::make_tuple(stress, tangent, arrays_of(next), energy, dissipation);
        });

  // Force, tangent, new history, stress, elastic energy, plastic work, dissipation of one cell.
  m.def("element_plastic",
        [](const std::string& cell, int degree, int geometry_degree, P points, V weights, P X,
           const J2Parameters& parameters, const std::string& strain, const std::string& hypothesis_name,
           const std::string& theta, V u, const Histories& given, bool with_tangent)
        {
          const Hypothesis h = hypothesis(hypothesis_name);
          const Sampler sampler(cell_type(cell), degree, geometry_degree, {points, weights},
                                h == Hypothesis::axisymmetric);
          const std::vector<J2History> history = histories(given);
          const PlasticInternal r = plastic_internal(
              sampler, X, J2(parameters), {h, plastic_strain(strain), dilatation(theta)}, u, history, with_tangent);
          Matrix stress(Eigen::Index(r.answers.size()), 9);
          for (std::size_t p = 0; p < r.answers.size(); ++p)
            set(stress, Eigen::Index(p), r.answers[p].stress);
          return std::make_tuple(r.force, r.tangent, arrays_of(r.history), stress, r.energy, r.work, r.dissipation);
        });

  nb::class_<PlasticBody::Trial>(m, "PlasticTrial")
      .def_ro("force", &PlasticBody::Trial::force)
      .def_prop_ro(
          "tangent", [](const PlasticBody::Trial& t) { return arrays(t.tangent); }, nb::rv_policy::move)
      .def_ro("energy", &PlasticBody::Trial::energy)
      .def_ro("work", &PlasticBody::Trial::work)
      .def_ro("dissipation", &PlasticBody::Trial::dissipation)
      .def_ro("stress", &PlasticBody::Trial::stress)
      .def_prop_ro("history", [](const PlasticBody::Trial& t) { return arrays_of(t.history); }, nb::rv_policy::move);
  nb::class_<PlasticBody>(m, "PlasticBody")
      .def(
          "__init__",
          [](PlasticBody* self, const Model& model, P points, V weights, const std::map<int, J2Parameters>& laws,
             const std::string& strain, const std::string& theta)
          { new (self) PlasticBody(model, {points, weights}, laws, plastic_strain(strain), dilatation(theta)); },
          nb::keep_alive<1, 2>())
      .def("average_pressure", &PlasticBody::average_pressure)
      .def("evaluate", &PlasticBody::evaluate)
      .def("commit", &PlasticBody::commit)
      .def_prop_ro(
          "history", [](const PlasticBody& b) { return arrays_of(b.history()); }, nb::rv_policy::move)
      .def("set_history", [](PlasticBody& b, const Histories& h) { b.set_history(histories(h)); })
      .def("solve",
           [](PlasticBody& b, const std::vector<std::int64_t>& fixed, V u0, V load0, P values, P loads,
              double tolerance, int max_iterations)
           {
             const PlasticStates r = solve_plastic(b, fixed, u0, load0, values, loads, tolerance, max_iterations);
             return std::make_tuple(r.u, r.force, r.energy, r.work, r.iterations, r.residuals);
           });
}
} // namespace impact_reference
