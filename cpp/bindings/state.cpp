// SPDX-License-Identifier: MIT
#include "dolfinx_impact/state/State.h"
#include "arrays.h"
#include <sstream>

using namespace dolfinx_impact::state;

namespace
{
using namespace dolfinx_impact::bindings;

/// Arrays of a field as NumPy sees them: views of its memory.
Typed<AnyArray> as_array(const Field& field, nb::handle owner)
{
  const std::size_t shape[] = {field.rows(), field.columns};
  return std::visit(
      [&](auto span)
      {
        typedef typename decltype(span)::value_type T;
        return typed<AnyArray>(
            nb::cast(nb::ndarray<nb::numpy, T>(span.data(), field.columns == 1 ? 1 : 2, shape, owner)));
      },
      field.values);
}

void print(std::ostringstream& out, const State& state, std::size_t depth)
{
  const std::string indent(2 * depth, ' ');
  out << indent << (state.name().empty() ? "state" : state.name()) << "\n";
  for (const Field& field : state.fields())
  {
    out << indent << "  " << field.name << ": ";
    if (field.place != Place::all)
      out << field.rows() << " x ";
    out << field.columns << " by " << to_string(field.place) << "\n";
  }
  for (const State& part : state.parts())
    print(out, part, depth + 1);
}

template <typename T>
void add(State& self, std::string name, Place place, nb::ndarray<T, nb::c_contig, nb::device::cpu> values)
{
  const std::size_t columns = values.ndim() < 2 ? 1 : values.shape(1);
  self.add(std::move(name), place, View(std::span<T>(values.data(), values.size())), columns);
  self.keep(std::make_shared<decltype(values)>(values));
}
} // namespace

void dolfinx_impact::bindings::state(nb::module_& m)
{
  nb::enum_<Place>(m, "Place", "What the rows of an array belong to")
      .value("node", Place::node)
      .value("facet", Place::facet)
      .value("cell", Place::cell)
      .value("rank", Place::rank)
      .value("all", Place::all);
  nb::class_<State>(m, "State", "A tree of named arrays, which are views of the memory of what has the state")
      .def(nb::init<std::string>(), nb::arg("name") = "")
      .def_prop_ro("name", &State::name)
      .def_prop_ro("names",
                   [](const State& self)
                   {
                     std::vector<std::string> out;
                     for (const Field& field : self.fields())
                       out.push_back(field.name);
                     return out;
                   })
      .def_prop_ro("parts",
                   [](const State& self)
                   {
                     std::vector<std::string> out;
                     for (const State& part : self.parts())
                       out.push_back(part.name());
                     return out;
                   })
      .def(
          "numbers",
          [](const State& self, Place place)
          {
            const std::vector<std::int64_t>* found = self.numbers(place);
            return typed<std::optional<NumpyArray<std::int64_t>>>(found ? nb::cast(copy(*found, {found->size()}))
                                                                        : nb::none());
          },
          nb::arg("place"), "Nodes or facets that rows at a place belong to; None: all")
      .def(
          "columns", [](const State& self, const std::string& name) { return self.field(name).columns; },
          nb::arg("name"))
      .def(
          "at",
          [](State& self, Place place,
             nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> numbers)
          { self.at(place, {numbers.data(), numbers.data() + numbers.size()}); },
          nb::arg("place"), nb::arg("numbers"), "Say which nodes or facets the rows at a place belong to")
      .def(
          "rename", [](State& self, std::string name) { self.rename(std::move(name)); }, nb::arg("name"))
      .def(
          "place", [](const State& self, const std::string& name) { return self.field(name).place; }, nb::arg("name"))
      .def(
          "array", [](nb::handle self, const std::string& name)
          { return as_array(nb::cast<const State&>(self).field(name), self); }, nb::arg("name"),
          "Values of a field, (rows) or (rows, columns); a view")
      .def(
          "part", [](const State& self, const std::string& name) -> const State& { return self.part(name); },
          nb::arg("name"), nb::rv_policy::reference_internal)
      .def("add", &add<double>, nb::arg("name"), nb::arg("place"), nb::arg("values").noconvert(), "A view of an array")
      .def("add", &add<std::int8_t>, nb::arg("name"), nb::arg("place"), nb::arg("values").noconvert())
      .def("add", &add<std::int32_t>, nb::arg("name"), nb::arg("place"), nb::arg("values").noconvert())
      .def("add", &add<std::int64_t>, nb::arg("name"), nb::arg("place"), nb::arg("values").noconvert())
      .def(
          "add", [](State& self, const State& part) { self.add(State(part)); }, nb::arg("part"))
      .def("copy", &State::copy, "The same tree with values of its own")
      .def("assign", &State::assign, nb::arg("other"),
           "Set the values to those of a tree with the same fields and parts")
      .def("difference_of_values", &State::difference_of_values, nb::arg("other"))
      .def("__repr__",
           [](const State& self)
           {
             std::ostringstream out;
             print(out, self, 0);
             return out.str();
           });
}
