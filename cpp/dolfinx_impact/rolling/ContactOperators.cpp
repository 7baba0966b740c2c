// SPDX-License-Identifier: MIT
#include "ContactOperators.h"
#include "../common/gather.h"
#include "../operators/CooMatrix.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::rolling
{
namespace
{
using operators::check;
using operators::OwnedVector;

/// Cosine of the angle between a direction and an axis at which they are the same.
constexpr double along_axis = 0.9;

std::pair<OwnedVector, OwnedVector> vectors(Mat matrix)
{
  Vec right = nullptr, left = nullptr;
  check(MatCreateVecs(matrix, &right, &left), "vectors are made");
  return {OwnedVector(right), OwnedVector(left)};
}

void copy(std::span<const double> from, Vec to)
{
  operators::Entries entries(to);
  for (std::size_t i = 0; i < entries.size(); ++i)
    entries[i] = from[i];
}

std::vector<double> frames_of(const RollingContact& c, int g)
{
  const std::vector<double>&normal = c.geometry().now().normal, &slip = c.slip_velocity();
  const std::vector<double> main = c.main_direction();
  const std::vector<std::int8_t>& fixed = c.geometry().fixed();
  std::vector<double> out;
  for (std::size_t i = 0; i < c.geometry().num_nodes(); ++i)
  {
    double first[3];
    for (int a = 0; a < g; ++a)
      first[a] = slip[i * g + a] != 0.0 ? slip[i * g + a] : main[i * g + a];
    const std::span<const double> n(&normal[i * g], g);
    const std::vector<double> across = tangents(n, {first, std::size_t(g)}, {&fixed[i * g], std::size_t(g)});
    out.insert(out.end(), n.begin(), n.end());
    out.insert(out.end(), across.begin(), across.end());
  }
  return out;
}
} // namespace

ContactOperators::ContactOperators(std::span<RollingContact* const> contacts, std::size_t num_owned)
    : _contacts(contacts.begin(), contacts.end()), _gdim(contacts.front()->geometry().gdim()), _starts{0}
{
  const std::size_t g = _gdim;
  for (const RollingContact* c : _contacts)
  {
    const std::vector<double>& frames = _frames.emplace_back(frames_of(*c, _gdim));
    std::vector<std::int8_t>& held = _held.emplace_back(c->held().size(), 0);
    for (std::size_t k = 0; k < held.size(); ++k)
      for (std::size_t b = 0; b < g; ++b)
        held[k] = held[k] || (std::abs(frames[k * g + b]) > along_axis && c->held()[k / g * g + b]);
    _starts.push_back(_starts.back() + g * c->geometry().num_nodes());
  }
  _forces = force_matrix(_contacts.front()->geometry().comm(), num_owned);
}

operators::OwnedMatrix ContactOperators::force_matrix(MPI_Comm comm, std::size_t num_owned) const
{
  const std::size_t g = _gdim;
  const long long here = (long long)_starts.back();
  long long first = 0;
  MPI_Scan(&here, &first, 1, MPI_LONG_LONG, MPI_SUM, comm);
  first -= here;
  operators::CooMatrix::Entries entries;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    const RollingContact& c = *_contacts[k];
    const std::vector<std::int8_t> carriers = c.carriers();
    PetscInt begin = 0;
    check(MatGetOwnershipRange(c.jump(), &begin, nullptr), "a matrix is asked for its rows");
    for (std::size_t i = 0; i < carriers.size(); ++i)
    {
      PetscInt num = 0;
      const PetscInt* at = nullptr;
      const PetscScalar* values = nullptr;
      const PetscInt row = begin + c.nodes()[i];
      check(MatGetRow(c.jump(), row, &num, &at, &values), "a row is read");
      for (PetscInt j = 0; j < num; ++j)
        for (std::size_t a = 0; a < g; ++a)
          entries.add(PetscInt(g) * at[j] + PetscInt(a), PetscInt(first + _starts[k] + g * i + a),
                      carriers[i] ? values[j] / c.geometry().now().weight[i] : 0.0);
      check(MatRestoreRow(c.jump(), row, &num, &at, &values), "a row is read");
    }
  }
  operators::CooMatrix matrix;
  matrix.assign(comm, PetscInt(num_owned), PetscInt(_starts.back()), 1, std::move(entries));
  check(PetscObjectReference(PetscObject(matrix.matrix())), "a matrix is kept");
  return operators::OwnedMatrix(matrix.matrix());
}

std::vector<PetscInt> ContactOperators::columns(const Candidates& candidates) const
{
  PetscInt first = 0;
  check(MatGetOwnershipRangeColumn(_forces.get(), &first, nullptr), "a matrix is asked for its columns");
  std::vector<std::int64_t> own;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    for (std::int32_t node : candidates.local()[k])
      for (int a = 0; a < _gdim; ++a)
        own.push_back(first + std::int64_t(_starts[k]) + std::int64_t(_gdim) * node + a);
  const std::vector<std::int64_t> all = common::gather(_contacts.front()->geometry().comm(), own);
  return {all.begin(), all.end()};
}

ContactOperators::ByContact ContactOperators::weights() const
{
  ByContact out;
  for (const RollingContact* c : _contacts)
  {
    const std::vector<std::int8_t> carriers = c->carriers();
    std::vector<double>& weight = out.emplace_back(c->geometry().now().weight);
    for (std::size_t i = 0; i < weight.size(); ++i)
      weight[i] = carriers[i] ? weight[i] : 0.0;
  }
  return out;
}

std::vector<double> ContactOperators::nodal_forces(const ByContact& multipliers) const
{
  const auto [x, y] = vectors(_forces.get());
  std::vector<double> all;
  for (const std::vector<double>& one : multipliers)
    all.insert(all.end(), one.begin(), one.end());
  copy(all, x.get());
  check(MatMult(_forces.get(), x.get(), y.get()), "a matrix is multiplied");
  operators::Entries entries(y.get());
  return {entries.begin(), entries.end()};
}

ContactOperators::ByContact ContactOperators::jumps(std::span<const double> values) const
{
  const auto [x, y] = vectors(_forces.get());
  copy(values, y.get());
  check(MatMultTranspose(_forces.get(), y.get(), x.get()), "a matrix is multiplied");
  operators::Entries entries(x.get());
  ByContact out;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    out.emplace_back(entries.begin() + _starts[k], entries.begin() + _starts[k + 1]);
  return out;
}
} // namespace dolfinx_impact::rolling
