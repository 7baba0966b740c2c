// SPDX-License-Identifier: MIT
#pragma once
#include "Rigid.h"
#include <cstdint>
#include <functional>
#include <mpi.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::gap
{
/// Points that are open on the far side of a rigid obstacle, through which their straight paths lead; one mark per
/// point.
/// @param[in] obstacle at the end of the increment
/// @param[in] start positions at the start, less the obstacle's motion since then, [i*gdim + c] [L]
/// @param[in] end positions at the end [L]
/// @param[in] offset added to gaps [L]
/// @param[in] tolerance gaps below it are none [L]
std::vector<std::int8_t> through_obstacle(const Rigid& obstacle, std::span<const double> start,
                                          std::span<const double> end, std::span<const double> offset,
                                          double tolerance);

/// Points without master at the end of an increment that have passed through it: they lie deep in it where they lose
/// it. One mark per point. Collective.
/// @param[in] comm communicator of the mesh
/// @param[in] suspects marks of the points that had a master at the start and have none at the end
/// @param[in] sizes of the points' facets [L]
/// @param[in] gap_at gaps of all points at a fraction of the increment, infinite without master [L]. Called on all
/// ranks, or on none
std::vector<std::int8_t> through_master(MPI_Comm comm, std::span<const std::int8_t> suspects,
                                        std::span<const double> sizes,
                                        const std::function<std::vector<double>(double)>& gap_at);

/// Points that have passed through their master, in words; empty without such points. Collective.
/// @param[in] name of the pair
/// @param[in] comm communicator of the mesh
/// @param[in] gdim dimension of space
/// @param[in] x positions of the points, [i*gdim + c] [L]
/// @param[in] passed marks
std::string describe_crossing(const std::string& name, MPI_Comm comm, int gdim, std::span<const double> x,
                              std::span<const std::int8_t> passed);
} // namespace dolfinx_impact::gap
