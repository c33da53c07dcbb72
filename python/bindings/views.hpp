// numpy arrays as C++ inputs: contiguous, not copied, of exactly the needed type.
#pragma once

#include <cstdint>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

namespace firstlap::bindings {

namespace nb = nanobind;

template <class T, std::size_t Dimensions>
using View = nb::ndarray<const T, nb::numpy, nb::ndim<Dimensions>, nb::c_contig, nb::device::cpu>;

using Ranges = View<float, 1>;
using Counts = View<std::int64_t, 1>;
using Values = View<double, 1>;
using Rows = View<double, 2>;
using Flags = View<std::uint8_t, 1>;
using Mask = View<std::uint8_t, 2>;

}  // namespace firstlap::bindings
