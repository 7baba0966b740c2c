// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/files/Block.h"
#include "dolfinx_impact/files/Damaged.h"
#include "dolfinx_impact/files/Seal.h"
#include "dolfinx_impact/files/checkpoint.h"
#include "dolfinx_impact/files/nodes.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <nanobind/stl/unique_ptr.h>
#include <system_error>

using namespace dolfinx_impact::files;

namespace
{
using namespace dolfinx_impact::bindings;
using dolfinx_impact::state::State;
typedef dolfinx::fem::FunctionSpace<double> Space;
typedef nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> InputNumbers;

/// Values of attributes by their names.
typedef nb::typed<nb::dict, std::string, nb::any> Named;

/// A text, int, float or array of floats.
Value as_value(nb::handle value)
{
  if (PyUnicode_Check(value.ptr()))
    return nb::cast<std::string>(value);
  if (PyLong_Check(value.ptr()))
    return nb::cast<std::int64_t>(value);
  if (PyFloat_Check(value.ptr()))
    return nb::cast<double>(value);
  const auto array = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(value);
  Numbers out;
  for (std::size_t i = 0; i < array.ndim(); ++i)
    out.shape.push_back(array.shape(i));
  out.values.assign(array.data(), array.data() + array.size());
  return out;
}

nb::object as_object(const Value& value)
{
  if (const auto* text = std::get_if<std::string>(&value))
    return nb::cast(*text);
  if (const auto* number = std::get_if<std::int64_t>(&value))
    return nb::cast(*number);
  if (const auto* number = std::get_if<double>(&value))
    return nb::cast(*number);
  if (const auto* numbers = std::get_if<Numbers>(&value))
    return nb::cast(copy(numbers->values, numbers->shape));
  return nb::none();
}

Attributes as_attributes(const Named& values)
{
  Attributes out;
  for (const auto& [name, value] : values)
    out.push_back({nb::cast<std::string>(name), as_value(value)});
  return out;
}

/// Identity of a problem.
/// @param[in] advice by name of an attribute
Identity as_identity(const Named& values, const std::map<std::string, std::string>& advice, const State& supports)
{
  Identity out{as_attributes(values), supports};
  for (Attribute& a : out.attributes)
    if (const auto found = advice.find(a.name); found != advice.end())
      a.advice = found->second;
  return out;
}

nb::bytes to_bytes(std::span<const std::byte> data)
{
  return nb::bytes(data.data(), data.size());
}

/// A block, which views a state, and the state.
struct OwnedBlock
{
  nb::object owner;
  Block block;
};

Typed<NumpyArray<double>> values(const OwnedBlock& self)
{
  std::vector<double> all = self.block.values();
  const std::size_t columns = self.block.width();
  if (self.block.flat())
    return typed<NumpyArray<double>>(nb::cast(take(std::move(all))));
  const std::size_t rows = columns == 0 ? 0 : all.size() / columns;
  return typed<NumpyArray<double>>(nb::cast(take(std::move(all), {rows, columns})));
}
} // namespace

void dolfinx_impact::bindings::files(nb::module_& m)
{
  nb::exception<Damaged>(m, "Damaged", PyExc_RuntimeError);
  nb::register_exception_translator(
      [](const std::exception_ptr& thrown, void*)
      {
        try
        {
          std::rethrow_exception(thrown);
        }
        catch (const std::system_error& error)
        {
          const nb::object arguments = nb::make_tuple(error.code().value(), error.what());
          PyErr_SetObject(PyExc_OSError, arguments.ptr());
        }
      });
  m.attr("FORMAT") = format;
  nb::class_<OwnedBlock>(m, "Block", "Fields of a state that are one table, or one attribute, of a file")
      .def_prop_ro("name", [](const OwnedBlock& self) { return self.block.name(); })
      .def_prop_ro("place", [](const OwnedBlock& self) { return self.block.place(); })
      .def_prop_ro(
          "numbers",
          [](const OwnedBlock& self)
          {
            const std::vector<std::int64_t>* found = self.block.numbers();
            return typed<std::optional<NumpyArray<std::int64_t>>>(found ? nb::cast(copy(*found, {found->size()}))
                                                                        : nb::none());
          },
          "Nodes or facets of the rows; None: all")
      .def_prop_ro(
          "width", [](const OwnedBlock& self) { return self.block.width(); }, "Number of columns, length of a vector")
      .def("values", &values, "The fields side by side, (rows, width), or one after the other")
      .def(
          "assign", [](const OwnedBlock& self, nb::ndarray<const double, nb::c_contig, nb::device::cpu> values)
          { self.block.assign({values.data(), values.size()}); }, nb::arg("values"), "Set the fields");
  m.def(
      "blocks",
      [](nb::handle_t<State> state)
      {
        nb::typed<nb::list, OwnedBlock> out;
        for (Block& block : blocks(nb::cast<const State&>(state)))
          out.append(nb::cast(OwnedBlock{nb::borrow<nb::object>(state), std::move(block)}));
        return out;
      },
      nb::arg("state"), "Tables and attributes of a state in a file");
  m.def(
      "places",
      [](const Space& V)
      {
        const std::size_t gdim = V.mesh()->geometry().dim();
        std::vector<double> x = places(V);
        const std::size_t rows = x.size() / gdim;
        return take(std::move(x), {rows, gdim});
      },
      nb::arg("V"), "Undeformed coordinates of this rank's owned nodes, (num_nodes, gdim)");
  m.def(
      "input_cells", [](const dolfinx::mesh::Mesh<double>& mesh) { return take(input_cells(mesh)); }, nb::arg("mesh"),
      nb::rv_policy::move, "Numbers of this rank's owned cells in the mesh's input; raises for submeshes");
  m.def(
      "set_input_numbers", [](dolfinx::mesh::Mesh<double>& mesh, const InputNumbers& cells, const InputNumbers& nodes)
      { set_input_numbers(mesh, {cells.data(), cells.size()}, {nodes.data(), nodes.size()}); }, nb::arg("mesh"),
      nb::arg("cells"), nb::arg("nodes"),
      "Give cells and geometry nodes of a mesh, ghosts included, other numbers in its input");
  m.def(
      "write",
      [](const std::string& path, const Space& V, const State& state, const Named& identity, const State& supports,
         const Named& more) { write(path, V, state, as_identity(identity, {}, supports), as_attributes(more)); },
      nb::arg("path"), nb::arg("V"), nb::arg("state"), nb::arg("identity"), nb::arg("supports"), nb::arg("more"),
      "Write a state. Collective.");
  m.def(
      "read",
      [](const std::string& path, const Space& V, const State& like, const Named& identity, const State& supports,
         const std::map<std::string, std::string>& advice, const std::vector<std::string>& more,
         const std::vector<std::string>& equal, const std::vector<std::string>& infinite)
      {
        const Saved saved = read(path, V, like, as_identity(identity, advice, supports), {more, equal, infinite});
        Named attributes;
        for (const Attribute& a : saved.attributes)
          attributes[a.name.c_str()] = as_object(a.value);
        return std::pair(saved.state, attributes);
      },
      nb::arg("path"), nb::arg("V"), nb::arg("like"), nb::arg("identity"), nb::arg("supports"), nb::arg("advice"),
      nb::arg("more"), nb::arg("equal"), nb::arg("infinite"), "State and all attributes of a file. Collective.");
  nb::class_<SealedFile>(m, "SealedFile", "A file under checksums, whose structure has been verified")
      .def(nb::new_([](const std::string& path) { return std::make_unique<SealedFile>(path); }), nb::arg("path"))
      .def_prop_ro(
          "mark", [](const SealedFile& self) { return to_bytes(std::as_bytes(std::span(self.mark()))); },
          "Checksum of all checksums, 16 bytes")
      .def_prop_ro("size", &SealedFile::size, "Bytes before the seal")
      .def_prop_ro(
          "sections",
          [](const SealedFile& self)
          {
            std::vector<std::tuple<std::int64_t, std::int64_t, bool>> out;
            for (const Section& s : self.sections())
              out.emplace_back(s.offset, s.length, s.data);
            return out;
          },
          "Offset, length and whether it is data, of every section");
  m.def(
      "seal",
      [](const nb::bytes& content)
      {
        const auto* data = static_cast<const std::byte*>(content.data());
        const auto structure = [data](std::int64_t begin, std::int64_t end)
        { return std::vector<std::byte>(data + begin, data + end); };
        return to_bytes(seal({}, structure, std::int64_t(content.size())));
      },
      nb::arg("content"), "Seal of a file with this content, to be written behind it");
}
