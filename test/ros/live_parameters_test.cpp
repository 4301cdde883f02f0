#include "ipm_mapping/ros/live_parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

using dynamic_reconfigure::Config;

const std::vector<std::string> groups{"segmentation", "localization", "camera"};

template <class Entries, class Value>
void set(Entries& entries, const std::string& name, const Value& value) {
  typename Entries::value_type entry;
  entry.name = name;
  entry.value = value;
  entries.push_back(entry);
}

template <class Entries>
auto valueOf(const Entries& entries, const std::string& name) {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const auto& entry) { return entry.name == name; });
  EXPECT_NE(found, entries.end()) << name;
  return found->value;
}

TEST(LiveParameters, DescriptionHoldsEveryFieldOfTheStructsWithItsDefaultAndRange) {
  const Parameters defaults;
  const auto description = describe(defaults, groups);
  std::size_t fields = 0;
  Parameters::groups(defaults, [&](const std::string& group, const auto& fields_of_group) {
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) return;
    const auto entry = std::find_if(description.groups.begin(), description.groups.end(),
                                    [&](const auto& candidate) { return candidate.name == group; });
    ASSERT_NE(entry, description.groups.end());
    EXPECT_EQ(entry->parent, 0);
    forEachField(
        fields_of_group, [&](const char* field, const auto& value, Unit, Range range, const char*) {
          using T = std::decay_t<decltype(value)>;
          const std::string name = group + "/" + field;
          const auto parameter =
              std::find_if(entry->parameters.begin(), entry->parameters.end(),
                           [&](const auto& candidate) { return candidate.name == name; });
          ASSERT_NE(parameter, entry->parameters.end()) << name;
          EXPECT_FALSE(parameter->description.empty());
          ++fields;
          if constexpr (std::is_same_v<T, double>) {
            EXPECT_EQ(parameter->type, "double");
            EXPECT_EQ(valueOf(description.dflt.doubles, name), value);
            EXPECT_EQ(valueOf(description.min.doubles, name), range.lowest);
            EXPECT_EQ(valueOf(description.max.doubles, name), range.highest);
          } else if constexpr (std::is_same_v<T, int>) {
            EXPECT_EQ(parameter->type, "int");
            EXPECT_EQ(valueOf(description.min.ints, name), static_cast<int>(range.lowest));
            EXPECT_EQ(valueOf(description.max.ints, name), static_cast<int>(range.highest));
          } else if constexpr (std::is_enum_v<T>) {
            EXPECT_EQ(parameter->type, "str");
            for (const char* choice : enum_names<T>)
              EXPECT_NE(parameter->edit_method.find(std::string("'value': '") + choice + "'"),
                        std::string::npos);
          }
        });
  });
  std::size_t described = 0;
  for (const auto& group : description.groups) described += group.parameters.size();
  EXPECT_EQ(described, fields);
  EXPECT_GT(fields, 20U);
}

TEST(LiveParameters, RequestChangesWhatItNamesAndNothingElse) {
  Parameters parameters = Parameters::profile("paper");
  const auto before = toConfig(parameters, groups);
  Config request;
  set(request.ints, "segmentation/min_threshold", 17);
  set(request.strs, "localization/method", std::string("score"));
  set(request.bools, "camera/pose_from_tf", std::uint8_t{0});
  set(request.doubles, "camera/pitch", 0.1 + 0.2);
  EXPECT_TRUE(applyConfig(request, groups, parameters).empty());
  EXPECT_EQ(parameters.segmentation.min_threshold, 17);
  EXPECT_EQ(parameters.localization.method, ContactMethod::Score);
  EXPECT_FALSE(parameters.camera.pose_from_tf);
  EXPECT_EQ(parameters.camera.pitch, 0.1 + 0.2);
  const auto after = toConfig(parameters, groups);
  int changed = 0;
  for (std::size_t i = 0; i < after.doubles.size(); ++i)
    changed += after.doubles[i].value != before.doubles[i].value;
  EXPECT_EQ(changed, 1);
}

TEST(LiveParameters, NumbersAreClampedToTheirRangeWhichIsSaid) {
  Parameters parameters;
  Config request;
  set(request.ints, "segmentation/min_threshold", 1000);
  set(request.doubles, "segmentation/min_separability", -5.0);
  const auto said = applyConfig(request, groups, parameters);
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0],
            "segmentation/min_threshold: 1000 is outside its range, 255 is the nearest that is "
            "allowed");
  EXPECT_NE(said[1].find("segmentation/min_separability: -5"), std::string::npos) << said[1];
  EXPECT_EQ(parameters.segmentation.min_threshold, 255);
  EXPECT_EQ(parameters.segmentation.min_separability, 0.0);
}

TEST(LiveParameters, WhatCannotBeTakenIsNamed) {
  Parameters parameters;
  Config request;
  set(request.strs, "localization/method", std::string("guess"));
  set(request.doubles, "segmentation/min_separability", std::numeric_limits<double>::quiet_NaN());
  set(request.doubles, "map/resolution", 1.0);
  set(request.ints, "segmentation/min_threshold", 9);
  const auto refused = applyConfig(request, groups, parameters);
  ASSERT_EQ(refused.size(), 3U);
  EXPECT_NE(refused[0].find("segmentation/min_separability"), std::string::npos);
  EXPECT_NE(refused[1].find("score | triangle"), std::string::npos);
  EXPECT_NE(refused[2].find("map/resolution"), std::string::npos);
  EXPECT_EQ(parameters.map.resolution, Parameters{}.map.resolution);
  EXPECT_EQ(parameters.segmentation.min_threshold, 9) << "the rest of the request counts";
}

TEST(LiveParameters, ContradictionsLeaveEverythingAsItWas) {
  Parameters parameters;
  Config request;
  set(request.doubles, "map/free_below", 0.5);
  set(request.doubles, "map/occupied_above", 0.5);
  set(request.doubles, "map/hit", 1.25);
  EXPECT_FALSE(applyConfig(request, {"map"}, parameters).empty());
  EXPECT_EQ(parameters.map.free_below, Parameters{}.map.free_below);
  EXPECT_EQ(parameters.map.hit, Parameters{}.map.hit);
}

}  // namespace
}  // namespace ipm_mapping
