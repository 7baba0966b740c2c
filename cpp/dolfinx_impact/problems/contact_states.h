// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include <memory>

/// States of static contacts as parts of what a checkpoint holds: contact0, contact1, ...
namespace dolfinx_impact::problems
{
typedef std::vector<std::shared_ptr<enforcement::StaticContact>> StaticContacts;

inline void add_contacts(state::State& out, const StaticContacts& contacts)
{
  for (std::size_t k = 0; k < contacts.size(); ++k)
    out.add(std::move(contacts[k]->saved_state().rename("contact" + std::to_string(k))));
}

/// @param[in] u displacements of the checkpoint, owned and ghosts [L]
inline void resume_contacts(const state::State& saved, const StaticContacts& contacts, std::span<const double> u)
{
  for (std::size_t k = 0; k < contacts.size(); ++k)
    contacts[k]->resume(saved.part("contact" + std::to_string(k)), u);
}
} // namespace dolfinx_impact::problems
