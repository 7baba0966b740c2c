// SPDX-License-Identifier: MIT
#pragma once
#include <functional>
#include <mpi.h>

namespace dolfinx_impact::common
{
/// Do what may fail on one rank alone, and let all ranks fail alike: a rank that throws while the others go on to an
/// exchange would leave them waiting there. Collective, one reduction.
/// @param[in] act does not communicate
/// @throws std::exception on all ranks: std::invalid_argument or std::runtime_error, with the text of the lowest rank
/// that failed; a single rank passes on whatever `act` throws
void agree(MPI_Comm comm, const std::function<void()>& act);
} // namespace dolfinx_impact::common
