#include "CentralDifference.h"
#include <algorithm>
#include <numeric>
#include <utility>

// Nodes in contact: their numbers, what belongs to them, kinematic contact.
namespace impact::integrators
{
void CentralDifference::search()
{
  ++_num_searches;
  const auto own = _V->dofmap()->index_map;
  std::vector<std::pair<std::int64_t, int>> found;
  const std::span<const std::int64_t> ghosts = own->ghosts();
  std::vector<std::int64_t> known(ghosts.begin(), ghosts.end());
  std::sort(known.begin(), known.end());
  std::vector<double> du(_v.begin(), _v.begin() + _owned);
  for (double& value : du)
    value *= _last_step > 0.0 ? _last_step : _contact_step;
  for (Contact& c : _contacts)
  {
    c.contact->search({_u.data(), _owned}, du);
    const auto nodes = c.contact->remote_nodes();
    for (std::size_t k = 0; k < nodes.size(); ++k)
      if (!std::binary_search(known.begin(), known.end(), nodes[k]))
        found.emplace_back(nodes[k], c.contact->remote_owners()[k]);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<std::int64_t> nodes(ghosts.begin(), ghosts.end());
  std::vector<int> owners(own->owners().begin(), own->owners().end());
  for (const auto& [node, owner] : found)
  {
    nodes.push_back(node);
    owners.push_back(owner);
  }
  resize(std::make_shared<const dolfinx::common::IndexMap>(own->comm(), own->size_local(), nodes, owners));
  for (std::vector<double>* values : {&_u, &_v, &_mass, &_inverse})
    _halo->forward(values->data(), _bs);
  number_contacts();
  _search_due = false;
}

/// Numbers of the nodes that contacts need: those this rank owns first, then ghosts.
void CentralDifference::number_contacts()
{
  const std::vector<double> kept = kept_forces();
  _near.kept.clear();
  _touched.clear();
  for (Contact& c : _contacts)
  {
    const auto nodes = c.contact->needs(*_halo);
    _touched.insert(_touched.end(), nodes.begin(), nodes.end());
  }
  const std::int32_t owned = _halo->num_owned();
  if (_kinematic) // corrections reach all who have the node as a ghost
  {
    std::vector<double> corrected(_halo->num_nodes(), 0.0);
    for (std::int32_t node : _touched)
      corrected[node] = 1.0;
    _halo->forward(corrected.data(), 1);
    for (std::int32_t node = owned; node < _halo->num_nodes(); ++node)
      if (corrected[node] > 0.0)
        _touched.push_back(node);
  }
  std::sort(_touched.begin(), _touched.end());
  _touched.erase(std::unique(_touched.begin(), _touched.end()), _touched.end());
  const std::int64_t own = std::lower_bound(_touched.begin(), _touched.end(), owned) - _touched.begin();
  // Global numbers, from the owners to those who have the nodes as ghosts.
  const auto& map = _halo->map();
  std::int64_t first = 0;
  dolfinx::MPI::check_error(map.comm(), MPI_Exscan(&own, &first, 1, MPI_INT64_T, MPI_SUM, map.comm()));
  if (dolfinx::MPI::rank(map.comm()) == 0)
    first = 0; // MPI leaves it undefined there
  std::vector<std::int32_t> numbers(_halo->num_nodes(), -1);
  std::vector<double> global(_halo->num_nodes(), -1.0), mass(_touched.size());
  for (std::size_t k = 0; k < _touched.size(); ++k)
  {
    numbers[_touched[k]] = std::int32_t(k);
    mass[k] = _mass[std::size_t(_touched[k]) * _bs];
    global[_touched[k]] = double(first + std::int64_t(k));
  }
  _halo->forward(global.data(), 1);
  std::vector<std::int64_t> ghosts;
  std::vector<int> owners;
  for (std::size_t k = own; k < _touched.size(); ++k)
  {
    ghosts.push_back(std::int64_t(global[_touched[k]]));
    owners.push_back(map.owners()[_touched[k] - owned]);
  }
  if (_near.halo)
    _traffic += _near.halo->traffic();
  _near.halo = std::make_unique<Halo>(
      std::make_shared<const dolfinx::common::IndexMap>(map.comm(), std::int32_t(own), ghosts, owners));
  const std::size_t size = _touched.size() * _bs;
  for (std::vector<double>* values : {&_near.u, &_near.du})
    values->assign(size, 0.0);
  for (std::vector<double>* values : {&_near.v, &_near.du_before})
    values->assign(_kinematic ? size : 0, 0.0);
  _near.before.assign(_kinematic ? 2 * size : 0, 0.0);
  _near.inverse.resize(size);
  for (std::size_t k = 0; k < _touched.size(); ++k)
    std::copy_n(_inverse.data() + std::size_t(_touched[k]) * _bs, _bs, _near.inverse.data() + k * _bs);
  take_forces(kept);
  for (Contact& c : _contacts)
    c.contact->number(*_near.halo, numbers, mass.data());
}

CentralDifference::Part* CentralDifference::springs()
{
  const auto found =
      std::find_if(_parts.begin(), _parts.end(), [](const Part& p) { return p.account == Account::contact; });
  return found == _parts.end() ? nullptr : &*found;
}

/// Contact forces of the last step, with their nodes' owners: of springs on owned degrees of freedom, then kinematic
/// ones. Collective.
std::vector<double> CentralDifference::kept_forces()
{
  if (!_near.kept.empty())
    return _near.kept;
  std::vector<double> out(2 * _owned, 0.0);
  const auto spread = [&](const std::vector<double>& values, double* to)
  {
    for (std::size_t k = 0; k < std::min(_touched.size(), values.size() / _bs); ++k)
      if (std::size_t i = std::size_t(_touched[k]) * _bs; i < _owned)
        std::copy_n(values.data() + k * _bs, _bs, to + i);
  };
  if (const Part* part = springs(); part && _near.halo)
  {
    std::vector<double> sums = part->force;
    _near.halo->reverse(sums.data(), _bs);
    spread(sums, out.data());
  }
  spread(_near.force, out.data() + _owned);
  return out;
}

void CentralDifference::take_forces(const std::vector<double>& forces)
{
  const auto take = [&](std::vector<double>& values, const double* from)
  {
    values.assign(_touched.size() * _bs, 0.0);
    for (std::size_t k = 0; k < _touched.size(); ++k)
      if (std::size_t i = std::size_t(_touched[k]) * _bs; i < _owned)
        std::copy_n(from + i, _bs, values.data() + k * _bs);
  };
  if (Part* part = springs())
    take(part->force, forces.data());
  take(_near.force, forces.data() + _owned);
}

/// Displacements and increments of the last step, velocities for kinematic contact.
/// @param[in,out] springs the forces of the last time level, or null; on return zero
/// @returns their work in these increments
double CentralDifference::gather(Part* springs)
{
  const auto sweep = [&]<int D, bool kinematic>()
  {
    double work[D] = {};
    for (std::size_t k = 0; k < _touched.size(); ++k)
      for (int c = 0; c < D; ++c)
      {
        const std::size_t i = std::size_t(_touched[k]) * D + c, n = k * D + c;
        _near.u[n] = _u[i];
        _near.du[n] = _last_step * _v[i];
        if constexpr (kinematic)
          _near.v[n] = _v[i];
        if (springs)
          work[c] += std::exchange(springs->force[n], 0.0) * _near.du[n];
      }
    return std::accumulate(work, work + D, 0.0);
  };
  if (_kinematic)
    return _bs == 2 ? sweep.operator()<2, true>() : sweep.operator()<3, true>();
  return _bs == 2 ? sweep.operator()<2, false>() : sweep.operator()<3, false>();
}

Halo::Traffic CentralDifference::traffic() const
{
  Halo::Traffic out = _traffic;
  out += _halo->traffic();
  if (_near.halo)
    out += _near.halo->traffic();
  return out;
}

void CentralDifference::look()
{
  for (Contact& c : _contacts)
    c.contact->look(_near.u.data());
}

void CentralDifference::move_obstacles(const double* amplitudes, bool first)
{
  for (Contact& c : _contacts)
  {
    if (c.columns[0] < 0)
      continue;
    std::array<double, 3> place{};
    for (int k = 0; k < 3; ++k)
      place[k] = amplitudes[c.columns[k]];
    c.moved_before = c.moved;
    for (int k = 0; k < 3; ++k)
      c.moved[k] = first ? 0.0 : place[k] - c.place[k];
    c.place = place;
    c.contact->set_obstacle(place, c.moved);
  }
}

void CentralDifference::kinematic_contact(double dt, double h, Sums& sums)
{
  _pending = true;
  _halo->forward_begin(_u.data(), _bs);
  std::swap(_last_step, dt); // ghosts' velocities are those of the new step
  receive();
  std::swap(_last_step, dt);
  const Stopwatch watch(_contact_seconds);
  const std::size_t size = _touched.size() * _bs;
  gather(nullptr);
  for (std::size_t n = 0; n < size; ++n)
  {
    _near.du[n] = dt * _near.v[n];
    _near.du_before[n] = _last_step * _near.before[2 * n];
    _near.force[n] = 0.0;
  }
  for (Contact& c : _contacts)
    if (c.contact->kinematic())
    {
      c.contact->correct(_near.u.data(), _near.du.data(), _near.du_before.data(), _near.inverse.data(), h * dt, dt,
                         _release_share, _near.force.data());
      for (int k = 0; k < _bs; ++k)
        _obstacle_work += 0.5 * c.moved_before[k] * c.contact->force()[k];
    }
  for (std::size_t k = 0; k < _touched.size(); ++k)
    for (int c = 0; c < _bs; ++c)
      _u[std::size_t(_touched[k]) * _bs + c] = _near.u[k * _bs + c];
  for (std::size_t i = _owned; i < _u.size(); ++i) // receive() has seen the prediction only
    _v[i] = (_u[i] - _old_ghosts[i - _owned]) / dt;
  const std::size_t owned = _near.halo->num_owned();
  for (std::size_t k = 0; k < owned; ++k)
    for (int c = 0; c < _bs; ++c)
    {
      const std::size_t n = k * _bs + c, i = std::size_t(_touched[k]) * _bs + c;
      if (_near.inverse[n] == 0.0)
        continue;
      const double old = _near.before[2 * n], r = _near.before[2 * n + 1], predicted = _near.v[n], f = _near.force[n];
      const double v = predicted + h * _near.inverse[n] * f, m = 1.0 / _near.inverse[n], load = load_at(i);
      _v[i] = v;
      sums.momentum += m * old * (v - predicted);
      sums.speed += m * (v * v - predicted * predicted);
      sums.after += r * (v - predicted);
      sums.load_after += load * (v - predicted);
    }
}
} // namespace impact::integrators
