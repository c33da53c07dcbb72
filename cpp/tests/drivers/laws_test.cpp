// Laws that hold for every reactive driver.
#include <cmath>
#include <gtest/gtest.h>
#include <type_traits>
#include <vector>

#include "firstlap/drivers/center_pid.hpp"
#include "firstlap/drivers/disparity_extender.hpp"
#include "firstlap/drivers/follow_the_gap.hpp"
#include "support/allocations.hpp"
#include "support/random_inputs.hpp"

namespace firstlap::drivers {
namespace {

using scene::Course;
using scene::pi;
using scene::Scene;

template <class AnyDriver>
class OpponentLaws : public testing::Test {
 public:
  using Params = std::remove_cvref_t<decltype(std::declval<AnyDriver>().params())>;
  AnyDriver driver{Params{}};
};
using Opponents = testing::Types<FollowTheGap, DisparityExtender, CenterPid>;
TYPED_TEST_SUITE(OpponentLaws, Opponents);

Course winding() { return Course{}.straight(4).turn(1.5, 1.4).straight(3).turn(2.0, -2.0).straight(6); }

TYPED_TEST(OpponentLaws, any_scan_gives_a_finite_command_within_limits) {
  const std::uint64_t seed = scene::seed_or(3);
  scene::RandomInputs random(seed);
  const auto& params = this->driver.params();
  for (int i = 0; i < scene::count_or(4000); ++i) {
    const scene::Scan scan = random.scan();
    const StepResult result = this->driver.step(scan.view(), random.state(), random.dt());
    ASSERT_TRUE(std::isfinite(result.command.speed)) << scene::how_to_repeat(seed, i);
    ASSERT_TRUE(std::isfinite(result.command.steering_angle)) << scene::how_to_repeat(seed, i);
    ASSERT_GE(result.command.speed, 0.0) << scene::how_to_repeat(seed, i);
    ASSERT_LE(result.command.speed, params.speed.v_max) << scene::how_to_repeat(seed, i);
    ASSERT_LE(std::abs(result.command.steering_angle), params.car.steering_limit) << scene::how_to_repeat(seed, i);
  }
}

TYPED_TEST(OpponentLaws, a_thousand_steps_allocate_nothing) {
  scene::RandomInputs random(scene::seed_or(4));
  std::vector<scene::Scan> scans;
  std::vector<VehicleState> states;
  const Course course = winding();
  const Scene track = course.walls(2.0);
  for (int i = 0; i < 1000; ++i) {
    scans.push_back(i % 10 < 7 ? track.scan(course.at(1.0 + 0.05 * (i % 200))) : random.scan());
    states.push_back(i % 10 < 7 ? VehicleState{2.0, 0.0, 0.0} : random.state());
  }
  scene::allocations = 0;
  int ok = 0;
  scene::counting = true;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ok += this->driver.step(scans[i].view(), states[i], 0.025).status == Status::ok;
    if (i % 333 == 0) this->driver.reset();
  }
  scene::counting = false;
  EXPECT_EQ(scene::allocations, 0);
  EXPECT_GT(ok, 400) << "the whole driver must have run";
}

// Deskewing depends on the scan period, not on the interval to the previous scan.
TYPED_TEST(OpponentLaws, an_early_scan_and_one_after_a_lost_scan_are_deskewed_like_the_others) {
  constexpr double period = 0.1;
  struct Case {
    double sweep, dt;  // [s]
  };
  const scene::Scan seen = winding().walls(2.0).scan(winding().at(3.0));
  const VehicleState state{3.0, 0.8, 0.1};
  for (const Case& odd : {Case{period, 0.5 * period}, Case{1.5 * period, 2.0 * period}}) {
    LaserScan scan = seen.view();
    scan.time_increment = odd.sweep / static_cast<double>(scan.ranges.size() - 1);
    TypeParam regular(this->driver.params()), other(this->driver.params());
    for (int i = 0; i < 10; ++i) {
      regular.step(scan, state, period);
      other.step(scan, state, period);
    }
    regular.step(scan, state, period);
    other.step(scan, state, odd.dt);
    for (std::size_t i = 0; i < regular.trace().ranges.size(); ++i)
      ASSERT_EQ(regular.trace().ranges[i], other.trace().ranges[i]) << odd.sweep << ' ' << odd.dt << ' ' << i;
  }
}

TYPED_TEST(OpponentLaws, a_mirrored_scan_mirrors_the_steering_and_keeps_the_speed) {
  const Course course = winding();
  const Scene track = course.walls(2.0);
  TypeParam other(this->driver.params());
  for (int i = 0; i < 100; ++i) {
    const Pose2 pose = course.at(1.0 + 0.1 * i, 0.2 * std::sin(0.3 * i));
    const scene::Scan scan = track.scan(pose);
    const StepResult a = this->driver.step(scan.view(), {2.0, 0.5, 0.1}, 0.025);
    const StepResult b = other.step(scan.mirrored().view(), {2.0, -0.5, -0.1}, 0.025);
    ASSERT_NEAR(a.command.steering_angle, -b.command.steering_angle, 1e-6) << i;
    ASSERT_NEAR(a.command.speed, b.command.speed, 1e-6) << i;
    ASSERT_EQ(a.status, b.status);
  }
}

TYPED_TEST(OpponentLaws, without_data_the_car_stops_and_the_status_tells_why) {
  const scene::Scan empty{.ranges = {}};
  EXPECT_EQ(this->driver.step(empty.view(), {3.0, 0.0, 0.0}, 0.025).command.speed, 0.0);
  EXPECT_EQ(this->driver.step(empty.view(), {3.0, 0.0, 0.0}, 0.025).status, Status::bad_scan);
  scene::Scan lost{.ranges = std::vector<float>(1081, INFINITY)};
  EXPECT_EQ(this->driver.step(lost.view(), {3.0, 0.0, 0.0}, 0.025).command.speed, 0.0);
  EXPECT_EQ(this->driver.step(lost.view(), {3.0, 0.0, 0.0}, 0.025).status, Status::bad_scan);
  const scene::Scan good = winding().walls(2.0).scan({1.0, 0.0, 0.0});
  EXPECT_EQ(this->driver.step(good.view(), {NAN, 0.0, 0.0}, 0.025).command.speed, 0.0);
  EXPECT_EQ(this->driver.step(good.view(), {NAN, 0.0, 0.0}, 0.025).status, Status::bad_state);
  EXPECT_EQ(this->driver.step(good.view(), {3.0, 0.0, 0.0}, 0.025).status, Status::ok);
}

TYPED_TEST(OpponentLaws, in_the_middle_of_a_straight_corridor_it_drives_straight) {
  const Scene corridor = Course{}.straight(40).walls(2.0);
  const StepResult result = this->driver.step(corridor.scan({5.0, 0.0, 0.0}).view(), {4.0, 0.0, 0.0}, 0.025);
  EXPECT_EQ(result.status, Status::ok);
  EXPECT_NEAR(result.command.steering_angle, 0.0, 0.02);
  EXPECT_NEAR(result.command.speed, 4.0 + this->driver.params().speed.delta_v_max, 0.41);
}

TYPED_TEST(OpponentLaws, it_steers_into_a_corner) {
  const Course course = Course{}.straight(5).turn(1.5, 0.5 * pi).straight(6);
  const Scene track = course.walls(2.0);
  StepResult result;
  for (int i = 0; i < 10; ++i) result = this->driver.step(track.scan(course.at(4.8)).view(), {1.5, 0.0, 0.0}, 0.025);
  EXPECT_GT(result.command.steering_angle, 0.05);
}

TYPED_TEST(OpponentLaws, a_wall_directly_ahead_stops_the_car) {
  Scene trap;
  trap.add(scene::neither, {{-3.0, -0.5}, {0.55, -0.5}, {0.55, 0.5}, {-3.0, 0.5}, {-3.0, -0.5}});
  const StepResult result = this->driver.step(trap.scan({0.0, 0.0, 0.0}).view(), {1.0, 0.0, 0.0}, 0.025);
  EXPECT_TRUE(result.status == Status::blocked || result.status == Status::no_path);
  EXPECT_EQ(result.command.speed, 0.0);
}

TYPED_TEST(OpponentLaws, the_steering_angle_changes_no_faster_than_the_servo) {
  const Course course = Course{}.straight(5).turn(1.2, 0.5 * pi).straight(6);
  const Scene track = course.walls(2.0);
  double before = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double angle =
        this->driver.step(track.scan(course.at(0.15 * i)).view(), {1.0, 0.0, 0.0}, 0.01).command.steering_angle;
    ASSERT_LE(std::abs(angle - before), 0.01 * this->driver.params().car.steering_rate + 1e-9);
    before = angle;
  }
}

TYPED_TEST(OpponentLaws, a_reset_driver_behaves_like_a_new_one) {
  const Course course = winding();
  const Scene track = course.walls(2.0);
  for (int i = 0; i < 20; ++i) this->driver.step(track.scan(course.at(0.3 * i)).view(), {2.0, 0.0, 0.0}, 0.025);
  this->driver.reset();
  TypeParam fresh(this->driver.params());
  for (int i = 0; i < 20; ++i) {
    const scene::Scan scan = track.scan(course.at(0.3 * i));
    const StepResult a = this->driver.step(scan.view(), {2.0, 0.0, 0.0}, 0.025);
    const StepResult b = fresh.step(scan.view(), {2.0, 0.0, 0.0}, 0.025);
    ASSERT_EQ(a.command.steering_angle, b.command.steering_angle);
    ASSERT_EQ(a.command.speed, b.command.speed);
  }
}

TYPED_TEST(OpponentLaws, invalid_parameters_are_refused_by_name) {
  auto params = this->driver.params();
  params.speed.v_min = params.speed.v_max + 1.0;
  EXPECT_THROW(TypeParam{params}, std::invalid_argument);
  params = this->driver.params();
  params.scan.range_use = NAN;
  try {
    const TypeParam refused{params};
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("scan.range_use"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace firstlap::drivers
