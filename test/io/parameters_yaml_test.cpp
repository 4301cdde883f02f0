#include "ipm_mapping/io/parameters_yaml.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <random>

#include "ipm_mapping/io/nearest_name.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

Parameters parse(const std::string& text) { return parseParametersYaml(text, "my.yaml"); }

std::string errorOf(const std::string& text) {
  try {
    parse(text);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}

/// Every value of a set as text, in order.
std::vector<std::string> texts(const Parameters& parameters) {
  std::vector<std::string> all;
  Parameters::groups(parameters, [&](const char* name, const auto& group) {
    describeFields(group, [&](const FieldText& field) {
      all.push_back(std::string(name) + "/" + field.name + " = " + field.value);
    });
  });
  return all;
}

/// Gives every field another allowed value.
struct Shake {
  std::mt19937 random{3};

  template <class T>
  void operator()(const char*, T& value, Unit, Range range, const char*) {
    if constexpr (std::is_same_v<T, std::string>) {
      value = "it's: # 'odd' \\ " + std::to_string(random());
    } else if constexpr (std::is_same_v<T, bool>) {
      value = !value;
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(random() % enum_names<T>.size());
    } else {
      std::uniform_real_distribution<double> within(range.lowest, range.highest);
      value = static_cast<T>(within(random));
    }
  }
};

TEST(ParametersYaml, WhatIsWrittenIsReadBackExactlyWhateverTheBase) {
  Parameters shaken;
  Shake shake;
  Parameters::groups(shaken, [&](const char*, auto& group) { forEachField(group, shake); });
  shaken.map.free_below = 0.1 + 0.2;
  shaken.map.occupied_above = 2.0 / 3.0;
  shaken.map.clamp = 3.5;
  shaken.memory.confirm_frames = 3;
  shaken.memory.confirm_of = 5;
  for (const std::string& base : Parameters::profileNames()) {
    const Parameters back = parse(parametersYaml(shaken, base));
    EXPECT_EQ(texts(back), texts(shaken));
    EXPECT_EQ(back.map.free_below, shaken.map.free_below) << "to the last bit";
    EXPECT_EQ(back.camera.pitch, shaken.camera.pitch);
  }
}

TEST(ParametersYaml, AnEmptyFileIsTheDefaultProfile) {
  EXPECT_EQ(texts(parse("")), texts(Parameters{}));
  EXPECT_EQ(texts(parse("# nothing\nmap:\n")), texts(Parameters{}));
}

TEST(ParametersYaml, ChangesOnlyWhatItNamesOnTopOfItsProfile) {
  const Parameters p = parse("profile: paper\nmap: {resolution: 0.1, update: log_odds}\n");
  Parameters expected = Parameters::profile("paper");
  expected.map.resolution = 0.1;
  expected.map.update = MapUpdate::LogOdds;
  EXPECT_EQ(texts(p), texts(expected));
}

TEST(ParametersYaml, ErrorsNameFileLineAndParameter) {
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"\nmap:\n  resolutoin: 0.1\n", {"my.yaml:3", "map/resolutoin", "'map/resolution'"}},
      {"mapp:\n  resolution: 0.1\n", {"my.yaml:1", "group 'mapp'", "'map'"}},
      {"profile: papr\n", {"my.yaml:1", "profile 'papr'", "'paper'"}},
      {"profile: [paper]\n", {"my.yaml:1", "profile"}},
      {"map:\n  block: 64.5\n", {"my.yaml:2", "map/block", "64.5", "integer"}},
      {"map:\n  resolution: wide\n", {"my.yaml:2", "map/resolution", "wide", "number"}},
      {"map:\n  resolution: .nan\n", {"my.yaml:2", "map/resolution"}},
      {"map:\n  resolution:\n", {"my.yaml:2", "map/resolution", "value"}},
      {"map:\n  resolution: [1]\n", {"my.yaml:2", "map/resolution", "value"}},
      {"map:\n  update: bayes\n", {"my.yaml:2", "map/update", "log_odds | mark_once"}},
      {"camera:\n  pose_from_tf: maybe\n", {"my.yaml:2", "camera/pose_from_tf", "true"}},
      {"map:\n  resolution: 5\n", {"my.yaml", "map/resolution = 5 m", "0.005 ... 1"}},
      {"map: {free_below: 0.5, occupied_above: 0.5}\n", {"my.yaml", "map/free_below"}},
      {"map:\n  hit: 1\n  hit: 2\n", {"my.yaml:3", "'hit'", "twice"}},
      {"map:\n  hit: 1\nmap:\n  miss: 1\n", {"my.yaml:3", "'map'", "twice"}},
      {"map: 3\n", {"my.yaml:1", "'map'", "map of parameters"}},
      {"- map\n", {"my.yaml:1"}},
      {"map:\n  hit: {{{\n", {"my.yaml:"}}};
  for (const auto& [text, expected] : cases) {
    const std::string error = errorOf(text);
    for (const char* words : expected)
      EXPECT_NE(error.find(words), std::string::npos) << text << "-> " << error;
  }
}

TEST(ParametersYaml, AFarFetchedNameIsNotSuggested) {
  EXPECT_EQ(errorOf("map:\n  xyzzy_plugh: 1\n").find("did you mean"), std::string::npos);
}

TEST(ParametersYaml, ProfilesAreNamesAndFilesArePaths) {
  EXPECT_EQ(texts(profileOrFile("paper")), texts(Parameters::profile("paper")));
  EXPECT_THROW((void)profileOrFile("papers"), ParameterError);
  const std::string path = ::testing::TempDir() + "/parameters_yaml_test.yaml";
  std::ofstream(path) << "map: {hit: 1.25}\n";
  EXPECT_EQ(profileOrFile(path).map.hit, 1.25);
  std::remove(path.c_str());
  try {
    (void)profileOrFile(path);
    FAIL() << "a file that is not there";
  } catch (const ParameterError& error) {
    EXPECT_EQ(std::string(error.what()).find(path + ": "), 0U) << error.what();
  }
}

TEST(NearestName, IsTheOneWithTheFewestChangedLetters) {
  const std::vector<std::string> known{"resolution", "hit", "miss", "max_side", "max_size"};
  EXPECT_EQ(nearestName("reslution", known), "resolution");
  EXPECT_EQ(nearestName("hits", known), "hit");
  EXPECT_EQ(nearestName("maxside", known), "max_side");
  EXPECT_EQ(nearestName("max_sie", known), "max_side") << "the first of equals";
  EXPECT_EQ(nearestName("completely_else", known), "");
  EXPECT_EQ(nearestName("x", {}), "");
}

}  // namespace
}  // namespace ipm_mapping
