#include "bindings.h"
#include "explicit.h"

namespace nb = nanobind;

namespace impact::reference
{
void bind_explicit(nb::module_& m)
{
  using P = const Matrix&;
  using V = const Vector&;
  using Dofs = const std::vector<std::int64_t>&;

  nb::class_<ExplicitContact>(m, "ExplicitContact");
  nb::class_<ContactHistories>(m, "ContactHistories")
      .def_ro("total", &ContactHistories::total)
      .def_ro("force", &ContactHistories::force)
      .def_ro("gap", &ContactHistories::gap)
      .def_ro("traction", &ContactHistories::traction)
      .def_ro("slip", &ContactHistories::slip)
      .def_ro("status", &ContactHistories::status);
  nb::class_<ExplicitHistory>(m, "ExplicitHistory")
      .def_ro("time", &ExplicitHistory::time)
      .def_ro("u", &ExplicitHistory::u)
      .def_ro("v", &ExplicitHistory::v)
      .def_ro("a", &ExplicitHistory::a)
      .def_ro("half", &ExplicitHistory::half)
      .def_ro("support", &ExplicitHistory::support)
      .def_ro("energies", &ExplicitHistory::energies)
      .def_ro("contacts", &ExplicitHistory::contacts);

  m.def("run_explicit",
        [](const Model& model, P points, V weights, P mass_points, V mass_weights, const std::string& lumping, V steps,
           V u0, V v0, Dofs fixed, P values, P loads, P amplitudes, double alpha, double beta, bool classical,
           double b1, double b2, int every, const std::vector<ExplicitContact*>& contacts)
        {
          return run_explicit(model, {{points, weights},
                                      {mass_points, mass_weights},
                                      lumping,
                                      steps,
                                      u0,
                                      v0,
                                      fixed,
                                      values,
                                      loads,
                                      amplitudes,
                                      alpha,
                                      beta,
                                      classical,
                                      b1,
                                      b2,
                                      every,
                                      contacts});
        });
  m.def("viscous_force", [](const Model& s, P points, V weights, V u, V v, double b1, double b2)
        { return s.viscous_force({points, weights}, u, v, b1, b2); });
  m.def("cell_frequency",
        [](const Model& s, P points, V weights, P mass_points, V mass_weights, const std::string& lumping)
        { return s.cell_frequency({points, weights}, {mass_points, mass_weights}, lumping); });
  m.def("passage", &Model::passage);
  m.def("highest_frequency", [](const Integers& indptr, const Integers& indices, V data, V mass, Dofs fixed)
        { return highest_frequency(csr(indptr, indices, data), mass, fixed); });
}
} // namespace impact::reference
