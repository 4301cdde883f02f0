#include "ipm_mapping/ros/parameter_loader.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "ipm_mapping/parameters/node_parameters.hpp"

namespace ipm_mapping {
namespace {

std::string errorOf(const ParameterTexts& texts) {
  std::vector<std::string> unknown;
  try {
    (void)parametersFrom(texts, unknown);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "accepted";
}

bool names(const std::string& text, const std::string& what) {
  return text.find(what) != std::string::npos;
}

/// Every parameter as text.
ParameterTexts allTexts(const Parameters& parameters) {
  ParameterTexts texts;
  Parameters::groups(parameters, [&](const char* group, const auto& fields) {
    describeFields(fields, [&](const FieldText& field) {
      texts[std::string(group) + "/" + field.name] = field.value;
    });
  });
  return texts;
}

TEST(ParameterLoader, NothingGivenIsTheDefaultProfile) {
  std::vector<std::string> unknown;
  EXPECT_EQ(allTexts(parametersFrom({}, unknown)), allTexts(Parameters::profile("default")));
  EXPECT_EQ(allTexts(parametersFrom({{"profile", "paper"}}, unknown)),
            allTexts(Parameters::profile("paper")));
  EXPECT_TRUE(unknown.empty());
}

TEST(ParameterLoader, TreeOfTheParameterServerReachesEveryKindOfField) {
  XmlRpc::XmlRpcValue tree;
  tree["profile"] = "paper";
  tree["map"]["resolution"] = 0.1;
  tree["camera"]["z"] = 1;  // an integer where a number is meant
  tree["camera"]["pose_from_tf"] = false;
  tree["camera"]["calibration_file"] = "/a/b c.yaml";
  tree["localization"]["n_lines"] = 120;
  tree["localization"]["method"] = "score";
  tree["image_transport"] = "compressed";
  std::vector<std::string> unknown;
  const Parameters p = parametersFrom(textsOf(tree), unknown);
  EXPECT_EQ(p.map.resolution, 0.1);
  EXPECT_EQ(p.camera.z, 1.0);
  EXPECT_FALSE(p.camera.pose_from_tf);
  EXPECT_EQ(p.camera.calibration_file, "/a/b c.yaml");
  EXPECT_EQ(p.localization.n_lines, 120);
  EXPECT_EQ(p.localization.method, ContactMethod::Score);
  EXPECT_EQ(p.map.update, MapUpdate::MarkOnce) << "the profile below";
  EXPECT_TRUE(unknown.empty());
}

TEST(ParameterLoader, NumbersLoseNoBitOnTheirWay) {
  XmlRpc::XmlRpcValue tree;
  tree["camera"]["pitch"] = 0.1 + 0.2;
  std::vector<std::string> unknown;
  EXPECT_EQ(parametersFrom(textsOf(tree), unknown).camera.pitch, 0.1 + 0.2);
}

TEST(ParameterLoader, MistypedNamesOfAKnownGroupAreReported) {
  std::vector<std::string> unknown;
  (void)parametersFrom({{"map/resolutoin", "0.1"}, {"elsewhere/x", "1"}, {"queue", "3"}}, unknown);
  EXPECT_EQ(unknown, std::vector<std::string>{"map/resolutoin"});
}

TEST(ParameterLoader, WrongValuesAreRefusedByName) {
  EXPECT_TRUE(names(errorOf({{"map/resolution", "fine"}}), "map/resolution"));
  EXPECT_TRUE(names(errorOf({{"map/resolution", "-1"}}), "map/resolution"));
  EXPECT_TRUE(names(errorOf({{"localization/n_lines", "80.5"}}), "localization/n_lines"));
  EXPECT_TRUE(names(errorOf({{"camera/pose_from_tf", "yes"}}), "camera/pose_from_tf"));
  EXPECT_TRUE(names(errorOf({{"map/update", "sometimes"}}), "log_odds | mark_once"));
  EXPECT_TRUE(names(errorOf({{"profile", "papre"}}), "'papre'"));
  EXPECT_TRUE(names(errorOf({{"profile", "/nowhere/x.yaml"}}), "/nowhere/x.yaml"));
}

TEST(ParameterLoader, ProfileFileStandsOnAProfileAndBelowThePrivateParameters) {
  const std::string path = testing::TempDir() + "/parameter_loader_test.yaml";
  std::ofstream(path) << "profile: paper\nmap:\n  resolution: 0.2\n  hit: 0.5\n  typo: 1\n";
  std::vector<std::string> unknown;
  const Parameters p = parametersFrom({{"profile", path}, {"map/hit", "0.7"}}, unknown);
  std::remove(path.c_str());
  EXPECT_EQ(p.map.resolution, 0.2);
  EXPECT_EQ(p.map.hit, 0.7);
  EXPECT_EQ(p.map.update, MapUpdate::MarkOnce);
  EXPECT_EQ(unknown, std::vector<std::string>{"map/typo"});
}

TEST(ParameterLoader, StructsOfANodeStandDirectlyInItsNamespace) {
  MapperParameters p;
  applyFields("", {{"publish_rate", "5"}, {"map/resolution", "0.1"}}, p);
  EXPECT_EQ(p.publish_rate, 5.0);
}

}  // namespace
}  // namespace ipm_mapping
