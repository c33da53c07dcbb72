// C++ results as plain Python data (dicts, lists, tuples, numpy arrays), according to their types and tables.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <nanobind/nanobind.h>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/sides.hpp"
#include "firstlap/sim/race_result.hpp"
#include "records.hpp"

namespace firstlap::bindings {

// Python representation of a struct with a table: a dict, an object of its own class, or a tuple.
enum class Form { dict, record, tuple };

template <class T>
inline constexpr Form form = Form::dict;
template <>
inline constexpr Form form<sim::Lap> = Form::record;
template <>
inline constexpr Form form<sim::Contact> = Form::record;
template <>
inline constexpr Form form<sim::ObstacleSeen> = Form::record;
template <>
inline constexpr Form form<Point2> = Form::tuple;
template <>
inline constexpr Form form<Pose2> = Form::tuple;
template <>
inline constexpr Form form<StepResult> = Form::tuple;
template <>
inline constexpr Form form<SplitCandidate> = Form::tuple;

template <class T>
concept Named = std::is_enum_v<T> && requires(T value) { to_string(value); };

template <class T>
concept Iterable = requires(const T& items) {
  items.begin();
  items.size();
};

template <class T>
nb::object to_python(const T& value);

template <HasColumns T>
nb::tuple as_tuple(const T& value) {
  return std::apply([&](const auto&... column) { return nb::make_tuple(to_python(std::invoke(column.get, value))...); },
                    flat_columns<T>());
}

template <HasColumns T>
nb::dict as_dict(const T& value) {
  nb::dict result;
  for_each_column<T>(
      [&](const auto& column) { result[text(column.name)] = to_python(std::invoke(column.get, value)); });
  return result;
}

// Element type of a numpy array of such values.
template <class T>
struct Element {
  using Type = std::conditional_t<std::integral<T> && (sizeof(T) > 1), std::int64_t, T>;
};
template <class T>
  requires std::is_enum_v<T>
struct Element<T> {
  using Type = std::underlying_type_t<T>;
};

// A numpy array with `get` of every item.
template <Iterable Items, class Get>
nb::object to_array(const Items& items, const Get& get) {
  using T = std::remove_cvref_t<std::invoke_result_t<const Get&, decltype(*items.begin())>>;
  if constexpr (std::is_same_v<T, Point2>) {
    std::vector<double> rows;
    rows.reserve(column_count<Point2> * items.size());
    for (const auto& item : items) append_row(std::invoke(get, item), rows);
    return nb::cast(to_numpy(std::move(rows), column_count<Point2>));
  } else if constexpr (std::is_same_v<T, bool>) {
    return nb::cast(flags(items, [&](const auto& item) { return std::invoke(get, item); }));
  } else {
    return nb::cast(column<typename Element<T>::Type>(items, [&](const auto& item) { return std::invoke(get, item); }));
  }
}

// Numbers and points become an array, objects and tuples a list, other structs a dict of arrays.
template <Iterable Items>
nb::object from_sequence(const Items& items) {
  using T = std::remove_cvref_t<decltype(*items.begin())>;
  if constexpr (!HasColumns<T> || std::is_same_v<T, Point2>) {
    return to_array(items, std::identity{});
  } else if constexpr (form<T> == Form::dict) {
    nb::dict result;
    for_each_column<T>([&](const auto& column) { result[text(column.name)] = to_array(items, column.get); });
    return result;
  } else {
    nb::list result;
    for (const T& item : items) result.append(to_python(item));
    return result;
  }
}

template <class Items, class Get>
nb::object from_part(const OfEach<Items, Get>& part) {
  return to_array(part.items, part.get);
}

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

template <class T>
inline constexpr bool is_pair = false;
template <class A, class B>
inline constexpr bool is_pair<std::pair<A, B>> = true;

template <class T>
nb::object to_python(const T& value) {
  if constexpr (Named<T>) {
    return nb::str(to_string(value));
  } else if constexpr (std::is_enum_v<T>) {
    return nb::cast(static_cast<int>(value));
  } else if constexpr (is_optional<T>) {
    return value ? to_python(*value) : nb::none();
  } else if constexpr (is_pair<T>) {
    return nb::make_tuple(value.first, value.second);
  } else if constexpr (HasColumns<T> && form<T> == Form::dict) {
    return as_dict(value);
  } else if constexpr (HasColumns<T> && form<T> == Form::tuple) {
    return as_tuple(value);
  } else if constexpr (Iterable<T>) {
    return from_sequence(value);
  } else if constexpr (requires { from_part(value); }) {
    return from_part(value);
  } else {
    return nb::cast(value);
  }
}

}  // namespace firstlap::bindings
