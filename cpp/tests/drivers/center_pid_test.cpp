#include "firstlap/drivers/center_pid.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap::drivers {
namespace {

constexpr VehicleState slow{1.0, 0.0, 0.0};

TEST(EstimateWall, is_exact_for_a_straight_wall) {
  const CenterParams p;
  for (const double yaw : {-0.3, 0.0, 0.2}) {
    const double distance = 0.9;  // a wall on the left that diverges by `yaw`
    const auto range = [&](double angle) { return distance / std::sin(angle - yaw); };
    const WallEstimate wall = estimate_wall(range(p.side_angle), range(p.ahead_angle), p, 1.2);
    EXPECT_NEAR(wall.angle, yaw, 1e-9);
    EXPECT_NEAR(wall.distance, distance, 1e-9);
    EXPECT_NEAR(wall.preview, distance + 1.2 * std::sin(yaw), 1e-9);
  }
}

TEST(CenterPid, the_error_in_a_corridor_is_the_offset_from_its_center_at_the_preview) {
  CenterPid driver(CenterPidParams{});
  const scene::Scene corridor = scene::Course{}.straight(30).walls(2.4);
  driver.step(corridor.scan({8, 0.3, 0.0}).view(), slow, 0.025);
  EXPECT_NEAR(driver.trace().error, -0.3, 2e-3);
  driver.step(corridor.scan({8, 0.0, 0.1}).view(), slow, 0.025);
  const double ahead = CarGeometry{}.laser_x + driver.trace().preview;
  EXPECT_NEAR(driver.trace().error, -ahead * std::sin(0.1), 0.01);
}

TEST(CenterPid, the_terms_are_those_of_a_pid_controller) {
  CenterPidParams params;
  params.center.k_i = 0.5;
  params.center.derivative_time = 0.0;
  CenterPid driver(params);
  const scene::Scene corridor = scene::Course{}.straight(30).walls(2.4);
  driver.step(corridor.scan({8, 0.3, 0.0}).view(), slow, 0.02);
  const double first = driver.trace().error;
  EXPECT_EQ(driver.trace().d_term, 0.0) << "there is no previous error yet";
  driver.step(corridor.scan({8, 0.2, 0.0}).view(), slow, 0.02);
  const CenterPid::Trace& t = driver.trace();
  EXPECT_NEAR(t.p_term, params.center.k_p * t.error, 1e-12);
  EXPECT_NEAR(t.i_term, params.center.k_i * 0.02 * (first + t.error), 1e-12);
  EXPECT_NEAR(t.d_term, params.center.k_d * (t.error - first) / 0.02, 1e-9);
}

TEST(CenterPid, an_opening_on_one_side_is_limited_to_side_range) {
  CenterPidParams params;
  params.center.side_range = 1.5;
  CenterPid driver(params);
  scene::Scene right_wall;
  right_wall.add(scene::right, {{-20, -1}, {30, -1}});
  right_wall.add(scene::left, {{-20, 9}, {30, 9}});
  driver.step(right_wall.scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_NEAR(driver.trace().error, 0.25, 0.01);
}

TEST(CenterPid, preview_grows_with_speed) {
  CenterPidParams params;
  params.center.preview = 0.5;
  params.center.preview_time = 0.2;
  CenterPid driver(params);
  const scene::Scene corridor = scene::Course{}.straight(30).walls(2.4);
  driver.step(corridor.scan({8, 0, 0}).view(), {3.0, 0, 0}, 0.025);
  EXPECT_NEAR(driver.trace().preview, 1.1, 1e-12);
}

TEST(CenterPid, returns_to_the_center_of_a_corridor) {
  CenterPid driver(CenterPidParams{});
  const scene::Scene corridor = scene::Course{}.straight(40).walls(2.0);
  Pose2 car{2.0, 0.5, 0.0};
  double worst = 0.0;
  for (int i = 0; i < 400; ++i) {
    const StepResult r = driver.step(corridor.scan(car).view(), {2.0, 0.0, 0.0}, 0.025);
    const double turn = 2.0 * std::tan(r.command.steering_angle) / CarGeometry{}.wheelbase * 0.025;
    car = {car.x + 0.05 * std::cos(car.yaw), car.y + 0.05 * std::sin(car.yaw), car.yaw + turn};
    if (i > 200) worst = std::max(worst, std::abs(car.y));
  }
  EXPECT_LT(worst, 0.1);
}

}  // namespace
}  // namespace firstlap::drivers
