// SPDX-License-Identifier: MIT
#include "Condensation.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
using operators::check;

Condensation::Condensation(MPI_Comm comm, std::size_t num_owned, std::int64_t first, int gdim,
                           std::vector<Constraints> parts)
    : known(num_owned, 0.0), _gdim(gdim), _parts(std::move(parts)), _pinned(num_owned, 0)
{
  int tilted = 0;
  std::vector<std::int8_t> keep(num_owned, 1);
  for (const Constraints& p : _parts)
  {
    tilted |= std::any_of(p.tilt.begin(), p.tilt.end(), [](double t) { return t != 0.0; });
    for (std::int32_t node : p.nodes)
    {
      if (p.gdim != gdim || std::size_t(node + 1) * gdim > num_owned)
        throw std::invalid_argument("constraints are of owned nodes of the space");
      std::fill_n(&keep[node * gdim], gdim, std::int8_t(0));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &tilted, 1, MPI_INT, MPI_MAX, comm);
  _symmetric = !tilted;
  operators::CooMatrix::Entries right, left;
  for (const Constraints& p : _parts)
    add(p, first, right, left);
  for (std::size_t i = 0; i < num_owned; ++i)
    if (keep[i])
    {
      right.add(PetscInt(first + i), PetscInt(first + i), 1.0);
      if (!_symmetric)
        left.add(PetscInt(first + i), PetscInt(first + i), 1.0);
    }
  _right.assign(comm, PetscInt(num_owned), PetscInt(num_owned), gdim, std::move(right));
  if (!_symmetric)
    _left.assign(comm, PetscInt(num_owned), PetscInt(num_owned), gdim, std::move(left));
}

/// Entries of one contact's nodes.
void Condensation::add(const Constraints& p, std::int64_t first, operators::CooMatrix::Entries& right,
                       operators::CooMatrix::Entries& left)
{
  const int g = _gdim;
  for (std::size_t i = 0; i < p.size(); ++i)
  {
    const std::int64_t dof = std::int64_t(p.nodes[i]) * g;
    const double *frame = &p.frames[i * g * g], *over = &p.over[i * g * g], *tilt = &p.tilt[i * g];
    const std::int8_t* held = &p.constrained[i * g];
    double normal[3];
    for (int a = 0; a < g; ++a)
    {
      normal[a] = frame[a * g + p.normal[i]];
      _pinned[dof + a] = held[a];
      known[dof + a] = 0.0;
      for (int d = 0; d < g; ++d)
        known[dof + a] += held[d] ? frame[a * g + d] * p.known[i * g + d] : 0.0;
    }
    for (int d = 0; d < g; ++d)
    {
      // Test functions of a slipping node: tangential ones lean on the normal one, t - (t . tilt) n.
      double lean = 0.0;
      for (int a = 0; a < g; ++a)
        lean += frame[a * g + d] * tilt[a];
      for (int a = 0; a < g; ++a)
      {
        const PetscInt row = PetscInt(first + dof + a), column = PetscInt(first + dof + d);
        const double own = held[d] ? 0.0 : frame[a * g + d];
        right.add(row, column, own);
        if (!_symmetric)
          left.add(row, column, held[d] ? 0.0 : own - normal[a] * lean);
      }
    }
    const bool one_for_all = p.values.size() == p.columns.size();
    for (std::int64_t k = p.pointers[i]; k < p.pointers[i + 1]; ++k)
      for (int a = 0; a < g; ++a)
        for (int b = 0; b < g; ++b)
        {
          const PetscInt row = PetscInt(first + dof + a), column = PetscInt(g * p.columns[k] + b);
          const double value = one_for_all ? p.values[k] : 1.0;
          const auto part = [&](int d) { return one_for_all ? 1.0 : p.part(k, d); };
          double projected = 0.0;
          for (int d = 0; d < g; ++d)
            projected += held[d] ? frame[a * g + d] * over[b * g + d] * part(d) : 0.0;
          right.add(row, column, projected * value);
          if (!_symmetric)
            left.add(row, column, (projected + normal[a] * tilt[b] * part(p.normal[i])) * value);
        }
  }
}

std::vector<double> Condensation::residual(std::span<const double> values) const
{
  if (values.size() != _pinned.size())
    throw std::invalid_argument("a residual has an entry for every owned degree of freedom");
  Vec force = nullptr, product = nullptr;
  check(MatCreateVecs(left(), &product, &force), "vectors are made");
  {
    operators::Entries entries(force);
    for (std::size_t i = 0; i < values.size(); ++i)
      entries[i] = values[i];
  }
  check(MatMultTranspose(left(), force, product), "a residual is condensed");
  std::vector<double> out(values.size());
  {
    operators::Entries entries(product);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = _pinned[i] ? 0.0 : entries[i];
  }
  VecDestroy(&force);
  VecDestroy(&product);
  return out;
}

std::vector<double> Condensation::forces(std::span<const double> residual) const
{
  if (residual.size() != _pinned.size())
    throw std::invalid_argument("a residual has an entry for every owned degree of freedom");
  std::vector<double> out(residual.begin(), residual.end());
  for (const Constraints& p : _parts)
    for (std::size_t i = 0; i < p.size(); ++i)
      for (int a = 0; a < _gdim; ++a)
      {
        double& value = out[p.nodes[i] * _gdim + a];
        value = 0.0;
        for (int d = 0; d < _gdim; ++d)
          if (!p.constrained[i * _gdim + d])
            value += p.frames[(i * _gdim + a) * _gdim + d] * residual[p.nodes[i] * _gdim + d];
      }
  return out;
}

std::vector<double> Condensation::unknowns(std::span<const double> increments) const
{
  if (increments.size() != _pinned.size())
    throw std::invalid_argument("increments have an entry for every owned degree of freedom");
  std::vector<double> y(increments.begin(), increments.end());
  for (const Constraints& p : _parts)
    for (std::size_t i = 0; i < p.size(); ++i)
      for (int d = 0; d < _gdim; ++d)
      {
        double& value = y[p.nodes[i] * _gdim + d];
        value = 0.0;
        for (int a = 0; a < _gdim; ++a)
          value += p.frames[(i * _gdim + a) * _gdim + d] * increments[p.nodes[i] * _gdim + a];
      }
  for (std::size_t i = 0; i < y.size(); ++i)
    if (_pinned[i])
      y[i] = 0.0;
  return y;
}

std::vector<double> Condensation::increment(Vec y) const
{
  Vec product = nullptr;
  check(MatCreateVecs(right(), nullptr, &product), "vectors are made");
  check(MatMult(right(), y, product), "increments are found");
  std::vector<double> out(known);
  {
    operators::Entries entries(product);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] += entries[i];
  }
  VecDestroy(&product);
  return out;
}

void Condensation::add_constrained(std::int32_t unknown, std::span<double> increments) const
{
  const std::int32_t node = unknown / _gdim, d = unknown % _gdim;
  for (const Constraints& p : _parts)
    for (std::size_t i = 0; i < p.size(); ++i)
      for (int a = 0; a < _gdim && p.nodes[i] == node; ++a)
        increments[std::size_t(node) * _gdim + a] += p.frames[(i * _gdim + a) * _gdim + d];
}

Mat Condensation::condense(Mat K) const
{
  Mat out = nullptr, product = nullptr;
  if (_symmetric)
  {
    check(MatPtAP(K, right(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &out), "a matrix is condensed");
    check(MatProductClear(out), "a product is forgotten"); // it keeps K and work of several times its size
    return out;
  }
  check(MatMatMult(K, right(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product), "a matrix is condensed");
  check(MatTransposeMatMult(left(), product, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &out), "a matrix is condensed");
  check(MatProductClear(out), "a product is forgotten");
  check(MatDestroy(&product), "a matrix is destroyed");
  return out;
}
} // namespace dolfinx_impact::enforcement
