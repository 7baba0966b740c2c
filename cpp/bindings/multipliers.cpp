// SPDX-License-Identifier: MIT
#include "casters.h"
#include "dolfinx_impact/enforcement/mortar/Condensation.h"
#include "dolfinx_impact/enforcement/mortar/SaddlePoint.h"
#include "dolfinx_impact/gap/MortarIntegrals.h"
#include "masks.h"
#include "petsc_objects.h"

using namespace dolfinx_impact::enforcement;
using namespace dolfinx_impact::gap;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Globals;

template <typename T, typename A>
std::vector<T> vector(const A& values)
{
  return std::vector<T>(values.data(), values.data() + values.size());
}

void bind_integrals(nb::module_& m)
{
  nb::class_<MortarIntegrals>(m, "MortarIntegrals", "Mortar integrals of a pair")
      .def_prop_ro(
          "normal_sums", [](const MortarIntegrals& s) { return copy(s.normal_sums(), {s.normal_sums().size()}); },
          nb::rv_policy::move)
      .def_prop_ro("segments", &MortarIntegrals::segments, nb::rv_policy::reference_internal)
      .def_prop_ro("M", &MortarIntegrals::M, nb::rv_policy::reference);
  m.def(
      "coo_matrix",
      [](dolfinx_wrappers::MPICommWrapper comm, std::int64_t num_rows, std::int64_t num_columns, Globals rows,
         Globals columns, Array values)
      {
        if (rows.size() != columns.size() || rows.size() != values.size())
          throw std::invalid_argument("rows, columns and values differ in their number");
        dolfinx_impact::operators::CooMatrix::Entries entries{{rows.data(), rows.data() + rows.size()},
                                                              {columns.data(), columns.data() + columns.size()},
                                                              vector<double>(values)};
        dolfinx_impact::operators::CooMatrix out;
        out.assign(comm.get(), PetscInt(num_rows), PetscInt(num_columns), 1, std::move(entries));
        return typed<Mat>(nb::cast(out.matrix(), nb::rv_policy::reference));
      },
      nb::arg("comm"), nb::arg("num_rows"), nb::arg("num_columns"), nb::arg("rows"), nb::arg("columns"),
      nb::arg("values"), "Matrix from entries of any rows, global numbers; equal places add up. Collective");
}

void bind_constraints(nb::module_& m)
{
  nb::class_<Constraints>(m, "Constraints", "Constrained slave nodes of one contact; properties are copies")
      .def(
          "__init__",
          [](Constraints* self, Indices rows, Indices nodes, Array frames, Array over, Mask constrained, Array known,
             Array tilt, Indices normal, Globals pointers, Globals columns, Array values)
          {
            const std::size_t num = nodes.size(), gdim = known.ndim() == 2 ? known.shape(1) : 0;
            if (gdim < 2 || gdim > 3 || rows.size() != num || frames.size() != num * gdim * gdim ||
                over.size() != num * gdim * gdim || constrained.size() != num * gdim || known.size() != num * gdim ||
                tilt.size() != num * gdim || normal.size() != num || pointers.size() != num + 1 ||
                columns.size() != values.size())
              throw std::invalid_argument("constraints: arrays of different numbers of nodes");
            new (self) Constraints{int(gdim),
                                   vector<std::int32_t>(rows),
                                   vector<std::int32_t>(nodes),
                                   vector<double>(frames),
                                   vector<double>(over),
                                   {view(constrained).begin(), view(constrained).end()},
                                   vector<double>(known),
                                   vector<double>(tilt),
                                   vector<std::int32_t>(normal),
                                   vector<std::int64_t>(pointers),
                                   vector<std::int64_t>(columns),
                                   vector<double>(values)};
          },
          nb::arg("rows"), nb::arg("nodes"), nb::arg("frames"), nb::arg("over"), nb::arg("constrained"),
          nb::arg("known"), nb::arg("tilt"), nb::arg("normal"), nb::arg("pointers"), nb::arg("columns"),
          nb::arg("values"))
      .def_prop_ro(
          "rows", [](const Constraints& c) { return copy(c.rows, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "nodes", [](const Constraints& c) { return copy(c.nodes, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "frames", [](const Constraints& c)
          { return copy(c.frames, {c.size(), std::size_t(c.gdim), std::size_t(c.gdim)}); }, nb::rv_policy::move)
      .def_prop_ro(
          "over", [](const Constraints& c)
          { return copy(c.over, {c.size(), std::size_t(c.gdim), std::size_t(c.gdim)}); }, nb::rv_policy::move)
      .def_prop_ro(
          "constrained", [](const Constraints& c) { return mask(c.constrained, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "known", [](const Constraints& c) { return copy(c.known, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "tilt", [](const Constraints& c) { return copy(c.tilt, {c.size(), std::size_t(c.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "normal", [](const Constraints& c) { return copy(c.normal, {c.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "pointers", [](const Constraints& c) { return copy(c.pointers, {c.pointers.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "columns", [](const Constraints& c) { return copy(c.columns, {c.columns.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "values", [](const Constraints& c) { return copy(c.values, {c.values.size()}); }, nb::rv_policy::move);
  m.def(
      "frames_at",
      [](Array normals, Mask fixed)
      {
        const std::size_t num = normals.shape(0), gdim = normals.shape(1);
        NodalFrames f = frames_at(int(gdim), view(normals), view(fixed));
        return std::tuple(take(std::move(f.frames), {num, gdim, gdim}), take(std::move(f.place)),
                          take(std::move(f.length)));
      },
      nb::arg("normals"), nb::arg("fixed"),
      "Frames (n, gdim, gdim), place of the normal direction (n), length of the normal's free part (n)");
}

void bind_condensation(nb::module_& m)
{
  nb::class_<Condensation>(m, "Condensation", "Unknowns and equations of constrained nodes exchanged: T_L^T K T")
      .def(
          "__init__",
          [](Condensation* self, dolfinx_wrappers::MPICommWrapper comm, std::size_t num_owned, std::int64_t first,
             int gdim, std::vector<Constraints> parts)
          { new (self) Condensation(comm.get(), num_owned, first, gdim, std::move(parts)); },
          nb::arg("comm"), nb::arg("num_owned"), nb::arg("first"), nb::arg("gdim"), nb::arg("parts"))
      .def_prop_ro("right", &Condensation::right, nb::rv_policy::reference)
      .def_prop_ro("left", &Condensation::left, nb::rv_policy::reference)
      .def_prop_ro("symmetric", &Condensation::symmetric)
      .def_prop_ro(
          "known", [](Condensation& c)
          { return nb::ndarray<nb::numpy, double, nb::ndim<1>>(c.known.data(), {c.known.size()}, nb::find(c)); },
          nb::rv_policy::reference, "Known increments, a view")
      .def_prop_ro(
          "pinned", [](const Condensation& c) { return mask(c.pinned(), {c.pinned().size()}); }, nb::rv_policy::move)
      .def(
          "residual", [](const Condensation& c, Array values) { return take(c.residual(view(values))); },
          nb::arg("values"), "T_L^T times a nodal residual, zero at pinned unknowns. Collective")
      .def(
          "unknowns", [](const Condensation& c, Array increments) { return take(c.unknowns(view(increments))); },
          nb::arg("increments"), "Unknowns that stand for displacement increments")
      .def(
          "increment", [](const Condensation& c, Vec y) { return take(c.increment(y)); }, nb::arg("y"),
          "Displacement increments T y + known. Collective")
      .def("condense", &Condensation::condense, nb::arg("K"), nb::rv_policy::take_ownership, "T_L^T K T. Collective");
}

void bind_saddle_point(nb::module_& m)
{
  nb::class_<SaddlePoint>(m, "SaddlePoint", "Displacements and multipliers as unknowns; `stiffness`: list of matrices")
      .def(
          "__init__",
          [](SaddlePoint* self, dolfinx_wrappers::MPICommWrapper comm, std::size_t num_owned, int gdim,
             std::vector<std::size_t> sizes) { new (self) SaddlePoint(comm.get(), num_owned, gdim, std::move(sizes)); },
          nb::arg("comm"), nb::arg("num_owned"), nb::arg("gdim"), nb::arg("sizes"), "Collective")
      .def(
          "assign",
          [](SaddlePoint& s, const std::vector<Constraints>& parts, Mask pinned, Array forces, double diagonal)
          { s.assign(parts, view(pinned), view(forces), diagonal); }, nb::arg("parts"), nb::arg("pinned"),
          nb::arg("forces"), nb::arg("diagonal"), "A new linear problem. Collective")
      .def_prop_ro(
          "pinned", [](const SaddlePoint& s) { return mask(s.pinned(), {s.pinned().size()}); }, nb::rv_policy::move,
          "Mask of the pinned unknowns, a copy")
      .def_prop_ro("right", &SaddlePoint::right, nb::rv_policy::reference, "C, kept by this object")
      .def_prop_ro("left", &SaddlePoint::left, nb::rv_policy::reference, "C_L, kept by this object")
      .def(
          "mult", [](SaddlePoint& s, const Matrices& stiffness, Vec x, Vec y) { s.mult(matrices(stiffness), x, y); },
          nb::arg("stiffness"), nb::arg("x"), nb::arg("y"), "y = A x. Collective")
      .def(
          "load", [](SaddlePoint& s, const Matrices& stiffness, Array residual, Vec values, Vec b)
          { s.load(matrices(stiffness), view(residual), values, b); }, nb::arg("stiffness"), nb::arg("residual"),
          nb::arg("values"), nb::arg("b"), "Right-hand side. Collective")
      .def(
          "assemble", [](SaddlePoint& s, const Matrices& stiffness) { return s.assemble(matrices(stiffness)); },
          nb::arg("stiffness"), nb::rv_policy::take_ownership, "A as a matrix of its own. Collective")
      .def(
          "unknowns", [](const SaddlePoint& s, Array increments, Array forces)
          { return take(s.unknowns(view(increments), view(forces))); }, nb::arg("increments"), nb::arg("forces"),
          "Unknowns that stand for displacement increments and the multipliers' forces")
      .def(
          "forces", [](const SaddlePoint& s, Vec y) { return take(s.forces(y)); }, nb::arg("y"),
          "The multipliers' forces that unknowns stand for");
}
} // namespace

void dolfinx_impact::bindings::multipliers(nb::module_& m)
{
  bind_integrals(m);
  bind_constraints(m);
  bind_condensation(m);
  bind_saddle_point(m);
}
