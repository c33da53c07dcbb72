// C++ sequences as numpy arrays that own their data.
#pragma once

#include <cstddef>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <utility>
#include <vector>

namespace firstlap::bindings {

namespace nb = nanobind;

template <class T, std::size_t Dimensions>
using Numpy = nb::ndarray<nb::numpy, T, nb::ndim<Dimensions>>;

template <class T>
Numpy<T, 1> to_numpy(std::vector<T> values) {
  auto* owned = new std::vector<T>(std::move(values));
  const nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Numpy<T, 1>(owned->data(), {owned->size()}, owner);
}

// An array with `columns` columns, from values in row-major order.
template <class T>
Numpy<T, 2> to_numpy(std::vector<T> values, std::size_t columns) {
  auto* owned = new std::vector<T>(std::move(values));
  const nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Numpy<T, 2>(owned->data(), {owned->size() / columns, columns}, owner);
}

// An array with `value(item)` of every item.
template <class T, class Range, class Value>
Numpy<T, 1> column(const Range& items, Value&& value) {
  std::vector<T> values;
  values.reserve(items.size());
  for (const auto& item : items) values.push_back(static_cast<T>(value(item)));
  return to_numpy(std::move(values));
}

// The same for bool, since a vector of bool has no array to hand over.
template <class Range, class Value>
Numpy<bool, 1> flags(const Range& items, Value&& value) {
  auto* owned = new bool[items.size()];
  const nb::capsule owner(owned, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  std::size_t i = 0;
  for (const auto& item : items) owned[i++] = value(item);
  return Numpy<bool, 1>(owned, {items.size()}, owner);
}

}  // namespace firstlap::bindings
