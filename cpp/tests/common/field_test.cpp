#include "firstlap/common/field.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace firstlap {
namespace {

struct Place {
  double x = 1.0;
  double y = 2.0;

  static constexpr auto columns() {
    return std::tuple{Column{"x", &Place::x, "m", "ahead"}, Column{"y", &Place::y, "m", "left"}};
  }
};

struct Found {
  double time = 0.5;
  Place place{};
  std::vector<Place> others{{3.0, 4.0}, {5.0, 6.0}};

  static constexpr auto columns() {
    return std::tuple{
        Column{"time", &Found::time, "s", "when"},
        Part{&Found::place},
        Column{"distance", [](const Found& f) { return f.place.x + f.place.y; }, "m", "of both"},
    };
  }
};

struct Seen {
  Found found{};

  static constexpr auto columns() {
    return std::tuple{Part{&Seen::found}, Part{[](const Seen& s) -> const auto& { return s.found.others; }}};
  }
};

template <class Struct>
std::vector<std::string> names() {
  std::vector<std::string> result;
  for_each_column<Struct>([&](const auto& column) { result.emplace_back(column.name); });
  return result;
}

TEST(Column, parts_are_expanded_in_the_table_of_their_struct) {
  EXPECT_EQ(names<Found>(), (std::vector<std::string>{"time", "x", "y", "distance"}));
  EXPECT_EQ(column_count<Found>, 4U);
  EXPECT_EQ(names<Seen>(), (std::vector<std::string>{"time", "x", "y", "distance", "x", "y"}));
}

TEST(Column, reads_members_of_parts_and_functions) {
  const Found found;
  const auto columns = flat_columns<Found>();
  EXPECT_EQ(std::invoke(std::get<2>(columns).get, found), 2.0);
  EXPECT_EQ(std::invoke(std::get<3>(columns).get, found), 3.0);
}

TEST(Column, sets_a_member_of_a_part) {
  Found found;
  std::invoke(std::get<1>(flat_columns<Found>()).get, found) = 7.0;
  EXPECT_EQ(found.place.x, 7.0);
}

TEST(Column, a_part_that_is_a_sequence_gives_one_column_per_member) {
  const Seen seen;
  const auto column = std::invoke(std::get<5>(flat_columns<Seen>()).get, seen);
  std::vector<double> values;
  for (const Place& place : column.items) values.push_back(std::invoke(column.get, place));
  EXPECT_EQ(values, (std::vector<double>{4.0, 6.0}));
}

}  // namespace
}  // namespace firstlap
