// Each parameter struct has a table of fields: name, member, unit, range and meaning. Validation, Python bindings,
// YAML, sliders, tuner bounds and the generated docs loop over the tables. A default is written only in the struct. A
// `Column` is the same for output data: bindings, JSON, logs and docs loop over the columns of scans, states, results
// and traces.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace firstlap {

// `T` is double, int or bool. For bool, min and max are 0 and 1.
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

// Calls `visit(field)` for every field in the table of `Struct`.
template <class Struct, class Visitor>
constexpr void for_each_field(Visitor&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Struct::fields());
}

// One entry of an output struct's table. `get` is a member pointer or a function of the struct.
template <class Get>
struct Column {
  std::string_view name;
  Get get;
  std::string_view unit;
  std::string_view doc;
};

template <class Get>
Column(std::string_view, Get, std::string_view, std::string_view) -> Column<Get>;

// A nested struct, or a sequence of structs, whose columns become columns of the outer table.
template <class Get>
struct Part {
  Get get;
};

template <class Get>
Part(Get) -> Part<Get>;

// Getter of a nested struct's column: applies `inner` to the result of `outer`.
template <class Outer, class Inner>
struct Through {
  Outer outer;
  Inner inner;

  constexpr decltype(auto) operator()(auto& object) const { return std::invoke(inner, std::invoke(outer, object)); }
};

template <class Outer, class Inner>
Through(Outer, Inner) -> Through<Outer, Inner>;

// `get` of every item of a sequence, evaluated lazily.
template <class Sequence, class Get>
struct OfEach {
  const Sequence& items;
  Get get;
};

template <class Sequence, class Get>
OfEach(const Sequence&, Get) -> OfEach<Sequence, Get>;

template <class Outer, class Inner>
struct ThroughEach {
  Outer outer;
  Inner inner;

  constexpr auto operator()(const auto& object) const { return OfEach{std::invoke(outer, object), inner}; }
};

template <class Outer, class Inner>
ThroughEach(Outer, Inner) -> ThroughEach<Outer, Inner>;

template <class T>
concept HasColumns = requires { T::columns(); };

template <HasColumns Struct>
constexpr auto flat_columns();

template <class Struct, class Get>
constexpr auto flatten(const Column<Get>& column) {
  return std::tuple<Column<Get>>{column};
}

template <class Struct, class Get>
constexpr auto flatten(const Part<Get>& part) {
  using Inner = std::remove_cvref_t<std::invoke_result_t<const Get&, const Struct&>>;
  if constexpr (HasColumns<Inner>) {
    return std::apply(
        [&](const auto&... inner) {
          return std::tuple{Column{inner.name, Through{part.get, inner.get}, inner.unit, inner.doc}...};
        },
        flat_columns<Inner>());
  } else {
    using Item = std::remove_cvref_t<decltype(*std::declval<const Inner&>().begin())>;
    return std::apply(
        [&](const auto&... inner) {
          return std::tuple{Column{inner.name, ThroughEach{part.get, inner.get}, inner.unit, inner.doc}...};
        },
        flat_columns<Item>());
  }
}

// The columns of `Struct`, with the columns of its parts in their place.
template <HasColumns Struct>
constexpr auto flat_columns() {
  return std::apply([](const auto&... entry) { return std::tuple_cat(flatten<Struct>(entry)...); }, Struct::columns());
}

// Calls `visit(column)` for every column in the table of `Struct`.
template <HasColumns Struct, class Visitor>
constexpr void for_each_column(Visitor&& visit) {
  std::apply([&](const auto&... column) { (visit(column), ...); }, flat_columns<Struct>());
}

template <HasColumns Struct>
inline constexpr std::size_t column_count = std::tuple_size_v<decltype(flat_columns<Struct>())>;

// A number without trailing zeros, for error messages.
inline std::string plain(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

// Throws std::invalid_argument if `low` is above `high`. The names are section.name, for the message.
inline void require_order(double low, double high, const char* low_name, const char* high_name) {
  if (low > high)
    throw std::invalid_argument(std::string(low_name) + " is " + plain(low) + ", allowed at most " + high_name +
                                ", which is " + plain(high));
}

// Throws std::invalid_argument with field, value and allowed range.
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
