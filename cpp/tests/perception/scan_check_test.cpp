#include "firstlap/perception/scan_check.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "firstlap/perception/scan_period.hpp"
#include "support/scene.hpp"

namespace firstlap {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();
constexpr float no_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

struct Sample {
  std::vector<float> ranges = std::vector<float>(1081, 2.0F);
  LaserScan scan{-0.75 * scene::pi, 1.5 * scene::pi / 1080.0, 1.7e-5, 0.02, 30.0, {}};

  LaserScan view() {
    scan.ranges = ranges;
    return scan;
  }
  ScanFault fault(const ScanContext& context = {}) { return check_scan(view(), context).fault; }
  std::string reason(const ScanContext& context = {}) {
    return describe_fault(view(), context, check_scan(view(), context));
  }
};

TEST(ScanCheck, a_valid_scan_has_no_fault_and_no_remark) {
  Sample s;
  EXPECT_EQ(s.fault(), ScanFault::none);
  EXPECT_EQ(s.reason(), "");
  EXPECT_EQ(describe_returns(check_scan(s.view())), "");
}

TEST(ScanCheck, angles_in_degrees_are_named) {
  Sample s;
  s.scan.angle_min = -135.0;
  s.scan.angle_increment = 0.25;
  EXPECT_EQ(s.fault(), ScanFault::too_wide);
  EXPECT_NE(s.reason().find("degrees"), std::string::npos);
  s.scan.angle_min = 0.0;
  s.scan.angle_increment = 1.0;
  EXPECT_EQ(s.fault(), ScanFault::too_wide);
}

TEST(ScanCheck, ranges_in_millimeters_or_centimeters_are_named) {
  for (const float factor : {100.0F, 1000.0F}) {
    Sample s;
    s.scan.range_max = 12.0 * static_cast<double>(factor);
    for (float& r : s.ranges) r = 0.6F * factor;
    EXPECT_EQ(s.fault(), ScanFault::nothing_in_reach) << factor;
    EXPECT_NE(s.reason().find("millimeters"), std::string::npos);
    s.scan.range_max = 12.0;  // the header in meters: every range is beyond it
    EXPECT_EQ(s.fault(), ScanFault::no_returns) << factor;
  }
}

TEST(ScanCheck, each_kind_of_invalid_header_has_its_own_fault) {
  Sample s;
  const auto with = [&](auto change) {
    Sample other = s;
    change(other.scan);
    return other.fault();
  };
  EXPECT_EQ(with([](LaserScan& scan) { scan.time_increment = -1e-5; }), ScanFault::time_increment);
  EXPECT_EQ(with([](LaserScan& scan) { scan.range_min = -inf; }), ScanFault::not_finite);
  EXPECT_EQ(with([](LaserScan& scan) { scan.range_max = nan; }), ScanFault::not_finite);
  EXPECT_EQ(with([](LaserScan& scan) { scan.angle_min = nan; }), ScanFault::not_finite);
  EXPECT_EQ(with([](LaserScan& scan) { scan.angle_increment = 0.0; }), ScanFault::zero_increment);
  EXPECT_EQ(with([](LaserScan& scan) { scan.angle_increment = 5e-324; }), ScanFault::zero_increment);
  EXPECT_EQ(with([](LaserScan& scan) { scan.angle_increment = 0.01; }), ScanFault::too_wide);
  EXPECT_EQ(with([](LaserScan& scan) { scan.range_min = 30.0; }), ScanFault::range_limits);
  EXPECT_EQ(with([](LaserScan& scan) { scan.range_max = inf; }), ScanFault::none) << "an infinite limit is valid";
  s.ranges.assign(1, 2.0F);
  EXPECT_EQ(s.fault(), ScanFault::no_beams);
}

TEST(ScanCheck, an_angle_max_that_does_not_match_the_number_of_beams_is_a_fault) {
  Sample s;
  EXPECT_EQ(s.fault({.angle_max = 0.75 * scene::pi + 1.5 * s.scan.angle_increment}), ScanFault::none);
  EXPECT_EQ(s.fault({.angle_max = 0.5 * scene::pi}), ScanFault::angle_max);
  EXPECT_EQ(s.fault({.angle_max = inf}), ScanFault::not_finite);
}

TEST(ScanCheck, all_encodings_of_no_return_count_alike) {
  for (const float lost : {no_number, infinite, -infinite, 0.0F, -1.0F, 65.533F, 29.96F, 30.04F, 0.01F}) {
    Sample s;
    for (std::size_t i = 0; i < s.ranges.size(); ++i)
      if (i % 10 != 0) s.ranges[i] = lost;
    const ScanCheck check = check_scan(s.view());
    EXPECT_TRUE(check.usable()) << lost << ": nine of ten lost beams are no reason to stop";
    EXPECT_EQ(check.returns, 109U) << lost;
    EXPECT_NE(describe_returns(check), "");
    for (std::size_t i = 0; i < s.ranges.size(); ++i)
      if (i > 2) s.ranges[i] = lost;
    EXPECT_EQ(s.fault(), ScanFault::no_returns) << lost;
  }
}

TEST(ScanCheck, a_lidar_without_beams_ahead_is_refused_wherever_its_seam_is) {
  Sample s;
  for (const double turned : {scene::pi, -scene::pi, 3.0 * scene::pi}) {
    Sample back = s;
    back.scan.angle_min += turned;
    EXPECT_EQ(back.fault(), ScanFault::blind_ahead) << turned;
    back.scan.angle_min = -(s.scan.angle_min + turned);
    back.scan.angle_increment = -s.scan.angle_increment;
    EXPECT_EQ(back.fault(), ScanFault::blind_ahead) << turned;
  }
  for (const double first : {0.0, 1.0, scene::pi, 5.0, -6.0}) {
    for (const double sign : {-1.0, 1.0}) {
      Sample round = s;
      round.scan.angle_min = first;
      round.scan.angle_increment = sign * 2.0 * scene::pi / 1081.0;
      EXPECT_EQ(round.fault(), ScanFault::none) << first << ' ' << sign;
    }
  }
}

TEST(ScanCheck, a_sweep_longer_than_the_period_is_not_deskewed) {
  Sample s;
  s.scan.time_increment = 0.025 / 1080.0;
  EXPECT_TRUE(check_scan(s.view(), {.period = 0.025}).time_usable);
  EXPECT_EQ(with_usable_time(s.view(), 0.025).time_increment, s.scan.time_increment);
  s.scan.time_increment = 0.040 / 1080.0;
  const ScanContext context{.period = 0.025};
  EXPECT_FALSE(check_scan(s.view(), context).time_usable);
  EXPECT_TRUE(check_scan(s.view(), context).usable()) << "a remark, not a fault";
  EXPECT_NE(describe_time(s.view(), context, check_scan(s.view(), context)), "");
  EXPECT_EQ(with_usable_time(s.view(), 0.025).time_increment, 0.0);
  EXPECT_TRUE(check_scan(s.view()).time_usable) << "the period is unknown";
  s.scan.time_increment = 1.0 / 1080.0;
  EXPECT_FALSE(check_scan(s.view()).time_usable) << "no LiDAR takes a second";
}

TEST(ScanCheck, a_remark_on_the_sweep_names_the_period_only_if_it_is_known) {
  Sample s;
  s.scan.time_increment = 1.0 / 1080.0;
  const std::string known = describe_time(s.view(), {.period = 0.025}, check_scan(s.view(), {.period = 0.025}));
  EXPECT_NE(known.find("longer than the scan period of 0.025 s:"), std::string::npos) << known;
  const std::string unknown = describe_time(s.view(), {}, check_scan(s.view()));
  EXPECT_EQ(unknown.find("scan period of"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("the scan period is not known"), std::string::npos) << unknown;
}

TEST(ScanPeriod, is_the_first_interval_and_then_changes_slowly) {
  ScanPeriod period;
  EXPECT_EQ(period.seconds(), 0.0);
  for (const double none : {0.0, -0.1, nan, inf, 2.0 * max_pause}) period.learn(none);
  EXPECT_EQ(period.seconds(), 0.0) << "unknown";
  period.learn(0.1);
  EXPECT_EQ(period.seconds(), 0.1);
  for (int i = 0; i < 100; ++i) period.learn(0.1);
  EXPECT_EQ(period.seconds(), 0.1) << "regular scans do not change it by rounding";
  period.learn(0.2);
  EXPECT_NEAR(period.seconds(), 0.11, 1e-12) << "one lost scan";
  for (int i = 0; i < 100; ++i) period.learn(0.05);
  EXPECT_NEAR(period.seconds(), 0.05, 1e-4) << "another LiDAR";
}

TEST(ScanCheck, an_implausible_sweep_time_counts_as_zero) {
  EXPECT_DOUBLE_EQ(usable_sweep_time(1e-4, 101, 0.025), 0.01);
  EXPECT_DOUBLE_EQ(usable_sweep_time(1e-3, 101, 0.1), 0.1) << "a full circle takes the whole period";
  EXPECT_EQ(usable_sweep_time(1e-3, 101, 0.025), 0.0);
  EXPECT_DOUBLE_EQ(usable_sweep_time(1e-3, 101, 0.0), 0.1) << "the period is unknown";
  for (const double increment : {-1e-4, 0.0, nan, inf, -inf}) {
    EXPECT_EQ(usable_sweep_time(increment, 101, 0.025), 0.0) << increment;
    EXPECT_EQ(usable_sweep_time(increment, 0, 0.0), 0.0) << increment;
  }
}

TEST(ScanCheck, every_fault_has_a_name_and_a_reason) {
  for (int fault = 1; fault <= static_cast<int>(ScanFault::nothing_in_reach); ++fault) {
    const auto kind = static_cast<ScanFault>(fault);
    EXPECT_STRNE(to_string(kind), "unknown");
    EXPECT_NE(describe_fault({}, {}, {.fault = kind}), "unknown");
    EXPECT_NE(describe_fault({}, {}, {.fault = kind}), "");
  }
}

}  // namespace
}  // namespace firstlap
