#include "ipm_mapping/ros/parameter_loader.hpp"

#include <ros/console.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <iomanip>
#include <limits>
#include <sstream>

namespace ipm_mapping {
namespace {

std::string textOf(double value) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << value;
  return out.str();
}

void flatten(XmlRpc::XmlRpcValue value, const std::string& path, ParameterTexts& texts) {
  using Value = XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case Value::TypeStruct:
      for (auto& member : value)
        flatten(member.second, path.empty() ? member.first : path + "/" + member.first, texts);
      break;
    case Value::TypeBoolean:
      texts[path] = static_cast<bool>(value) ? "true" : "false";
      break;
    case Value::TypeInt:
      texts[path] = std::to_string(static_cast<int>(value));
      break;
    case Value::TypeDouble:
      texts[path] = textOf(static_cast<double>(value));
      break;
    case Value::TypeString:
      texts[path] = static_cast<std::string>(value);
      break;
    default:
      break;
  }
}

void flatten(const YAML::Node& node, const std::string& path, ParameterTexts& texts) {
  if (node.IsScalar()) texts[path] = node.Scalar();
  if (!node.IsMap()) return;
  for (const auto& member : node) {
    const auto name = member.first.as<std::string>();
    flatten(member.second, path.empty() ? name : path + "/" + name, texts);
  }
}

bool isFile(const std::string& profile) {
  const auto& names = Parameters::profileNames();
  return std::find(names.begin(), names.end(), profile) == names.end() &&
         profile.find_first_of("./") != std::string::npos;
}

}  // namespace

ParameterTexts textsOf(const XmlRpc::XmlRpcValue& tree) {
  ParameterTexts texts;
  flatten(tree, "", texts);
  return texts;
}

ParameterTexts readParameterFile(const std::string& path) {
  ParameterTexts texts;
  try {
    flatten(YAML::LoadFile(path), "", texts);
  } catch (const std::exception& error) {
    throw ParameterError("parameter file '" + path + "': " + error.what());
  }
  return texts;
}

std::vector<std::string> applyGroups(const ParameterTexts& texts, Parameters& parameters) {
  std::vector<std::string> unknown;
  Parameters::groups(parameters, [&](const char* name, auto& group) {
    for (std::string& each : applyFields(std::string(name) + "/", texts, group))
      unknown.push_back(std::move(each));
  });
  return unknown;
}

Parameters parametersFrom(const ParameterTexts& texts, std::vector<std::string>& unknown) {
  const auto named = texts.find("profile");
  const std::string profile = named == texts.end() ? "default" : named->second;
  Parameters parameters;
  if (isFile(profile)) {
    const ParameterTexts file = readParameterFile(profile);
    const auto base = file.find("profile");
    parameters = Parameters::profile(base == file.end() ? "default" : base->second);
    unknown = applyGroups(file, parameters);
  } else {
    parameters = Parameters::profile(profile);
  }
  for (std::string& each : applyGroups(texts, parameters)) unknown.push_back(std::move(each));
  parameters.validate();
  return parameters;
}

ParameterTexts privateTexts(const ros::NodeHandle& private_node) {
  XmlRpc::XmlRpcValue tree;
  private_node.getParam(private_node.getNamespace(), tree);
  return textsOf(tree);
}

Parameters loadParameters(const ros::NodeHandle& private_node) {
  std::vector<std::string> unknown;
  Parameters parameters = parametersFrom(privateTexts(private_node), unknown);
  for (const std::string& name : unknown)
    ROS_WARN("%s: parameter '%s' does not exist and is ignored",
             private_node.getNamespace().c_str(), name.c_str());
  return parameters;
}

}  // namespace ipm_mapping
