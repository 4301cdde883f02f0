#include "ipm_mapping/parameters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

template <class Action>
std::string errorOf(Action&& action) {
  try {
    action();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}
bool contains(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

/// Calls use(group, field, value, range, doc) for every field of the set.
template <class Use>
void everyField(Parameters& parameters, Use&& use) {
  Parameters::groups(parameters, [&](const char* group, auto& fields) {
    forEachField(fields, [&](const char* name, auto& value, Unit, Range range, const char* doc) {
      use(std::string(group), std::string(name), value, range, std::string(doc));
    });
  });
}

template <class T>
constexpr bool is_number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

TEST(Parameters, EveryProfileIsValid) {
  for (const std::string& name : Parameters::profileNames())
    EXPECT_NO_THROW(Parameters::profile(name).validate()) << name;
}

TEST(Parameters, EveryNumberHasARangeAroundItsDefaultAndEveryFieldADescription) {
  Parameters parameters;
  int fields = 0;
  everyField(parameters, [&](const std::string& group, const std::string& name, auto& value,
                             Range range, const std::string& doc) {
    ++fields;
    EXPECT_FALSE(doc.empty()) << group << "/" << name;
    if constexpr (is_number<std::remove_reference_t<decltype(value)>>) {
      EXPECT_LT(range.lowest, range.highest) << group << "/" << name;
      EXPECT_TRUE(std::isfinite(range.lowest) && std::isfinite(range.highest))
          << group << "/" << name;
      EXPECT_TRUE(range.contains(static_cast<double>(value))) << group << "/" << name;
    }
  });
  EXPECT_GT(fields, 40);
}

TEST(Parameters, NamesAreUniqueWithinTheirGroupAndGroupsAreUnique) {
  Parameters parameters;
  std::set<std::string> names, groups;
  everyField(parameters, [&](const std::string& group, const std::string& name, auto&, Range,
                             const std::string&) {
    EXPECT_TRUE(names.insert(group + "/" + name).second) << group << "/" << name;
  });
  Parameters::groups(parameters, [&](const char* name, auto&) {
    EXPECT_TRUE(groups.insert(name).second) << name;
  });
}

TEST(Parameters, ANumberOutsideItsRangeIsRefusedByNameValueAndRange) {
  Parameters parameters;
  everyField(parameters, [&](const std::string& group, const std::string& name, auto& value,
                             Range range, const std::string&) {
    using T = std::remove_reference_t<decltype(value)>;
    if constexpr (is_number<T>) {
      const T good = value;
      for (const double wrong : {range.lowest - 1.0, range.highest + 1.0}) {
        value = static_cast<T>(wrong);
        const std::string error = errorOf([&] { parameters.validate(); });
        EXPECT_TRUE(contains(error, group + "/" + name + " = ")) << error;
        EXPECT_TRUE(contains(error, " ... ")) << error;
      }
      if constexpr (std::is_floating_point_v<T>) {
        value = std::numeric_limits<T>::quiet_NaN();
        EXPECT_TRUE(contains(errorOf([&] { parameters.validate(); }), group + "/" + name));
      }
      value = good;
    }
  });
  EXPECT_NO_THROW(parameters.validate());
}

TEST(Parameters, ContradictionsAreRefused) {
  Parameters parameters;
  parameters.map.free_below = parameters.map.occupied_above = 0.5;
  EXPECT_TRUE(contains(errorOf([&] { parameters.validate(); }), "map/free_below"));
  for (const auto& [clamp, occupied, free] :
       {std::tuple{2.0, 0.89, 0.35}, std::tuple{2.0, 0.65, 0.11}}) {
    parameters = Parameters{};
    parameters.map.clamp = clamp;
    EXPECT_NO_THROW(parameters.validate());
    parameters.map.occupied_above = occupied;
    parameters.map.free_below = free;
    EXPECT_TRUE(contains(errorOf([&] { parameters.validate(); }), "map/clamp = 2"))
        << "0.88 and 0.12 are as sure as such a map can be";
  }
}

TEST(Parameters, ProfilesDifferWhereTheSourceDoesOtherwise) {
  const Parameters paper = Parameters::profile("paper"), ours = Parameters::profile("default");
  EXPECT_EQ(paper.map.update, MapUpdate::MarkOnce);
  EXPECT_TRUE(paper.reference.previous_frame && !ours.reference.previous_frame);
  EXPECT_TRUE(paper.segmentation.previous_threshold && !ours.segmentation.previous_threshold);
  EXPECT_EQ(paper.segmentation.min_separability, 0.0);
  EXPECT_EQ(paper.localization.selection, Selection::Peaks);
  EXPECT_EQ(paper.localization.n_lines, 80);
  EXPECT_EQ(paper.map.resolution, 0.05);
  EXPECT_EQ(paper.localization.max_range, 2.0);
  const std::string error = errorOf([] { (void)Parameters::profile("papers"); });
  for (const std::string& name : Parameters::profileNames())
    EXPECT_TRUE(contains(error, name)) << error;
  EXPECT_TRUE(contains(error, "'papers'"));
}

TEST(Parameters, SetChangesOneFieldByItsPath) {
  Parameters parameters;
  parameters.set("map/resolution", "0.1");
  parameters.set("map/update", "mark_once");
  parameters.set("camera/pose_from_tf", "false");
  parameters.set("camera/calibration_file", "a b.yaml");
  EXPECT_EQ(parameters.map.resolution, 0.1);
  EXPECT_EQ(parameters.map.update, MapUpdate::MarkOnce);
  EXPECT_FALSE(parameters.camera.pose_from_tf);
  EXPECT_EQ(parameters.camera.calibration_file, "a b.yaml");
  for (const char* unknown : {"map/reso", "resolution", "map", "", "map/resolution/x"})
    EXPECT_TRUE(
        contains(errorOf([&] { parameters.set(unknown, "1"); }), "'" + std::string(unknown) + "'"));
}

TEST(Parameters, SetNamesTheParameterThatMayBeMeant) {
  Parameters parameters;
  EXPECT_EQ(errorOf([&] { parameters.set("sweep/publish_scor", "4"); }),
            "there is no parameter 'sweep/publish_scor'; did you mean 'sweep/publish_score'?");
  EXPECT_EQ(errorOf([&] { parameters.set("nonsense", "4"); }), "there is no parameter 'nonsense'");
}

// --- one value from text ---------------------------------------------------------------

template <class T>
T fromText(const std::string& text) {
  T value{};
  setFromText("group/field", text, value);
  return value;
}
template <class T>
std::string textError(const std::string& text) {
  return errorOf([&] { fromText<T>(text); });
}

TEST(SetFromText, ReadsEveryType) {
  EXPECT_EQ(fromText<int>("-12"), -12);
  EXPECT_EQ(fromText<int>(" 7 "), 7);
  EXPECT_EQ(fromText<double>("1e-3"), 0.001);
  EXPECT_EQ(fromText<double>("3"), 3.0);
  EXPECT_TRUE(fromText<bool>("true") && fromText<bool>("1"));
  EXPECT_FALSE(fromText<bool>("false") || fromText<bool>("0"));
  EXPECT_EQ(fromText<std::string>(" as it is "), " as it is ");
  EXPECT_EQ(fromText<MapUpdate>("mark_once"), MapUpdate::MarkOnce);
}

TEST(SetFromText, RefusesWhatIsNotOfTheTypeAndNamesIt) {
  for (const char* text : {"", "1.5", "x", "1x", "99999999999999", "1 2", "0x10"})
    EXPECT_TRUE(contains(textError<int>(text),
                         "group/field: '" + std::string(text) + "' is not an integer"))
        << textError<int>(text);
  for (const char* text : {"", "wide", "1.5m", "nan", "inf", "1,5"})
    EXPECT_TRUE(contains(textError<double>(text), "is not a number")) << text;
  for (const char* text : {"", "yes", "True", "2"})
    EXPECT_TRUE(contains(textError<bool>(text), "neither true nor false")) << text;
  for (const char* text : {"", "LogOdds", "log_odds "})
    EXPECT_TRUE(contains(textError<MapUpdate>(text), "log_odds | mark_once")) << text;
}

TEST(SetFromText, ARefusedTextLeavesTheValueAlone) {
  int value = 5;
  EXPECT_THROW(setFromText("a", "6x", value), ParameterError);
  EXPECT_EQ(value, 5);
}

TEST(FieldText, ReadsBackAsTheSameValue) {
  for (const double value : {0.1, 0.1 + 0.2, 1.0 / 3.0, 1e-12, 123456789.125, -0.0, 2e300})
    EXPECT_EQ(fromText<double>(parameter_detail::valueText(value)), value);
  EXPECT_EQ(parameter_detail::valueText(0.05), "0.05") << "and stays short";
  for (const MapUpdate value : {MapUpdate::LogOdds, MapUpdate::MarkOnce})
    EXPECT_EQ(fromText<MapUpdate>(parameter_detail::valueText(value)), value);
}

TEST(FieldText, DescribesTypeUnitRangeAndChoices) {
  std::vector<FieldText> fields;
  describeFields(MapParameters{}, [&](const FieldText& field) { fields.push_back(field); });
  ASSERT_GE(fields.size(), 3U);
  EXPECT_EQ(fields[0].name, "update");
  EXPECT_EQ(fields[0].type, "enum");
  EXPECT_EQ(fields[0].range, "log_odds | mark_once");
  EXPECT_EQ(fields[1].name, "resolution");
  EXPECT_EQ(fields[1].type, "double");
  EXPECT_EQ(fields[1].unit, "m");
  EXPECT_EQ(fields[1].value, "0.05");
  EXPECT_EQ(fields[1].range, "0.005 ... 1");
  describeFields(SourceParameters{}, [](const FieldText& field) {
    EXPECT_TRUE(field.type != "string" || field.range.empty()) << field.name;
  });
}

TEST(FieldText, RangesReadBackAsTheirFieldsType) {
  Parameters parameters;
  Parameters::groups(parameters, [](const char*, const auto& group) {
    describeFields(group, [](const FieldText& field) {
      if (field.type != "int") return;
      const std::size_t dots = field.range.find(" ... ");
      ASSERT_NE(dots, std::string::npos) << field.name;
      EXPECT_NO_THROW(fromText<int>(field.range.substr(0, dots))) << field.name;
      EXPECT_NO_THROW(fromText<int>(field.range.substr(dots + 5))) << field.name;
    });
  });
  parameters.fpga_clock.frame_blanking = -1;
  EXPECT_TRUE(contains(errorOf([&] { parameters.validate(); }), "0 ... 100000000"));
}

TEST(NodeParameters, DefaultsLieInTheirRanges) {
  EXPECT_NO_THROW(validateFields("source", SourceParameters{}));
  EXPECT_NO_THROW(validateFields("mapper", MapperParameters{}));
}

TEST(Range, IsClosed) {
  const Range range{-1.0, 2.0};
  EXPECT_TRUE(range.contains(-1.0) && range.contains(2.0));
  EXPECT_FALSE(range.contains(-1.0001) || range.contains(2.0001) || range.contains(std::nan("")));
}

}  // namespace
}  // namespace ipm_mapping
