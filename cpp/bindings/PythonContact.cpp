// SPDX-License-Identifier: MIT
#include "PythonContact.h"
#include "dolfinx_impact/enforcement/mortar/MortarContact.h"
#include "petsc_objects.h"
#include <algorithm>
#include <limits>

namespace dolfinx_impact::bindings
{
namespace
{
/// Entries of an array of any shape.
template <typename To, typename From = To>
std::vector<To> entries(const nb::handle& value)
{
  const auto array = nb::cast<nb::ndarray<const From, nb::c_contig, nb::device::cpu>>(value);
  return {array.data(), array.data() + array.size()};
}

auto array(std::span<const double> values)
{
  return take(std::vector<double>(values.begin(), values.end()));
}

auto rows(std::span<const double> values, std::size_t num)
{
  return take(std::vector<double>(values.begin(), values.end()), {num, num > 0 ? values.size() / num : 0});
}

auto mask(std::span<const std::int8_t> values)
{
  auto* out = new bool[values.size()];
  std::copy(values.begin(), values.end(), out);
  nb::capsule owner(out, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  const std::size_t shape[] = {values.size()};
  return nb::ndarray<nb::numpy, bool>(out, 1, shape, owner);
}

} // namespace

PythonContact::PythonContact(const nb::object& contact)
    : _contact(contact), _name(nb::cast<std::string>(contact.attr("pair").attr("name"))),
      _has_multipliers(nb::cast<bool>(contact.attr("has_multipliers"))),
      _has_friction(nb::cast<double>(contact.attr("pair").attr("friction")) > 0.0)
{
}

nb::object PythonContact::contact() const
{
  nb::object found = _contact();
  if (found.is_none())
    throw std::runtime_error("the contact " + _name + " is gone, with its problem");
  return found;
}

enforcement::MortarContact* PythonContact::mortar()
{
  return _has_multipliers ? nb::cast<enforcement::MortarContact*>(contact().attr("_cpp_object")) : nullptr;
}

void PythonContact::check_parameters()
{
  contact().attr("check_parameters")();
}

std::vector<double> PythonContact::numbers_of(const char* attribute) const
{
  return entries<double>(contact().attr(attribute));
}

std::string PythonContact::fault() const
{
  return nb::cast<std::string>(contact().attr("fault"));
}

std::optional<std::array<double, 3>> PythonContact::displacement() const
{
  if (!nb::cast<bool>(contact().attr("pair").attr("rigid")))
    return {};
  const std::vector<double> values = numbers_of("displacement");
  return std::array{values[0], values[1], values[2]};
}

void PythonContact::begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                               std::span<const double> target)
{
  nb::object place = displacement ? nb::cast(array(*displacement)) : nb::none();
  nb::object goal = target.empty() ? nb::none() : nb::cast(array(target));
  contact().attr("begin_step")(array(u), place, goal);
}

state::State PythonContact::state()
{
  return nb::cast<state::State>(contact().attr("state")());
}

state::State PythonContact::saved_state()
{
  return nb::cast<state::State>(contact().attr("saved_state")());
}

void PythonContact::resume(const state::State& saved, std::span<const double> u)
{
  contact().attr("resume")(saved, array(u));
}

void PythonContact::accept_step()
{
  contact().attr("accept_step")();
}

bool PythonContact::augment()
{
  return nb::cast<bool>(contact().attr("augment")());
}

std::string PythonContact::prescribed_overlap()
{
  return nb::cast<std::string>(contact().attr("prescribed_overlap")());
}

std::string PythonContact::passed_through()
{
  return nb::cast<std::string>(contact().attr("passed_through")());
}

void PythonContact::update_gap(std::span<const double> u)
{
  contact().attr("update_gap")(array(u));
}

int PythonContact::update_active_set(bool first, std::optional<std::int64_t> last)
{
  return nb::cast<int>(contact().attr("update_active_set")(first, last ? nb::object(nb::int_(*last)) : nb::none()));
}

std::vector<double> PythonContact::contact_forces() const
{
  return entries<double>(contact().attr("contact_forces")());
}

void PythonContact::add_residual(Vec b) const
{
  contact().attr("add_residual")(nb::cast(b, nb::rv_policy::reference));
}

void PythonContact::update_nodal_stiffness(Mat K)
{
  contact().attr("update_nodal_stiffness")(nb::cast(K, nb::rv_policy::reference));
}

Mat PythonContact::tangent()
{
  _kept = contact().attr("tangent")();
  return _kept.is_none() ? nullptr : as_petsc<Mat>(_kept);
}

void PythonContact::set_convex(bool convex)
{
  contact().attr("convex") = convex;
}

bool PythonContact::symmetric() const
{
  return nb::cast<bool>(contact().attr("symmetric"));
}

std::int64_t PythonContact::num_active() const
{
  return nb::cast<std::int64_t>(contact().attr("num_active"));
}

double PythonContact::violation() const
{
  return nb::cast<double>(contact().attr("violation")());
}

double PythonContact::round_off() const
{
  return nb::cast<double>(contact().attr("round_off")());
}

std::string PythonContact::largest_violation() const
{
  return nb::cast<std::string>(contact().attr("largest_violation")());
}

std::string PythonContact::mesh_advice() const
{
  return nb::cast<std::string>(contact().attr("mesh_advice")());
}

double PythonContact::smallest_gap() const
{
  double least = std::numeric_limits<double>::infinity();
  for (double gap : numbers_of("gap"))
    least = std::min(least, gap);
  const nb::module_ mpi = nb::module_::import_("mpi4py.MPI");
  return nb::cast<double>(contact().attr("comm").attr("allreduce")(least, mpi.attr("MIN")));
}

void PythonContact::forget()
{
  contact().attr("forget")();
}

std::vector<double> PythonContact::rigid_body_products(const operators::RigidBodyModes& modes) const
{
  return entries<double>(contact().attr("rigid_body_products")(nb::cast(&modes, nb::rv_policy::reference)));
}

bool PythonContact::close_nearest()
{
  return nb::cast<bool>(contact().attr("close_nearest")());
}

std::vector<double> PythonContact::closing_forces() const
{
  const nb::object forces = contact().attr("closing_forces")();
  return forces.is_none() ? std::vector<double>() : entries<double>(forces);
}

std::vector<enforcement::ContactStatus> PythonContact::status() const
{
  std::vector<enforcement::ContactStatus> out;
  for (std::int64_t number : nb::cast<std::vector<std::int64_t>>(contact().attr("status").attr("tolist")()))
    out.push_back(enforcement::ContactStatus(number));
  return out;
}

std::vector<double> PythonContact::covered() const
{
  return entries<double>(contact().attr("covered")());
}

std::optional<std::array<double, 3>> PythonContact::force() const
{
  const nb::object force = contact().attr("force");
  if (force.is_none())
    return {};
  std::array<double, 3> out{};
  std::ranges::copy(entries<double>(force), out.begin());
  return out;
}

double PythonContact::dissipated() const
{
  return nb::cast<double>(contact().attr("dissipated"));
}

double PythonContact::stored_energy() const
{
  return nb::cast<double>(contact().attr("stored_energy")());
}

// --- multipliers
// ------------------------------------------------------------------------------------------------------

std::span<const std::int32_t> PythonContact::nodes() const
{
  if (_nodes.empty()) // they stay as they are
    _nodes = entries<std::int32_t>(contact().attr("nodes"));
  return _nodes;
}

std::span<const std::int64_t> PythonContact::numbers() const
{
  if (_numbers.empty())
    _numbers = entries<std::int64_t>(contact().attr("numbers"));
  return _numbers;
}

std::span<const std::int8_t> PythonContact::active() const
{
  _active = entries<std::int8_t, bool>(contact().attr("active"));
  return _active;
}

std::span<const std::int8_t> PythonContact::sliding() const
{
  _sliding = entries<std::int8_t, bool>(contact().attr("sliding"));
  return _sliding;
}

std::span<const double> PythonContact::multiplier() const
{
  _multiplier = numbers_of("multiplier");
  return _multiplier;
}

std::int64_t PythonContact::last_change() const
{
  return nb::cast<std::int64_t>(contact().attr("last_change"));
}

void PythonContact::update_multipliers(std::span<const double> residual)
{
  contact().attr("update_multipliers")(array(residual));
}

double PythonContact::gap_round_off() const
{
  return nb::cast<double>(contact().attr("gap_round_off")());
}

enforcement::Constraints PythonContact::constraints()
{
  return nb::cast<enforcement::Constraints>(contact().attr("constraints")());
}

std::optional<std::pair<Mat, std::vector<double>>> PythonContact::friction_springs()
{
  const nb::object found = contact().attr("friction_springs")();
  if (found.is_none())
    return {};
  Mat matrix = as_petsc<Mat>(found[0]);
  PetscObjectReference(PetscObject(matrix)); // the caller's own
  return std::pair{matrix, entries<double>(found[1])};
}

std::vector<double> PythonContact::imposed_friction_forces() const
{
  const nb::object forces = contact().attr("imposed_friction_forces")();
  return forces.is_none() ? std::vector<double>() : entries<double>(forces);
}

void PythonContact::update_linearised_gap(std::span<const double> increments)
{
  contact().attr("update_linearised_gap")(array(increments));
}

std::pair<std::vector<double>, std::vector<double>>
PythonContact::linearised_response(std::span<const double> increments, std::span<const double> forces) const
{
  const nb::object found = contact().attr("linearised_response")(array(increments), array(forces));
  return {entries<double>(found[0]), entries<double>(found[1])};
}

void PythonContact::correct_linearisation(std::span<const double> u)
{
  contact().attr("correct_linearisation")(array(u));
}

void PythonContact::set_multipliers(std::span<const double> forces)
{
  contact().attr("set_multipliers")(rows(forces, nodes().size()));
}

std::int64_t PythonContact::num_turning() const
{
  return nb::cast<std::int64_t>(contact().attr("num_turning")());
}

void PythonContact::set_redundant(std::span<const std::int32_t> redundant)
{
  contact().attr("set_redundant")(take(std::vector<std::int32_t>(redundant.begin(), redundant.end())));
}

std::vector<std::int32_t> PythonContact::over_constrained() const
{
  return entries<std::int32_t>(contact().attr("over_constrained")());
}

void PythonContact::rotate_friction_traction()
{
  contact().attr("rotate_friction_traction")();
}

std::vector<double> PythonContact::unit_gap(std::int64_t number) const
{
  return entries<double>(contact().attr("unit_gap")(number));
}

std::vector<double> PythonContact::unit_force(std::int64_t number) const
{
  return entries<double>(contact().attr("unit_force")(number));
}

std::span<const double> PythonContact::linearised_gap() const
{
  _linearised_gap = numbers_of("linearised_gap");
  return _linearised_gap;
}

void PythonContact::set_linearised(std::span<const std::int8_t> active, std::span<const double> gap,
                                   std::span<const double> multiplier)
{
  contact().attr("active") = mask(active);
  contact().attr("linearised_gap") = array(gap);
  contact().attr("multiplier") = array(multiplier);
}
} // namespace dolfinx_impact::bindings
