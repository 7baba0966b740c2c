// SPDX-License-Identifier: MIT
#include "shared_nodes.h"
#include "../../common/gather.h"
#include "../../common/text.h"
#include "../../common/vectors.h"
#include "../../operators/nodal_sums.h"
#include "JoinedNodes.h"
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <unordered_set>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Normals of two pairs at a node agree within 30 degrees, as facets of one smooth surface do: cosine.
constexpr double crease = 0.86602540378443865;
/// Places in a message.
constexpr std::size_t shown = 3;

/// Positions of all ranks, the first of them, in words. Collective.
std::string first_places(const MortarContact& contact, std::vector<double> here)
{
  const std::size_t g = contact.geometry().gdim();
  here.resize(std::min(here.size(), shown * g));
  std::vector<double> all = common::gather(contact.geometry().comm(), here);
  all.resize(std::min(all.size(), shown * g));
  return common::places(all, int(g));
}

/// Reference positions of the first of some nodes, of all ranks, in words. Collective.
std::string node_places(const MortarContact& contact, std::span<const std::int32_t> nodes)
{
  const std::size_t g = contact.geometry().gdim();
  std::vector<double> here;
  for (std::int32_t node : nodes.first(std::min(nodes.size(), shown)))
  {
    const double* x = contact.geometry().reference_point(node);
    here.insert(here.end(), x, x + g);
  }
  return first_places(contact, std::move(here));
}

/// Facets that two surfaces have in common.
struct CommonFacets
{
  long long number = 0; ///< of all ranks
  std::string places;   ///< of the first of them
};

CommonFacets common_facets(const MortarContact& contact, const surface::Facets* one, const surface::Facets* other)
{
  const std::size_t g = contact.geometry().gdim();
  CommonFacets out;
  std::vector<double> here;
  if (one && other)
  {
    const std::unordered_set<std::int64_t> ids(other->id.begin(), other->id.end());
    for (std::size_t f = 0; f < one->size(); ++f)
    {
      if (!ids.contains(one->id[f]))
        continue;
      ++out.number;
      const int corners = one->geometry.num_nodes();
      for (std::size_t c = 0; c < g && out.number <= (long long)shown; ++c)
      {
        double sum = 0.0;
        for (int i = 0; i < corners; ++i)
          sum += one->X_of(f)[i * g + c];
        here.push_back(sum / corners);
      }
    }
  }
  out.places = first_places(contact, std::move(here));
  out.number = common::sum(contact.geometry().comm(), out.number);
  return out;
}

/// Do two contacts have the same rigid master?
bool same_obstacle(const MortarContact& a, const MortarContact& b)
{
  return a.geometry().obstacle() && a.geometry().obstacle() == b.geometry().obstacle();
}

/// Refuse pairs that constrain the same facets twice. Collective.
void check_surfaces(const MortarContact& a, const MortarContact& b)
{
  const MortarGeometry &first = a.geometry(), &second = b.geometry();
  const CommonFacets slaves = common_facets(a, &first.slave(), &second.slave());
  bool same_master = same_obstacle(a, b);
  if (first.master() && second.master())
    same_master = common_facets(a, first.master(), second.master()).number > 0;
  if (slaves.number > 0 && same_master)
    throw std::invalid_argument(a.name() + " and " + b.name() + " pair the same " + std::to_string(slaves.number) +
                                " slave facets with the same master twice, the first at " + slaves.places +
                                ": leave them out of one of the pairs");
  const CommonFacets crossed = common_facets(a, &first.slave(), second.master()),
                     back = common_facets(a, first.master(), &second.slave());
  if (crossed.number > 0 && back.number > 0)
    throw std::invalid_argument(
        a.name() + " and " + b.name() + ": the slave of each is the master of the other, on " +
        std::to_string(crossed.number) + " and " + std::to_string(back.number) + " facets, the first at " +
        crossed.places +
        ": multipliers would hold every point twice, which leaves the bodies no freedom; leave one of the two pairs "
        "out");
}

/// Do slave nodes of one contact lie on the master of another? Collective.
bool chained(const MortarContact& a, const MortarContact& b)
{
  const surface::Facets* master = b.geometry().master();
  if (!master)
    return false;
  const auto map = b.geometry().map();
  std::vector<double> marks(map->size_local() + map->num_ghosts(), 0.0);
  for (std::int32_t node : master->nodes)
    marks[node] = 1.0;
  marks = operators::sum_over_ranks(map, std::move(marks), 1);
  const bool here = std::ranges::any_of(a.nodes(), [&](std::int32_t node) { return marks[node] > 0.0; });
  return common::largest(a.geometry().comm(), here) > 0.0;
}

/// Is one constraint meant by those of two contacts at a node?
bool agree(const MortarContact& a, std::size_t i, const MortarContact& b, std::size_t j)
{
  if (a.geometry().obstacle() || b.geometry().obstacle())
    return same_obstacle(a, b);
  const std::size_t g = a.geometry().gdim();
  return dot(&a.geometry().now().normal[i * g], &b.geometry().now().normal[j * g], int(g)) > crease;
}

/// Numbers of the slave nodes of this rank, those that are to be joined alike.
struct Numbering
{
  std::vector<std::vector<std::int32_t>> numbers; ///< of each contact's nodes
  std::size_t count = 0;
  std::set<std::int32_t> joined; ///< nodes
  std::set<std::int32_t> apart;  ///< nodes with several constraints

  explicit Numbering(std::span<MortarContact* const> contacts)
  {
    struct Seen
    {
      const MortarContact* contact;
      std::size_t row;
      std::int32_t number;
    };
    std::map<std::int32_t, int> times;
    for (const MortarContact* c : contacts)
      for (std::int32_t node : c->nodes())
        ++times[node];
    std::map<std::int32_t, std::vector<Seen>> seen;
    for (const MortarContact* c : contacts)
    {
      std::vector<std::int32_t>& own = numbers.emplace_back(c->nodes().size(), -1);
      for (std::size_t i = 0; i < own.size(); ++i)
        if (times[c->nodes()[i]] == 1)
          own[i] = std::int32_t(count++);
      for (std::size_t i = 0; i < own.size(); ++i)
      {
        const std::int32_t node = c->nodes()[i];
        if (times[node] == 1)
          continue;
        std::vector<Seen>& before = seen[node];
        const auto alike = std::ranges::find_if(before, [&](const Seen& s) { return agree(*s.contact, s.row, *c, i); });
        if (alike != before.end())
        {
          own[i] = alike->number;
          joined.insert(node);
        }
        else
        {
          own[i] = std::int32_t(count++);
          if (!before.empty())
            apart.insert(node);
        }
        before.push_back({c, i, own[i]});
      }
    }
  }
};

/// Tell contacts which of their nodes others constrain along another normal.
void tell_edges(std::span<MortarContact* const> contacts, const Numbering& of)
{
  for (std::size_t a = 0; a < contacts.size(); ++a)
    for (std::size_t b = 0; b < contacts.size(); ++b)
    {
      if (a == b)
        continue;
      std::map<std::int32_t, std::int32_t> places;
      for (std::size_t j = 0; j < of.numbers[b].size(); ++j)
        places[contacts[b]->nodes()[j]] = std::int32_t(j);
      MortarContact::Edge edge{contacts[b], {}, {}};
      for (std::size_t i = 0; i < of.numbers[a].size(); ++i)
      {
        const auto at = places.find(contacts[a]->nodes()[i]);
        if (at == places.end() || of.numbers[a][i] == of.numbers[b][at->second])
          continue;
        edge.mine.push_back(std::int32_t(i));
        edge.theirs.push_back(at->second);
      }
      if (!edge.mine.empty())
        contacts[a]->edges.push_back(std::move(edge));
    }
}
} // namespace

bool connect(std::span<MortarContact* const> contacts)
{
  if (contacts.size() < 2)
    return false;
  for (std::size_t a = 0; a < contacts.size(); ++a)
    for (std::size_t b = a + 1; b < contacts.size(); ++b)
      check_surfaces(*contacts[a], *contacts[b]);
  bool any_chained = false;
  for (const MortarContact* a : contacts)
    for (const MortarContact* b : contacts)
      if (a != b)
        any_chained |= chained(*a, *b);
  const Numbering found(contacts);
  const MPI_Comm comm = contacts[0]->geometry().comm();
  const bool joined = common::sum(comm, (long long)found.joined.size()) > 0,
             apart = common::sum(comm, (long long)found.apart.size()) > 0;
  if (any_chained || joined || apart)
    for (const MortarContact* contact : contacts)
      if (!contact->options().may_share_nodes)
      {
        std::vector<std::int32_t> nodes(found.joined.begin(), found.joined.end());
        nodes.insert(nodes.end(), found.apart.begin(), found.apart.end());
        throw std::invalid_argument(
            contact->name() + " shares nodes with another contact by multipliers, the first at " +
            node_places(*contact, nodes) +
            ": rolling with friction solves for contacts one by one; leave the common nodes out of one of the tags, or "
            "use Penalty without friction");
      }
  if (joined)
  {
    std::vector<MortarGeometry*> geometries;
    for (MortarContact* contact : contacts)
      geometries.push_back(&contact->geometry());
    JoinedNodes::join(geometries, found.numbers, found.count);
    for (std::size_t k = 0; k < contacts.size(); ++k)
      for (std::size_t i = 0; i < contacts.size(); ++i)
        if (i != k)
          contacts[k]->partners.push_back({contacts[i], geometries[k]->joined()->rows_in(int(k), int(i))});
  }
  if (apart)
    tell_edges(contacts, found);
  return any_chained || apart;
}
} // namespace dolfinx_impact::enforcement
