#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "ipm_mapping/mapping/localized_map.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"

namespace {
std::atomic<long> allocations{0};
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace ipm_mapping {
namespace {

Obstacles frameFacing(double theta) {
  Obstacles frame;
  frame.view.T_odom_base = {0.5, 0.5, theta};
  frame.view.T_base_camera = cameraPose(0.05, 0.0, 0.45, 0.42);
  for (int i = 0; i < 80; ++i) {
    Bearing bearing;
    bearing.state = i % 2 ? BearingState::Free : BearingState::Occupied;
    bearing.angle = 0.5F - 0.0125F * static_cast<float>(i);
    bearing.near = 0.3F;
    bearing.range = 0.8F;
    frame.bearings.push_back(bearing);
    Contact contact;
    contact.p_base = {0.05F + 0.8F * std::cos(bearing.angle), 0.8F * std::sin(bearing.angle)};
    if (i % 2 == 0) frame.contacts.push_back(contact);
  }
  return frame;
}

TEST(OccupancyMap, AllocatesOnlyWhenItGrows) {
  OccupancyMap map;
  const Obstacles frames[] = {frameFacing(0.0), frameFacing(1.0), frameFacing(2.0)};
  for (const Obstacles& frame : frames) map.update(frame);
  TrinaryMap copy;
  map.copyTo(copy);
  const std::uint64_t revision = map.geometry().revision;
  const long before = allocations;
  for (const Obstacles& frame : frames) map.update(frame);
  map.copyTo(copy);
  EXPECT_EQ(allocations - before, 0);
  ASSERT_EQ(map.geometry().revision, revision);
  map.include({100.0, 0.0});
  EXPECT_GT(allocations - before, 0) << "the counter counts";
}

TEST(LocalizedMap, AllocatesOnlyUntilItsMemoryIsFull) {
  OccupancyMap map;
  LocalizedMap localized(map, MapCorrection::Follow, 4);
  const Obstacles frames[] = {frameFacing(0.0), frameFacing(1.0), frameFacing(2.0)};
  const auto drive = [&](int rounds) {
    for (int i = 0; i < rounds; ++i)
      for (const Obstacles& frame : frames) localized.update(frame, {});
  };
  drive(4);
  const long before = allocations;
  drive(4);
  EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace ipm_mapping
