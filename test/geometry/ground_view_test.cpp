#include "ipm_mapping/geometry/ground_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ipm_mapping/geometry/vanishing_point.hpp"

namespace ipm_mapping {
namespace {

/// Pixel of a point of space by the textbook: into the camera, divide, scale.
Eigen::Vector2d pixelOf(const Intrinsics& k, const CameraPose& T_world_camera,
                        const Eigen::Vector3d& point) {
  const Eigen::Vector3d c = T_world_camera.inverse() * point;
  return {k.fx * c.x() / c.z() + k.cx, k.fy * c.y() / c.z() + k.cy};
}

/// Floor point under a pixel: the ray from the camera, cut with z = 0.
Eigen::Vector3d floorByRay(const Intrinsics& k, const CameraPose& T_world_camera,
                           const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d direction =
      T_world_camera.linear() *
      Eigen::Vector3d((pixel.x() - k.cx) / k.fx, (pixel.y() - k.cy) / k.fy, 1.0);
  const Eigen::Vector3d origin = T_world_camera.translation();
  return origin - direction * (origin.z() / direction.z());
}

Eigen::Isometry3d inSpace(const SE2& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(pose.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(pose.x, pose.y, 0.0);
  return T;
}

/// Views of a few robots: pitch, yaw, roll and position of the camera, motions with turns.
std::vector<GroundView> views() {
  std::vector<GroundView> all;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) {
    GroundView view;
    view.camera = CameraModel({640, 480, 525, 510, 318, 243}, {});
    view.T_base_camera = cameraPose(0.1 * u(random), 0.1 * u(random), 0.5 + 0.3 * u(random),
                                    0.45 + 0.25 * u(random), 0.3 * u(random), 0.1 * u(random));
    view.motion = {0.2 + 0.1 * u(random), 0.05 * u(random), 0.3 * u(random)};
    all.push_back(view);
  }
  return all;
}

TEST(GroundProjection, AgreesWithTheRayThroughThePixelCutWithTheFloor) {
  for (const GroundView& view : views()) {
    const GroundProjection floor = view.currentFloor();
    for (int v = 200; v < 480; v += 60)
      for (int u = 0; u < 640; u += 80) {
        const Eigen::Vector3d expected =
            floorByRay(view.camera.intrinsics(), view.T_base_camera, {double(u), double(v)});
        const auto point = floor.floor({double(u), double(v)});
        ASSERT_TRUE(point);
        EXPECT_TRUE(point->isApprox(expected.head<2>(), 1e-9));
        const auto pixel = floor.pixel(*point);
        ASSERT_TRUE(pixel);
        EXPECT_NEAR(pixel->x(), u, 1e-6);
        EXPECT_NEAR(pixel->y(), v, 1e-6);
        const double depth = (view.T_base_camera.inverse() * expected).z();
        EXPECT_NEAR(floor.inverseDepth(u, v), 1.0 / depth, 1e-9);
      }
  }
}

TEST(GroundProjection, HasNoFloorOnOrAboveTheHorizonAndNoPixelBehindTheCamera) {
  GroundView view;
  view.camera = CameraModel({640, 480, 500, 500, 320, 240}, {});
  view.T_base_camera = cameraPose(0.0, 0.0, 0.5, 0.2);
  const GroundProjection floor = view.currentFloor();
  const double horizon = 240.0 - 500.0 * std::tan(0.2);
  EXPECT_NEAR(floor.inverseDepth(17.0, horizon), 0.0, 1e-12);
  EXPECT_TRUE(floor.floor({320.0, horizon + 0.01}));
  EXPECT_FALSE(floor.floor({320.0, horizon - 0.01}));
  EXPECT_FALSE(floor.floor({320.0, -5000.0}));
  EXPECT_TRUE(floor.pixel({5.0, 0.0}));
  EXPECT_FALSE(floor.pixel({-5.0, 0.0}));
}

TEST(GroundView, GTakesACurrentPixelOverTheFloorToTheReferenceView) {
  int compared = 0;
  for (const GroundView& view : views()) {
    const Intrinsics& k = view.camera.intrinsics();
    const CameraPose current_in_reference = CameraPose(inSpace(view.motion) * view.T_base_camera);
    for (int v = 240; v < 480; v += 48)
      for (int u = 0; u < 640; u += 64) {
        const Eigen::Vector3d point = floorByRay(k, current_in_reference, {double(u), double(v)});
        const Eigen::Vector3d mapped = view.G() * Eigen::Vector3d(u, v, 1.0);
        const Eigen::Vector3d in_reference = view.T_base_camera.inverse() * point;
        if (in_reference.z() < 0.05) continue;
        ++compared;
        EXPECT_TRUE(mapped.hnormalized().isApprox(pixelOf(k, view.T_base_camera, point), 1e-8));
      }
  }
  EXPECT_GT(compared, 1500);
}

TEST(GroundView, HcIsTheCurrentViewOfTheReferenceFloor) {
  for (const GroundView& view : views()) {
    const CameraPose current_in_reference = CameraPose(inSpace(view.motion) * view.T_base_camera);
    for (const Eigen::Vector2d& floor : {Eigen::Vector2d(1.0, 0.2), Eigen::Vector2d(1.5, -0.4)}) {
      const Eigen::Vector3d p = view.H_c() * floor.homogeneous();
      const Eigen::Vector3d point(floor.x(), floor.y(), 0.0);
      EXPECT_TRUE(p.hnormalized().isApprox(
          pixelOf(view.camera.intrinsics(), current_in_reference, point), 1e-9));
      EXPECT_NEAR(p.z(), (current_in_reference.inverse() * point).z(), 1e-9)
          << "its scale is the depth";
    }
  }
}

TEST(GroundView, WithoutMotionNothingMoves) {
  GroundView view = views().front();
  view.motion = {};
  EXPECT_TRUE((view.G() / view.G()(2, 2)).isIdentity(1e-12));
  EXPECT_TRUE(view.H_c().isApprox(view.H_r()));
}

TEST(GroundView, TheFloorEntersTheViewAtTheBottomRow) {
  const CameraModel camera({640, 480, 500, 500, 320, 239.5}, {});
  const double below_axis = std::atan((479.0 - 239.5) / 500.0);
  EXPECT_NEAR(nearestVisibleFloor(camera, cameraPose(0.3, 0.1, 0.45, 0.42, 0.5)),
              0.45 / std::tan(0.42 + below_axis), 1e-9);
  EXPECT_TRUE(std::isinf(nearestVisibleFloor(camera, cameraPose(0, 0, 0.45, -0.9))));
}

TEST(GroundView, PosesThatCannotSeeTheFloorAreRefusedByName) {
  EXPECT_EQ(checkCameraPose(cameraPose(0, 0, 0.45, 0.42)), std::nullopt);
  EXPECT_NE(checkCameraPose(cameraPose(0, 0, -0.1, 0.4))->find("height -0.1"), std::string::npos);
  EXPECT_NE(checkCameraPose(cameraPose(0, 0, 0.0, 0.4))->find("height"), std::string::npos);
  EXPECT_NE(checkCameraPose(cameraPose(0, 0, 0.4, 1.55))->find("pitch"), std::string::npos);
  EXPECT_NE(checkCameraPose(cameraPose(std::nan(""), 0, 0.4, 0.4))->find("finite"),
            std::string::npos);
}

// --- vanishing points ----------------------------------------------------------------

/// Whether `target` (homogeneous) lies on the line through pixels a and b: distance of b from the
/// line through a that points to the target.
double missesBy(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector3d& target) {
  const Eigen::Vector2d direction = (target.head<2>() - target.z() * a).normalized();
  const Eigen::Vector2d d = b - a;
  return std::abs(direction.x() * d.y() - direction.y() * d.x());
}

TEST(VanishingPoints, AVerticalEdgePointsToF1AndItsWarpedImageToF2AndBothMeetAtTheContact) {
  int edges = 0;
  double parallax = 0.0;
  for (const GroundView& view : views()) {
    const Intrinsics& k = view.camera.intrinsics();
    const CameraPose current = CameraPose(inSpace(view.motion) * view.T_base_camera);
    const VanishingPoints points = vanishingPoints(view);
    const Eigen::Matrix3d reference_to_current = view.G().inverse();
    for (const Eigen::Vector2d& foot : {Eigen::Vector2d(1.2, 0.3), Eigen::Vector2d(0.9, -0.2)}) {
      const Eigen::Vector3d low(foot.x(), foot.y(), 0.0), high(foot.x(), foot.y(), 0.15);
      const Eigen::Vector2d contact = pixelOf(k, current, low);
      const Eigen::Vector2d top = pixelOf(k, current, high);
      const auto warped = [&](const Eigen::Vector3d& p) {
        return Eigen::Vector2d(
            (reference_to_current * pixelOf(k, view.T_base_camera, p).homogeneous()).hnormalized());
      };
      ++edges;
      EXPECT_LT(missesBy(contact, top, points.f1), 1e-6);
      EXPECT_LT(missesBy(contact, warped(high), points.f2), 1e-6);
      EXPECT_LT((warped(low) - contact).norm(), 1e-6) << "both meet at the contact";
      parallax += missesBy(contact, warped(high), points.f1);
    }
  }
  EXPECT_EQ(edges, 80);
  EXPECT_GT(parallax / edges, 5.0) << "pixels that tell the two apart";
}

TEST(VanishingPoints, F1IsTheImageOfTheDirectionDown) {
  for (const GroundView& view : views()) {
    const Eigen::Vector3d down =
        view.T_base_camera.linear().transpose() * Eigen::Vector3d(0, 0, -1);
    const Eigen::Vector3d expected = view.camera.intrinsics().matrix() * down;
    EXPECT_TRUE(vanishingPoints(view).f1.isApprox(expected * view.cameraHeight(), 1e-9));
  }
}

TEST(Focus, MidFootIsTheImageOfTheMidFootPoint) {
  for (const GroundView& view : views()) {
    const Eigen::Vector2d foot = view.cameraFoot();
    const Eigen::Vector2d middle = 0.5 * (foot + view.motion * foot);
    const Eigen::Vector3d image = view.H_c() * middle.homogeneous();
    EXPECT_TRUE(midFootFocus(vanishingPoints(view)).f.isApprox(2.0 * image, 1e-9));
  }
}

TEST(Focus, MeanOfPixelsOnlyWhileBothLieInFront) {
  VanishingPoints points{{100.0, 900.0, 0.5}, {50.0, 600.0, 0.25}};
  EXPECT_TRUE(meanPixelFocus(points).pixel()->isApprox(Eigen::Vector2d(200.0, 2100.0)));
  EXPECT_TRUE(midFootFocus(points).pixel()->isApprox(Eigen::Vector2d(200.0, 2000.0)));
  points.f2.z() = -0.1;
  EXPECT_EQ(meanPixelFocus(points).f, midFootFocus(points).f);
}

TEST(Focus, DirectionPointsDownTheBeamInFrontAtInfinityAndBehind) {
  const Focus in_front{{640.0, 2000.0, 2.0}}, level{{3.0, 500.0, 0.0}},
      behind{{-320.0, 500.0, -1.0}};
  EXPECT_TRUE(in_front.direction(320.0, 100.0).isApprox(Eigen::Vector2d(0.0, 1800.0)));
  EXPECT_EQ(level.direction(7.0, 9.0), level.direction(600.0, 400.0)) << "a parallel beam";
  EXPECT_FALSE(level.pixel());
  const Eigen::Vector2d left = behind.direction(100.0, 400.0),
                        right = behind.direction(500.0, 400.0);
  EXPECT_GT(left.y(), 0.0);
  EXPECT_LT(left.x(), right.x()) << "the beam diverges downwards";
}

}  // namespace
}  // namespace ipm_mapping
