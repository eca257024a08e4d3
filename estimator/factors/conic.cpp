#include "estimator/factors/conic.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <optional>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"
#include "estimator/factors/shape_block.h"

namespace uniquadric {
namespace {

// An outline in coordinates in which the observed ellipse is the unit circle about the origin, with the
// derivatives by the shape's pose in the camera (rho, phi) and by ln a. Sigma is kept as xx, xy, yy.
struct Outline {
  Eigen::Vector2d mu = Eigen::Vector2d::Zero();
  Eigen::Matrix2d sigma = Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 2, 9> mu_by = Eigen::Matrix<double, 2, 9>::Zero();
  Eigen::Matrix<double, 3, 9> sigma_by = Eigen::Matrix<double, 3, 9>::Zero();
};

Eigen::Matrix3d symmetric_product(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a * b.transpose() + b * a.transpose();
}

// d C of C = G diag(d) G^T - c c^T by each of the nine parameters.
std::array<Eigen::Matrix3d, 9> dual_conic_derivatives(const Eigen::Matrix3d& G, const Eigen::Vector3d& c,
                                                      const Eigen::Vector3d& d) {
  std::array<Eigen::Matrix3d, 9> by;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    by[k] = -symmetric_product(G.col(k), c);
    by[3 + k] = (d[i] - d[j]) * symmetric_product(G.col(i), G.col(j));
    by[6 + k] = d[k] * symmetric_product(G.col(k), G.col(k));
  }
  return by;
}

// P: projection into the whitened image. Nothing where the outline is no ellipse.
std::optional<Outline> outline(const Eigen::Matrix3d& P, const Pose& camera_from_shape,
                               const Eigen::Vector3d& semi_axes_m, bool derivatives) {
  const Eigen::Matrix3d G = P * camera_from_shape.rotation.toRotationMatrix();
  const Eigen::Vector3d c = P * camera_from_shape.translation;
  const Eigen::Vector3d d = semi_axes_m.cwiseAbs2();
  const Eigen::Matrix3d C = G * d.asDiagonal() * G.transpose() - c * c.transpose();
  if (!(c.z() > 0 && C(2, 2) < 0)) return std::nullopt;
  Outline o;
  const Eigen::Matrix3d N = C / C(2, 2);
  o.mu = N.topRightCorner<2, 1>();
  o.sigma = o.mu * o.mu.transpose() - N.topLeftCorner<2, 2>();
  if (!(o.sigma(0, 0) > 0 && o.sigma.determinant() > 0)) return std::nullopt;
  if (!derivatives) return o;
  const auto by = dual_conic_derivatives(G, c, d);
  for (int k = 0; k < 9; ++k) {
    const Eigen::Matrix3d dN = (by[k] - N * by[k](2, 2)) / C(2, 2);
    const Eigen::Vector2d dmu = dN.topRightCorner<2, 1>();
    const Eigen::Matrix2d dsigma = dmu * o.mu.transpose() + o.mu * dmu.transpose() - dN.topLeftCorner<2, 2>();
    o.mu_by.col(k) = dmu;
    o.sigma_by.col(k) << dsigma(0, 0), dsigma(0, 1), dsigma(1, 1);
  }
  return o;
}

template <int Rows>
struct Residual {
  Eigen::Matrix<double, Rows, 1> value;
  Eigen::Matrix<double, Rows, 9> by;
};

Eigen::Matrix2d from_upper(const Eigen::Vector3d& xx_xy_yy) {
  Eigen::Matrix2d m;
  m << xx_xy_yy[0], xx_xy_yy[1], xx_xy_yy[1], xx_xy_yy[2];
  return m;
}

// (log a - log b) / (a - b), also where a and b are close.
double log_difference_quotient(double a, double b) {
  const double x = (a - b) / b;
  return std::abs(x) < 1e-5 ? (1 - x / 2 + x * x / 3) / b : std::log(a / b) / (a - b);
}

Residual<5> vector_residual(const Outline& o, bool derivatives) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(o.sigma);
  const Eigen::Matrix2d& U = eigen.eigenvectors();
  const Eigen::Vector2d& l = eigen.eigenvalues();
  const Eigen::Matrix2d log_sigma = U * l.array().log().matrix().asDiagonal() * U.transpose();
  const auto stack = [](const Eigen::Matrix2d& m) -> Eigen::Vector3d {
    return Eigen::Vector3d(m(0, 0), std::numbers::sqrt2 * m(0, 1), m(1, 1)) / (2 * std::numbers::sqrt2);
  };
  Residual<5> r;
  r.value << o.mu / 2, stack(log_sigma);
  if (!derivatives) return r;
  // Daleckii-Krein: d log(S) = U (F o U^T dS U) U^T
  Eigen::Matrix2d F;
  const double off = log_difference_quotient(l[0], l[1]);
  F << 1 / l[0], off, off, 1 / l[1];
  r.by.topRows<2>() = o.mu_by / 2;
  for (int k = 0; k < 9; ++k) {
    const Eigen::Matrix2d inner = U.transpose() * from_upper(o.sigma_by.col(k)) * U;
    r.by.col(k).tail<3>() = stack(U * F.cwiseProduct(inner) * U.transpose());
  }
  return r;
}

Residual<1> literal_residual(const Outline& o, bool derivatives) {
  const Eigen::Matrix2d mean = (o.sigma + Eigen::Matrix2d::Identity()) / 2;
  const Eigen::Matrix2d mean_inverse = mean.inverse(), sigma_inverse = o.sigma.inverse();
  const Eigen::Vector2d pull = mean_inverse * o.mu;
  const double e_B = o.mu.dot(pull) / 8 + std::log(mean.determinant() / std::sqrt(o.sigma.determinant())) / 2;
  Residual<1> r;
  r.value << std::sqrt(std::max(2 * e_B, 0.0));
  r.by.setZero();
  constexpr double kAtMinimum = 1e-7;  // below it e_B is lost to rounding, and so is its direction
  if (!derivatives || r.value[0] < kAtMinimum) return r;
  for (int k = 0; k < 9; ++k) {
    const Eigen::Matrix2d dsigma = from_upper(o.sigma_by.col(k));
    const double de = pull.dot(o.mu_by.col(k)) / 4 - pull.dot(dsigma * pull) / 16 +
                      (mean_inverse * dsigma).trace() / 4 - (sigma_inverse * dsigma).trace() / 4;
    r.by(k) = de / r.value[0];
  }
  return r;
}

template <int Rows>  // 5: vector, 1: literal
class Conic final : public ceres::SizedCostFunction<Rows, 7, 7, 3> {
 public:
  Conic(const Camera& camera, const Pose& world_from_camera, const Ellipse& observed, double sigma)
      : world_from_camera_(world_from_camera), weight_(1 / sigma) {
    const Eigen::Matrix2d shape = ellipse_covariance(observed);
    Eigen::Matrix3d whiten = Eigen::Matrix3d::Identity();
    whiten.topLeftCorner<2, 2>() =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(shape).operatorInverseSqrt();
    Eigen::Matrix3d K = camera.matrix();
    K.topRightCorner<2, 1>() -= observed.center;
    projection_ = whiten * K;
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose world_from_body = pose_from_block(blocks[0]), body_from_shape = pose_from_block(blocks[1]);
    const Pose camera_from_shape = relative_pose(world_from_camera_, world_from_body) * body_from_shape;
    const auto seen =
        outline(projection_, camera_from_shape, axes_from_block(blocks[2]), jacobians != nullptr);
    Residual<Rows> r;
    if (!seen) {
      r.value.setZero();
      r.value[0] = kNoOutlineResidual;
      r.by.setZero();
    } else if constexpr (Rows == 5) {
      r = vector_residual(*seen, jacobians != nullptr);
    } else {
      r = literal_residual(*seen, jacobians != nullptr);
    }
    Eigen::Map<Eigen::Matrix<double, Rows, 1>>{residuals} = weight_ * r.value;
    if (jacobians) write_jacobians(weight_ * r.by, world_from_body, body_from_shape, jacobians);
    return true;
  }

 private:
  static void write_jacobians(const Eigen::Matrix<double, Rows, 9>& by, const Pose& world_from_body,
                              const Pose& body_from_shape, double** jacobians) {
    const Eigen::Matrix<double, Rows, 6> by_pose = by.template leftCols<6>();
    if (jacobians[0])
      write_pose_jacobian<Rows>(by_pose * adjoint(body_from_shape.inverse()), world_from_body.rotation,
                                jacobians[0]);
    if (jacobians[1]) write_pose_jacobian<Rows>(by_pose, body_from_shape.rotation, jacobians[1]);
    if (jacobians[2])
      Eigen::Map<Eigen::Matrix<double, Rows, 3, Eigen::RowMajor>>{jacobians[2]} = by.template rightCols<3>();
  }

  Pose world_from_camera_;
  double weight_;
  Eigen::Matrix3d projection_;  // W K, the observed ellipse's centre moved to the origin
};

}  // namespace

double conic_sigma(const Ellipse& observed, double sigma_px) {
  return sigma_px / (2 * std::sqrt(observed.semi_major * observed.semi_minor));
}

double bhattacharyya_distance(const Ellipse& a, const Ellipse& b) {
  const Eigen::Matrix2d A = ellipse_covariance(a), B = ellipse_covariance(b), mean = (A + B) / 2;
  const Eigen::Vector2d d = b.center - a.center;
  return d.dot(mean.inverse() * d) / 8 +
         std::log(mean.determinant() / std::sqrt(A.determinant() * B.determinant())) / 2;
}

std::unique_ptr<ceres::CostFunction> conic_factor(const Camera& camera, const Pose& world_from_camera,
                                                  const Ellipse& observed, const ConicOptions& options) {
  if (options.residual == ConicResidual::literal)
    return std::make_unique<Conic<1>>(camera, world_from_camera, observed, options.sigma);
  return std::make_unique<Conic<5>>(camera, world_from_camera, observed, options.sigma);
}

}  // namespace uniquadric
