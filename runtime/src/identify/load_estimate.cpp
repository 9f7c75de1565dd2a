#include "driveline/runtime/identify/load_estimate.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace driveline::runtime {
namespace {

/// Names of the parameters in the order of the columns; those of a pendulum come last.
constexpr std::array<std::string_view, 6> kNames{"inertia", "viscous friction", "Coulomb friction",
                                                 "gravity", "pendulum",         "pendulum"};
constexpr std::size_t kPlainFigures = 4;
constexpr std::size_t kFewestRows = 40;
/// A parameter is not distinguishable if the others widen its confidence interval by this factor.
constexpr double kMaxInflation = 30.0;
/// Quantile of the normal distribution.
constexpr double kTwoSided95 = 1.96;

struct Table {
  Eigen::MatrixXd columns;  ///< one row per instant, one column per parameter
  Eigen::VectorXd torque;
  std::vector<LoadRow> rows;
};

/// Averages with triangular weights over 2 n + 1 samples around one sample.
class Window {
 public:
  Window(std::span<const LoadSample> samples, std::size_t half)
      : samples_(samples), half_(half), step_s_((samples.back().time_s - samples.front().time_s) / last()) {}

  [[nodiscard]] std::size_t half() const noexcept { return half_; }
  [[nodiscard]] double velocity(std::size_t at) const {
    return (samples_[at + 1].position - samples_[at - 1].position) / (2.0 * step_s_);
  }
  [[nodiscard]] double acceleration(std::size_t at) const {
    const double length = static_cast<double>(half_) * step_s_;
    return (samples_[at + half_].position - 2.0 * samples_[at].position + samples_[at - half_].position) /
           (length * length);
  }
  /// Returns the average of `figure(k)` over the samples k around `at`.
  template <typename Figure>
  [[nodiscard]] double average(std::size_t at, Figure figure) const {
    double sum = static_cast<double>(half_) * figure(at);
    for (std::size_t k = 1; k < half_; ++k) sum += static_cast<double>(half_ - k) * (figure(at - k) + figure(at + k));
    return sum / static_cast<double>(half_ * half_);
  }
  /// Whether the axis moves in one direction throughout the window, faster than `least`.
  [[nodiscard]] bool moves(std::size_t at, double least) const {
    const bool forward = velocity(at) > 0.0;
    for (std::size_t k = at - half_; k <= at + half_; ++k) {
      if ((forward ? velocity(k) : -velocity(k)) <= least) return false;
    }
    return true;
  }

 private:
  [[nodiscard]] double last() const noexcept { return static_cast<double>(samples_.size() - 1); }

  std::span<const LoadSample> samples_;
  std::size_t half_;
  double step_s_;
};

Table make_table(std::span<const LoadSample> samples, const Window& window, const LoadSettings& settings) {
  Table table;
  std::vector<std::array<double, kNames.size()>> rows;
  const auto half = window.half();
  for (std::size_t at = half + 1; at + half + 1 < samples.size(); at += half) {
    if (!window.moves(at, settings.standstill)) continue;
    const auto velocity = window.average(at, [&](std::size_t k) { return window.velocity(k); });
    const auto sine = window.average(at, [&](std::size_t k) { return std::sin(samples[k].position); });
    const auto cosine = window.average(at, [&](std::size_t k) { return std::cos(samples[k].position); });
    const auto torque = window.average(at, [&](std::size_t k) { return samples[k].torque; });
    rows.push_back({window.acceleration(at), velocity, std::copysign(1.0, velocity), 1.0, sine, cosine});
    table.rows.push_back({samples[at].time_s, samples[at].position, velocity, rows.back()[0], torque, 0.0});
  }
  const auto figures = settings.pendulum ? kNames.size() : kPlainFigures;
  table.columns.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(figures));
  table.torque.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const auto r = static_cast<Eigen::Index>(row);
    for (std::size_t figure = 0; figure < figures; ++figure)
      table.columns(r, static_cast<Eigen::Index>(figure)) = rows[row][figure];
    table.torque(r) = table.rows[row].torque;
  }
  return table;
}

/// Returns what a motion needs in order to show a parameter.
std::string_view remedy(std::size_t figure) {
  constexpr std::array<std::string_view, kNames.size()> kRemedies{"a higher acceleration",
                                                                  "a higher velocity, or a longer distance",
                                                                  "a motion in both directions",
                                                                  "a motion in both directions",
                                                                  "a longer distance: half a turn or more",
                                                                  "a longer distance: half a turn or more"};
  return kRemedies[figure];
}

/// Normal equations with columns scaled to length 1: otherwise the condition would depend on the units.
struct Normal {
  explicit Normal(const Table& table) : lengths(table.columns.colwise().norm().transpose().cwiseMax(1e-300)) {
    const Eigen::MatrixXd scaled = table.columns * lengths.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled.transpose() * scaled);
    const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(1e-12);
    inverse = solver.eigenvectors() * values.cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
    condition = std::sqrt(values(values.size() - 1) / values(0));
    found = lengths.cwiseInverse().cwiseProduct(inverse * (scaled.transpose() * table.torque));
  }
  /// Returns the covariance of `found` for torques with this variance.
  [[nodiscard]] Eigen::MatrixXd covariance(double variance) const {
    return variance * (lengths.cwiseInverse().asDiagonal() * inverse * lengths.cwiseInverse().asDiagonal());
  }
  Eigen::VectorXd lengths;
  Eigen::MatrixXd inverse;
  Eigen::VectorXd found;
  double condition = 0.0;
};

/// Returns the parameter whose confidence interval the others widen most, if it is too wide.
std::optional<std::size_t> find_indistinguishable(const Normal& normal) {
  Eigen::Index worst = 0;
  const double most = normal.inverse.diagonal().maxCoeff(&worst);
  if (std::sqrt(most) < kMaxInflation) return std::nullopt;
  return static_cast<std::size_t>(worst);
}

/// Sets pendulum and angle from `sine` sin(q) + `cosine` cos(q), with intervals from their covariance.
void set_pendulum(LoadEstimate& estimate, const Eigen::VectorXd& found, const Eigen::MatrixXd& covariance) {
  const double sine = found(4);
  const double cosine = found(5);
  const double pendulum = std::hypot(sine, cosine);
  const Eigen::Vector2d along(sine / pendulum, cosine / pendulum);
  const Eigen::Vector2d across(cosine / pendulum, -sine / pendulum);
  const Eigen::Matrix2d both = covariance.block<2, 2>(4, 4);
  estimate.pendulum = LoadFigure{pendulum, kTwoSided95 * std::sqrt(along.dot(both * along))};
  estimate.pendulum_zero =
      LoadFigure{std::atan2(-cosine, sine), kTwoSided95 * std::sqrt(across.dot(both * across)) / pendulum};
}

}  // namespace

Result<LoadEstimate> estimate_load(std::span<const LoadSample> samples, const LoadSettings& settings) {
  if (samples.size() < kFewestRows) return fail(ErrorKind::kSetting, "there are too few samples of the motion");
  const double step_s = (samples.back().time_s - samples.front().time_s) / static_cast<double>(samples.size() - 1);
  const auto gap = [step_s](const LoadSample& a, const LoadSample& b) { return b.time_s - a.time_s > 1.5 * step_s; };
  if (std::adjacent_find(samples.begin(), samples.end(), gap) != samples.end())
    return fail(ErrorKind::kSetting, "records of the motion were lost: this machine was too busy");
  const auto torque = [](const LoadSample& sample) { return std::abs(sample.torque) > 0.0; };
  if (std::none_of(samples.begin(), samples.end(), torque))
    return fail(ErrorKind::kSetting,
                "the drive reports no torque: map 6077h (Torque actual value) into its process data");
  const auto half = static_cast<std::size_t>(std::max(2.0, std::round(0.5 * settings.window_s / step_s)));
  auto table = make_table(samples, Window(samples, half), settings);
  if (table.rows.size() < kFewestRows) {
    return fail(
        ErrorKind::kSetting,
        fmt::format("the axis was in motion in {} of the {} windows of {:.3g} s that are needed: a longer distance, or "
                    "a higher velocity, is needed",
                    table.rows.size(), kFewestRows, 2.0 * static_cast<double>(half) * step_s));
  }
  const Normal normal(table);
  if (const auto figure = find_indistinguishable(normal)) {
    return fail(ErrorKind::kSetting,
                fmt::format("{} cannot be separated from the other figures of the load: {} is needed", kNames[*figure],
                            remedy(*figure)));
  }
  const auto& found = normal.found;
  const Eigen::VectorXd model = table.columns * found;
  const double rows = static_cast<double>(table.rows.size());
  const double squares = (table.torque - model).squaredNorm();
  const auto covariance = normal.covariance(squares / (rows - static_cast<double>(found.size())));
  const auto figure = [&](Eigen::Index i) { return LoadFigure{found(i), kTwoSided95 * std::sqrt(covariance(i, i))}; };
  if (!(found(0) > 0.0)) {
    return fail(ErrorKind::kSetting,
                fmt::format("the torque goes against the acceleration: an inertia of {:.3g} was found", found(0)));
  }
  LoadEstimate estimate{figure(0), figure(1), figure(2), figure(3)};
  if (settings.pendulum) set_pendulum(estimate, found, covariance);
  estimate.condition = normal.condition;
  estimate.residual_rms = std::sqrt(squares / rows);
  estimate.torque_rms = std::sqrt(table.torque.squaredNorm() / rows);
  estimate.rows = std::move(table.rows);
  for (std::size_t row = 0; row < estimate.rows.size(); ++row)
    estimate.rows[row].model = model(static_cast<Eigen::Index>(row));
  return estimate;
}

}  // namespace driveline::runtime
