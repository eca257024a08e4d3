#include "evaluation/trajectory/calibrated_drift.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <unsupported/Eigen/NonLinearOptimization>
#include <vector>

#include "evaluation/trajectory/drift_angles.h"

namespace uniquadric {
namespace {

constexpr int kEvaluations = 200;  // a good start needs about ten
constexpr std::size_t kCoarse = 500;
constexpr double kStep = 1e-6;           // m and rad, of the derivatives: truncation and rounding both 1e-10
constexpr double kRankTolerance = 1e-6;  // of the greatest column: the derivatives' own error, and more
constexpr double kTolerance = 1e-10;     // of the sum of squares and the step: a fit is as good before

struct Motions {
  std::vector<Pose> estimate, reference;  // e_k, g_k, from the second pair on
};

Motions motions_of(const PosePairs& poses) {
  Motions motions;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    motions.estimate.push_back(relative_pose(poses.estimate[k], poses.estimate[0]));
    motions.reference.push_back(relative_pose(poses.reference[k], poses.reference[0]));
  }
  return motions;
}

// Evenly, to at most kCoarse: enough to choose among the starts.
Motions thinned(const Motions& motions) {
  const std::size_t every = (motions.estimate.size() + kCoarse - 1) / kCoarse;
  Motions coarse;
  for (std::size_t k = every - 1; k < motions.estimate.size(); k += every) {
    coarse.estimate.push_back(motions.estimate[k]);
    coarse.reference.push_back(motions.reference[k]);
  }
  return coarse;
}

Pose error_of(const Pose& C, const Pose& estimate, const Pose& reference) {
  return C * estimate * C.inverse() * reference.inverse();
}

// Residuals and their derivatives by C's own small motion, Exp(x) C: central differences.
struct Calibration {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Motions& motions;
  Pose start;

  int inputs() const { return 6; }
  int values() const { return static_cast<int>(6 * motions.estimate.size()); }
  Pose at(const Eigen::VectorXd& x) const { return exp_se3(x) * start; }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& residuals) const {
    const Pose C = at(x);
    for (std::size_t k = 0; k < motions.estimate.size(); ++k)
      residuals.segment<6>(static_cast<Eigen::Index>(6 * k)) =
          log_se3(error_of(C, motions.estimate[k], motions.reference[k]));
    return 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& J) const {
    Eigen::VectorXd more(values()), less(values());
    for (int i = 0; i < 6; ++i) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(6, i);
      (*this)(x + step, more);
      (*this)(x - step, less);
      J.col(i) = (more - less) / (2 * kStep);
    }
    return 0;
  }
};

// The turn that carries `from` onto `to` best.
Eigen::Quaterniond turn_of(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(to * from.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  const Eigen::Vector3d signs(1, 1, U.determinant() * V.determinant() < 0 ? -1 : 1);
  return Eigen::Quaterniond(Eigen::Matrix3d(U * signs.asDiagonal() * V.transpose())).normalized();
}

// C turns the estimate's rotation vectors into the reference's, and the ways of a body that hardly turns.
std::vector<Pose> starts(const Motions& motions) {
  const auto n = static_cast<Eigen::Index>(motions.estimate.size());
  Eigen::Matrix3Xd turns[2] = {{3, n}, {3, n}}, ways[2] = {{3, n}, {3, n}};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Pose both[2] = {motions.estimate[static_cast<std::size_t>(k)],
                          motions.reference[static_cast<std::size_t>(k)]};
    for (int i = 0; i < 2; ++i) {
      turns[i].col(k) = log_so3(both[i].rotation);
      ways[i].col(k) = both[i].translation;
    }
  }
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return {Pose{}, {turn_of(turns[0], turns[1]), none}, {turn_of(ways[0], ways[1]), none}};
}

struct Fit {
  Pose C;
  double cost = 0;
  bool determined = true;
};

Fit fit_from(const Motions& motions, const Pose& start) {
  Calibration calibration{motions, start};
  Eigen::LevenbergMarquardt<Calibration> solver(calibration);
  solver.parameters.maxfev = kEvaluations;
  solver.parameters.ftol = solver.parameters.xtol = kTolerance;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(6), residuals(calibration.values());
  solver.minimize(x);
  calibration(x, residuals);
  Eigen::MatrixXd J(calibration.values(), 6);
  calibration.df(x, J);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
  qr.setThreshold(kRankTolerance);
  return {calibration.at(x), residuals.squaredNorm(), qr.rank() == 6};
}

}  // namespace

std::optional<CalibratedDrift> calibrated_drift(const PosePairs& poses) {
  if (poses.size() < kMinPairs) return std::nullopt;
  const Motions motions = motions_of(poses);
  const Motions coarse = thinned(motions);
  std::optional<Fit> best;
  for (const Pose& start : starts(coarse))
    if (const Fit fit = fit_from(coarse, start); !best || fit.cost < best->cost) best = fit;
  if (coarse.estimate.size() < motions.estimate.size()) best = fit_from(motions, best->C);
  CalibratedDrift drift;
  drift.reference_from_estimate = best->C;
  drift.determined = best->determined;
  double path_m = 0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    path_m += (poses.reference[k].translation - poses.reference[k - 1].translation).norm();
    const Pose error = error_of(best->C, motions.estimate[k - 1], motions.reference[k - 1]);
    if (const double size_m = error.translation.norm(); size_m > drift.max_translation_m) {
      drift.max_translation_m = size_m;
      drift.translation_index = k;
      drift.max_translation_percent_of_path.reset();
      if (path_m > 0) drift.max_translation_percent_of_path = 100 * size_m / path_m;
    }
    const Eigen::Matrix3d rotation = error.rotation.toRotationMatrix();
    if (const double angle = rotation_angle(rotation); angle > drift.max_angle_rad) {
      drift.max_angle_rad = angle;
      drift.roll_pitch_yaw_rad = roll_pitch_yaw(rotation);
      drift.angle_index = k;
    }
  }
  if (drift.max_translation_m == 0 && path_m > 0) drift.max_translation_percent_of_path = 0;
  return drift;
}

}  // namespace uniquadric
