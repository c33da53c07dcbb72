// Bindings of structs of parameter sections. Everything loops over the field tables: no parameter is named here.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "firstlap/common/field.hpp"
#include "records.hpp"

namespace firstlap::bindings {

namespace nb = nanobind;

template <class T>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<T, bool>) return "bool";
  if constexpr (std::is_same_v<T, int>) return "int";
  return "float";
}

// Calls `visit(section name, section, field)` for every field of every section.
template <class Sections, class Visitor>
void for_each_parameter(Sections& sections, Visitor&& visit) {
  for_each_section(sections, [&](std::string_view name, auto& section) {
    using Section = std::remove_cvref_t<decltype(section)>;
    for_each_field<Section>([&](const auto& field) { visit(name, section, field); });
  });
}

template <class Sections>
nb::list field_list() {
  const Sections defaults{};
  nb::list result;
  for_each_parameter(defaults, [&](std::string_view name, const auto& section, const auto& field) {
    const auto value = section.*(field.member);
    nb::dict entry;
    entry["section"] = text(name);
    entry["name"] = text(field.name);
    entry["unit"] = text(field.unit);
    entry["min"] = field.min;
    entry["max"] = field.max;
    entry["default"] = value;
    entry["doc"] = text(field.doc);
    entry["type"] = type_name<std::remove_cvref_t<decltype(value)>>();
    result.append(entry);
  });
  return result;
}

template <class Sections>
nb::object get_parameter(const Sections& sections, std::string_view section_name, std::string_view name) {
  nb::object result;
  for_each_parameter(sections, [&](std::string_view in, const auto& section, const auto& field) {
    if (in == section_name && field.name == name) result = nb::cast(section.*(field.member));
  });
  if (!result.is_valid()) throw nb::key_error((std::string(section_name) + "." + std::string(name)).c_str());
  return result;
}

template <class Sections>
void set_parameter(Sections& sections, std::string_view section_name, std::string_view name, double value) {
  bool found = false;
  for_each_parameter(sections, [&](std::string_view in, auto& section, const auto& field) {
    if (in != section_name || field.name != name) return;
    found = true;
    using T = std::remove_cvref_t<decltype(section.*(field.member))>;
    if (!(value >= field.min && value <= field.max) ||
        (!std::is_same_v<T, double> && value != static_cast<double>(static_cast<int>(value)))) {
      throw std::invalid_argument(std::string(section_name) + "." + std::string(name) + " = " + std::to_string(value) +
                                  " is not an allowed value");
    }
    section.*(field.member) = static_cast<T>(value);
  });
  if (!found) throw nb::key_error((std::string(section_name) + "." + std::string(name)).c_str());
}

template <class Sections>
nb::dict all_values(const Sections& sections) {
  nb::dict result;
  for_each_section(sections, [&](std::string_view name, const auto& section) {
    using Section = std::remove_cvref_t<decltype(section)>;
    nb::dict values;
    for_each_field<Section>([&](const auto& field) { values[text(field.name)] = section.*(field.member); });
    result[text(name)] = values;
  });
  return result;
}

// Binds a struct of sections with the members common to all of them. Returns the class for more.
template <class Sections>
nb::class_<Sections> bind_sections(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<Sections>(m, name, doc)
      .def(nb::init<>(), "All parameters at their defaults.")
      .def(nb::init<const Sections&>(), nb::arg("other"), "A copy.")
      .def_static("fields", &field_list<Sections>,
                  "The field table: a list of dicts with section, name, unit, min, max, default, doc and type.")
      .def("get", &get_parameter<Sections>, nb::arg("section"), nb::arg("name"),
           "One value. Raises KeyError for an unknown name.")
      .def("set", &set_parameter<Sections>, nb::arg("section"), nb::arg("name"), nb::arg("value"),
           "Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.")
      .def("values", &all_values<Sections>, "All values, {section: {name: value}}.")
      .def(
          "validate", [](const Sections& self) { validate(self); },
          "Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.");
}

}  // namespace firstlap::bindings
