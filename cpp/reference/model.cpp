// SPDX-License-Identifier: MIT
#include "Model.h"
#include "NodalPressure.h"
#include "NodalStrain.h"
#include <algorithm>
#include <stdexcept>

namespace impact_reference
{
Model::Model(const impact_plain::Mesh& mesh, const std::map<int, Material>& materials, int degree)
    : geometry_(impact_reference::geometry(mesh)), field_(number_field(geometry_, degree)), pattern_(field_),
      facets_(geometry_)
{
  if (materials.empty())
    throw std::invalid_argument("a model needs at least one material");
  std::map<int, int> place;
  for (const auto& [tag, material] : materials)
  {
    check(material);
    if (material.hypothesis != materials.begin()->second.hypothesis)
      throw std::invalid_argument("materials have different hypotheses (" + material.hypothesis + " and " +
                                  materials.begin()->second.hypothesis + "): a model has one");
    place[tag] = int(materials_.size());
    materials_.push_back(material);
    tags_.push_back(tag);
  }
  const std::int64_t num_cells = geometry_.cells.rows();
  if (mesh.cell_tags.empty() and materials.size() > 1)
    throw std::invalid_argument("several materials need cell_tags, one tag per cell");
  if (not mesh.cell_tags.empty() and std::int64_t(mesh.cell_tags.size()) != num_cells)
    throw std::invalid_argument("there are " + std::to_string(num_cells) + " cells but " +
                                std::to_string(mesh.cell_tags.size()) + " cell_tags");
  material_of_cell_.assign(num_cells, 0);
  for (std::size_t c = 0; c < mesh.cell_tags.size(); ++c)
  {
    const auto found = place.find(mesh.cell_tags[c]);
    if (found == place.end())
      throw std::invalid_argument("cell " + std::to_string(c) + " has tag " + std::to_string(mesh.cell_tags[c]) +
                                  ", for which no material was given");
    material_of_cell_[c] = found->second;
  }
  hypothesis_ = impact_reference::hypothesis(materials_[0].hypothesis);
  if ((hypothesis_ == Hypothesis::solid) != (gdim() == 3))
    throw std::invalid_argument("hypothesis '" + materials_[0].hypothesis + "' does not go with " + mesh.cell_type +
                                " cells: solid cells need 3d, plane cells plane_strain, plane_stress or axisymmetric");
  linear_ =
      std::all_of(materials_.begin(), materials_.end(), [](const Material& m) { return m.law == "linear_elastic"; });

  springs_ = dashpots_ = added_mass_ = pattern_.matrix(gdim());

  // Visits every cell once, so that an inverted cell is named here and not in the middle of an analysis.
  const Sampler probe = sampler(quadrature(geometry_.cell, "table:" + std::to_string(2 * geometry_.degree)));
  for (std::int64_t c = 0; c < num_cells; ++c)
    for (int q = 0; q < probe.num_points(); ++q)
      probe.at(cell_points(c), q, c);
}

Sampler Model::sampler(const Rule& rule) const
{
  return {geometry_.cell, field_.degree, geometry_.degree, rule, hypothesis_ == Hypothesis::axisymmetric};
}

FacetSampler Model::facet_sampler(const Rule& rule) const
{
  return {geometry_.cell, field_.degree, geometry_.degree, rule, hypothesis_ == Hypothesis::axisymmetric};
}

std::vector<std::int64_t> Model::cell_nodes(std::int64_t cell) const
{
  return {field_.cells.row(cell).begin(), field_.cells.row(cell).end()};
}

Matrix Model::cell_points(std::int64_t cell) const
{
  Matrix X(geometry_.cells.cols(), gdim());
  for (int i = 0; i < X.rows(); ++i)
    X.row(i) = geometry_.points.row(geometry_.cells(cell, i));
  return X;
}

Vector Model::gather(const Vector& u, std::int64_t cell) const
{
  const int d = gdim();
  Vector result(d * field_.cells.cols());
  for (int i = 0; i < field_.cells.cols(); ++i)
    result.segment(d * i, d) = u.segment(d * field_.cells(cell, i), d);
  return result;
}

void Model::scatter(Vector& global, int block, std::int64_t cell, const Vector& element) const
{
  for (int i = 0; i < field_.cells.cols(); ++i)
    global.segment(block * field_.cells(cell, i), block) += element.segment(block * i, block);
}

void Model::check_vector(const Vector& u) const
{
  if (u.size() != num_dofs())
    throw std::invalid_argument("the model has " + std::to_string(num_dofs()) + " degrees of freedom, but " +
                                std::to_string(u.size()) + " values were given");
  for (std::int64_t i = 0; i < u.size(); ++i)
    if (not std::isfinite(u(i)))
      throw std::invalid_argument("degree of freedom " + std::to_string(i) + " is NaN or infinite");
}

FacetPlace Model::locate(const Cells& facets, std::int64_t row) const
{
  return facets_.find({facets.row(row).begin(), facets.row(row).end()});
}

template <typename F>
Csr Model::assemble(int block, F&& element) const
{
  Csr matrix = pattern_.matrix(block);
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
    pattern_.add(matrix, block, cell_nodes(c), element(cell_points(c), c));
  return matrix;
}

template <typename F>
Vector Model::assemble_vector(int block, F&& element) const
{
  Vector result = Vector::Zero(block * field_.points.rows());
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
    scatter(result, block, c, element(cell_points(c), c));
  return result;
}

Csr Model::stiffness(const Rule& rule) const
{
  const Sampler s = sampler(rule);
  return assemble(gdim(),
                  [&](const Matrix& X, std::int64_t c) { return impact_reference::stiffness(s, X, material(c), c); });
}

Csr Model::mass(const Rule& rule) const
{
  const Sampler s = sampler(rule);
  Csr M =
      assemble(gdim(), [&](const Matrix& X, std::int64_t c) { return impact_reference::mass(s, X, material(c), c); });
  M.add(added_mass_);
  return M;
}

Vector Model::lumped_mass(const Rule& rule, const std::string& scheme) const
{
  const LumpedMass lump(geometry_.cell, field_.degree, geometry_.degree, rule, hypothesis_ == Hypothesis::axisymmetric,
                        scheme);
  return assemble_vector(gdim(), [&](const Matrix& X, std::int64_t c) { return lump(X, material(c), c); }) +
         added_mass_.dot(Vector::Ones(num_dofs()));
}

Csr Model::damping(const Rule& rule, const Rule& mass_rule, double alpha, double beta) const
{
  if (not std::isfinite(alpha) or not std::isfinite(beta))
    throw std::invalid_argument("a Rayleigh damping coefficient is NaN or infinite");
  Csr C = stiffness(rule);
  const Csr M = alpha == 0 ? pattern_.matrix(gdim()) : mass(mass_rule);
  for (std::size_t k = 0; k < C.data.size(); ++k)
    C.data[k] = alpha * M.data[k] + beta * C.data[k];
  return C;
}

namespace
{
constexpr double share_of_nodes = 0.6; // of the shear modulus, with averaged strains

// Energy and force of the pressures at the nodes, and of their strains.
NodalPressure::Answer nodal_answer(const Model& model, const Vector& u, bool with_strains)
{
  std::map<int, NodalPressure::Law> laws;
  std::map<int, NodalStrain::Law> strain_laws;
  for (std::int64_t c = 0; c < model.num_cells(); ++c)
    if (not laws.contains(model.tag(c)))
    {
      const auto [lambda, mu] = lame(model.material(c));
      laws[model.tag(c)] = squared_law(lambda, model.linear());
      const double own = share_of_nodes * mu;
      strain_laws[model.tag(c)] = model.linear() ? squared_strain_law(own) : stretched_law(own);
    }
  NodalPressure::Answer answer =
      NodalPressure(model).at_nodes(u, model.linear(), [&](int tag) { return laws.at(tag); });
  if (with_strains)
  {
    const NodalPressure::Answer strains = NodalStrain(model).at_nodes(u, [&](int tag) { return strain_laws.at(tag); });
    answer.energy += strains.energy;
    answer.force += strains.force;
  }
  return answer;
}
} // namespace

void Model::average_pressure()
{
  const NodalPressure checked(*this);
  for (const Material& m : materials_)
    if (m.law != materials_[0].law or (m.law != "linear_elastic" and m.law != "neo_hookean"))
      throw std::invalid_argument("pressure is averaged at nodes of linear_elastic or of neo_hookean bodies only");
  averages_pressure_ = true;
}

void Model::average_strain()
{
  average_pressure();
  averages_strain_ = true;
}

Material Model::own_material(std::int64_t cell) const
{
  Material own = material(cell);
  if (averages_pressure_) // the same shear modulus, or the share that is left of it, and lambda = 0
  {
    own.E = 2 * lame(own)[1] * (averages_strain_ ? 1 - share_of_nodes : 1);
    own.nu = 0;
  }
  return own;
}

double Model::energy(const Rule& rule, const Vector& u) const
{
  check_vector(u);
  const Sampler s = sampler(rule);
  double sum = 0;
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
    sum += internal(s, cell_points(c), own_material(c), gather(u, c), false, c).energy;
  if (averages_pressure_)
    sum += nodal_answer(*this, u, averages_strain_).energy;
  return sum + u.dot(springs_.dot(u)) / 2;
}

Vector Model::internal_force(const Rule& rule, const Vector& u) const
{
  check_vector(u);
  const Sampler s = sampler(rule);
  Vector force = assemble_vector(gdim(), [&](const Matrix& X, std::int64_t c)
                                 { return internal(s, X, own_material(c), gather(u, c), false, c).force; });
  if (averages_pressure_)
    force += nodal_answer(*this, u, averages_strain_).force;
  return force + springs_.dot(u);
}

Csr Model::tangent(const Rule& rule, const Vector& u) const
{
  Csr K = elastic_tangent(rule, u);
  K.add(springs_);
  return K;
}

Csr Model::elastic_tangent(const Rule& rule, const Vector& u) const
{
  check_vector(u);
  if (averages_pressure_)
    throw std::invalid_argument("with pressures averaged at the nodes there is no tangent here");
  const Sampler s = sampler(rule);
  return assemble(gdim(), [&](const Matrix& X, std::int64_t c)
                  { return internal(s, X, material(c), gather(u, c), true, c).tangent; });
}

std::array<Matrix, 2> Model::stress(const Rule& rule, const Vector& u) const
{
  check_vector(u);
  const Sampler s = sampler(rule);
  const int n = s.num_points();
  Matrix values(n * geometry_.cells.rows(), num_strains(hypothesis_)), places(values.rows(), gdim());
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
  {
    values.middleRows(n * c, n) = impact_reference::stress(s, cell_points(c), material(c), gather(u, c), c);
    for (int q = 0; q < n; ++q)
      places.row(n * c + q) = s.at(cell_points(c), q, c).x.transpose();
  }
  return {values, places};
}

Vector Model::body_force(const Rule& rule, const Vector& f) const
{
  const Sampler s = sampler(rule);
  if (f.size() != gdim())
    throw std::invalid_argument("the body force needs " + std::to_string(gdim()) + " components, but " +
                                std::to_string(f.size()) + " were given");
  return assemble_vector(gdim(),
                         [&](const Matrix& X, std::int64_t c) { return impact_reference::body_force(s, X, f, c); });
}

Vector Model::traction(const Rule& facet_rule, const Cells& facets, const Vector& t) const
{
  const FacetSampler s = facet_sampler(facet_rule);
  if (t.size() != gdim())
    throw std::invalid_argument("the traction needs " + std::to_string(gdim()) + " components, but " +
                                std::to_string(t.size()) + " were given");
  Vector result = Vector::Zero(num_dofs());
  for (std::int64_t f = 0; f < facets.rows(); ++f)
  {
    const FacetPlace place = locate(facets, f);
    scatter(result, gdim(), place.cell, impact_reference::traction(s, cell_points(place.cell), place.facet, t));
  }
  return result;
}

std::pair<Vector, Csr> Model::follower_pressure(const Rule& facet_rule, const Cells& facets, const Vector& u,
                                                double p) const
{
  check_vector(u);
  const FacetSampler s = facet_sampler(facet_rule);
  std::pair<Vector, Csr> result{Vector::Zero(num_dofs()), pattern_.matrix(gdim())};
  for (std::int64_t f = 0; f < facets.rows(); ++f)
  {
    const FacetPlace place = locate(facets, f);
    if (place.num_cells > 1)
      throw std::invalid_argument("facet " + std::to_string(f) +
                                  " lies between two cells: a pressure needs facets on the boundary");
    const Follower element =
        impact_reference::follower_pressure(s, cell_points(place.cell), gather(u, place.cell), place.facet, p);
    scatter(result.first, gdim(), place.cell, element.force);
    pattern_.add(result.second, gdim(), cell_nodes(place.cell), element.tangent);
  }
  return result;
}

Csr Model::foundation(const Rule& facet_rule, const Cells& facets, const Vector& k) const
{
  const FacetSampler s = facet_sampler(facet_rule);
  Csr result = pattern_.matrix(gdim());
  for (std::int64_t f = 0; f < facets.rows(); ++f)
  {
    const FacetPlace place = locate(facets, f);
    if (place.num_cells > 1)
      throw std::invalid_argument("facet " + std::to_string(f) +
                                  " lies between two cells: a foundation needs facets on the boundary");
    pattern_.add(result, gdim(), cell_nodes(place.cell),
                 impact_reference::foundation(s, cell_points(place.cell), place.facet, k));
  }
  return result;
}

void Model::add_foundation(const Csr& springs, const Csr& dashpots)
{
  springs_.add(springs);
  dashpots_.add(dashpots);
  on_foundation_ = true;
}

Csr Model::gyroscopic(const Rule& rule, const Vector& spin, const Vector& centre) const
{
  const Sampler s = sampler(rule);
  return assemble(gdim(),
                  [&](const Matrix& X, std::int64_t c) { return ale(s, X, material(c), spin, centre, c).gyroscopic; });
}

Csr Model::ale_inertia(const Rule& rule, const Vector& spin, const Vector& centre) const
{
  const Sampler s = sampler(rule);
  return assemble(gdim(),
                  [&](const Matrix& X, std::int64_t c) { return ale(s, X, material(c), spin, centre, c).inertia; });
}

Vector Model::ale_load(const Rule& rule, const Vector& spin, const Vector& centre) const
{
  const Sampler s = sampler(rule);
  return assemble_vector(gdim(),
                         [&](const Matrix& X, std::int64_t c) { return ale(s, X, material(c), spin, centre, c).load; });
}

Csr Model::poisson(const Rule& rule, double k) const
{
  const Sampler s = sampler(rule);
  return assemble(1, [&](const Matrix& X, std::int64_t c) { return impact_reference::poisson(s, X, k, c); });
}

Vector Model::scalar_load(const Rule& rule, double f) const
{
  const Sampler s = sampler(rule);
  const Vector one = Vector::Constant(1, f);
  return assemble_vector(1,
                         [&](const Matrix& X, std::int64_t c) { return impact_reference::body_force(s, X, one, c); });
}

Vector Model::flux_load(const Rule& facet_rule, const Cells& facets, double q) const
{
  const FacetSampler s = facet_sampler(facet_rule);
  Vector result = Vector::Zero(field_.points.rows());
  for (std::int64_t f = 0; f < facets.rows(); ++f)
  {
    const FacetPlace place = locate(facets, f);
    scatter(result, 1, place.cell,
            impact_reference::traction(s, cell_points(place.cell), place.facet, Vector::Constant(1, q)));
  }
  return result;
}
} // namespace impact_reference
