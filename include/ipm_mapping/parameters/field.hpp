#pragma once
// How a parameter struct describes itself.
//
// A parameter struct holds its defaults as member initialisers and lists its fields once in a
// static member function template
//
//   template <class Self, class Visitor>
//   static void fields(Self& self, Visitor&& field) {
//     field("min_baseline", self.min_baseline, Unit{"m"}, Range{0.0, 5.0}, "what it does");
//     field("method", self.method, "what it does");          // an enum with enumNames()
//     field("refine", self.refine, "what it does");          // a bool
//   }
//
// Everything else (validation, ROS and YAML loading, dynamic_reconfigure, the tables of the
// documentation, the profiles in config/) is a visitor.

#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace ipm_mapping {

/// Unit of a field as it is printed in the documentation; empty for pure numbers.
struct Unit {
  const char* symbol = "";
};

/// Closed interval of allowed values, in the field's unit.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool contains(double value) const { return value >= lowest && value <= highest; }
};

/// Thrown by validation and by loaders; what() names the parameter, its value and what is allowed.
class ParameterError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Names of an enum's values, in order from 0. Specialised beside each enum:
///   template <> inline constexpr std::array<const char*, 2> enum_names<Method>{"score",
///   "triangle"};
template <class Enum>
inline constexpr std::array<const char*, 0> enum_names{};

}  // namespace ipm_mapping
