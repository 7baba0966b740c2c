// SPDX-License-Identifier: MIT
#pragma once
#include "../files/checkpoint.h"
#include "explicit_state.h"
#include "implicit_state.h"
#include "static_state.h"
#include <filesystem>

/// Problems in files: written and read on any number of ranks; see files/checkpoint.h.
namespace dolfinx_impact::problems
{
/// Write a problem to a file. An earlier file stays until the new one is complete. Collective.
/// @param[in] identity texts, numbers and arrays by which the problem is recognised, materials for example, beside its
/// kind, mesh and supports, which are always compared
/// @throws common::Failure on all ranks: the file cannot be written, or no space is left; an earlier file is as it was
void save(const std::filesystem::path& path, StaticProblem& problem, const files::Attributes& identity = {});
void save(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity = {});
void save(const std::filesystem::path& path, ExplicitProblem& problem, const files::Attributes& identity = {});

/// Go on from a file that `save` has written of the same problem, on any number of ranks. An `advance` of an explicit
/// problem that was left goes on with its steps. Collective.
/// @throws common::Failure on all ranks: the file cannot be read, or is damaged; the problem is as it was
/// @throws common::BadValue on all ranks: the file belongs to another problem; the problem is as it was
void restore(const std::filesystem::path& path, StaticProblem& problem, const files::Attributes& identity = {});
void restore(const std::filesystem::path& path, NewmarkProblem& problem, const files::Attributes& identity = {});
void restore(const std::filesystem::path& path, ExplicitProblem& problem, const files::Attributes& identity = {});
} // namespace dolfinx_impact::problems
