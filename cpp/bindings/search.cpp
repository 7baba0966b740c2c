// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/search/BoxTree.h"
#include "dolfinx_impact/search/Exchange.h"
#include "dolfinx_impact/search/boxes.h"
#include "dolfinx_impact/search/closest_point/PairSearch.h"
#include "dolfinx_impact/search/closest_point/SurfaceSearch.h"

using namespace dolfinx_impact::search;
using dolfinx_impact::surface::Facets;

namespace
{
using dolfinx_impact::bindings::Indices;
using dolfinx_impact::bindings::Values;

/// Arrays by point, by their names.
typedef nanobind::typed<nanobind::dict, std::string, dolfinx_impact::bindings::AnyArray> Projections;

typedef nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu> Points;

/// Named arrays from structs.
Projections projections(const std::vector<Projection>& found, std::size_t gdim)
{
  std::vector<std::int8_t> status, entity;
  std::vector<std::int32_t> facet;
  std::vector<double> xi, gap, normal;
  for (const Projection& p : found)
  {
    status.push_back(std::int8_t(p.status));
    entity.push_back(p.entity);
    facet.push_back(p.facet);
    xi.insert(xi.end(), p.xi, p.xi + 2);
    gap.push_back(p.gap);
    normal.insert(normal.end(), p.normal, p.normal + gdim);
  }
  Projections out;
  out["status"] = dolfinx_impact::bindings::take(std::move(status));
  out["entity"] = dolfinx_impact::bindings::take(std::move(entity));
  out["facet"] = dolfinx_impact::bindings::take(std::move(facet));
  out["xi"] = dolfinx_impact::bindings::take(std::move(xi), {found.size(), 2});
  out["gap"] = dolfinx_impact::bindings::take(std::move(gap));
  out["normal"] = dolfinx_impact::bindings::take(std::move(normal), {found.size(), gdim});
  return out;
}

/// Facets that live as long as the exchange they are part of.
std::shared_ptr<Facets> facets(const std::shared_ptr<const Exchange>& exchange, const Facets& part)
{
  return {std::const_pointer_cast<Exchange>(exchange), const_cast<Facets*>(&part)};
}

} // namespace

void dolfinx_impact::bindings::search(nb::module_& m)
{
  nb::class_<BoxTree>(m, "BoxTree", "Bounding-volume hierarchy; a box is gdim lower, then gdim upper bounds")
      .def(
          "__init__", [](BoxTree* self, int gdim, Values boxes) { new (self) BoxTree(gdim, view(boxes)); },
          nb::arg("gdim"), nb::arg("boxes"))
      .def(
          "refit", [](BoxTree& tree, Values boxes) { tree.refit(view(boxes)); }, nb::arg("boxes"))
      .def_prop_ro("size", &BoxTree::size)
      .def(
          "overlapping",
          [](const BoxTree& tree, Values box)
          {
            if (box.size() != std::size_t(2 * tree.gdim()))
              throw std::invalid_argument("a box is given by 2*gdim numbers");
            std::vector<std::int32_t> found;
            tree.overlapping(box.data(), found);
            return take(std::move(found));
          },
          nb::arg("box"), "Ascending numbers of the boxes that overlap `box`")
      .def(
          "nearest",
          [](const BoxTree& tree, Values x)
          {
            if (x.size() != std::size_t(tree.gdim()))
              throw std::invalid_argument("a point is given by gdim numbers");
            int nearest = -1;
            double best = std::numeric_limits<double>::infinity();
            tree.nearest(x.data(), best,
                         [&](std::int32_t i)
                         {
                           const double d = tree.squared_distance(i, x.data());
                           if (d < best || (d == best && i < nearest))
                           {
                             nearest = i;
                             best = d;
                           }
                           return best;
                         });
            return std::pair(nearest, std::sqrt(best));
          },
          nb::arg("x"), "Number of the box nearest to a point (-1 without boxes) and its distance");
  m.def(
      "bounding_boxes",
      [](const Facets& facets)
      {
        std::vector<double> boxes;
        bounding_boxes(facets, boxes);
        return take(std::move(boxes), {facets.size(), std::size_t(2 * facets.gdim)});
      },
      nb::arg("facets"), "Boxes around facets, curved ones included");

  nb::enum_<ProjectionStatus>(m, "ProjectionStatus", nb::is_arithmetic())
      .value("converged", ProjectionStatus::converged)
      .value("edge", ProjectionStatus::edge)
      .value("vertex", ProjectionStatus::vertex)
      .value("outside", ProjectionStatus::outside);
  nb::class_<Exchange>(m, "Exchange", "A rank's slave facets and the master facets of all ranks within reach of them")
      .def(
          "__init__",
          [](Exchange* self, const dolfinx_impact::surface::FunctionSpace& V, const Facets& slave, const Facets& master,
             double reach) { new (self) Exchange(V, slave, master, reach); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("reach"),
          "Collective. reach: master facets are kept whose boxes come within it of the box around all slave facets of "
          "the rank: the distance of pairing and what the surfaces may move before the next Exchange [L]")
      .def_prop_ro("slave", &Exchange::slave, nb::rv_policy::reference_internal)
      .def_prop_ro("master", &Exchange::master, nb::rv_policy::reference_internal)
      .def_prop_ro("map", &Exchange::map, "Nodal map: owned blocks of V, then ghosts")
      .def_prop_ro("size", &Exchange::size, "Entries of a vector over the map")
      .def(
          "forward",
          [](const Exchange& self, Values u)
          {
            std::vector<double> values(self.size());
            self.forward(view(u), values);
            return take(std::move(values));
          },
          nb::arg("u"), "Values at the map's nodes from a vector of V. Collective")
      .def(
          "reverse", [](const Exchange& self, Values values, MutableValues b)
          { self.reverse(view(values), {b.data(), b.size()}); }, nb::arg("values"), nb::arg("b").noconvert(),
          "Add values at the map's nodes to a vector of V (changed). Collective")
      .def(
          "move", [](Exchange& self, Values u) { self.move(view(u)); }, nb::arg("u"),
          "Both surfaces to X + u, u a vector of V. Collective");

  nb::class_<PairSearch>(m, "PairSearch", "Two deformable surfaces as they move; candidates are kept while they hold")
      .def(
          "__init__",
          [](PairSearch* self, std::shared_ptr<const dolfinx_impact::surface::FunctionSpace> V, const Facets& slave,
             const Facets& master, double reach) { new (self) PairSearch(std::move(V), slave, master, reach); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("reach") = 0.0)
      .def(
          "update", [](PairSearch& self, Values u, Values start) { self.update(view(u), view(start)); }, nb::arg("u"),
          nb::arg("start"), "Move both surfaces to u and search anew where needed. Collective")
      .def("forget", &PairSearch::forget, "Exchange candidates in the next update, whatever has moved")
      .def_prop_ro("slave", [](const PairSearch& self) { return facets(self.exchange(), self.slave()); })
      .def_prop_ro("master", [](const PairSearch& self) { return facets(self.exchange(), self.master()); })
      .def_prop_ro("map", &PairSearch::map)
      .def_prop_ro("reach", &PairSearch::reach)
      .def_prop_ro("kept", &PairSearch::kept)
      .def_prop_ro("num_exchanges", &PairSearch::num_exchanges);
  nb::class_<SurfaceSearch>(m, "SurfaceSearch", "Closest points of a surface")
      .def(nb::init<const Facets&>(), nb::arg("master"), nb::keep_alive<1, 2>())
      .def_prop_ro("master", &SurfaceSearch::master, nb::rv_policy::reference_internal)
      .def("update", &SurfaceSearch::update, "To be called when the facets have moved")
      .def(
          "project",
          [](const SurfaceSearch& self, Points x, Points slave_normals, double reach,
             const std::optional<Indices>& previous)
          {
            const std::size_t num = x.shape(0), gdim = self.master().gdim;
            if (x.shape(1) != gdim || slave_normals.shape(0) != num || slave_normals.shape(1) != gdim)
              throw std::invalid_argument("points and slave normals are arrays of shape (number, gdim)");
            if (previous && previous->size() != num)
              throw std::invalid_argument("previous facets: one number per point");
            std::vector<Projection> found(num);
            for (std::size_t i = 0; i < num; ++i)
              found[i] = self.project(x.data() + i * gdim, slave_normals.data() + i * gdim, reach,
                                      previous ? previous->data()[i] : -1);
            return projections(found, gdim);
          },
          nb::arg("x"), nb::arg("slave_normals"), nb::arg("reach"), nb::arg("previous").none() = nb::none(),
          "Closest points: dictionary of status (0 inside, 1 edge, 2 vertex, 3 none), entity, facet, xi, gap, normal");
}
