// SPDX-License-Identifier: MIT
#include "Csr.h"
#include <algorithm>
#include <stdexcept>

namespace impact_reference
{
Vector Csr::dot(const Vector& x) const
{
  if (x.size() != size)
    throw std::invalid_argument("the matrix has " + std::to_string(size) + " columns, but the vector has " +
                                std::to_string(x.size()) + " entries");
  Vector y = Vector::Zero(size);
  for (std::int64_t i = 0; i < size; ++i)
    for (std::int64_t k = indptr[i]; k < indptr[i + 1]; ++k)
      y(i) += data[k] * x(indices[k]);
  return y;
}

void Csr::add(const Csr& other)
{
  if (other.indices != indices or other.indptr != indptr)
    throw std::invalid_argument("the matrices have different patterns: they belong to different models");
  for (std::size_t k = 0; k < data.size(); ++k)
    data[k] += other.data[k];
}

Pattern::Pattern(const Field& field) : offsets_(field.points.rows() + 1)
{
  std::vector<std::vector<std::int64_t>> lists(field.points.rows());
  for (std::int64_t c = 0; c < field.cells.rows(); ++c)
    for (std::int64_t node : field.cells.row(c))
      lists[node].insert(lists[node].end(), field.cells.row(c).begin(), field.cells.row(c).end());
  for (std::size_t i = 0; i < lists.size(); ++i)
  {
    auto& list = lists[i];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    neighbours_.insert(neighbours_.end(), list.begin(), list.end());
    offsets_[i + 1] = std::int64_t(neighbours_.size());
    std::vector<std::int64_t>().swap(list);
  }
}

Csr Pattern::matrix(int block) const
{
  const auto nodes = std::int64_t(offsets_.size()) - 1;
  Csr result;
  result.size = block * nodes;
  result.indptr.reserve(result.size + 1);
  result.indices.reserve(block * block * neighbours_.size());
  result.indptr.push_back(0);
  for (std::int64_t i = 0; i < nodes; ++i)
    for (int a = 0; a < block; ++a)
    {
      for (std::int64_t k = offsets_[i]; k < offsets_[i + 1]; ++k)
        for (int b = 0; b < block; ++b)
          result.indices.push_back(block * neighbours_[k] + b);
      result.indptr.push_back(std::int64_t(result.indices.size()));
    }
  result.data.assign(result.indices.size(), 0.0);
  return result;
}

void Pattern::add(Csr& matrix, int block, const std::vector<std::int64_t>& nodes, const Matrix& element) const
{
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    const auto begin = neighbours_.begin() + offsets_[nodes[i]], end = neighbours_.begin() + offsets_[nodes[i] + 1];
    for (std::size_t j = 0; j < nodes.size(); ++j)
    {
      const std::int64_t place = std::lower_bound(begin, end, nodes[j]) - begin;
      for (int a = 0; a < block; ++a)
      {
        double* row = matrix.data.data() + matrix.indptr[block * nodes[i] + a] + block * place;
        for (int b = 0; b < block; ++b)
          row[b] += element(block * i + a, block * j + b);
      }
    }
  }
}
} // namespace impact_reference
