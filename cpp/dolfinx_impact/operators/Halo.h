#pragma once
#include <cstdint>
#include <dolfinx/common/IndexMap.h>
#include <dolfinx/common/Scatterer.h>
#include <memory>
#include <mpi.h>
#include <vector>

namespace impact::operators
{
/// Exchange of nodal values between a rank and its neighbours, without allocation: arrays values[node*bs + c] over the
/// nodes of an IndexMap, owned first, then ghosts. One message per neighbour and direction.
class Halo
{
public:
  /// @param[in] map nodes. Collective.
  explicit Halo(std::shared_ptr<const dolfinx::common::IndexMap> map);

  const dolfinx::common::IndexMap& map() const { return *_map; }
  std::int32_t num_owned() const { return _map->size_local(); }
  /// Owned nodes and ghosts.
  std::int32_t num_nodes() const { return _map->size_local() + _map->num_ghosts(); }

  /// Owned values to the ranks that have them as ghosts. Collective; between begin and end owned values may be read.
  void forward_begin(const double* values, int bs);
  void forward_end(double* values, int bs);
  void forward(double* values, int bs)
  {
    forward_begin(values, bs);
    forward_end(values, bs);
  }
  /// Ghost values added to those of their owners; ghosts keep theirs. Collective; between begin and end owned values
  /// may be written.
  void reverse_begin(const double* values, int bs);
  void reverse_end(double* values, int bs);
  void reverse(double* values, int bs)
  {
    reverse_begin(values, bs);
    reverse_end(values, bs);
  }

private:
  static constexpr int max_bs = 4;
  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  dolfinx::common::Scatterer<> _scatterer; ///< with block size 1; messages of bs values per node
  MPI_Datatype _type[max_bs + 1];
  std::vector<double> _local, _remote; ///< packed owned values, packed ghost values
  MPI_Request _request = MPI_REQUEST_NULL;
};
} // namespace impact::operators
