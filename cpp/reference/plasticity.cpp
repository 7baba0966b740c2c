// SPDX-License-Identifier: MIT
#include "plasticity.h"
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
namespace
{
const double root32 = std::sqrt(1.5);

template <typename... T>
[[noreturn]] void invalid(const T&... parts)
{
  std::ostringstream text;
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}

double inner(const Tensor& a, const Tensor& b)
{
  return a.cwiseProduct(b).sum();
}

Tensor deviator(const Tensor& a)
{
  return a - a.trace() / 3 * Tensor::Identity();
}

Tensor unit(int i, int j)
{
  Tensor e = Tensor::Zero();
  e(i, j) = 1;
  return e;
}

// The deviatoric step of backward Euler. With x = da and r = 1 + gamma x,
//   beta = (beta_n + 2/3 C d eps_p) / r,   s - beta = eta - (2 G + 2/3 C / r) sqrt(3/2) x n,   eta = s_tr - beta_n / r:
// n is the direction of eta, and x is the root of the scalar
//   f(x) = sqrt(3/2) |eta(x)| - (3 G + C / r) x - Y(a_n + x).
class Return
{
public:
  Return(const J2& law, double shear, const Tensor& trial, const J2History& history)
      : law_(law), shear_(shear), trial_(trial), back_n_(history.back_stress), a_n_(history.equivalent)
  {
    if (value(0) > 0)
      solve();
  }

  double x() const { return x_; }
  Tensor flow() const { return root32 * x_ * n_; } // d eps_p
  Tensor stress() const { return trial_ - 2 * shear_ * flow(); }
  Tensor back_stress() const
  {
    if (x_ == 0)
      return back_n_;
    return (back_n_ + 2.0 / 3 * law_.parameters().kinematic * flow()) / recall(x_);
  }

  // Derivative of stress() in a direction (d trial, d back_n, d shear); tensors are deviatoric.
  Tensor derivative(const Tensor& d_trial, const Tensor& d_back, double d_shear = 0) const
  {
    if (x_ == 0)
      return d_trial;
    const double r = recall(x_), gamma = law_.parameters().recall;
    const Tensor given = d_trial - d_back / r; // of eta at constant x
    const double dx = (root32 * inner(n_, given) - 3 * x_ * d_shear) / -slope(x_);
    const Tensor d_eta = given + gamma / (r * r) * dx * back_n_;
    const Tensor d_n = (d_eta - inner(n_, d_eta) * n_) / eta(x_).norm();
    return d_trial - 2 * root32 * (d_shear * x_ * n_ + shear_ * (dx * n_ + x_ * d_n));
  }

private:
  double recall(double x) const { return 1 + law_.parameters().recall * x; }
  Tensor eta(double x) const { return trial_ - back_n_ / recall(x); }
  double value(double x) const
  {
    return root32 * eta(x).norm() - (3 * shear_ + law_.parameters().kinematic / recall(x)) * x -
           law_.yield_stress(a_n_ + x);
  }
  double slope(double x) const
  {
    const double r2 = recall(x) * recall(x);
    const Tensor e = eta(x);
    return (root32 * law_.parameters().recall * inner(e, back_n_) / e.norm() - law_.parameters().kinematic) / r2 -
           3 * shear_ - law_.hardening_slope(a_n_ + x);
  }

  // Newton's method, and bisection where it would leave the bracket: f falls, |beta_n| being at most sqrt(2/3) C/gamma.
  void solve()
  {
    double low = 0, high = std::numeric_limits<double>::infinity(), x = 0;
    const double size = root32 * (trial_.norm() + back_n_.norm());
    for (int iteration = 0; iteration < 200; ++iteration)
    {
      const double f = value(x);
      (f > 0 ? low : high) = x;
      const double newton = x - f / slope(x);
      if (std::abs(f) <= 1e-15 * size or std::abs(newton - x) <= 1e-16 * size / shear_)
      {
        accept(newton >= 0 ? newton : x);
        return;
      }
      if (newton > low and newton < high)
        x = newton;
      else
        x = std::isinf(high) ? 2 * low + size / (3 * shear_) : (low + high) / 2;
    }
    throw std::domain_error("the return mapping did not converge: check the hardening for steep softening");
  }

  void accept(double x)
  {
    const double y = law_.yield_stress(a_n_ + x);
    if (not(y > 0))
      throw std::domain_error("the material has softened to nothing: its yield stress is " + std::to_string(y) +
                              " at the equivalent plastic strain " + std::to_string(a_n_ + x));
    x_ = x;
    n_ = eta(x).normalized();
  }

  const J2& law_;
  double shear_;
  Tensor trial_, back_n_;
  double a_n_, x_ = 0;
  Tensor n_ = Tensor::Zero();
};

// What follows from a return and is the same in small and finite strain. `stress` and `flow` are those of the history.
void finish(J2Answer& answer, const J2& law, const Return& step, const J2History& history, const Tensor& flow)
{
  const J2Parameters& p = law.parameters();
  J2History& next = answer.history;
  next.equivalent = history.equivalent + step.x();
  next.work = history.work + 0.5 * inner(history.stress + next.stress, flow);
  answer.dissipation = law.yield_stress(next.equivalent) * step.x();
  if (p.recall > 0)
    answer.dissipation += 1.5 * p.recall / p.kinematic * next.back_stress.squaredNorm() * step.x();
}

using Spectrum = Eigen::SelfAdjointEigenSolver<Tensor>;

template <typename F>
Tensor of_eigenvalues(const Spectrum& s, F&& function)
{
  const Eigen::Vector3d values = s.eigenvalues().unaryExpr(function);
  return s.eigenvectors() * values.asDiagonal() * s.eigenvectors().transpose();
}

void check_orientation(const Tensor& F)
{
  if (not(F.determinant() > 0))
    throw std::domain_error("the deformation turns the material inside out: det F is " +
                            std::to_string(F.determinant()));
}

// i with det(a + i I) = i^3 - |a|^2/2 i + det a = 1 for a deviatoric a: the largest root, by Newton's method from
// above.
double unimodular(const Tensor& a)
{
  const double c = a.squaredNorm() / 2, d = a.determinant();
  double i = 1 + c + std::abs(d);
  for (int iteration = 0; iteration < 100; ++iteration)
  {
    const double next = i - (i * i * i - c * i + d - 1) / (3 * i * i - c);
    if (not(next < i))
      break;
    i = next;
  }
  return i;
}

// F = R U by the eigenvectors of F^T F.
class Polar
{
public:
  explicit Polar(const Tensor& F) : square_(F.transpose() * F), N_(square_.eigenvectors())
  {
    const Eigen::Vector3d u = square_.eigenvalues().cwiseSqrt();
    R_ = F * N_ * u.cwiseInverse().asDiagonal() * N_.transpose();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        of_turn_(i, j) = 1 / (u(i) + u(j));
  }

  const Tensor& R() const { return R_; }
  Tensor forward(const Tensor& a) const { return R_ * a * R_.transpose(); }
  Tensor back(const Tensor& a) const { return R_.transpose() * a * R_; }

  // Derivative of forward(a): dR = R W with the skew W of W U + U W = R^T dF - dF^T R.
  Tensor forward_derivative(const Tensor& a, const Tensor& dF) const
  {
    const Tensor A = N_.transpose() * R_.transpose() * dF * N_;
    const Tensor W = N_ * of_turn_.cwiseProduct(A - A.transpose()) * N_.transpose();
    return forward(W * a - a * W);
  }

private:
  Spectrum square_;
  Tensor N_, R_, of_turn_;
};

// (ln a - ln b) / (a - b), 1/b where they agree.
double log_slope(double a, double b)
{
  const double x = (a - b) / b;
  return x == 0 ? 1 / b : std::log1p(x) / (x * b);
}
} // namespace

Components components(const Tensor& A)
{
  return {A(0, 0), A(0, 1), A(0, 2), A(1, 0), A(1, 1), A(1, 2), A(2, 0), A(2, 1), A(2, 2)};
}

PlasticStrain plastic_strain(const std::string& name)
{
  if (name == "small")
    return PlasticStrain::small;
  if (name == "simo")
    return PlasticStrain::simo;
  if (name == "hencky")
    return PlasticStrain::hencky;
  invalid("unknown strain '", name, "' of a plastic law: use small, simo or hencky");
}

void check(const J2Parameters& p)
{
  check(Material{"linear_elastic", "3d", p.E, p.nu, 0});
  const double shear = p.E / (2 * (1 + p.nu));
  const auto stiff = [&](double slope)
  {
    if (not(slope > -3 * shear))
      invalid("the hardening falls with slope ", slope, ": it must stay above -3 G = ", -3 * shear,
              ", or the stress is not unique");
  };
  for (const auto& [name, value] : {std::pair{"kinematic modulus", p.kinematic}, std::pair{"recall", p.recall}})
    if (not(value >= 0) or not std::isfinite(value))
      invalid("the ", name, " is ", value, ": it must not be negative, and finite");
  if (p.recall > 0 and not(p.kinematic > 0))
    invalid("recall is ", p.recall, ", but the kinematic modulus is 0: there is no back stress to be recalled");
  if (p.table_strain.size() != p.table_stress.size())
    invalid("the hardening table has ", p.table_strain.size(), " strains but ", p.table_stress.size(), " stresses");
  if (not p.table_strain.empty())
  {
    if (p.table_strain[0] != 0)
      invalid("the hardening table begins at the plastic strain ", p.table_strain[0], ": it must begin at 0");
    for (std::size_t i = 0; i < p.table_strain.size(); ++i)
    {
      if (not std::isfinite(p.table_strain[i]) or not(p.table_stress[i] > 0) or not std::isfinite(p.table_stress[i]))
        invalid("row ", i, " of the hardening table is (", p.table_strain[i], ", ", p.table_stress[i],
                "): stresses must be positive, and all values finite");
      if (i == 0)
        continue;
      if (not(p.table_strain[i] > p.table_strain[i - 1]))
        invalid("the strains of the hardening table do not increase in row ", i);
      stiff((p.table_stress[i] - p.table_stress[i - 1]) / (p.table_strain[i] - p.table_strain[i - 1]));
    }
    return;
  }
  if (not(p.yield_stress > 0) or not std::isfinite(p.yield_stress))
    invalid("the yield stress is ", p.yield_stress, ": it must be positive and finite");
  if (not std::isfinite(p.hardening))
    invalid("the hardening modulus is NaN or infinite");
  if (not(p.saturation_rate >= 0) or not std::isfinite(p.saturation_rate))
    invalid("the saturation rate is ", p.saturation_rate, ": it must not be negative, and finite");
  if (p.saturation_rate > 0 and (not(p.saturation_stress > 0) or not std::isfinite(p.saturation_stress)))
    invalid("the saturation stress is ", p.saturation_stress, ": it must be positive and finite");
  // The slope of Voce's part has its extremes at a = 0 and infinity.
  stiff(p.hardening);
  if (p.saturation_rate > 0)
    stiff(p.hardening + p.saturation_rate * (p.saturation_stress - p.yield_stress));
}

J2::J2(const J2Parameters& parameters) : parameters_(parameters)
{
  check(parameters);
  bulk_ = parameters.E / (3 * (1 - 2 * parameters.nu));
  shear_ = parameters.E / (2 * (1 + parameters.nu));
}

J2History J2::virgin(PlasticStrain strain)
{
  J2History history;
  if (strain != PlasticStrain::small)
    history.plastic.setIdentity();
  return history;
}

double J2::yield_stress(double a) const
{
  const J2Parameters& p = parameters_;
  if (not p.table_strain.empty())
  {
    const auto above = std::upper_bound(p.table_strain.begin(), p.table_strain.end(), a) - p.table_strain.begin();
    const auto i = std::max<std::ptrdiff_t>(above - 1, 0);
    return p.table_stress[i] + hardening_slope(a) * (a - p.table_strain[i]);
  }
  double y = p.yield_stress + p.hardening * a;
  if (p.saturation_rate > 0)
    y -= (p.saturation_stress - p.yield_stress) * std::expm1(-p.saturation_rate * a);
  return y;
}

double J2::hardening_slope(double a) const
{
  const J2Parameters& p = parameters_;
  if (not p.table_strain.empty())
  {
    const auto above = std::upper_bound(p.table_strain.begin(), p.table_strain.end(), a) - p.table_strain.begin();
    if (above == std::ptrdiff_t(p.table_strain.size()))
      return 0;
    const auto i = std::max<std::ptrdiff_t>(above, 1);
    return (p.table_stress[i] - p.table_stress[i - 1]) / (p.table_strain[i] - p.table_strain[i - 1]);
  }
  double h = p.hardening;
  if (p.saturation_rate > 0)
    h += (p.saturation_stress - p.yield_stress) * p.saturation_rate * std::exp(-p.saturation_rate * a);
  return h;
}

J2Answer J2::small_strain(const Tensor& strain, const J2History& history, bool with_tangent) const
{
  const Tensor elastic = strain - history.plastic;
  const Return step(*this, shear_, 2 * shear_ * deviator(elastic), history);
  J2Answer answer;
  answer.stress = bulk_ * elastic.trace() * Tensor::Identity() + step.stress();
  answer.history.plastic = history.plastic + step.flow();
  answer.history.back_stress = step.back_stress();
  answer.history.stress = answer.stress;
  answer.energy = 0.5 * inner(answer.stress, strain - answer.history.plastic);
  finish(answer, *this, step, history, step.flow());
  if (with_tangent)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
      {
        const Tensor d = 0.5 * (unit(k, l) + unit(l, k));
        const Tensor d_stress = step.derivative(2 * shear_ * deviator(d), Tensor::Zero());
        answer.tangent.col(3 * k + l) = components(bulk_ * d.trace() * Tensor::Identity() + d_stress);
      }
  return answer;
}

J2Answer J2::hencky(const Tensor& F, const J2History& history, bool with_tangent) const
{
  check_orientation(F);
  const Tensor inverse = F.inverse();
  const Tensor b = F * history.plastic * F.transpose();
  const Spectrum trial(0.5 * (b + b.transpose()));
  if (not(trial.eigenvalues()(0) > 0))
    throw std::domain_error("the elastic left Cauchy-Green tensor is not positive: a smaller step is needed");
  const Tensor strain = of_eigenvalues(trial, [](double x) { return 0.5 * std::log(x); });

  // F = R U: the frame that the back stress is kept in.
  const Polar polar(F);
  J2History turned = history;
  turned.back_stress = polar.forward(history.back_stress);

  const Return step(*this, shear_, 2 * shear_ * deviator(strain), turned);
  const Tensor elastic = strain - step.flow();
  const Tensor tau = bulk_ * strain.trace() * Tensor::Identity() + step.stress();
  J2Answer answer;
  answer.stress = tau * inverse.transpose();
  answer.energy = 0.5 * inner(tau, elastic);
  answer.history.plastic = history.plastic;
  if (step.x() > 0) // an elastic step leaves C_p as it is, without round-off
  {
    const Tensor b_e = of_eigenvalues(Spectrum(elastic), [](double x) { return std::exp(2 * x); });
    const Tensor plastic = inverse * b_e * inverse.transpose();
    answer.history.plastic = 0.5 * (plastic + plastic.transpose());
  }
  answer.history.back_stress = step.x() > 0 ? polar.back(step.back_stress()) : history.back_stress;
  answer.history.stress = polar.back(tau);
  finish(answer, *this, step, history, polar.back(step.flow()));
  if (not with_tangent)
    return answer;

  const Tensor& V = trial.eigenvectors();
  Tensor of_log; // factors in the eigenbasis of b
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      of_log(i, j) = 0.5 * log_slope(trial.eigenvalues()(i), trial.eigenvalues()(j));
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l)
    {
      const Tensor dF = unit(k, l);
      const Tensor half = dF * history.plastic * F.transpose();
      const Tensor d = V * of_log.cwiseProduct(V.transpose() * (half + half.transpose()) * V) * V.transpose();
      const Tensor d_back = polar.forward_derivative(history.back_stress, dF);
      const Tensor d_tau = bulk_ * d.trace() * Tensor::Identity() + step.derivative(2 * shear_ * deviator(d), d_back);
      answer.tangent.col(3 * k + l) = components((d_tau - answer.stress * dF.transpose()) * inverse.transpose());
    }
  return answer;
}

J2Answer J2::simo(const Tensor& F, const J2History& history, bool with_tangent) const
{
  check_orientation(F);
  const double J = F.determinant(), scale = std::pow(J, -2.0 / 3);
  const Tensor inverse = F.inverse();
  const Tensor b = scale * F * history.plastic * F.transpose(); // be_bar_tr
  const double third = b.trace() / 3;
  const Polar polar(F);
  J2History turned = history;
  turned.back_stress = polar.forward(history.back_stress);
  const Return step(*this, shear_ * third, shear_ * deviator(b), turned);
  const Tensor s = step.stress();
  const Tensor tau = 0.5 * bulk_ * (J * J - 1) * Tensor::Identity() + s;
  J2Answer answer;
  answer.stress = tau * inverse.transpose();
  const double trace = 3 * unimodular(s / shear_); // of be_bar
  answer.energy = 0.5 * bulk_ * (0.5 * (J * J - 1) - std::log(J)) + 0.5 * shear_ * (trace - 3);
  answer.history.plastic = history.plastic;
  if (step.x() > 0)
  {
    const Tensor plastic = inverse * (s / shear_ + trace / 3 * Tensor::Identity()) * inverse.transpose() / scale;
    answer.history.plastic = 0.5 * (plastic + plastic.transpose());
  }
  answer.history.back_stress = step.x() > 0 ? polar.back(step.back_stress()) : history.back_stress;
  answer.history.stress = polar.back(tau);
  finish(answer, *this, step, history, polar.back(step.flow()));
  if (not with_tangent)
    return answer;

  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l)
    {
      const Tensor dF = unit(k, l);
      const double dJ = J * inverse(l, k);
      const Tensor half = scale * dF * history.plastic * F.transpose();
      const Tensor d = half + half.transpose() - 2.0 / 3 * dJ / J * b;
      const Tensor d_back = polar.forward_derivative(history.back_stress, dF);
      const Tensor d_s = step.derivative(shear_ * deviator(d), d_back, shear_ * d.trace() / 3);
      const Tensor d_tau = bulk_ * J * dJ * Tensor::Identity() + d_s;
      answer.tangent.col(3 * k + l) = components((d_tau - answer.stress * dF.transpose()) * inverse.transpose());
    }
  return answer;
}

J2Answer J2::answer(PlasticStrain strain, Hypothesis hypothesis, const Tensor& gradient, const J2History& history,
                    bool with_tangent) const
{
  if (hypothesis == Hypothesis::plane_stress)
    return strain == PlasticStrain::small ? plane_stress(gradient, history, with_tangent)
                                          : finite_plane_stress(strain, gradient, history, with_tangent);
  if (strain == PlasticStrain::small)
    return small_strain(gradient, history, with_tangent);
  return strain == PlasticStrain::simo ? simo(gradient, history, with_tangent)
                                       : hencky(gradient, history, with_tangent);
}
} // namespace impact_reference
