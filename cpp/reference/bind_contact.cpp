// SPDX-License-Identifier: MIT
#include "MovingBodies.h"
#include "RollingBodies.h"
#include "SteadySlip.h"
#include "bindings.h"
#include "contact_solve.h"
#include <set>

namespace nb = nanobind;

namespace impact_reference
{
namespace
{
Vec<double> vec(const Vector& v, int gdim)
{
  if (v.size() != gdim or not v.allFinite())
    throw std::invalid_argument("an obstacle's point, direction or displacement needs " + std::to_string(gdim) +
                                " finite components");
  return {v(0), v(1), gdim == 3 ? v(2) : 0};
}

Vector vector(const Vec<double>& v, int gdim)
{
  return Eigen::Map<const Vector>(v.c, gdim);
}

template <typename E>
Integers integers(const std::vector<E>& values)
{
  Integers result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    result(i) = std::int64_t(values[i]);
  return result;
}

Integers field_nodes(const Surface& surface)
{
  std::set<std::int64_t> nodes;
  for (const Facet& facet : surface.facets)
    nodes.insert(facet.nodes.begin(), facet.nodes.end());
  return integers(std::vector<std::int64_t>(nodes.begin(), nodes.end()));
}
} // namespace

Rigid rigid(const Obstacle& o, int gdim)
{
  Rigid r{o.shape == "plane"    ? Rigid::Shape::plane
          : o.shape == "sphere" ? Rigid::Shape::sphere
                                : Rigid::Shape::cylinder,
          vec(o.point, gdim),
          {0, 0, 1},
          o.radius,
          vec(o.pivot, gdim),
          {}};
  if (r.shape == Rigid::Shape::plane or (r.shape == Rigid::Shape::cylinder and gdim == 3))
  {
    r.direction = vec(o.direction, gdim);
    if (not(norm(r.direction) > 0))
      throw std::invalid_argument("the normal of a plane or the axis of a cylinder is zero");
    r.direction = unit(r.direction);
  }
  if (r.shape != Rigid::Shape::plane and not(o.radius > 0 and std::isfinite(o.radius)))
    throw std::invalid_argument("the radius of a rigid sphere or cylinder must be positive");
  return r;
}

namespace
{
Basis basis_of(const std::string& name)
{
  for (const auto& [known, basis] :
       {std::pair{"dual", Basis::dual}, {"standard", Basis::standard}, {"linear", Basis::linear}})
    if (name == known)
      return basis;
  throw std::invalid_argument("unknown basis '" + name + "': use 'dual', 'standard' or 'linear'");
}

// Vectors of rotation have three components in the plane, too.
RigidPlace rigid_place(const Vector& displacement, const Vector& angle, int gdim)
{
  return {vec(displacement, gdim), vec(angle, 3)};
}

using State = std::tuple<Vector, Vector, Vector, Vector, Matrix, Matrix, Integers, Vector, Matrix, Vector>;

class Bound
{
public:
  Bound(const Model& model, const Cells& slave, const Cells& master, const std::vector<Obstacle>& obstacle,
        double friction, const std::vector<std::int64_t>& prescribed, double search_distance)
      : pair_{model, surface(model, slave, "slave"), {}, {}, friction, {}, search_distance}, gdim_(model.gdim())
  {
    if (not(friction >= 0) or not std::isfinite(friction))
      throw std::invalid_argument("the friction coefficient must not be negative");
    if (not(search_distance > 0))
      throw std::invalid_argument("the search distance must be positive");
    if (obstacle.empty())
      pair_.master = surface(model, master, "master");
    else
      pair_.rigid = rigid(obstacle[0], gdim_);
    pair_.prescribed.assign(model.num_dofs(), false);
    for (auto dof : prescribed)
    {
      if (dof < 0 or dof >= model.num_dofs())
        throw std::invalid_argument("prescribed degree of freedom " + std::to_string(dof) + " is out of range");
      pair_.prescribed[dof] = true;
    }
  }

  void check(const Vector& u) const
  {
    if (u.size() != pair_.model.num_dofs() or not u.allFinite())
      throw std::invalid_argument("a displacement needs " + std::to_string(pair_.model.num_dofs()) +
                                  " finite values, but " + std::to_string(u.size()) + " were given");
  }

  ContactPair at(const Vector& displacement, const Vector& angle) const
  {
    ContactPair pair = pair_;
    if (pair.rigid)
      pair.rigid->place = rigid_place(displacement, angle, gdim_);
    return pair;
  }

  ContactHistory history(const Vector& u, const Vector& displacement, const Matrix& traction, const Matrix& slip,
                         const Integers& touched, const Vector& angle) const
  {
    check(u);
    return {u, rigid_place(displacement, angle, gdim_), traction, slip, touched};
  }

  auto tuple(const ContactHistory& h) const
  {
    return std::make_tuple(h.u, vector(h.place.displacement, gdim_), h.traction, h.slip, h.touched,
                           vector(h.place.angle, 3));
  }

  auto tuple(const ContactPoints& p) const
  {
    return std::make_tuple(p.gap, p.normal, integers(p.facet), p.xi, p.position, p.weight, p.pressure, p.traction,
                           integers(p.status), Integers(p.beside));
  }

  ContactState state(const State& s) const
  {
    const auto& [u, load, history_u, displacement, traction, slip, touched, multiplier, z, angle] = s;
    check(u);
    return {u, load, history(history_u, displacement, traction, slip, touched, angle), multiplier, z};
  }

  auto tuple(const ContactSolution& s) const
  {
    const ContactState& t = s.state;
    return std::make_tuple(std::make_tuple(t.u, t.load, t.history.u, vector(t.history.place.displacement, gdim_),
                                           t.history.traction, t.history.slip, t.history.touched, t.multiplier, t.z,
                                           vector(t.history.place.angle, 3)),
                           s.contact_force, s.reactions, s.iterations, s.residuals, tuple(s.points), s.pressure, s.gap,
                           integers(s.status));
  }

  ContactLoads loads(const std::vector<std::int64_t>& fixed, const Vector& values, const Vector& load,
                     const Vector& displacement, const Vector& angle) const
  {
    return {fixed, values, load, rigid_place(displacement, angle, gdim_)};
  }

  ContactPair pair_;
  int gdim_;
};
} // namespace

void bind_contact(nb::module_& m)
{
  using P = const Matrix&;
  using V = const Vector&;
  using Dofs = const std::vector<std::int64_t>&;
  nb::class_<Bound>(m, "Contact")
      .def(
          "__init__",
          [](Bound* self, const Model& model, const Cells& slave, const Cells& master,
             const std::vector<std::tuple<std::string, Vector, Vector, double, Vector>>& obstacle, double friction,
             Dofs prescribed, double search_distance)
          {
            std::vector<Obstacle> list;
            list.reserve(obstacle.size());
            for (const auto& [shape, point, direction, radius, pivot] : obstacle)
              list.push_back({shape, point, direction, radius, pivot});
            new (self) Bound(model, slave, master, list, friction, prescribed, search_distance);
          },
          nb::keep_alive<1, 2>())
      .def("shift_gaps",
           [](Bound& s, V shift)
           {
             if (not shift.allFinite())
               throw std::invalid_argument("what is added to gaps must be finite");
             s.pair_.gap_shift = shift;
           })
      .def_prop_ro("num_facets", [](const Bound& s) { return s.pair_.slave.facets.size(); })
      .def("penalty",
           [](const Bound& s, P points, V weights, V displacement, V angle, V u, double chi, double chi_t, V history_u,
              V history_displacement, P traction, P slip, const Integers& touched, V history_angle, V multiplier)
           {
             s.check(u);
             const Penalty r = penalty(
                 s.at(displacement, angle), {points, weights}, u, chi, chi_t,
                 s.history(history_u, history_displacement, traction, slip, touched, history_angle), multiplier);
             return std::make_tuple(r.force, csr(r.tangent, u.size()), s.tuple(r.points), s.tuple(r.history));
           })
      .def("mortar",
           [](const Bound& s, P points, V weights, V displacement, V angle, const std::string& basis, V u, V history_u,
              V history_displacement, V history_angle, P z)
           {
             s.check(u);
             const ContactHistory h = s.history(history_u, history_displacement, {}, {}, {}, history_angle);
             const Mortar r = mortar(s.at(displacement, angle), {points, weights}, basis_of(basis), u, h, z);
             const std::int64_t n = z.rows();
             Matrix gamma = Matrix::Zero(n, s.gdim_), normal = gamma, moved = gamma;
             Vector cover = Vector::Zero(n);
             Integers part = Integers::Zero(n);
             for (const auto& [number, node] : r.nodes)
             {
               gamma.row(number) = vector(node.gamma.value, s.gdim_).transpose();
               normal.row(number) = vector(node.normal.value, s.gdim_).transpose();
               moved.row(number) = vector(node.moved.value, s.gdim_).transpose();
               cover(number) = node.cover;
               part(number) = node.part;
             }
             return std::make_tuple(csr(r.D, n), csr(r.M, n), gamma, normal, moved, cover, part, r.force,
                                    csr(r.tangent, u.size()));
           })
      .def("solve_penalty",
           [](const Bound& s, P points, V weights, P contact_points, V contact_weights, double chi, double chi_t,
              const State& state, Dofs fixed, V values, V load, V displacement, V angle, int steps, int iterations,
              double tolerance, bool augmented)
           {
             return s.tuple(solve_penalty(s.pair_, ElasticForces(s.pair_.model, {points, weights}),
                                          {contact_points, contact_weights}, chi, chi_t, s.state(state),
                                          s.loads(fixed, values, load, displacement, angle),
                                          {steps, iterations, tolerance, augmented}));
           })
      .def("solve_lagrange",
           [](const Bound& s, P points, V weights, P contact_points, V contact_weights, const std::string& basis,
              const State& state, Dofs fixed, V values, V load, V displacement, V angle, int steps, int iterations,
              double tolerance)
           {
             return s.tuple(solve_lagrange(s.pair_, ElasticForces(s.pair_.model, {points, weights}),
                                           {contact_points, contact_weights}, basis_of(basis), s.state(state),
                                           s.loads(fixed, values, load, displacement, angle),
                                           {steps, iterations, tolerance}));
           })
      .def("step_penalty",
           [](const Bound& s, const MovingBodies& bodies, P points, V weights, double chi, double chi_t,
              const State& state, Dofs fixed, V values, V load, V displacement, V angle, int iterations,
              double tolerance)
           {
             return s.tuple(solve_penalty(s.pair_, bodies, {points, weights}, chi, chi_t, s.state(state),
                                          s.loads(fixed, values, load, displacement, angle),
                                          {1, iterations, tolerance, false, false, 2}));
           })
      .def("step_lagrange",
           [](const Bound& s, const MovingBodies& bodies, P points, V weights, const std::string& basis,
              const State& state, Dofs fixed, V values, V load, V displacement, V angle, int iterations,
              double tolerance)
           {
             return s.tuple(solve_lagrange(s.pair_, bodies, {points, weights}, basis_of(basis), s.state(state),
                                           s.loads(fixed, values, load, displacement, angle),
                                           {1, iterations, tolerance, false, false, 2}));
           })
      .def("step_rolling",
           [](const Bound& s, const RollingBodies& bodies, P points, V weights, const std::string& basis,
              const State& state, Dofs fixed, V values, V load, V displacement, V angle, int steps, int iterations,
              double tolerance, V flow, const Integers& indptr, const Integers& indices, V data, V obstacle)
           {
             const SteadySlip steady(flow, csr(indptr, indices, data), vec(obstacle, s.gdim_), s.gdim_);
             return s.tuple(solve_lagrange(s.pair_, bodies, {points, weights}, basis_of(basis), s.state(state),
                                           s.loads(fixed, values, load, displacement, angle),
                                           {steps, iterations, tolerance, false, false, 2}, &steady));
           })
      .def("slave_nodes", [](const Bound& s) { return field_nodes(s.pair_.slave); })
      .def("master_nodes", [](const Bound& s) { return field_nodes(s.pair_.master); });
}
} // namespace impact_reference
