// One table per parameter struct. A `Field` names a member, its unit, its range and its meaning; loops
// over the tables give validation, Python bindings, YAML reading, sliders, tuner bounds and the
// generated docs. A default stands in the struct and nowhere else.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace firstlap {

// `T` is double, int or bool. For bool min and max are 0 and 1.
template <class Struct, class T>
struct Field {
  std::string_view name;
  T Struct::*member;
  std::string_view unit;
  double min;
  double max;
  std::string_view doc;
};

template <class Struct, class T>
Field(const char*, T Struct::*, const char*, double, double, const char*) -> Field<Struct, T>;

// Calls `visit(field)` for every field of the table of `Struct`.
template <class Struct, class Visitor>
constexpr void for_each_field(Visitor&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Struct::fields());
}

// A number as people write it: without zeros that say nothing.
inline std::string plain(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

// Throws std::invalid_argument where `low` is above `high`; both names are of the table, section.name.
inline void require_order(double low, double high, const char* low_name, const char* high_name) {
  if (low > high)
    throw std::invalid_argument(std::string(low_name) + " is " + plain(low) + ", allowed at most " + high_name +
                                ", which is " + plain(high));
}

// Throws std::invalid_argument naming the field, the value and the allowed range.
template <class Struct>
void validate(const Struct& params, std::string_view section) {
  for_each_field<Struct>([&](const auto& field) {
    const auto value = static_cast<double>(params.*(field.member));
    if (!(value >= field.min && value <= field.max)) {
      throw std::invalid_argument(std::string(section) + "." + std::string(field.name) + " is " +
                                  (std::isfinite(value) ? plain(value) : "not finite") + ", allowed " +
                                  plain(field.min) + " to " + plain(field.max) +
                                  (field.unit.empty() ? "" : " " + std::string(field.unit)));
    }
  });
}

}  // namespace firstlap
