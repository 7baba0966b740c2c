// SPDX-License-Identifier: MIT
#include "explicit.h"
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <stdexcept>

namespace impact_reference
{
namespace
{
void check(const Model& model, const ExplicitData& d)
{
  const auto n = model.num_dofs();
  const auto need = [](bool good, const std::string& what)
  {
    if (not good)
      throw std::invalid_argument(what);
  };
  need(d.steps.size() > 0, "an explicit analysis needs at least one step");
  for (std::int64_t k = 0; k < d.steps.size(); ++k)
    need(d.steps(k) > 0 and std::isfinite(d.steps(k)), "step " + std::to_string(k) + " is not positive and finite");
  need(d.u0.size() == n and d.v0.size() == n and d.u0.allFinite() and d.v0.allFinite(),
       "u0 and v0 need " + std::to_string(n) + " finite values");
  need(d.values.rows() == d.steps.size() + 2 and d.values.cols() == std::int64_t(d.fixed_dofs.size()) and
           d.values.allFinite(),
       "prescribed values need one finite row per time level and one column per degree of freedom");
  for (auto dof : d.fixed_dofs)
    need(dof >= 0 and dof < n, "prescribed degree of freedom " + std::to_string(dof) + " is out of range");
  need(d.loads.rows() == d.amplitudes.cols() and (d.loads.rows() == 0 or d.loads.cols() == n) and
           d.amplitudes.rows() == d.steps.size() + 1 and d.loads.allFinite() and d.amplitudes.allFinite(),
       "loads need " + std::to_string(n) + " finite values and a finite amplitude per time level");
  need(d.alpha >= 0 and d.beta >= 0 and d.b1 >= 0 and d.b2 >= 0, "damping and viscosity must not be negative");
  need(d.every > 0, "every must be 1 or more");
  need(not d.plastic or d.beta == 0, "damping by the stiffness goes with elastic bodies: leave out beta");
  need(not d.plastic or &d.plastic->model() == &model, "the plastic body belongs to another model");
  if (d.classical)
  {
    need(d.beta == 0, "scheme 'classical' needs a diagonal damping matrix: leave out beta or use 'half_step'");
    need(d.steps.maxCoeff() - d.steps.minCoeff() <= 1e-12 * d.steps(0),
         "scheme 'classical' needs equal steps: use 'half_step'");
  }
}

// Forces at t_n, as they stand on the right-hand side.
struct Forces
{
  Vector internal, external, damping, viscosity, contact, support;
};

// Where a step leads.
struct Advance
{
  Vector next;          // u_(n+1)
  Vector before, after; // velocities half a step before and after t_n
  Vector v, a;          // at t_n
};

class Run
{
public:
  Run(const Model& model, const ExplicitData& data)
      : model_(model), data_(data), num_(model.num_dofs()), mass_(model.lumped_mass(data.mass_rule, data.lumping)),
        inverse_(mass_.cwiseInverse()), prescribed_(num_, false), energies_(Vector::Zero(num_energies))
  {
    if (not(mass_.minCoeff() > 0))
      throw std::invalid_argument("a nodal mass is not positive: choose the lumping scheme hrz or auto");
    for (auto dof : data.fixed_dofs)
    {
      inverse_(dof) = 0;
      prescribed_[dof] = true;
    }
    if (model.linear() and data.beta > 0)
      stiffness_ = model.elastic_tangent(data.rule, Vector::Zero(num_));
    last_answers_.resize(data.contacts.size());
  }

  ExplicitHistory run()
  {
    const int count = int(data_.steps.size());
    ExplicitHistory out = room(count / data_.every + 1 + (count % data_.every != 0));
    std::int64_t row = 0;
    double time = 0, dt_before = 0;
    // v_0 stands for v_(-1/2), and zero for the step before the first: then (3.72) is (3.76).
    Vector u = data_.u0, u_before = u, half = data_.v0;
    for (int n = 0; n <= count; ++n)
    {
      const double dt = data_.steps(std::min(n, count - 1));
      const Vector moved = u - u_before;
      Forces f = forces(n, dt, u, moved, half);
      const Advance step =
          data_.classical ? classical(n, dt, u, u_before, moved, f) : half_step(n, dt_before, dt, u, moved, half, f);
      if (not step.next.allFinite())
        throw std::runtime_error("the displacements overflow in step " + std::to_string(n) +
                                 ": the step is longer than the stable one");
      for (auto* contact : data_.contacts)
        if (RigidBall* ball = contact->ball())
          ball->push((dt_before + dt) / 2, n == 0);
      update_energies(n, u, moved, step, f);
      if (n % data_.every == 0 or n == count)
        keep(out, row++, time, u, step, f);
      for (auto* contact : data_.contacts)
        if (RigidBall* ball = contact->ball())
          ball->move(dt);
      time += dt;
      u_before = u;
      u = step.next;
      half = step.after;
      dt_before = dt;
    }
    return out;
  }

private:
  Vector internal_force(const Vector& u)
  {
    if (not data_.plastic)
      return model_.internal_force(data_.rule, u);
    const PlasticBody::Trial trial = data_.plastic->evaluate(u, false);
    data_.plastic->commit(trial);
    const Vector springs = model_.springs().dot(u);
    stored_ = trial.energy + springs.dot(u) / 2;
    return trial.force + springs;
  }

  Forces forces(int n, double dt, const Vector& u, const Vector& moved, const Vector& half)
  {
    const Vector zero = Vector::Zero(num_);
    Forces f{-internal_force(u), zero, zero, zero, zero, zero};
    for (Eigen::Index k = 0; k < data_.loads.rows(); ++k)
      f.external += data_.amplitudes(n, k) * data_.loads.row(k).transpose();
    if (data_.b1 > 0 or data_.b2 > 0)
      f.viscosity = -model_.viscous_force(data_.rule, u, half, data_.b1, data_.b2,
                                          data_.plastic and data_.plastic->finite_strain());
    f.damping = -data_.alpha * mass_.cwiseProduct(half);
    if (data_.beta > 0)
      f.damping -= data_.beta * (model_.linear() ? stiffness_ : model_.elastic_tangent(data_.rule, u)).dot(half);
    if (model_.on_foundation())
      f.damping -= model_.dashpots().dot(half);
    for (auto* contact : data_.contacts)
      if (not contact->kinematic())
      {
        if (RigidBall* ball = contact->ball())
          ball->clear();
        contact->before({n, dt, dt * dt, u, moved, inverse_});
        f.contact += contact->answer().force;
      }
    return f;
  }

  // Gives the prescribed degrees of freedom their place at t_(n+1).
  void prescribe(int n, Vector& next) const
  {
    for (std::size_t k = 0; k < data_.fixed_dofs.size(); ++k)
      next(data_.fixed_dofs[k]) = data_.values(n + 1, Eigen::Index(k));
  }

  // Step n with the share of absorbed energy that kinematic contacts may return: never more than their total.
  ContactStep contact_step(int n, double dt, double h, const Vector& u, const Vector& moved) const
  {
    double absorbed = 0, recoverable = 0;
    for (const auto* contact : data_.contacts)
    {
      absorbed += contact->absorbed();
      recoverable += contact->recoverable();
    }
    const double share = recoverable > 0 ? std::min(1.0, std::max(0.0, absorbed) / recoverable) : 0;
    return {n, dt, h, u, moved, inverse_, share};
  }

  // Forces of kinematic contact at a prediction, which they move.
  Vector kinematic_forces(const ContactStep& step, Vector& predicted)
  {
    KinematicWeights weights;
    int sweeps = 0;
    for (auto* contact : data_.contacts)
    {
      contact->close(step, predicted, weights);
      sweeps = std::max(sweeps, contact->sweeps());
    }
    for (const auto& [node, sum] : weights.sums)
      weights.in_sweeps[node] = weights.num_surfaces[node] > 1 ? largest_in_one_direction(node, sum, weights) : sum;
    for (auto* contact : data_.contacts)
      contact->respond(step, predicted, weights);
    const auto pushed = [&]
    {
      Vector force = Vector::Zero(num_);
      for (const auto* contact : data_.contacts)
        contact->push(step, force);
      return force;
    };
    for (int number = 0; number < sweeps; ++number)
    {
      // The first sweep does not see what the nodes that leave bring.
      const Vector moved = number == 0 ? Vector(Vector::Zero(num_)) : Vector(step.h * inverse_.cwiseProduct(pushed()));
      for (auto* contact : data_.contacts)
        contact->sweep(step, moved, number);
    }
    const Vector force = pushed(), moved = step.h * inverse_.cwiseProduct(force);
    for (auto* contact : data_.contacts)
      contact->conclude(step, moved);
    predicted += moved;
    return force;
  }

  // Of what weighs on a node, all that can add up in one direction; the sum itself where components are prescribed.
  double largest_in_one_direction(std::int64_t node, double sum, const KinematicWeights& weights) const
  {
    const int d = model_.gdim();
    for (int k = 0; k < d; ++k)
      if (inverse_(d * node + k) == 0)
        return sum;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(weights.directions.at(node), Eigen::EigenvaluesOnly);
    return solver.eigenvalues().maxCoeff();
  }

  void update_contacts(const ContactStep& step, const Vector& next)
  {
    for (auto* contact : data_.contacts)
      contact->corrected(step, next);
  }

  // (3.72)-(3.77); dt_before = 0 in the first step.
  Advance half_step(int n, double dt_before, double dt, const Vector& u, const Vector& moved, const Vector& half,
                    Forces& f)
  {
    const double mean = (dt_before + dt) / 2;
    Vector sum = f.internal + f.external + f.damping + f.viscosity + f.contact;
    Vector after = half + mean * inverse_.cwiseProduct(sum);
    Vector next = u + dt * after;
    prescribe(n, next);
    const ContactStep step = contact_step(n, dt, mean * dt, u, moved);
    const Vector kinematic = kinematic_forces(step, next);
    f.contact += kinematic;
    sum += kinematic;
    after += mean * inverse_.cwiseProduct(kinematic);
    for (std::int64_t i = 0; i < num_; ++i)
      if (prescribed_[i])
      {
        after(i) = (next(i) - u(i)) / dt;
        f.support(i) = mass_(i) * (after(i) - half(i)) / mean - sum(i);
      }
      else
        next(i) = u(i) + dt * after(i);
    update_contacts(step, next);
    const Vector a = (after - half) / mean;
    return {next, n == 0 ? Vector(2 * data_.v0 - after) : half, after, half + dt_before / 2 * a, a};
  }

  // (3.68)-(3.71) in displacements; u_before is u_(n-1), which the first step makes itself.
  Advance classical(int n, double dt, const Vector& u, const Vector& u_before, const Vector& moved, Forces& f)
  {
    const Vector damping = data_.alpha * mass_; // the diagonal of C
    const Vector effective = mass_ + dt / 2 * damping;
    Vector sum = f.internal + f.external + f.viscosity + f.contact;
    Vector before = u_before, next;
    const ContactStep step = contact_step(n, dt, n == 0 ? dt * dt / 2 : dt * dt / (1 + dt / 2 * data_.alpha), u, moved);
    if (n == 0)
    {
      // (3.71), and where prescribed the acceleration that leads to the prescribed place.
      Vector a0 = (sum - damping.cwiseProduct(data_.v0)).cwiseQuotient(mass_);
      Vector predicted = u + dt * data_.v0 + dt * dt / 2 * a0;
      prescribe(n, predicted);
      const Vector kinematic = kinematic_forces(step, predicted);
      f.contact += kinematic;
      sum += kinematic;
      a0 += inverse_.cwiseProduct(kinematic);
      for (std::int64_t i = 0; i < num_; ++i)
        if (prescribed_[i])
          a0(i) = 2 * (predicted(i) - u(i) - dt * data_.v0(i)) / (dt * dt);
      before = u - dt * data_.v0 + dt * dt / 2 * a0; // (3.70)
    }
    const auto solve = [&]() // (3.69)
    {
      return Vector((dt * dt * sum + dt / 2 * damping.cwiseProduct(before) + mass_.cwiseProduct(2 * u - before))
                        .cwiseQuotient(effective));
    };
    next = solve();
    prescribe(n, next);
    if (n > 0)
    {
      const Vector kinematic = kinematic_forces(step, next);
      f.contact += kinematic;
      sum += kinematic;
      next = solve();
      prescribe(n, next);
    }
    update_contacts(step, next);
    const Vector v = (next - before) / (2 * dt), a = (next - 2 * u + before) / (dt * dt); // (3.68)
    f.damping = -damping.cwiseProduct(v);
    for (std::int64_t i = 0; i < num_; ++i)
      if (prescribed_[i])
        f.support(i) = mass_(i) * a(i) - sum(i) - f.damping(i);
    return {next, (u - before) / dt, (next - u) / dt, v, a};
  }

  // Energies at t_n. The work of every force is that of the trapezoidal rule: with equal steps it is exactly what the
  // kinetic energy changes by.
  void update_energies(int n, const Vector& u, const Vector& moved, const Advance& step, const Forces& f)
  {
    const auto work = [&](Vector Forces::* force) { return n == 0 ? 0.0 : ((last_.*force) + f.*force).dot(moved) / 2; };
    Vector& e = energies_;
    e(kinetic) = step.before.dot(mass_.cwiseProduct(step.after)) / 2;
    if (data_.plastic)
    {
      e(plastic_energy) -= work(&Forces::internal) + (n == 0 ? 0 : stored_ - e(internal_energy));
      e(internal_energy) = stored_;
    }
    else if (model_.linear())
      e(internal_energy) = -u.dot(f.internal) / 2;
    else
      e(internal_energy) -= work(&Forces::internal);
    e(damping_energy) -= work(&Forces::damping);
    e(viscosity_energy) -= work(&Forces::viscosity);
    e(external_energy) += work(&Forces::external) + work(&Forces::support);
    contact_energies(n, moved);
    for (const auto* contact : data_.contacts)
      if (const RigidBall* ball = contact->ball())
      {
        e(kinetic) += ball->kinetic();
        e(external_energy) += ball->external() - ball_work_;
        ball_work_ = ball->external();
      }
    e(total_energy) = e.head(external_energy).sum() - e(external_energy);
    largest_ = std::max(largest_, e.head(external_energy + 1).cwiseAbs().sum());
    if (n == 0)
      start_ = e(total_energy);
    e(drift) = largest_ > 0 ? (e(total_energy) - start_) / largest_ : 0;
    last_ = f;
  }

  void contact_energies(int n, const Vector& moved)
  {
    double stored = 0, dissipated = 0, absorbed = 0;
    for (std::size_t k = 0; k < data_.contacts.size(); ++k)
    {
      const ExplicitContact& contact = *data_.contacts[k];
      const ContactAnswer& now = contact.answer();
      ContactAnswer& last = last_answers_[k];
      if (n > 0)
      {
        const Vec<double> master = contact.master_moved(n);
        const auto half_sum = [](const Vec<double>& a, const Vec<double>& b) { return 0.5 * (a + b); };
        // A moving obstacle does work as a prescribed motion does; a ball that forces move has energy of its own.
        if (not contact.ball())
        {
          energies_(external_energy) += dot(half_sum(last.total, now.total), master);
          // Forces before the step are carried on by its rotation, those after it have been carried there.
          const Eigen::Matrix3d turn = contact.master_turned(n), one = Eigen::Matrix3d::Identity();
          energies_(external_energy) += (turn - one).cwiseProduct(last.moment).sum() / 2;
          energies_(external_energy) += (one - turn.transpose()).cwiseProduct(now.moment).sum() / 2;
        }
        if (contact.kinematic())
        {
          const double all = (last.force + now.force).dot(moved) / 2 - dot(half_sum(last.total, now.total), master);
          const double slip =
              (last.tangential + now.tangential).dot(moved) / 2 - dot(half_sum(last.friction, now.friction), master);
          energies_(impact_energy) -= all - slip;
          energies_(friction_energy) -= slip;
        }
      }
      stored += now.stored - last.stored;
      dissipated += now.dissipated - last.dissipated;
      absorbed += now.absorbed - last.absorbed;
      last = now;
    }
    energies_(contact_energy) += stored;
    energies_(friction_energy) += dissipated;
    energies_(impact_energy) += absorbed;
  }

  ExplicitHistory room(std::int64_t rows) const
  {
    const Matrix field = Matrix::Zero(rows, num_);
    ExplicitHistory out{
        Vector::Zero(rows), field, field, field, field, field, Matrix::Zero(rows, num_energies), {}, {}, {}, {}};
    if (data_.plastic)
    {
      const auto points = std::int64_t(data_.plastic->history().size());
      out.equivalent.setZero(rows, points);
      out.plastic.setZero(rows, 9 * points);
      out.back_stress.setZero(rows, 9 * points);
    }
    for (const auto* contact : data_.contacts)
    {
      const auto nodes = std::int64_t(contact->nodes().size());
      const int d = model_.gdim();
      out.contacts.push_back({Matrix::Zero(rows, d),
                              field,
                              Matrix::Zero(rows, nodes),
                              Matrix::Zero(rows, d * nodes),
                              Matrix::Zero(rows, d * nodes),
                              {}});
      out.contacts.back().status.setZero(rows, nodes);
    }
    return out;
  }

  void keep(ExplicitHistory& out, std::int64_t row, double time, const Vector& u, const Advance& step,
            const Forces& f) const
  {
    out.time(row) = time;
    out.u.row(row) = u.transpose();
    out.v.row(row) = step.v.transpose();
    out.a.row(row) = step.a.transpose();
    out.half.row(row) = step.after.transpose();
    out.support.row(row) = f.support.transpose();
    out.energies.row(row) = energies_.transpose();
    if (data_.plastic)
      keep_history(out, row);
    for (std::size_t k = 0; k < data_.contacts.size(); ++k)
    {
      const ContactAnswer& now = data_.contacts[k]->answer();
      ContactHistories& to = out.contacts[k];
      for (int c = 0; c < model_.gdim(); ++c)
        to.total(row, c) = now.total[c];
      to.force.row(row) = now.force.transpose();
      to.gap.row(row) = now.gap.transpose();
      to.traction.row(row) = now.traction.reshaped<Eigen::RowMajor>().transpose();
      to.slip.row(row) = now.slip.reshaped<Eigen::RowMajor>().transpose();
      for (std::size_t i = 0; i < now.status.size(); ++i)
        to.status(row, Eigen::Index(i)) = std::int64_t(now.status[i]);
    }
  }

  void keep_history(ExplicitHistory& out, std::int64_t row) const
  {
    const std::vector<J2History>& history = data_.plastic->history();
    for (std::size_t p = 0; p < history.size(); ++p)
    {
      out.equivalent(row, Eigen::Index(p)) = history[p].equivalent;
      for (int i = 0; i < 9; ++i)
      {
        out.plastic(row, Eigen::Index(9 * p) + i) = history[p].plastic(i / 3, i % 3);
        out.back_stress(row, Eigen::Index(9 * p) + i) = history[p].back_stress(i / 3, i % 3);
      }
    }
  }

  const Model& model_;
  const ExplicitData& data_;
  std::int64_t num_;
  Vector mass_, inverse_;
  std::vector<bool> prescribed_;
  Csr stiffness_;
  Vector energies_;
  Forces last_;
  std::vector<ContactAnswer> last_answers_; // of the contacts at t_(n-1)
  double largest_ = 0, start_ = 0;
  double stored_ = 0;    // elastic energy of a plastic body
  double ball_work_ = 0; // of the external force on a ball, up to t_(n-1)
};
} // namespace

ExplicitHistory run_explicit(const Model& model, const ExplicitData& data)
{
  check(model, data);
  return Run(model, data).run();
}
} // namespace impact_reference
