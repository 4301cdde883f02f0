#include "ipm_mapping/detectors/chain_detector.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/detectors/pipeline.hpp"
#include "support/ray_scene.hpp"

namespace ipm_mapping::test {
namespace {

/// A robot that carries a detector through a scene.
struct Drive {
  RayScene scene;
  std::unique_ptr<Detector> detector;
  Obstacles obstacles;
  std::uint64_t frames = 0;

  Drive(RayScene world, const Parameters& parameters)
      : scene(std::move(world)), detector(makeDetector(parameters)) {
    detector->setCamera(scene.camera, scene.T_base_camera);
  }
  FrameStatus to(const SE2& T_odom_base) {
    const Image<std::uint8_t> picture = scene.render(T_odom_base);
    const Frame frame{frames, 0.1 * static_cast<double>(frames), picture.view(), T_odom_base};
    ++frames;
    return detector->process(frame, obstacles);
  }
  [[nodiscard]] Eigen::Vector2d inOdom(const Contact& c) const {
    return obstacles.view.T_odom_base * c.p_base.cast<double>().eval();
  }
  /// Distance of the nearest contact to the box's outline, metres.
  [[nodiscard]] double errorOfNearest(const std::vector<Contact>& contacts) const {
    const auto nearest = std::min_element(contacts.begin(), contacts.end(), [](auto& a, auto& b) {
      return a.p_base.norm() < b.p_base.norm();
    });
    return nearest == contacts.end() ? 1e9 : scene.distanceToOutline(inOdom(*nearest));
  }
  /// Contacts on floor that both frames saw: the way there leads past the box, by 5 cm or more.
  [[nodiscard]] int onVisibleFloor(const std::vector<Contact>& contacts) const {
    const GroundView& view = obstacles.view;
    const Eigen::Vector2d now = view.T_odom_base * view.cameraFoot();
    const Eigen::Vector2d then = view.T_odom_base * view.motion.inverse() * view.cameraFoot();
    int n = 0;
    for (const Contact& c : contacts) n += passesBy(now, inOdom(c)) && passesBy(then, inOdom(c));
    return n;
  }
  [[nodiscard]] bool passesBy(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    for (double t = 0.0; t <= 1.0; t += 0.01)
      if (scene.distanceToOutline(from + t * (to - from)) < 0.05) return false;
    return true;
  }
};

/// To the left of the way: straight ahead, vertical edges show no parallax.
RayScene boxAhead() {
  static const RayScene empty = wideScene();
  RayScene scene = empty;
  scene.boxes = {{1.1, 1.4, 0.35, 0.6, 0.4}};
  return scene;
}

class EitherProfile : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] Parameters parameters() const {
    Parameters p = Parameters::profile(GetParam());
    p.detector.kind = DetectorKind::Chain;
    p.localization.n_lines = 320;  // dense enough for a line through the very foot
    return p;
  }
};

TEST_P(EitherProfile, FindsTheFootOfABox) {
  Drive drive(boxAhead(), parameters());
  EXPECT_EQ(drive.to({-0.3, 0, 0}), FrameStatus::NoReference);
  EXPECT_TRUE(drive.obstacles.contacts.empty());
  // The paper's threshold is that of the frame before: the second pair is the first to answer.
  ASSERT_EQ(drive.to({0, 0, 0}), FrameStatus::Used);
  ASSERT_EQ(drive.to({0.3, 0, 0}), FrameStatus::Used);
  EXPECT_GE(drive.obstacles.candidates.size(), 4U);
  EXPECT_LT(drive.errorOfNearest(drive.obstacles.candidates), 0.06);
  EXPECT_EQ(drive.onVisibleFloor(drive.obstacles.candidates), 0);
  EXPECT_FALSE(drive.obstacles.contacts.empty());
  EXPECT_EQ(drive.obstacles.frame, 2U);
  EXPECT_GT(drive.obstacles.threshold, 0);
  EXPECT_GT(drive.obstacles.separability, 0.3F);
}

TEST_P(EitherProfile, UsesNoFrameWhileStanding) {
  Drive drive(boxAhead(), parameters());
  drive.to({0, 0, 0});
  ASSERT_EQ(drive.to({0.11, 0, 0}), FrameStatus::Used);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(drive.to({0.11, 0, 0}), FrameStatus::NoMotion);
    EXPECT_TRUE(drive.obstacles.contacts.empty());
    EXPECT_TRUE(drive.obstacles.bearings.empty());
  }
}

TEST_P(EitherProfile, UsesNoFrameWhileTurningOnTheSpot) {
  Drive drive(boxAhead(), parameters());
  drive.to({0, 0, 0});
  for (int i = 1; i < 5; ++i) {
    EXPECT_EQ(drive.to({0, 0, 0.05 * i}), FrameStatus::TooMuchRotation);
    EXPECT_TRUE(drive.obstacles.contacts.empty());
    EXPECT_TRUE(drive.obstacles.bearings.empty());
  }
}

TEST_P(EitherProfile, WorksInReverseAndOnACurve) {
  for (const SE2& step : {SE2{-0.3, 0.0, 0.0}, SE2{0.25, 0.01, 0.08}}) {
    Drive drive(boxAhead(), parameters());
    SE2 pose{step.x < 0 ? 0.6 : -0.25, 0, 0};
    drive.to(pose);
    for (int i = 0; i < 2; ++i) {
      pose = pose * step;
      ASSERT_EQ(drive.to(pose), FrameStatus::Used);
    }
    EXPECT_GE(drive.obstacles.candidates.size(), 4U) << step.x;
    EXPECT_LT(drive.errorOfNearest(drive.obstacles.candidates), 0.08) << step.x;
    EXPECT_EQ(drive.onVisibleFloor(drive.obstacles.candidates), 0) << step.x;
  }
}

TEST_P(EitherProfile, ForgetsOnReset) {
  Drive drive(boxAhead(), parameters()), fresh(boxAhead(), parameters());
  drive.to({-0.22, 0, 0});
  drive.to({-0.11, 0, 0});
  drive.detector->reset();
  EXPECT_EQ(drive.to({0, 0, 0}), FrameStatus::NoReference);
  EXPECT_EQ(fresh.to({0, 0, 0}), FrameStatus::NoReference);
  ASSERT_EQ(drive.to({0.11, 0, 0}), FrameStatus::Used);
  ASSERT_EQ(fresh.to({0.11, 0, 0}), FrameStatus::Used);
  EXPECT_EQ(drive.obstacles.threshold, fresh.obstacles.threshold);
  ASSERT_EQ(drive.obstacles.candidates.size(), fresh.obstacles.candidates.size());
  for (std::size_t i = 0; i < fresh.obstacles.candidates.size(); ++i)
    EXPECT_EQ(drive.obstacles.candidates[i].p_base, fresh.obstacles.candidates[i].p_base);
}

TEST_P(EitherProfile, RefusesPicturesOfAnotherSizeAndKeepsItsHistory) {
  Drive drive(boxAhead(), parameters());
  drive.to({0, 0, 0});
  const Image<std::uint8_t> small(240, 180);
  EXPECT_EQ(drive.detector->process({9, 0.5, small.view(), {0.1, 0, 0}}, drive.obstacles),
            FrameStatus::SizeMismatch);
  EXPECT_EQ(drive.to({0.11, 0, 0}), FrameStatus::Used);
}

INSTANTIATE_TEST_SUITE_P(Chain, EitherProfile, ::testing::Values("default", "paper"),
                         [](const auto& info) { return std::string(info.param); });

Parameters chainDefaults() {
  Parameters p = Parameters::profile("default");
  p.detector.kind = DetectorKind::Chain;
  return p;
}

TEST(ChainDetector, SeesNothingOnAnEmptyFloor) {
  Drive drive(wideScene(), chainDefaults());
  int used = 0;
  for (int i = 0; i < 5; ++i) {
    const FrameStatus status = drive.to({0.06 * i, 0.004 * i, 0.01 * i});
    used += status == FrameStatus::Used;
    EXPECT_TRUE(drive.obstacles.contacts.empty());
    for (const Bearing& b : drive.obstacles.bearings)
      EXPECT_TRUE(b.state == BearingState::Free || b.state == BearingState::Unknown);
  }
  EXPECT_EQ(used, 3);
}

TEST(ChainDetector, BearingsTellTheBoxFromTheFloorBesideIt) {
  Drive drive(boxAhead(), chainDefaults());
  drive.to({0, 0, 0});
  ASSERT_EQ(drive.to({0.3, 0, 0}), FrameStatus::Used);
  const Obstacles& o = drive.obstacles;
  ASSERT_EQ(o.bearings.size(), 80U);
  int free_beside = 0, occupied_beside = 0, stopped = 0;
  for (const Bearing& b : o.bearings) {
    // Seen from the foot, the box spans 0.32 to 0.68 rad.
    const bool stops = b.state == BearingState::Occupied || b.state == BearingState::Blocked;
    if (b.angle < 0.25F) {
      free_beside += b.state == BearingState::Free && b.range > 1.2F;
      occupied_beside += stops;
    } else {
      stopped += stops;
    }
  }
  EXPECT_GT(free_beside, 25);
  EXPECT_EQ(occupied_beside, 0);
  EXPECT_GE(stopped, 4);
  for (std::size_t i = 1; i < o.bearings.size(); ++i)
    EXPECT_LE(o.bearings[i].angle, o.bearings[i - 1].angle + 0.005F) << i;  // whole pixels
}

TEST(ChainDetector, EveryContactStandsOnAnOccupiedBearingAndMapsToItsPixel) {
  Drive drive(boxAhead(), chainDefaults());
  drive.to({0, 0, 0});
  ASSERT_EQ(drive.to({0.3, 0, 0}), FrameStatus::Used);
  const Obstacles& o = drive.obstacles;
  ASSERT_FALSE(o.contacts.empty());
  const GroundProjection floor = o.view.currentFloor();
  for (const Contact& c : o.contacts) {
    const Bearing& b = o.bearings[static_cast<std::size_t>(c.bearing)];
    EXPECT_EQ(b.state, BearingState::Occupied);
    EXPECT_NEAR(b.range, (c.p_base.cast<double>() - o.view.cameraFoot()).norm(), 1e-5);
    const auto pixel = floor.pixel(c.p_base.cast<double>());
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), c.u, 1e-3);
    EXPECT_NEAR(pixel->y(), c.v, 1e-3);
    EXPECT_LE(c.p_base.norm(), o.max_range);
  }
}

TEST(ChainDetector, DropsContactsBeyondTheRange) {
  Parameters near = chainDefaults();
  near.localization.max_range = 0.7;
  Drive drive(boxAhead(), near);
  drive.to({0, 0, 0});
  ASSERT_EQ(drive.to({0.3, 0, 0}), FrameStatus::Used);
  EXPECT_TRUE(drive.obstacles.contacts.empty());
  for (const Bearing& b : drive.obstacles.bearings) {
    EXPECT_TRUE(b.state == BearingState::Free || b.state == BearingState::Unknown);
    EXPECT_LE(b.range, 0.7F);
  }
}

TEST(ChainDetector, NeedsACamera) {
  const auto detector = makeDetector(chainDefaults());
  const Image<std::uint8_t> picture(480, 360);
  Obstacles obstacles;
  EXPECT_EQ(detector->process({0, 0.0, picture.view(), {}}, obstacles), FrameStatus::NoCamera);
}

TEST(ChainDetector, NewCameraForgetsTheHistory) {
  Drive drive(boxAhead(), chainDefaults());
  drive.to({0, 0, 0});
  drive.detector->setCamera(drive.scene.camera, drive.scene.T_base_camera);
  EXPECT_EQ(drive.to({0.11, 0, 0}), FrameStatus::NoReference);
}

// ---- the links apart --------------------------------------------------------------------------

class LinksApart : public ::testing::TestWithParam<const char*> {};

TEST_P(LinksApart, AnswerBitForBitLikeTheDetector) {
  Parameters parameters = Parameters::profile(GetParam());
  parameters.detector.kind = DetectorKind::Chain;
  Drive drive(boxAhead(), parameters);
  InversePerspectiveMapping ipm(parameters.reference);
  ipm.setCamera(drive.scene.camera, drive.scene.T_base_camera);
  Segmentation segmentation(parameters.segmentation);
  Localization localization(parameters.localization);
  int contacts = 0;
  for (int i = 0; i < 5; ++i) {
    const SE2 pose{0.15 * i - 0.3, 0.002 * i, 0.01 * i};
    const FrameStatus status = drive.to(pose);

    // What the nodelets do: every message has buffers of its own.
    const Image<std::uint8_t> picture = drive.scene.render(pose);
    const auto index = static_cast<std::uint64_t>(i);
    Image<std::uint8_t> difference(480, 360), valid(480, 360), mask(480, 360);
    GroundView view;
    Obstacles apart;
    FrameStatus apart_status = ipm.select({index, 0.1 * i, picture.view(), pose}, view);
    if (apart_status == FrameStatus::Used) {
      ipm.difference(difference.view(), valid.view());
      segmentation.process(difference.view(), valid.view(), mask.view());
      apart_status = localization.process(view, mask.view(), apart);
    }
    ipm.remember();

    ASSERT_EQ(status, apart_status);
    const Obstacles& whole = drive.obstacles;
    ASSERT_EQ(whole.contacts.size(), apart.contacts.size());
    for (std::size_t k = 0; k < apart.contacts.size(); ++k) {
      EXPECT_EQ(whole.contacts[k].bearing, apart.contacts[k].bearing);
      EXPECT_EQ(whole.contacts[k].p_base, apart.contacts[k].p_base);
      EXPECT_EQ(whole.contacts[k].score, apart.contacts[k].score);
    }
    ASSERT_EQ(whole.bearings.size(), apart.bearings.size());
    for (std::size_t k = 0; k < apart.bearings.size(); ++k) {
      EXPECT_EQ(whole.bearings[k].angle, apart.bearings[k].angle);
      EXPECT_EQ(whole.bearings[k].density, apart.bearings[k].density);
      EXPECT_EQ(whole.bearings[k].range, apart.bearings[k].range);
      EXPECT_EQ(whole.bearings[k].near, apart.bearings[k].near);
      EXPECT_EQ(whole.bearings[k].state, apart.bearings[k].state);
    }
    contacts += static_cast<int>(apart.contacts.size());
  }
  EXPECT_GT(contacts, 0);
}

INSTANTIATE_TEST_SUITE_P(Chain, LinksApart, ::testing::Values("default", "paper"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ipm_mapping::test
