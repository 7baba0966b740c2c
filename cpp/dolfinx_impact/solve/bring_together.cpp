// SPDX-License-Identifier: MIT
#include "bring_together.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../enforcement/mortar/MortarContact.h"
#include "../enforcement/mortar/Tie.h"
#include "../operators/RigidBodyModes.h"
#include "../operators/body_size.h"
#include "../operators/petsc_check.h"
#include "dense.h"
#include "unconstrained_modes.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace dolfinx_impact::solve
{
namespace
{
constexpr double touching = 1e-9; ///< of the bodies' size: gaps that count as closed
constexpr double probe = 1e-6;    ///< of the bodies' size: motion whose differences tell the rates of gaps
constexpr double slow = 1e-5;     ///< rate of a gap per motion, or part of a mode, that counts as none
constexpr double unloaded = 1e-8; ///< of the forces' products with a motion: less is round-off
constexpr double farthest = 10.0; ///< sizes of the bodies that they are moved by at most
constexpr int most_motions = 50;  ///< from one contact to the next
constexpr int most_parts = 2000;  ///< of one of them: gaps bound each from below
constexpr int deepest = 24;       ///< doublings of the overlap that a law of the interface needs to act

/// The free rigid motions of bodies, and what loads and closed contacts do to them. Coordinates of a motion are those
/// of the modes that supports leave.
class FreeBodies
{
public:
  explicit FreeBodies(const EquilibriumProblem& p)
      : _problem(p), _size(operators::body_size(*p.space().mesh())), _u(common::array(*p.u->x())),
        _start(_u.begin(), _u.end()), _motions(p.space(), _u, p.axisymmetric)
  {
    for (const auto& contact : p.contacts)
      _saved.push_back(contact->state().copy());
    for (const auto& contact : p.contacts)
      contact->begin_step(_u, contact->displacement());
    update();
    std::vector<enforcement::StaticContact*> holding;
    for (const auto& contact : p.contacts)
    {
      const bool holds = dynamic_cast<const enforcement::Tie*>(contact.get()) ||
                         (contact->needs_line_search() && contact->num_active() > 0);
      (holds ? holding : _touching).push_back(contact.get());
    }
    Mat springs = p.body->properties().has_springs ? p.body->tangent() : nullptr;
    _modes = free_modes(_motions, p.space(), p.fixed, holding, p.axisymmetric, springs);
    for (const std::vector<double>& mode : _modes)
    {
      _fields.push_back(_motions.field(mode));
      for (std::size_t i = 0; i < _fields.back().size(); ++i) // prescribed values stay to the bit
        if (p.fixed[i])
          _fields.back()[i] = 0.0;
    }
    _way.assign(_motions.num_modes(), 0.0);
  }

  bool any() const { return !_modes.empty() && !_touching.empty(); }

  /// Generalised forces of the loads; zero where their products cancel. Collective.
  std::vector<double> loads()
  {
    const std::vector<double> residual = operators::values_of(_problem.body->residual(), _problem.num_owned());
    const std::size_t m = _fields.size();
    std::vector<double> sums(2 * m, 0.0);
    for (std::size_t k = 0; k < m; ++k)
      for (std::size_t i = 0; i < residual.size(); ++i)
      {
        sums[k] -= residual[i] * _fields[k][i];
        sums[m + k] += std::abs(residual[i] * _fields[k][i]);
      }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, _problem.comm());
    std::vector<double> out(m);
    const double all = std::accumulate(sums.begin() + m, sums.end(), 0.0);
    for (std::size_t k = 0; k < m; ++k)
      out[k] = std::abs(sums[k]) > unloaded * all ? sums[k] : 0.0;
    return out;
  }

  /// Rates of the closed gaps under the modes, [row][mode]; the same on all ranks. Collective.
  std::vector<std::vector<double>> closed_gaps()
  {
    const double step = probe * _size;
    const std::vector<std::vector<double>> now = gaps();
    std::vector<std::vector<std::vector<double>>> beside;
    for (std::size_t k = 0; k < _fields.size(); ++k)
    {
      std::vector<double> q(_fields.size(), 0.0);
      q[k] = step;
      const std::vector<double> here(_u.begin(), _u.end());
      go(here, q);
      beside.push_back(gaps());
      std::ranges::copy(here, _u.begin());
    }
    update();
    std::vector<double> flat;
    for (std::size_t c = 0; c < now.size(); ++c)
      for (std::size_t i = 0; i < now[c].size(); ++i)
      {
        if (!(now[c][i] <= touching * _size))
          continue;
        for (const auto& there : beside)
          flat.push_back(i < there[c].size() && std::isfinite(there[c][i]) ? (there[c][i] - now[c][i]) / step : 0.0);
      }
    flat = common::gather(_problem.comm(), flat);
    std::set<std::vector<double>> rows; // many points of flat surfaces have the same
    for (std::size_t i = 0; i < flat.size(); i += _fields.size())
    {
      std::vector<double> row(flat.begin() + i, flat.begin() + i + _fields.size());
      for (double& value : row)
        value = std::round(value / slow) * slow;
      if (std::ranges::any_of(row, [](double value) { return value != 0.0; }))
        rows.insert(std::move(row));
    }
    return {rows.begin(), rows.end()};
  }

  /// Why motions that rows leave are not one translation of each body; empty if they are. Not collective.
  std::string ambiguous(const std::vector<std::vector<double>>& rows) const
  {
    const int m = int(_modes.size()), per_body = _motions.per_body(), gdim = _motions.gdim();
    const int shifts = _problem.axisymmetric ? per_body : gdim;
    std::vector<double> gram(std::size_t(m) * m, 0.0);
    for (const std::vector<double>& row : rows)
      for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j)
          gram[i * m + j] += row[i] * row[j];
    const SymmetricEigen found = symmetric_eigen(gram, m);
    std::vector<std::vector<double>> left;
    for (int k = 0; k < m && found.values[k] < slow * std::max(found.values.back(), 1.0); ++k)
      left.push_back(combined({found.vectors.begin() + k * m, found.vectors.begin() + (k + 1) * m}));
    for (int b = 0; b < _motions.num_bodies(); ++b)
    {
      std::vector<double> square(std::size_t(shifts) * shifts, 0.0);
      for (const std::vector<double>& mode : left)
      {
        const double* own = mode.data() + b * per_body;
        for (int i = 0; i < shifts; ++i)
          for (int j = 0; j < shifts; ++j)
            square[i * shifts + j] += own[i] * own[j];
        for (int i = shifts; i < per_body; ++i)
          if (std::abs(own[i]) > slow)
            return body(b) + " may turn";
      }
      const SymmetricEigen directions = symmetric_eigen(square, shifts);
      if (shifts > 1 && directions.values[shifts - 2] > slow)
        return body(b) + " may move along more than one direction";
    }
    return "";
  }
  /// Whether rows leave no motion. Not collective.
  bool held(const std::vector<std::vector<double>>& rows) const
  {
    const int m = int(_modes.size());
    std::vector<double> gram(std::size_t(m) * m, 0.0);
    for (const std::vector<double>& row : rows)
      for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j)
          gram[i * m + j] += row[i] * row[j];
    return symmetric_eigen(gram, m).values.front() > slow;
  }

  /// Move along a direction until a contact closes. Collective.
  /// @returns whether one has
  bool move(std::vector<double> direction)
  {
    const std::vector<double> here(_u.begin(), _u.end());
    // The fastest node moves by one; two bodies may move towards each other.
    const double longest = 2.0 * length(direction);
    for (double& value : direction)
      value /= longest;
    const auto at = [&](double way)
    {
      std::vector<double> q(direction);
      for (double& value : q)
        value *= way;
      go(here, q);
    };
    // Gaps that are closed at the start slide along or open.
    const std::vector<std::vector<double>> first = gaps();
    const auto nearest = [&](const std::vector<std::vector<double>>& now)
    {
      double out = std::numeric_limits<double>::infinity();
      for (std::size_t c = 0; c < now.size(); ++c)
        for (std::size_t i = 0; i < now[c].size(); ++i)
          if (i >= first[c].size() || !(first[c][i] <= touching * _size) ||
              now[c][i] < first[c][i] - touching * _size) // it closes later on after all
            out = std::min(out, now[c][i]);
      return -common::largest(_problem.comm(), -out);
    };
    double way = 0.0, gap = nearest(first), open = 0.0, closed = std::numeric_limits<double>::infinity();
    for (int part = 0; part < most_parts; ++part)
    {
      if (std::abs(gap) <= touching * _size && way > 0.0)
      {
        for (std::size_t k = 0; k < direction.size(); ++k)
          for (std::size_t i = 0; i < _way.size(); ++i)
            _way[i] += way * direction[k] * _modes[k][i];
        _last = direction;
        return true;
      }
      // No gap closes by more than the motion. What lies beyond the search distance is found within it or, as the
      // search reaches as far as bodies have moved, as overlap.
      if (gap < 0.0)
        closed = std::min(closed, way);
      else
        open = way;
      if (std::isfinite(closed))
        way = gap > 0.0 && open + gap < closed ? open + gap : 0.5 * (open + closed);
      else
        way = open + (std::isfinite(gap) ? std::max(gap, 0.5 * touching * _size) : std::max(open, 1e-3 * _size));
      if (open > 2.0 * farthest * _size || closed - open < 1e-14 * _size)
        return false;
      at(way);
      gap = nearest(gaps());
    }
    return false;
  }

  /// Overlap by as much as contacts need that act by a law, which has no force in gaps of zero. Collective.
  /// @returns whether they act
  bool press()
  {
    double step = touching * _size;
    for (int k = 0; k < deepest; ++k, step *= 2.0)
    {
      bool acts = true;
      for (enforcement::StaticContact* contact : _touching)
        if (contact->needs_line_search() && contact->smallest_gap() <= 2.0 * touching * _size)
          acts = acts && contact->num_active() > 0;
      if (acts)
        return true;
      std::vector<double> q(_last);
      for (double& value : q)
        value *= step;
      go({_u.begin(), _u.end()}, q);
      update();
    }
    return false;
  }

  /// What was moved, and which contacts are closed now. Collective.
  std::string moved()
  {
    update();
    std::vector<std::string> bodies, contacts;
    const int per_body = _motions.per_body(), gdim = _motions.gdim();
    for (int b = 0; b < _motions.num_bodies(); ++b)
    {
      std::vector<double> way(gdim, 0.0);
      std::copy_n(_way.data() + b * per_body, _problem.axisymmetric ? 1 : gdim,
                  way.begin() + (_problem.axisymmetric ? 1 : 0));
      const double far = std::sqrt(std::inner_product(way.begin(), way.end(), way.begin(), 0.0));
      if (far <= touching * _size)
        continue;
      for (double& value : way)
        value = std::round(1e6 * value / far) / 1e6 + 0.0;
      bodies.push_back(body(b) + " by " + common::text("%.4g", far) + " along (" + common::components(way) + ")");
    }
    for (const enforcement::StaticContact* contact : _touching)
      if (contact->smallest_gap() <= 2.0 * touching * _size)
        contacts.push_back(contact->name());
    return "bodies that were apart are brought together before the solve: " + common::joined(bodies, ", ") +
           "; closed now: " + common::joined(contacts, ", ");
  }
  /// Names of bodies that a direction moves. Not collective.
  std::string movers(const std::vector<double>& direction) const
  {
    std::vector<std::string> out;
    const std::vector<double> mode = combined(direction);
    const int per_body = _motions.per_body();
    const double all = std::sqrt(std::inner_product(mode.begin(), mode.end(), mode.begin(), 0.0));
    for (int b = 0; b < _motions.num_bodies(); ++b)
      if (std::any_of(mode.begin() + b * per_body, mode.begin() + (b + 1) * per_body,
                      [&](double value) { return std::abs(value) > slow * all; }))
        out.push_back(body(b));
    return common::joined(out, ", ");
  }
  /// Whether a direction turns a body. Not collective.
  bool turns(const std::vector<double>& direction) const
  {
    const std::vector<double> mode = combined(direction);
    const int per_body = _motions.per_body(), shifts = _problem.axisymmetric ? per_body : _motions.gdim();
    const double all = std::sqrt(std::inner_product(mode.begin(), mode.end(), mode.begin(), 0.0));
    for (int k = 0; k < _motions.num_modes(); ++k)
      if (k % per_body >= shifts && std::abs(mode[k]) > slow * all)
        return true;
    return false;
  }

  /// Contacts are as they were, but for those that bodies have left. Collective.
  void release()
  {
    restore_contacts();
    for (const auto& contact : _problem.contacts)
      if (enforcement::MortarContact* mortar = contact->mortar())
      {
        mortar->begin_step(_u, mortar->displacement());
        mortar->update_gap(_u);
        mortar->open_apart();
      }
  }
  /// Everything is as it was. Not collective.
  void restore()
  {
    std::ranges::copy(_start, _u.begin());
    restore_contacts();
  }
  bool apart()
  {
    for (const enforcement::StaticContact* contact : _touching)
      if (contact->smallest_gap() > touching * _size)
        return true;
    return false;
  }

private:
  void restore_contacts()
  {
    for (std::size_t k = 0; k < _saved.size(); ++k)
      _problem.contacts[k]->state().assign(_saved[k]);
  }
  std::string body(int b) const
  {
    const int gdim = _motions.gdim();
    return "the body around (" + common::components(_motions.centres().subspan(b * gdim, gdim)) + ")";
  }
  std::vector<double> combined(const std::vector<double>& q) const
  {
    std::vector<double> out(_motions.num_modes(), 0.0);
    for (std::size_t k = 0; k < q.size(); ++k)
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += q[k] * _modes[k][i];
    return out;
  }
  double length(const std::vector<double>& q) const
  {
    const std::size_t gdim = _motions.gdim();
    double out = 0.0;
    for (std::size_t i = 0; i < _fields.front().size(); i += gdim)
    {
      double squares = 0.0;
      for (std::size_t c = 0; c < gdim; ++c)
      {
        double value = 0.0;
        for (std::size_t k = 0; k < q.size(); ++k)
          value += q[k] * _fields[k][i + c];
        squares += value * value;
      }
      out = std::max(out, std::sqrt(squares));
    }
    return common::largest(_problem.comm(), out);
  }
  void go(const std::vector<double>& from, const std::vector<double>& q)
  {
    std::ranges::copy(from, _u.begin());
    for (std::size_t k = 0; k < q.size(); ++k)
      for (std::size_t i = 0; i < _fields[k].size(); ++i)
        _u[i] += q[k] * _fields[k][i];
    _problem.u->x()->scatter_fwd();
  }
  void update()
  {
    for (const auto& contact : _problem.contacts)
    {
      contact->update_gap(_u);
      contact->update_active_set(true);
    }
  }
  std::vector<std::vector<double>> gaps()
  {
    std::vector<std::vector<double>> out;
    for (enforcement::StaticContact* contact : _touching)
    {
      contact->update_gap(_u);
      out.push_back(contact->gap());
    }
    return out;
  }

  const EquilibriumProblem& _problem;
  double _size;
  std::span<double> _u;
  std::vector<double> _start;
  operators::RigidBodyModes _motions;
  std::vector<state::State> _saved;
  std::vector<enforcement::StaticContact*> _touching;
  std::vector<std::vector<double>> _modes, _fields;
  std::vector<double> _way, _last;
};
} // namespace

Approach bring_together(const EquilibriumProblem& p)
{
  const auto& dofmap = *p.space().dofmap();
  if (p.contacts.empty() || p.body->properties().has_inertia || !p.fields.empty() ||
      dofmap.index_map_bs() != int(p.space().mesh()->geometry().dim()))
    return {};
  FreeBodies bodies(p);
  const auto give_up = [&](const std::string& why)
  {
    bodies.restore();
    return Approach{"", why};
  };
  if (!bodies.any() || !bodies.apart())
    return give_up("");
  bool moved = false;
  for (int k = 0; k < most_motions; ++k)
  {
    const std::vector<std::vector<double>> rows = bodies.closed_gaps();
    const std::vector<double> forces = bodies.loads();
    std::vector<double> opposite(forces);
    for (double& f : opposite)
      f = -f;
    const std::vector<double> bearing = nonnegative_least_squares(rows, opposite);
    std::vector<double> direction(forces);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < direction.size(); ++j)
        direction[j] += bearing[i] * rows[i][j];
    const auto norm = [](const std::vector<double>& v)
    { return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0)); };
    if (norm(direction) <= slow * norm(forces)) // the contacts bear the loads, or there are none
    {
      if (!moved)
        return give_up(norm(forces) == 0.0 && !bodies.held(rows) ? "no load moves what is free" : "");
      if (!bodies.held(rows))
        return give_up("bodies would touch, and still be free to move where no load does");
      if (!bodies.press())
        return give_up("bodies would touch where the law of the interface does not act");
      Approach out{bodies.moved(), ""};
      bodies.release();
      return out;
    }
    if (bodies.turns(direction))
      return give_up("the loads turn " + bodies.movers(direction));
    std::vector<std::vector<double>> along; // closed gaps that stay so
    for (const std::vector<double>& row : rows)
      if (std::abs(std::inner_product(row.begin(), row.end(), direction.begin(), 0.0)) <= 10 * slow * norm(direction))
        along.push_back(row);
    if (const std::string why = bodies.ambiguous(along); !why.empty())
      return give_up(why);
    if (!bodies.move(direction))
      return give_up("along the loads " + bodies.movers(direction) + " meets nothing that bears it");
    moved = true;
  }
  return give_up("bodies would go from one contact to the next without an end");
}
} // namespace dolfinx_impact::solve
