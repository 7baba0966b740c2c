// SPDX-License-Identifier: MIT
#include "dolfinx_impact/kernels/KernelTable.h"
#include "dolfinx_impact/kernels/check.h"
#include "dolfinx_impact/kernels/timing.h"
#include "module.h"
#include <stdexcept>

namespace nb = nanobind;
using namespace dolfinx_impact::kernels;

namespace
{
/// Handle of a kernel on the Python side, and where it stands in a form; descriptors live as long as the process.
struct Kernel
{
  const impact_kernel* k;
  std::vector<int> subdomains;   ///< tags that it belongs to; -1: everywhere
  std::vector<int> coefficients; ///< number of each of its coefficients in the form's list
  std::vector<int> constants;    ///< number of each of its constants in the form's list
};

/// A kernel in the form that it was compiled of.
Kernel wrap(const impact_kernel* k)
{
  Kernel out{k, {k->subdomains, k->subdomains + k->num_subdomains}, {}, {}};
  for (int i = 0; i < k->num_coefficients; ++i)
    out.coefficients.push_back(k->coefficients[i].position);
  for (int i = 0; i < k->num_constants; ++i)
    out.constants.push_back(i);
  return out;
}

std::vector<Kernel> wrap(const std::vector<const impact_kernel*>& list)
{
  std::vector<Kernel> out;
  for (auto* k : list)
    out.push_back(wrap(k));
  return out;
}

/// A kernel as a part of another form.
Kernel placed(const Kernel& kernel, std::vector<int> subdomains, std::vector<int> coefficients,
              std::vector<int> constants)
{
  if (coefficients.size() != kernel.coefficients.size() || constants.size() != kernel.constants.size())
    throw std::invalid_argument(std::string("kernel ") + kernel.k->name + " has " +
                                std::to_string(kernel.coefficients.size()) + " coefficients and " +
                                std::to_string(kernel.constants.size()) + " constants: give each its number");
  return {kernel.k, std::move(subdomains), std::move(coefficients), std::move(constants)};
}

/// What is known of an element, a coefficient, an output, by name.
typedef nb::typed<nb::dict, std::string, nb::any> Description;
typedef nb::typed<nb::list, Description> Descriptions;

Description element(const impact_element& e)
{
  Description d;
  d["description"] = e.description;
  d["kind"] = e.kind;
  d["degree"] = e.degree;
  d["block_size"] = e.block_size;
  d["num_dofs"] = e.num_dofs;
  return d;
}

typedef nb::ndarray<const double, nb::c_contig, nb::device::cpu> In;
typedef nb::ndarray<double, nb::c_contig, nb::device::cpu> InOut;
} // namespace

void dolfinx_impact::bindings::kernels(nb::module_& m)
{
  nb::class_<Kernel>(m, "Kernel", "A compiled integral")
      .def_prop_ro("name", [](const Kernel& s) { return s.k->name; })
      .def_prop_ro("signature", [](const Kernel& s) { return s.k->signature; })
      .def_prop_ro("integral_type", [](const Kernel& s) { return s.k->integral_type; })
      .def_prop_ro("cell", [](const Kernel& s) { return s.k->cell; })
      .def_prop_ro("hypothesis", [](const Kernel& s) { return s.k->hypothesis; })
      .def_prop_ro("geometry_degree", [](const Kernel& s) { return s.k->geometry_degree; })
      .def_prop_ro("gdim", [](const Kernel& s) { return s.k->gdim; })
      .def_prop_ro("rank", [](const Kernel& s) { return s.k->rank; })
      .def_prop_ro("shape", [](const Kernel& s) { return std::pair(s.k->shape[0], s.k->shape[1]); })
      .def_prop_ro("size_A", [](const Kernel& s) { return s.k->size_A; })
      .def_prop_ro("num_points", [](const Kernel& s) { return s.k->num_points; })
      .def_prop_ro("sums",
                   [](const Kernel& s)
                   {
                     std::map<std::string, int> d;
                     for (int i = 0; i < s.k->num_sums; ++i)
                       d[s.k->sums[i].name] = s.k->sums[i].offset;
                     return d;
                   })
      .def_prop_ro("outputs",
                   [](const Kernel& s)
                   {
                     Descriptions out;
                     for (int i = 0; i < s.k->num_outputs; ++i)
                     {
                       Description d;
                       d["name"] = s.k->outputs[i].name;
                       d["num_components"] = s.k->outputs[i].num_components;
                       d["offset"] = s.k->outputs[i].offset;
                       d["coefficient"] = s.k->outputs[i].coefficient;
                       out.append(d);
                     }
                     return out;
                   })
      .def_prop_ro("flops", [](const Kernel& s) { return s.k->flops; })
      .def_ro("subdomains", &Kernel::subdomains)
      .def_prop_ro("arguments",
                   [](const Kernel& s)
                   {
                     Descriptions out;
                     for (int i = 0; s.k->arguments && i < s.k->rank; ++i)
                       out.append(element(s.k->arguments[i]));
                     return out;
                   })
      .def_prop_ro("coefficients",
                   [](const Kernel& s)
                   {
                     Descriptions out;
                     for (int i = 0; i < s.k->num_coefficients; ++i)
                     {
                       Description d = element(s.k->coefficients[i].element);
                       d["name"] = s.k->coefficients[i].name;
                       d["offset"] = s.k->coefficients[i].offset;
                       d["position"] = s.coefficients[i];
                       out.append(d);
                     }
                     return out;
                   })
      .def_prop_ro("constants",
                   [](const Kernel& s)
                   {
                     Descriptions out;
                     for (int i = 0; i < s.k->num_constants; ++i)
                     {
                       Description d;
                       d["name"] = s.k->constants[i].name;
                       d["size"] = s.k->constants[i].size;
                       d["offset"] = s.k->constants[i].offset;
                       d["position"] = s.constants[i];
                       out.append(d);
                     }
                     return out;
                   })
      .def("placed", &placed, nb::arg("subdomains"), nb::arg("coefficients"), nb::arg("constants"),
           "The kernel as a part of a form: the tags that it belongs to there, and the number of each of its "
           "coefficients and constants in the form's lists")
      .def_prop_ro("widths",
                   [](const Kernel& s)
                   {
                     std::vector<int> out;
                     for (int w : {1, 4, 8})
                       if (width(*s.k, w) == w)
                         out.push_back(w);
                     return out;
                   })
      .def(
          "tabulate",
          [](const Kernel& s, InOut A, In w, In c, In x, int entity, int lanes)
          {
            const std::size_t n = std::size_t(s.k->size_A) * lanes;
            if (width(*s.k, lanes) != lanes)
              throw std::invalid_argument("this machine runs no kernel of " + std::to_string(lanes) + " lanes");
            if (A.size() != n || w.size() != std::size_t(s.k->size_w) * lanes || c.size() != std::size_t(s.k->size_c) ||
                x.size() % (3 * lanes) != 0)
              throw std::invalid_argument("arrays do not have the sizes of the kernel (kernels/Kernel.h)");
            if (lanes > 1)
              for (auto [p, size] : {std::pair{static_cast<const double*>(A.data()), A.size()},
                                     std::pair{w.data(), w.size()}, std::pair{x.data(), x.size()}})
                if (size > 0 && reinterpret_cast<std::uintptr_t>(p) % (8 * lanes))
                  throw std::invalid_argument("arrays of several lanes must be aligned to their vectors");
            tabulate(*s.k, lanes)(A.data(), w.data(), c.data(), x.data(), entity);
          },
          nb::arg("A").noconvert(), nb::arg("w"), nb::arg("c"), nb::arg("x"), nb::arg("entity") = 0,
          nb::arg("lanes") = 1, "Element tensor of `lanes` cells, added to A; layout in kernels/Kernel.h")
      .def(
          "tabulate_cells",
          [](const Kernel& s, InOut A, In w, In c, In x, std::size_t num_cells)
          {
            const std::size_t n = s.k->size_A, m = s.k->size_w;
            if (A.size() != n * num_cells || w.size() != m * num_cells || c.size() != std::size_t(s.k->size_c) ||
                (num_cells > 0 && x.size() % (3 * num_cells) != 0))
              throw std::invalid_argument("arrays do not have the sizes of the kernel times the number of cells");
            const std::size_t size_x = num_cells > 0 ? x.size() / num_cells : 0;
            for (std::size_t i = 0; i < num_cells; ++i)
              tabulate(*s.k, 1)(A.data() + n * i, w.data() + m * i, c.data(), x.data() + size_x * i, 0);
          },
          nb::arg("A").noconvert(), nb::arg("w"), nb::arg("c"), nb::arg("x"), nb::arg("num_cells"),
          "Element tensors of many cells, one after another in each array, added to A; layout of a cell in "
          "kernels/Kernel.h")
      .def(
          "seconds_per_cell",
          [](const Kernel& s, const std::vector<int>& widths) { return seconds_per_cell(*s.k, widths); },
          nb::arg("widths"), "Time per cell of each of some widths, arrays in the cache (kernels/timing.h) [s]")
      .def_prop_ro(
          "width", [](const Kernel& s) { return width(*s.k); }, "Cells per call that operators take by default")
      .def_prop_ro(
          "num_nodes", [](const Kernel& s) { return reference_nodes(*s.k).size() / 3; },
          "Nodes of the cell, of both cells at a facet between two")
      .def(
          "check_mesh", [](const Kernel& s, const dolfinx::mesh::Mesh<double>& mesh) { check_mesh(*s.k, mesh); },
          nb::arg("mesh"), "Raise RuntimeError unless the kernel was compiled for this kind of mesh")
      .def_prop_ro("address", [](const Kernel& s) { return reinterpret_cast<std::uintptr_t>(s.k); });
  m.def("table", [] { return wrap({table().begin(), table().end()}); }, "Kernels built with the package");
  m.def(
      "find",
      [](const std::string& name, const std::string& cell, int degree, int geometry_degree,
         const std::string& hypothesis) { return wrap(find({name, cell, degree, geometry_degree, hypothesis})); },
      nb::arg("name"), nb::arg("cell"), nb::arg("degree"), nb::arg("geometry_degree") = 1, nb::arg("hypothesis") = "");
  m.def("find_signature", [](const std::string& s) { return wrap(find_signature(s)); }, nb::arg("signature"));
  m.def(
      "load", [](const std::string& path, const std::vector<std::string>& symbols)
      { return wrap(load(path, symbols)); }, nb::arg("path"), nb::arg("symbols"));
  m.def(
      "load", [](const nb::bytes& path, const std::vector<std::string>& symbols)
      { return wrap(load({path.c_str(), path.size()}, symbols)); }, nb::arg("path"), nb::arg("symbols"),
      "Kernels of a shared library; path: bytes as the file system has them, which need be no text");
  m.attr("ABI") = int(IMPACT_KERNEL_ABI);
  m.def("processor_width", &processor_width, "Widest vector of doubles of this processor that is used: 1, 4 or 8");
}
