// Bindings of structs with a table of columns. Everything loops over the tables: no member is named here.
#pragma once

#include <cstddef>
#include <functional>
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "firstlap/common/field.hpp"

namespace firstlap::bindings {

namespace nb = nanobind;

inline nb::str text(std::string_view view) { return nb::str(view.data(), view.size()); }

template <class Record, class Get>
using ColumnValue = std::remove_cvref_t<std::invoke_result_t<const Get&, const Record&>>;

// The table of a struct: a list of dicts with name, unit and doc.
template <HasColumns Record>
nb::list column_list() {
  nb::list result;
  for_each_column<Record>([&](const auto& column) {
    nb::dict entry;
    entry["name"] = text(column.name);
    entry["unit"] = text(column.unit);
    entry["doc"] = text(column.doc);
    result.append(entry);
  });
  return result;
}

template <HasColumns Record>
nb::tuple as_values(const Record& record) {
  return std::apply([&](const auto&... column) { return nb::make_tuple(std::invoke(column.get, record)...); },
                    flat_columns<Record>());
}

template <HasColumns Record>
nb::dict values_by_name(const Record& record) {
  nb::dict result;
  for_each_column<Record>([&](const auto& column) { result[text(column.name)] = std::invoke(column.get, record); });
  return result;
}

template <HasColumns Record, class Values>
void assign(Record& record, const Values& values) {
  constexpr auto columns = flat_columns<Record>();
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    ((std::invoke(std::get<I>(columns).get, record) = std::get<I>(values)), ...);
  }(std::make_index_sequence<column_count<Record>>{});
}

// Conversion between structs of numbers and rows.
template <HasColumns Record>
void append_row(const Record& record, std::vector<double>& rows) {
  for_each_column<Record>([&](const auto& column) { rows.push_back(std::invoke(column.get, record)); });
}

template <HasColumns Record>
Record from_row(const double* row) {
  Record record{};
  for_each_column<Record>([&](const auto& column) { std::invoke(column.get, record) = *row++; });
  return record;
}

template <HasColumns Record>
std::string representation(const char* name, const Record& record) {
  std::string result = std::string(name) + "(";
  const char* between = "";
  for_each_column<Record>([&](const auto& column) {
    const nb::object value = nb::cast(std::invoke(column.get, record));
    result += between + std::string(column.name) + "=" + nb::cast<std::string>(nb::str(nb::repr(value)));
    between = ", ";
  });
  return result + ")";
}

// Docstring of a property.
template <class Get>
std::string described(const Column<Get>& column) {
  return (column.unit.empty() ? "" : "[" + std::string(column.unit) + "] ") + std::string(column.doc);
}

// Defines a read-only property for every column of `part(object)`.
template <HasColumns Record, class Class, class Part>
void def_columns(Class& bound, Part part) {
  using Object = typename Class::Type;
  for_each_column<Record>([&](const auto& column) {
    const auto get = column.get;
    bound.def_prop_ro(
        column.name.data(), [get, part](const Object& self) { return std::invoke(get, std::invoke(part, self)); },
        described(column).c_str());
  });
}

// Defines a constructor with an argument for every column, with its default.
template <HasColumns Record, class... Gets>
void def_init(nb::class_<Record>& bound, const std::tuple<Column<Gets>...>& columns) {
  const Record defaults{};
  const auto init = [](Record* self, ColumnValue<Record, Gets>... values) {
    new (self) Record{};
    assign(*self, std::tuple{values...});
  };
  std::apply(
      [&](const auto&... column) {
        bound.def("__init__", init, (nb::arg(column.name.data()) = std::invoke(column.get, defaults))...);
      },
      columns);
}

// Binds an immutable Python class with the columns as properties; it unpacks in the order of the table.
template <HasColumns Record>
nb::class_<Record> bind_record(nb::module_& m, const char* name, const char* doc) {
  using Values = decltype(std::apply(
      [](const auto&... column) { return std::tuple<ColumnValue<Record, decltype(column.get)>...>{}; },
      flat_columns<Record>()));
  nb::class_<Record> bound(m, name, doc);
  def_init<Record>(bound, flat_columns<Record>());
  def_columns<Record>(bound, [](const Record& self) -> const Record& { return self; });
  bound.def_static("columns", &column_list<Record>, "The table: a list of dicts with name, unit and doc.")
      .def("to_dict", &values_by_name<Record>, "{name: value}, in the order of the table.")
      .def(
          "__iter__", [](const Record& self) { return nb::iter(as_values(self)); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"))
      .def(
          "__eq__", [](const Record& a, const Record& b) { return as_values(a).equal(as_values(b)); },
          nb::is_operator(), nb::sig("def __eq__(self, arg: object, /) -> bool"))
      .def("__hash__", [](const Record& self) { return nb::hash(as_values(self)); })
      .def("__repr__", [name](const Record& self) { return representation(name, self); })
      .def("__getstate__", &as_values<Record>)
      .def("__setstate__", [](Record& self, const Values& values) {
        new (&self) Record{};
        assign(self, values);
      });
  return bound;
}

}  // namespace firstlap::bindings
