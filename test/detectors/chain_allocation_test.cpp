// No memory is asked for in a frame once every buffer has its size.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "ipm_mapping/detectors/contact_memory.hpp"
#include "ipm_mapping/detectors/pipeline.hpp"
#include "support/fan_world.hpp"
#include "support/ray_scene.hpp"

namespace {
std::atomic<long> allocations{0};

// Out of line: the compiler would pair this free() with the built-in new.
[[gnu::noinline]] void release(void* p) { std::free(p); }
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }

namespace ipm_mapping::test {
namespace {

class Allocation : public ::testing::TestWithParam<const char*> {};

TEST_P(Allocation, HappensDuringWarmUpOnly) {
  Parameters parameters = Parameters::profile(GetParam());
  parameters.detector.kind = DetectorKind::Chain;
  parameters.reference.history = 4;
  RayScene scene = wideScene();
  std::vector<Image<std::uint8_t>> pictures;
  std::vector<SE2> poses;
  for (int i = 0; i < 10; ++i) {
    // The first frames see an empty floor, the last ones several boxes.
    if (i == 6) scene.boxes = {{1.1, 1.4, 0.35, 0.75, 0.4}, {1.2, 1.5, -0.8, -0.4, 0.4}};
    poses.push_back({0.12 * i - 0.7, 0.0, 0.01 * i});
    pictures.push_back(scene.render(poses.back()));
  }
  const auto detector = makeDetector(parameters);
  detector->setCamera(scene.camera, scene.T_base_camera);
  Obstacles obstacles;
  const auto drive = [&](std::size_t i) {
    const auto index = static_cast<std::uint64_t>(i);
    return detector->process({index, 0.1 * static_cast<double>(i), pictures[i].view(), poses[i]},
                             obstacles);
  };
  for (std::size_t i = 0; i < 6; ++i) drive(i);
  const long before = allocations;
  int used = 0;
  for (std::size_t i = 6; i < pictures.size(); ++i) used += drive(i) == FrameStatus::Used;
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(used, 4);
  EXPECT_GT(obstacles.candidates.size(), 0U);
}

TEST(AllocationCount, CountsTheLibrarysAllocations) {
  const long before = allocations;
  const auto detector = makeDetector(Parameters::profile("paper"));
  EXPECT_GT(allocations - before, 0);
}

TEST(MemoryAllocation, HappensDuringWarmUpOnly) {
  MemoryParameters parameters;
  parameters.filter = true;
  ContactMemory memory(parameters);
  const FanWorld world{{{{2.0, 0.3}, 0.2}, {{2.2, -0.4}, 0.3}}};
  std::vector<Obstacles> seen;
  for (int k = 0; k < 80; ++k) seen.push_back(world.seenFrom({0.01 * k, 0.0, 0.0}, 0.1 * k));
  Obstacles recalled;
  std::size_t contacts = 0;
  const auto drive = [&](int from, int to) {
    for (int k = from; k < to; ++k) {
      Obstacles& answer = seen[static_cast<std::size_t>(k)];
      Frame frame{0, answer.view.stamp, GrayView{}, answer.view.T_odom_base};
      memory.follow(frame, FrameStatus::Used, answer);
      frame.stamp += 0.05;
      memory.follow(frame, FrameStatus::NoMotion, recalled);
      contacts += recalled.contacts.size();
    }
  };
  // Until the nearest view of the obstacles has passed through every slot.
  drive(0, 80);
  seen.clear();
  for (int k = 0; k < 80; ++k) seen.push_back(world.seenFrom({0.01 * k, 0.0, 0.0}, 10 + 0.1 * k));
  contacts = 0;
  const long before = allocations;
  drive(0, 80);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(contacts, 500U);
}

INSTANTIATE_TEST_SUITE_P(Chain, Allocation, ::testing::Values("default", "paper"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace ipm_mapping::test
