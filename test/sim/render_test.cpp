#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ipm_mapping_sim/simulation.hpp"

namespace ipm_mapping::sim {
namespace {

Scene plainScene(const std::string& more) {
  return parseScene(
      "{name: test, seed: 3, ambient: 1.0, ceiling: 0.02,"
      " camera: {fx: 500, fy: 510, cx: 322.3, cy: 236.8, x: 0.07, y: -0.02, z: 0.43, pitch: 0.37,"
      "          distortion: [0.09, -0.17, 0.001, -0.0015, 0.02]}," +
      more + "}");
}

/// OpenCV's own projection, from the numbers in the scene: an oracle that shares no code.
cv::Point2d oracleProjection(const CameraSpec& c, const Eigen::Vector3d& base) {
  const double x = base.x() - c.x, y = base.y() - c.y, z = base.z() - c.z;
  const double s = std::sin(c.pitch), k = std::cos(c.pitch);
  const std::vector<cv::Point3d> optical{{-y, -s * x - k * z, k * x - s * z}};
  const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(optical, cv::Vec3d(), cv::Vec3d(), K, c.distortion, pixels);
  return pixels[0];
}

std::vector<float> still(Renderer& renderer, const Scene& scene, const SE2& robot = {}) {
  CameraPose base = CameraPose::Identity();
  base.linear() = Eigen::AngleAxisd(robot.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  base.translation() = Eigen::Vector3d(robot.x, robot.y, 0.0);
  const CameraPose pose = base * truePose(scene.camera);
  std::vector<float> radiance;
  renderer.render([&](int) { return pose; }, radiance);
  return radiance;
}

/// Centre of the light above `dark` in a window: exact for a bright patch on a dark floor.
cv::Point2d brightCentre(const std::vector<float>& image, int width, const cv::Rect& window,
                         float dark) {
  double sum = 0.0, su = 0.0, sv = 0.0;
  for (int v = window.y; v < window.y + window.height; ++v) {
    for (int u = window.x; u < window.x + window.width; ++u) {
      const double light =
          static_cast<double>(image[static_cast<std::size_t>(v * width + u)] - dark);
      sum += light;
      su += light * u;
      sv += light * v;
    }
  }
  return {su / sum, sv / sum};
}

TEST(Lens, UndistortedPointOfEveryPixelProjectsBackOntoIt) {
  const Scene scene = plainScene("");
  const Lens lens(cameraModel(scene.camera));
  double worst = 0.0;
  for (int v = 0; v < 480; v += 7) {
    for (int u = 0; u < 640; u += 9) {
      ASSERT_TRUE(lens.pixel(u, v).seen);
      const Eigen::Vector2f at = lens.pixel(u, v).at;
      const cv::Matx33d K(500, 0, 322.3, 0, 510, 236.8, 0, 0, 1);
      std::vector<cv::Point2d> pixels;
      const std::vector<cv::Point3d> ray{
          {static_cast<double>(at.x()), static_cast<double>(at.y()), 1}};
      cv::projectPoints(ray, cv::Vec3d(), cv::Vec3d(), K, scene.camera.distortion, pixels);
      worst = std::max(worst, std::hypot(pixels[0].x - u, pixels[0].y - v));
    }
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(Renderer, SmallFloorDiscsAppearWhereTheCameraModelPutsThem) {
  std::string discs;
  std::vector<Point> places;
  for (const double x : {0.75, 1.1, 1.7, 2.6}) {
    for (const double y : {-0.35, 0.05, 0.4}) {
      places.emplace_back(x, y * x);
      discs += "{kind: disc, wear: 0, albedo: 0.9, r: " + std::to_string(0.004 + 0.007 * x) +
               ", x: " + std::to_string(x) + ", y: " + std::to_string(y * x) + "}, ";
    }
  }
  const Scene scene =
      plainScene("floor: {albedo: 0, grain: none, blotch_contrast: 0}, paint: [" + discs + "]");
  Renderer renderer(scene);
  const std::vector<float> image = still(renderer, scene);
  for (const Point& place : places) {
    const cv::Point2d wanted = oracleProjection(scene.camera, {place.x(), place.y(), 0.0});
    const cv::Rect window(cvRound(wanted.x) - 12, cvRound(wanted.y) - 8, 25, 17);
    const cv::Point2d found = brightCentre(image, 640, window, 0.0F);
    EXPECT_NEAR(found.x, wanted.x, 0.1) << place.transpose();
    EXPECT_NEAR(found.y, wanted.y, 0.1) << place.transpose();
  }
}

/// Sub-pixel column of the first change from dark to bright along a row.
double edgeColumn(const std::vector<float>& image, int v, int from, int to, float dark,
                  float bright) {
  double covered = 0.0;
  for (int u = from; u < to; ++u) {
    covered += static_cast<double>((image[static_cast<std::size_t>(v * 640 + u)] - dark) /
                                   (bright - dark));
  }
  return to - 0.5 - covered;
}

TEST(Renderer, CornersOfABoxLieWithinATenthOfAPixelOfTheCameraModel) {
  const Scene scene = plainScene(
      "floor: {albedo: 0, grain: none, blotch_contrast: 0},"
      "obstacles: [{kind: box, name: b, x: 1.4, y: 0.05, yaw: 0, lx: 0.3, ly: 0.36, h: 0.25,"
      "             material: {albedo: 0.5, grain: none}}]");
  Renderer renderer(scene);
  const std::vector<float> image = still(renderer, scene);
  // The front face's vertical edges, met row by row between its upper and lower corners.
  for (const double side : {-0.13, 0.23}) {
    const cv::Point2d low = oracleProjection(scene.camera, {1.25, side, 0.0});
    const cv::Point2d high = oracleProjection(scene.camera, {1.25, side, 0.25});
    for (const double z : {0.03, 0.08, 0.13, 0.19}) {
      const cv::Point2d at = oracleProjection(scene.camera, {1.25, side, z});
      const int v = cvRound(at.y), u = cvRound(at.x);
      const double t = (v - at.y) / (high.y - low.y);
      const double wanted = at.x + t * (high.x - low.x);
      const bool right = side < 0;  // the box is to the left of its right edge
      const float inside = image[static_cast<std::size_t>(v * 640 + u + (right ? -6 : 6))];
      const double found = right ? edgeColumn(image, v, u - 5, u + 6, inside, 0.0F)
                                 : edgeColumn(image, v, u - 5, u + 6, 0.0F, inside);
      EXPECT_NEAR(found, wanted, 0.1) << "side " << side << " height " << z;
    }
  }
}

TEST(Renderer, FloorWarpsOntoItselfThroughTheHomographyAtTheNoiseLevel) {
  const Scene scene = parseScene(
      "{name: test, seed: 5, ambient: 0.5, sensor: {blur: 0.6, full_well: 9000},"
      " camera: {pitch: 0.5, x: 0.05},"
      " floor: {albedo: 0.5, grain: concrete, grain_contrast: 0.16, cell_x: 0.3, cell_y: 0.3,"
      "         gap: 0.005, gap_albedo: 0.2},"
      " lamps: [{at: [1, 0, 2.5], energy: 0.5, size: 1}]}");
  Renderer renderer(scene);
  Sensor sensor(scene.sensor, 640, 480, 5);
  const SE2 motion{0.12, 0.01, 0.05};  // of the current base in the reference base
  std::vector<std::uint8_t> reference, current;
  std::vector<float> light = still(renderer, scene);
  sensor.expose(0, 0.0, light, reference);
  light = still(renderer, scene, motion);
  sensor.expose(1, 0.1, light, current);

  GroundView view;
  view.camera = cameraModel(scene.camera);
  view.T_base_camera = truePose(scene.camera);
  view.motion = motion;
  const Eigen::Matrix3d G = view.G();
  cv::Matx33d matrix;
  for (int i = 0; i < 9; ++i) matrix.val[i] = G(i / 3, i % 3);
  const cv::Mat a(480, 640, CV_8U, reference.data()), b(480, 640, CV_8U, current.data());
  cv::Mat warped;
  cv::warpPerspective(a, warped, matrix, a.size(), cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT, cv::Scalar(0));
  const cv::Rect floor(60, 200, 520, 180);  // seen in both
  cv::Mat difference;
  cv::subtract(warped(floor), b(floor), difference, cv::noArray(), CV_32F);
  cv::Mat square = difference.mul(difference);
  const double rms = std::sqrt(cv::mean(square)[0]);
  // Noise of one image, from two exposures of the same light.
  std::vector<std::uint8_t> again;
  light = still(renderer, scene, motion);
  sensor.expose(2, 0.2, light, again);
  cv::subtract(cv::Mat(480, 640, CV_8U, again.data())(floor), b(floor), difference, cv::noArray(),
               CV_32F);
  square = difference.mul(difference);
  const double noise = std::sqrt(cv::mean(square)[0]);
  EXPECT_GT(noise, 0.8);
  EXPECT_LT(rms, 1.35 * noise);
  // The check can fail: a quarter of a degree of wrong heading is seen.
  view.motion.theta += 0.0044;
  const Eigen::Matrix3d wrong = view.G();
  for (int i = 0; i < 9; ++i) matrix.val[i] = wrong(i / 3, i % 3);
  cv::warpPerspective(a, warped, matrix, a.size(), cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::subtract(warped(floor), b(floor), difference, cv::noArray(), CV_32F);
  square = difference.mul(difference);
  EXPECT_GT(std::sqrt(cv::mean(square)[0]), 1.35 * noise);
}

TEST(Renderer, AMirrorFloorShowsABoxUpsideDown) {
  const Scene scene = plainScene(
      "floor: {albedo: 0, grain: none, blotch_contrast: 0, reflection: 1.0},"
      "obstacles: [{kind: box, name: b, x: 1.5, y: 0, lx: 0.2, ly: 0.4, h: 0.12,"
      "             material: {albedo: 0.5, grain: none}}]");
  Renderer renderer(scene);
  const std::vector<float> image = still(renderer, scene);
  // The mirror image's lower edge is where a point 0.12 m under the floor would be.
  const cv::Point2d low = oracleProjection(scene.camera, {1.4, 0.0, -0.12});
  const auto at = [&](int dv) {
    return image[static_cast<std::size_t>((cvRound(low.y) + dv) * 640 + cvRound(low.x))];
  };
  EXPECT_GT(at(-3), 0.1F);
  EXPECT_LT(at(3), 0.05F);
}

TEST(Renderer, HardLampCastsTheShadowWhereGeometryPutsIt) {
  const std::string scene_text =
      "floor: {albedo: 0.5, grain: none, blotch_contrast: 0},"
      "lamps: [{at: [1.0, 1.0, 2.0], energy: 1.0}],"
      "obstacles: [{kind: box, name: b, x: 1.5, y: 0.1, lx: 0.4, ly: 0.02, h: 0.3,"
      "             material: {albedo: 0.5, grain: none}}]";
  const Scene scene = plainScene(scene_text);
  Renderer renderer(scene);
  const std::vector<float> image = still(renderer, scene);
  // The top edge y = 0.1 at x = 1.5 is thrown to y = 0.1 - (0.9 / 1.7) * 0.3 behind the board.
  const double y = 0.09 - (1.0 - 0.09) / 1.7 * 0.3, x = 1.5 + 0.5 / 1.7 * 0.3;
  const auto light = [&](double py) {
    const cv::Point2d p = oracleProjection(scene.camera, {x, py, 0.0});
    return image[static_cast<std::size_t>(cvRound(p.y) * 640 + cvRound(p.x))];
  };
  EXPECT_GT(light(y - 0.015), 1.3F * light(y + 0.015));
}

/// Something that has gone somewhere looks, and throws shadows, as if it had always stood there.
TEST(Renderer, AMovedThingIsWhereItHasGone) {
  const std::string lamp =
      "lamps: [{at: [1.0, 1.0, 2.0], energy: 1.0}],"
      "floor: {albedo: 0.5, grain: none, blotch_contrast: 0, reflection: 0.2},";
  const std::string post =
      "kind: cylinder, name: p, r: 0.08, h: 0.4,"
      "material: {albedo: 0.4, grain: none}";
  const Scene gone = plainScene(lamp + "obstacles: [{" + post +
                                ", x: 3.0, y: 1.5, way: [{at: 0, x: 0, y: 0}, "
                                "{at: 2, x: -3.0, y: -3.0}]}]");
  const Scene stands = plainScene(lamp + "obstacles: [{" + post + ", x: 1.5, y: 0.0}]");
  Renderer moved(gone), fixed(stands);
  moved.moveTo(1.0);
  const std::vector<float> a = still(moved, gone), b = still(fixed, stands);
  double worst = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(a[i] - b[i])));
    sum += std::abs(static_cast<double>(a[i] - b[i]));
  }
  EXPECT_LT(sum / static_cast<double>(a.size()), 5e-4);
  EXPECT_LT(worst, 0.12) << "coarser squares of light at the shadow's edge";
  // The check can fail: before it has gone, and once it goes on.
  for (const double time : {0.0, 1.1}) {
    moved.moveTo(time);
    const std::vector<float> other = still(moved, gone);
    double difference = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
      difference += std::abs(static_cast<double>(other[i] - b[i]));
    EXPECT_GT(difference / static_cast<double>(a.size()), 2e-3) << time;
  }
  // and back again, to the bit
  moved.moveTo(1.0);
  EXPECT_EQ(still(moved, gone), a);
}

TEST(Simulation, TheSameSeedMakesTheSameBytesAndAnotherSeedDoesNot) {
  const std::string text =
      "{name: test, camera: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5},"
      " lamps: [{at: [1, 0, 2.5], energy: 0.5, size: 1}], odometry: {speed_noise: 0.01},"
      " obstacles: [{kind: heap, name: h, x: 1.2, y: 0.1, lx: 0.3, ly: 0.3, h: 0.3}],"
      " drive: [{seconds: 1, v: 0.2}]}";
  const auto run = [&](const std::string& seed, std::vector<std::uint8_t>& last) {
    Simulation simulation(parseScene(text, {{"seed", seed}}));
    for (int frame = 0; frame < 3; ++frame) simulation.capture(frame, last);
    return truthJson(simulation, 3);
  };
  std::vector<std::uint8_t> a, b, c;
  const std::string truth_a = run("1", a), truth_b = run("1", b), truth_c = run("2", c);
  EXPECT_EQ(a, b);
  EXPECT_EQ(truth_a, truth_b);
  EXPECT_NE(a, c);
  EXPECT_NE(truth_a, truth_c);
}

TEST(Simulation, AFrameDoesNotDependOnTheFramesBeforeIt) {
  const std::string text =
      "{name: test, camera: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5},"
      " lamps: [{at: [1, 0.5, 2.5], energy: 0.5}], drive: [{seconds: 1, v: 0.2}],"
      " obstacles: [{kind: cylinder, name: c, x: 1.2, y: 0.1, r: 0.1, h: 0.3},"
      "             {kind: box, name: b, x: 1.4, y: 0.5, h: 0.3,"
      "              way: [{at: 0, y: 0}, {at: 1, y: -1}]}]}";
  Simulation whole(parseScene(text)), late(parseScene(text));
  std::vector<std::uint8_t> a, b;
  for (int frame = 0; frame <= 7; ++frame) whole.capture(frame, a);
  late.capture(7, b);
  EXPECT_EQ(a, b);
}

}  // namespace
}  // namespace ipm_mapping::sim
