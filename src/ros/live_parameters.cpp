#include "ipm_mapping/ros/live_parameters.hpp"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include "ipm_mapping/parameters/visitors.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

using dynamic_reconfigure::Config;

template <class T>
inline constexpr bool is_number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// `use(group, "group/field", value, unit, range, doc)` for every field of the groups.
template <class AnyParameters, class Use>
void forFields(AnyParameters& parameters, const std::vector<std::string>& groups, Use&& use) {
  std::decay_t<AnyParameters>::groups(parameters, [&](const std::string& name, auto& group) {
    if (std::find(groups.begin(), groups.end(), name) == groups.end()) return;
    forEachField(group,
                 [&](const char* field, auto& value, Unit unit, Range range, const char* doc) {
                   use(name, name + "/" + field, value, unit, range, doc);
                 });
  });
}

template <class Entry, class Value>
void append(std::vector<Entry>& entries, const std::string& name, const Value& value) {
  Entry entry;
  entry.name = name;
  entry.value = value;
  entries.push_back(entry);
}

template <class T>
void append(Config& config, const std::string& name, const T& value) {
  if constexpr (std::is_same_v<T, bool>)
    append(config.bools, name, static_cast<std::uint8_t>(value));
  else if constexpr (std::is_enum_v<T> || std::is_same_v<T, std::string>)
    append(config.strs, name, parameter_detail::valueText(value));
  else if constexpr (std::is_integral_v<T>)
    append(config.ints, name, static_cast<std::int32_t>(value));
  else
    append(config.doubles, name, value);
}

/// A bound as dynamic_reconfigure can send it: of the field's own type.
template <class T>
T bound(double limit) {
  const double lowest = static_cast<double>(std::numeric_limits<T>::lowest());
  const double highest = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(std::clamp(limit, lowest, highest));
}

// Only numbers have a range; a bool has two values, and a text stands for itself.
bool lowestOf(bool) { return false; }
bool highestOf(bool) { return true; }
template <class Text>
const Text& lowestOf(const Text& value) {
  return value;
}
template <class Text>
const Text& highestOf(const Text& value) {
  return value;
}

/// Drop-down menu of an enum, in the form that rqt_reconfigure evaluates.
template <class Enum>
std::string menu() {
  std::string entries;
  for (const char* name : enum_names<Enum>)
    entries += sentence(entries.empty() ? "" : ", ", "{'name': '", name, "', 'type': 'str', ",
                        "'value': '", name, "', 'description': '', 'srcline': 0, 'srcfile': '', ",
                        "'cconsttype': 'const char * const', 'ctype': 'std::string'}");
  return "{'enum_description': 'choices', 'enum': [" + entries + "]}";
}

template <class T>
dynamic_reconfigure::ParamDescription describeField(const std::string& name, Unit unit,
                                                    const char* doc) {
  dynamic_reconfigure::ParamDescription description;
  description.name = name;
  description.type = parameter_detail::typeName<T>();
  if (std::is_enum_v<T> || std::is_same_v<T, std::string>) description.type = "str";
  const std::string symbol = unit.symbol;
  description.description = symbol.empty() ? doc : sentence(doc, " [", symbol, "]");
  if constexpr (std::is_enum_v<T>) description.edit_method = menu<T>();
  return description;
}

/// What a request asks for, by name.
using Wishes = std::map<std::string, std::string>;

Wishes wishesOf(const Config& config) {
  Wishes wishes;
  for (const auto& each : config.bools) wishes[each.name] = each.value ? "true" : "false";
  for (const auto& each : config.ints) wishes[each.name] = std::to_string(each.value);
  for (const auto& each : config.strs) wishes[each.name] = each.value;
  for (const auto& each : config.doubles) {
    std::ostringstream text;
    text.precision(std::numeric_limits<double>::max_digits10);
    text << each.value;
    wishes[each.name] = text.str();
  }
  return wishes;
}

/// As a value within the range; says so where that is another one.
template <class T>
void grant(const std::string& name, const std::string& wish, Range range, T& value,
           std::vector<std::string>& complaints) {
  T wanted = value;
  setFromText(name, wish, wanted);
  if constexpr (is_number<T>) {
    if (!std::isfinite(static_cast<double>(wanted))) throw ParameterError(name + " is not finite");
    const T within = std::clamp(wanted, bound<T>(range.lowest), bound<T>(range.highest));
    if (within != wanted)
      complaints.push_back(sentence(name, ": ", wanted, " is outside its range, ", within,
                                    " is the nearest that is allowed"));
    wanted = within;
  }
  value = wanted;
}

dynamic_reconfigure::GroupState state(const std::string& name, int id) {
  dynamic_reconfigure::GroupState group;
  group.name = name;
  group.state = 1;
  group.id = id;
  group.parent = 0;
  return group;
}

}  // namespace

std::vector<std::string> applyConfig(const Config& config, const std::vector<std::string>& groups,
                                     Parameters& parameters) {
  std::vector<std::string> complaints;
  Wishes wishes = wishesOf(config);
  Parameters candidate = parameters;
  forFields(candidate, groups,
            [&](const std::string&, const std::string& name, auto& value, Unit, Range range,
                const char*) {
              const auto wish = wishes.find(name);
              if (wish == wishes.end()) return;
              try {
                grant(name, wish->second, range, value, complaints);
              } catch (const ParameterError& error) {
                complaints.emplace_back(error.what());
              }
              wishes.erase(wish);
            });
  for (const auto& wish : wishes) complaints.push_back(wish.first + " cannot be changed here");
  try {
    candidate.validate();
    parameters = candidate;
  } catch (const ParameterError& error) {
    complaints.emplace_back(error.what());
  }
  return complaints;
}

Config toConfig(const Parameters& parameters, const std::vector<std::string>& groups) {
  Config config;
  config.groups.push_back(state("Default", 0));
  forFields(parameters, groups,
            [&](const std::string& group, const std::string& name, const auto& value, Unit, Range,
                const char*) {
              append(config, name, value);
              if (config.groups.back().name != group)
                config.groups.push_back(state(group, static_cast<int>(config.groups.size())));
            });
  return config;
}

dynamic_reconfigure::ConfigDescription describe(const Parameters& defaults,
                                                const std::vector<std::string>& groups) {
  dynamic_reconfigure::ConfigDescription description;
  description.dflt = toConfig(defaults, groups);
  for (const auto& group : description.dflt.groups) {
    dynamic_reconfigure::Group& entry = description.groups.emplace_back();
    entry.name = group.name;
    entry.id = group.id;
    entry.parent = group.parent;
  }
  forFields(defaults, groups,
            [&](const std::string& group, const std::string& name, const auto& value, Unit unit,
                Range range, const char* doc) {
              using T = std::decay_t<decltype(value)>;
              for (auto& entry : description.groups)
                if (entry.name == group)
                  entry.parameters.push_back(describeField<T>(name, unit, doc));
              if constexpr (is_number<T>) {
                append(description.min, name, bound<T>(range.lowest));
                append(description.max, name, bound<T>(range.highest));
              } else {
                append(description.min, name, lowestOf(value));
                append(description.max, name, highestOf(value));
              }
            });
  return description;
}

LiveParameters::LiveParameters(const ros::NodeHandle& private_node, const Parameters& parameters,
                               std::vector<std::string> groups,
                               std::function<void(const Parameters&)> changed)
    : private_node_(private_node),
      parameters_(parameters),
      groups_(std::move(groups)),
      changed_(std::move(changed)),
      descriptions_(private_node_.advertise<dynamic_reconfigure::ConfigDescription>(
          "parameter_descriptions", 1, true)),
      updates_(private_node_.advertise<Config>("parameter_updates", 1, true)),
      service_(private_node_.advertiseService("set_parameters", &LiveParameters::onRequest, this)) {
  descriptions_.publish(describe(Parameters{}, groups_));
  publish();
}

void LiveParameters::publish() { updates_.publish(toConfig(parameters_, groups_)); }

bool LiveParameters::onRequest(dynamic_reconfigure::Reconfigure::Request& request,
                               dynamic_reconfigure::Reconfigure::Response& response) {
  const Config before = toConfig(parameters_, groups_);
  for (const std::string& sentence : applyConfig(request.config, groups_, parameters_))
    ROS_WARN_STREAM(private_node_.getNamespace() << ": " << sentence);
  response.config = toConfig(parameters_, groups_);
  if (!(response.config == before)) changed_(parameters_);
  updates_.publish(response.config);
  return true;
}

}  // namespace ipm_mapping
