#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <string>
#include <vector>

#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {

/// Parameters as text by path, `map/resolution` -> `0.05`: what the parameter server and a YAML
/// file have in common.
using ParameterTexts = std::map<std::string, std::string>;

/// Scalars of a parameter server's tree; lists are left out.
[[nodiscard]] ParameterTexts textsOf(const XmlRpc::XmlRpcValue& tree);
/// Scalars of a YAML file. Throws ParameterError naming the file.
[[nodiscard]] ParameterTexts readParameterFile(const std::string& path);

/// Sets the fields that `texts` names. Returns the names under the struct's prefix that it does not
/// have. Throws ParameterError naming the parameter.
template <class Struct>
std::vector<std::string> applyFields(const std::string& prefix, const ParameterTexts& texts,
                                     Struct& parameters) {
  ParameterTexts left;
  for (const auto& [path, text] : texts)
    if (path.compare(0, prefix.size(), prefix) == 0) left.emplace(path, text);
  forEachField(parameters, [&](const char* name, auto& value, Unit, Range, const char*) {
    const auto found = left.find(prefix + name);
    if (found == left.end()) return;
    setFromText(found->first, found->second, value);
    left.erase(found);
  });
  std::vector<std::string> unknown;
  for (const auto& each : left) unknown.push_back(each.first);
  return unknown;
}

/// The same for every group, `group/field`. Names of no group at all are not reported.
std::vector<std::string> applyGroups(const ParameterTexts& texts, Parameters& parameters);

/// Parameters of a node from its texts: the profile that `profile` names (default, paper or a YAML
/// file), changed by what else is there, validated. Unknown names go to `unknown`.
[[nodiscard]] Parameters parametersFrom(const ParameterTexts& texts,
                                        std::vector<std::string>& unknown);

/// Everything below a node handle's namespace, in one request.
[[nodiscard]] ParameterTexts privateTexts(const ros::NodeHandle& private_node);

/// parametersFrom() for a nodelet; unknown names are warned about.
[[nodiscard]] Parameters loadParameters(const ros::NodeHandle& private_node);

/// A struct whose fields stand directly in the private namespace, validated.
template <class Struct>
[[nodiscard]] Struct loadStruct(const ros::NodeHandle& private_node) {
  Struct parameters;
  applyFields("", privateTexts(private_node), parameters);
  validateFields(private_node.getNamespace(), parameters);
  return parameters;
}

}  // namespace ipm_mapping
