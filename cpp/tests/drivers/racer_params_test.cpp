#include "firstlap/drivers/racer_params.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <set>
#include <string>
#include <string_view>

#include "firstlap/drivers/racer.hpp"

namespace firstlap {
namespace {

std::string refusal(const Params& params) {
  try {
    validate(params);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Number of initializers of an aggregate.
struct Anything {
  template <class T>
  operator T() const;
};
template <class T, class... Args>
constexpr std::size_t member_count() {
  if constexpr (requires { T{Args{}..., Anything{}}; })
    return member_count<T, Args..., Anything>();
  else
    return sizeof...(Args);
}

TEST(Params, the_defaults_are_valid) { EXPECT_EQ(refusal({}), ""); }

TEST(Params, every_field_refuses_values_outside_its_range_by_name) {
  Params params;
  for_each_section(params, [&](std::string_view section, auto& values) {
    using Section = std::remove_reference_t<decltype(values)>;
    for_each_field<Section>([&](const auto& field) {
      auto& value = values.*(field.member);
      const auto before = value;
      if constexpr (!std::is_same_v<std::remove_reference_t<decltype(value)>, bool>) {
        using T = std::remove_reference_t<decltype(value)>;
        for (const double wrong : {field.min - 1.0, field.max + 1.0}) {
          value = static_cast<T>(wrong);
          const std::string text = refusal(params);
          EXPECT_NE(text.find(std::string(section) + "." + std::string(field.name)), std::string::npos) << text;
          EXPECT_NE(text.find("allowed"), std::string::npos) << text;
        }
        if constexpr (std::is_same_v<T, double>) {
          value = std::numeric_limits<double>::quiet_NaN();
          EXPECT_NE(refusal(params).find("not finite"), std::string::npos) << field.name;
          value = std::numeric_limits<double>::infinity();
          EXPECT_NE(refusal(params), "") << field.name;
        }
      }
      value = before;
    });
  });
}

TEST(Params, every_field_has_a_doc_and_a_default_within_its_range) {
  Params params;
  for_each_section(params, [](std::string_view section, auto& values) {
    using Section = std::remove_reference_t<decltype(values)>;
    for_each_field<Section>([&](const auto& field) {
      EXPECT_FALSE(field.doc.empty()) << section << '.' << field.name;
      EXPECT_LT(field.min, field.max) << section << '.' << field.name;
    });
  });
}

TEST(Params, field_names_are_unique_over_all_sections) {
  Params params;
  std::set<std::string> names;
  for_each_section(params, [&](std::string_view, auto& values) {
    using Section = std::remove_reference_t<decltype(values)>;
    for_each_field<Section>([&](const auto& field) { EXPECT_TRUE(names.emplace(field.name).second) << field.name; });
  });
}

template <class Section>
void expect_every_member_in_its_table(std::string_view section) {
  EXPECT_EQ(member_count<Section>(), std::tuple_size_v<decltype(Section::fields())>) << section;
}

TEST(Params, every_member_is_in_its_table) {
  Params params;
  for_each_section(params, [](std::string_view section, auto& values) {
    using Section = std::remove_reference_t<decltype(values)>;
    if constexpr (std::is_same_v<Section, CarModel>) {  // its members are those of its bases
      static_assert(sizeof(CarModel) == sizeof(CarGeometry) + sizeof(CarDynamics));
      expect_every_member_in_its_table<CarGeometry>(section);
      expect_every_member_in_its_table<CarDynamics>(section);
    } else {
      expect_every_member_in_its_table<Section>(section);
    }
  });
}

TEST(Params, pairs_that_contradict_each_other_are_refused) {
  Params p;
  p.velocity_profile.v_min = 5.0;
  EXPECT_NE(refusal(p).find("v_min"), std::string::npos);
  EXPECT_NE(refusal(p).find("v_max"), std::string::npos);
  p = {};
  p.segmentation.break_min = 0.9;
  EXPECT_NE(refusal(p), "");
  p = {};
  p.segmentation.pass_min = 1.5;
  EXPECT_NE(refusal(p), "");
  p = {};
  p.track_width.width_min = 2.5;
  p.track_width.width_max = 1.5;
  EXPECT_NE(refusal(p), "");
}

TEST(Params, the_racer_refuses_invalid_parameters_and_keeps_the_old_ones) {
  Params bad;
  bad.stanley.k_ang = -1.0;
  EXPECT_THROW(Racer{bad}, std::invalid_argument);
  Racer racer{Params{}};
  EXPECT_THROW(racer.set_params(bad), std::invalid_argument);
  EXPECT_EQ(racer.params().stanley.k_ang, Params{}.stanley.k_ang);
}

}  // namespace
}  // namespace firstlap
