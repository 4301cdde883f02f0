#pragma once
// The visitors that several rooms share: as text, from text, range check.

#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// One field, ready to print.
struct FieldText {
  std::string name, type, unit, value, range, doc;
};

namespace parameter_detail {

template <class T>
std::string typeName() {
  if constexpr (std::is_same_v<T, bool>)
    return "bool";
  else if constexpr (std::is_same_v<T, std::string>)
    return "string";
  else if constexpr (std::is_enum_v<T>)
    return "enum";
  else if constexpr (std::is_integral_v<T>)
    return "int";
  else
    return "double";
}

/// Shortest text that reads back as the same number.
inline std::string numberText(double value) {
  std::ostringstream out;
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    out.str("");
    out << std::setprecision(digits) << value;
    if (std::strtod(out.str().c_str(), nullptr) == value) break;
  }
  return out.str();
}

template <class T>
std::string valueText(const T& value) {
  if constexpr (std::is_same_v<T, bool>)
    return value ? "true" : "false";
  else if constexpr (std::is_enum_v<T>)
    return enum_names<T>.at(static_cast<std::size_t>(value));
  else if constexpr (std::is_floating_point_v<T>)
    return numberText(value);
  else if constexpr (std::is_integral_v<T>)
    return std::to_string(value);
  else
    return value;
}

/// The bound of a field of type T.
template <class T>
std::string boundText(double bound) {
  std::ostringstream out;
  if constexpr (std::is_integral_v<T>)
    out << std::llround(bound);
  else
    out << bound;
  return out.str();
}

template <class T>
std::string rangeText(Range range) {
  return boundText<T>(range.lowest) + " ... " + boundText<T>(range.highest);
}

template <class T>
std::string choices() {
  std::string all;
  for (const char* name : enum_names<T>) all += (all.empty() ? "" : " | ") + std::string(name);
  return all;
}

/// Brings the two forms of a field's declaration to one.
template <class Use>
struct Uniform {
  Use& use;
  template <class T>
  void operator()(const char* name, T& value, Unit unit, Range range, const char* doc) const {
    use(name, value, unit, range, doc);
  }
  template <class T>
  void operator()(const char* name, T& value, const char* doc) const {
    use(name, value, Unit{}, Range{}, doc);
  }
};

}  // namespace parameter_detail

/// Calls `use(name, reference to the value, Unit, Range, doc)` for every field of `parameters`,
/// whichever of the two forms the field was declared in.
template <class Struct, class Use>
void forEachField(Struct& parameters, Use&& use) {
  std::remove_const_t<Struct>::fields(parameters, parameter_detail::Uniform<Use>{use});
}

/// Calls `use(FieldText)` for every field.
template <class Struct, class Use>
void describeFields(const Struct& parameters, Use&& use) {
  forEachField(parameters, [&use](const char* name, const auto& value, Unit unit, Range range,
                                  const char* doc) {
    using T = std::remove_cv_t<std::remove_reference_t<decltype(value)>>;
    FieldText text{name,        parameter_detail::typeName<T>(),
                   unit.symbol, parameter_detail::valueText(value),
                   "",          doc};
    if constexpr (std::is_enum_v<T>) {
      text.range = parameter_detail::choices<T>();
    } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      if (std::isfinite(range.lowest) || std::isfinite(range.highest))
        text.range = parameter_detail::rangeText<T>(range);
    }
    use(text);
  });
}

/// Sets one value from its text; throws ParameterError naming `name` and what is allowed.
template <class T>
void setFromText(const std::string& name, const std::string& text, T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    value = text;
  } else if constexpr (std::is_same_v<T, bool>) {
    if (text != "true" && text != "false" && text != "1" && text != "0")
      throw ParameterError(name + ": '" + text + "' is neither true nor false");
    value = text == "true" || text == "1";
  } else if constexpr (std::is_enum_v<T>) {
    for (std::size_t i = 0; i < enum_names<T>.size(); ++i) {
      if (text == enum_names<T>[i]) {
        value = static_cast<T>(i);
        return;
      }
    }
    throw ParameterError(name + ": '" + text + "' is not one of " + parameter_detail::choices<T>());
  } else {
    std::istringstream in(text);
    T parsed{};
    if (!(in >> parsed) || !(in >> std::ws).eof())
      throw ParameterError(name + ": '" + text + "' is not " +
                           (std::is_integral_v<T> ? "an integer" : "a number"));
    value = parsed;
  }
}

/// Throws ParameterError for the first field outside its range.
template <class Struct>
void validateFields(const std::string& prefix, const Struct& parameters) {
  forEachField(parameters,
               [&prefix](const char* name, const auto& value, Unit unit, Range range, const char*) {
                 using T = std::remove_cv_t<std::remove_reference_t<decltype(value)>>;
                 if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
                   if (range.contains(static_cast<double>(value))) return;
                   std::ostringstream out;
                   out << prefix << "/" << name << " = " << value << " " << unit.symbol
                       << ": allowed is " << parameter_detail::rangeText<T>(range);
                   throw ParameterError(out.str());
                 }
               });
}

}  // namespace ipm_mapping
