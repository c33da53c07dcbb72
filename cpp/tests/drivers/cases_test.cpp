// The cases of method.md, section 3, on synthetic scans with known truth: the side of every wall point, and the medial
// line.
#include <cmath>
#include <gtest/gtest.h>

#include "support/random_inputs.hpp"

namespace firstlap {
namespace {

using scene::carry;
using scene::Course;
using scene::drive;
using scene::Scan;
using scene::Scene;
using scene::Tour;

// Expected of a tour: a path from every scan, no wall on the wrong side near the car, and a line in the middle.
void expect_good(const Tour& tour, double line_tolerance, const std::string& what, double wrong_labels = 0.0) {
  EXPECT_EQ(tour.not_ok, 0) << what << ": steps without a path from their scan, of " << tour.steps;
  EXPECT_LE(tour.wrong_labels, wrong_labels * tour.labels) << what << ": of " << tour.labels << " wall samples";
  EXPECT_LT(tour.worst_line, line_tolerance) << what << ": line off the medial line, at " << tour.worst_at << " m";
  EXPECT_EQ(tour.short_lines, 0) << what << ": steps with less than 1.5 m of line, of " << tour.steps;
}

// The front axle swings out of the line in a curve; 0.3 m leaves clearance for the car in 1.4 m.
void expect_driven(const Tour& tour, double offset, const std::string& what) {
  EXPECT_LT(tour.worst_offset, offset) << what << ": the car left the medial line";
  EXPECT_EQ(tour.not_ok, 0) << what << ": steps without a path from their scan, of " << tour.steps;
}

std::string named(const char* name, double value) { return name + std::string(" ") + std::to_string(value); }

// Straight ------------------------------------------------------------------------------------------

TEST(Cases, straight) {
  const Course course = Course{}.straight(30);
  for (const double width : {1.0, 1.4, 2.0, 3.5}) {
    Racer racer{Params{}};
    expect_good(carry(racer, course.walls(width), course, 3, 20), 0.02, named("width", width));
  }
}

// Past the last visible piece of a wall, the LiDAR sees what is behind it: this share of the samples near the car may
// be on the wrong side (method.md, section 11: precision 0.95 to 1.0).
constexpr double past_the_end = 0.02;

// Wall pairs wider than width_max are not used: a single wall represents the track, and its remembered width is the
// maximum.
TEST(Cases, wider_than_the_pair_limit) {
  const Course course = Course{}.straight(12).turn(6, 0.6).straight(12);
  const double most = Params{}.track_width.width_max;
  for (const double wider : {-0.1, 0.1, 0.4}) {
    Racer racer{Params{}};
    const Tour tour = carry(racer, course.walls(most + wider), course, 3, 20);
    expect_good(tour, 0.3, named("width", most + wider), past_the_end);
    EXPECT_NEAR(racer.trace().width, most, 0.15);
  }
}

// Bends ---------------------------------------------------------------------------------------------

TEST(Cases, hairpin_carried_along_the_middle) {
  for (const double sign : {1.0, -1.0}) {
    for (const double radius : {0.9, 1.2, 1.6}) {
      const Course course = Course{}.straight(8).turn(radius, sign * scene::pi).straight(10);
      Racer racer{Params{}};
      expect_good(carry(racer, course.walls(1.5), course, 3, 14), 0.25, named("hairpin of radius", sign * radius),
                  past_the_end);
    }
  }
}

TEST(Cases, hairpin_driven) {
  for (const double sign : {1.0, -1.0}) {
    for (const double radius : {1.0, 1.2, 1.6}) {
      const Course course = Course{}.straight(8).turn(radius, sign * scene::pi).straight(10);
      Racer racer{Params{}};
      expect_driven(drive(racer, course.walls(1.6), course, 3, 14, 2.0), 0.45,
                    named("hairpin of radius", sign * radius));
    }
  }
}

// Around a single pipe: the inner wall is a line whose end occludes its other face.
TEST(Cases, hairpin_around_the_end_of_a_thin_wall) {
  for (const double sign : {1.0, -1.0}) {
    Scene scene;
    const int inner = sign > 0.0 ? scene::left : scene::right;
    scene.add(-inner, Course{}.straight(10).turn(1.5, sign * scene::pi).straight(10).parallel(-sign * 0.0, 0, 24.7));
    for (scene::Wall& wall : scene.walls) {
      wall.a.y -= sign * 0.75;
      wall.b.y -= sign * 0.75;
    }
    scene.add(inner, {{0, sign * 0.75}, {10, sign * 0.75}});
    const Course middle = Course{}.straight(10).turn(0.75, sign * scene::pi).straight(10);
    Racer racer{Params{}};
    expect_driven(drive(racer, scene, middle, 3, 17, 2.0), 0.5, named("thin wall", sign));
    Racer carried{Params{}};
    expect_good(carry(carried, scene, middle, 3, 17), 0.3, named("thin wall", sign), past_the_end);
  }
}

// Only one wall is visible: the inner wall of a hairpin is already behind the car.
TEST(Cases, hairpin_with_the_inner_wall_occluded_in_the_first_scan_still_turns_the_right_way) {
  for (const double sign : {1.0, -1.0}) {
    const Course course = Course{}.straight(8).turn(1.2, sign * scene::pi).straight(8);
    const Scene scene = course.walls(1.6);
    for (double s = 8.2; s < 10.0; s += 0.3) {
      Racer racer{Params{}};
      StepResult r;
      for (int i = 0; i < 6; ++i) r = racer.step(scene.scan(course.at(s)).view(), {2.0, sign * 1.6, 0.0}, 0.0);
      for (int i = 0; i < 6; ++i) r = racer.step(scene.scan(course.at(s)).view(), {0.0, 0.0, 0.0}, 0.025);
      EXPECT_EQ(r.status, Status::ok) << sign << " at " << s;
      EXPECT_GT(sign * r.command.steering_angle, 0.05) << sign << " at " << s;
    }
  }
}

TEST(Cases, slalom) {
  Course course = Course{}.straight(5);
  course.turn(1.5, 0.9);
  for (int i = 0; i < 4; ++i) course.turn(1.5, i % 2 == 0 ? -1.8 : 1.8);
  course.turn(1.5, -0.9).straight(9);
  Racer carried{Params{}};
  expect_good(carry(carried, course.walls(1.5), course, 3, course.length() - 8), 0.2, "slalom carried");
  Racer driver{Params{}};
  expect_driven(drive(driver, course.walls(1.5), course, 3, course.length() - 8, 2.0), 0.4, "slalom driven");
}

TEST(Cases, chicane_of_right_angles) {
  // A corridor of 1.6 m that jumps sideways by 1.6 m.
  Scene scene;
  scene.add(scene::right, {{-2, -0.8}, {8, -0.8}, {8, 0.8}, {25, 0.8}});
  scene.add(scene::left, {{-2, 0.8}, {6.4, 0.8}, {6.4, 2.4}, {25, 2.4}});
  const Course middle = Course{}.straight(6.4).turn(0.8, 0.5 * scene::pi).turn(0.8, -0.5 * scene::pi).straight(14);
  Racer racer{Params{}};
  const Tour tour = drive(racer, scene, middle, 1, 14, 2.0);
  expect_driven(tour, 0.5, "chicane");
  EXPECT_EQ(tour.wrong_labels, 0) << "of " << tour.labels;
}

TEST(Cases, right_angle_corners) {
  for (const int side : {scene::right, scene::left}) {
    Scene scene;
    const double d = side;
    scene.add(side, {{-2, d * 0.8}, {8, d * 0.8}, {8, d * 20}});
    scene.add(-side, {{-2, -d * 0.8}, {9.6, -d * 0.8}, {9.6, d * 20}});
    const Course middle = Course{}.straight(8).turn(0.8, d * 0.5 * scene::pi).straight(14);
    Racer racer{Params{}};
    const Tour tour = drive(racer, scene, middle, 1, 15, 2.0);
    expect_driven(tour, 0.5, "corner");
    EXPECT_EQ(tour.wrong_labels, 0) << "of " << tour.labels;
  }
}

// Pipes -----------------------------------------------------------------------------------------------

TEST(Cases, pipes_with_joints_in_a_straight_with_a_hall_behind) {
  for (const double joint : {0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8}) {
    for (const double pipe : {1.0, 2.0}) {
      const Course course = Course{}.straight(30);
      Scene scene = course.pipes(2.0, pipe, joint);
      scene.add(scene::neither, {{-5, 3.5}, {35, 3.5}}).add(scene::neither, {{-5, -2.5}, {35, -2.5}});
      Racer racer{Params{}};
      expect_good(carry(racer, scene, course, 3, 20), 0.15, named("joint", joint) + named(", pipe", pipe),
                  past_the_end);
    }
  }
}

TEST(Cases, pipes_with_joints_in_curves_with_a_hall_behind) {
  // On the outside of the curve a joint is 1.5 times as wide.
  for (const double joint : {0.05, 0.2, 0.4, 0.5}) {
    const Course course = Course{}.straight(6).turn(2.0, 1.5).turn(2.0, -2.5).straight(9);
    Scene scene = course.pipes(2.0, 1.0, joint);
    scene.box(scene::neither, -6, -12, 35, 24);
    Racer carried{Params{}};
    expect_good(carry(carried, scene, course, 3, course.length() - 8), 0.25, named("joint", joint), past_the_end);
    Racer driver{Params{}};
    expect_driven(drive(driver, scene, course, 3, course.length() - 8, 2.0), 0.5, named("joint", joint));
  }
}

// Seen and not seen ------------------------------------------------------------------------------------

TEST(Cases, an_open_area_beyond_a_low_wall) {
  // Through a gap of 4 m in the left wall the LiDAR sees a hall with a column and a far wall.
  const Course course = Course{}.straight(30);
  for (const int side : {scene::left, scene::right}) {
    Scene scene;
    scene.add(-side, course.parallel(-1.0 * side, 0, 30));
    scene.add(side, course.parallel(1.0 * side, 0, 9)).add(side, course.parallel(1.0 * side, 13, 30));
    scene.add(scene::neither, {{-5, 6.0 * side}, {35, 6.0 * side}});
    scene.box(scene::neither, 11, 3.0 * side, 0.5, 0.5);
    Racer carried{Params{}};
    const Tour tour = carry(carried, scene, course, 3, 20);
    EXPECT_EQ(tour.not_ok, 0);
    EXPECT_LT(tour.worst_line, 0.3) << "at " << tour.worst_at;
    Racer driver{Params{}};
    expect_driven(drive(driver, scene, course, 3, 20, 2.0), 0.4, "low wall");
  }
}

TEST(Cases, a_missing_wall) {
  // Nothing at all in place of 5 m of one wall.
  const Course course = Course{}.straight(5).turn(4.0, 0.8).straight(20);
  for (const int side : {scene::left, scene::right}) {
    Scene scene;
    scene.add(-side, course.parallel(-0.9 * side, 0, course.length()));
    scene.add(side, course.parallel(0.9 * side, 0, 6)).add(side, course.parallel(0.9 * side, 11, course.length()));
    Racer carried{Params{}};
    const Tour tour = carry(carried, scene, course, 3, 18);
    EXPECT_EQ(tour.not_ok, 0) << side;
    EXPECT_EQ(tour.wrong_labels, 0) << side << ", of " << tour.labels;
    EXPECT_LT(tour.worst_line, 0.2) << side << " at " << tour.worst_at;
    Racer driver{Params{}};
    expect_driven(drive(driver, scene, course, 3, 18, 2.0), 0.4, "missing wall");
  }
}

TEST(Cases, only_one_wall_exists) {
  for (const int side : {scene::left, scene::right}) {
    const Course course = Course{}.straight(5).turn(3.0, 1.5).straight(5).turn(3.0, -1.5).straight(8);
    Scene scene;
    scene.add(side, course.parallel(1.0 * side, 0, course.length()));
    Racer racer{Params{}};
    const Tour tour = carry(racer, scene, course, 3, course.length() - 6);
    EXPECT_EQ(tour.not_ok, 0) << side;
    EXPECT_EQ(tour.wrong_labels, 0) << side << ", of " << tour.labels;
    EXPECT_LT(tour.worst_line, 0.25) << side << " at " << tour.worst_at << " (the remembered width is the true one)";
  }
}

// Lost beams ------------------------------------------------------------------------------------------

Course winding() { return Course{}.straight(5).turn(1.8, 1.4).turn(1.8, -1.4).straight(10); }

TEST(Cases, beams_lost_individually) {
  for (const double share : {0.01, 0.1, 0.3, 0.6}) {
    scene::RandomInputs random(scene::seed_or(9));
    const Course course = winding();
    Racer racer{Params{}};
    const Tour tour = carry(racer, course.walls(1.6), course, 3, course.length() - 8, 2.0, [&](Scan& scan, int) {
      for (float& r : scan.ranges)
        if (random.chance(share)) r = 0.0F;
    });
    expect_good(tour, 0.15, named("lost", share));
  }
}

TEST(Cases, beams_lost_in_blocks) {
  for (const double share : {0.05, 0.2, 0.4, 0.6}) {
    scene::RandomInputs random(scene::seed_or(10));
    const Course course = winding();
    Racer racer{Params{}};
    const Tour tour = carry(racer, course.walls(1.6), course, 3, course.length() - 8, 2.0, [&](Scan& scan, int) {
      constexpr int block = 20;  // 5 degrees
      for (std::size_t i = 0; i < scan.ranges.size(); i += block)
        if (random.chance(share))
          for (std::size_t k = i; k < std::min(i + block, scan.ranges.size()); ++k) scan.ranges[k] = 0.0F;
    });
    // A hole in a wall is passable until the LiDAR sees that it is not: method.md, section 11, has 0.95 to 1.0.
    EXPECT_LE(tour.wrong_labels, 0.02 * tour.labels) << share;
    EXPECT_EQ(tour.not_ok, 0) << share << ", of " << tour.steps;
    EXPECT_LT(tour.worst_line, 0.3) << share << " at " << tour.worst_at;
  }
}

TEST(Cases, range_noise_of_the_papers_lidar) {
  // 10 mm as in section 9, and 30 mm as in the data sheet of the paper's LiDAR.
  for (const double sigma : {0.010, 0.030}) {
    scene::RandomInputs random(scene::seed_or(11));
    const Course course = winding();
    Racer racer{Params{}};
    const Tour tour = carry(racer, course.walls(1.6), course, 3, course.length() - 8, 2.0, [&](Scan& scan, int) {
      for (float& r : scan.ranges) {
        double noise = -6.0;
        for (int k = 0; k < 12; ++k) noise += random.uniform(0.0, 1.0);
        r += static_cast<float>(sigma * noise);
      }
    });
    expect_good(tour, 0.15, named("sigma", sigma));
  }
}

// Obstacles -------------------------------------------------------------------------------------------

// Smallest distance of the planned path (up to 3 m ahead) to the box while the car passes it.
double clearance_of_box(double box_y, double width, Tour& tour) {
  const Course course = Course{}.straight(30);
  Scene scene = course.walls(width);
  Scene box;
  box.box(scene::neither, 12, box_y - 0.1, 0.3, 0.2);  // a shoe box
  scene.walls.insert(scene.walls.end(), box.walls.begin(), box.walls.end());
  Racer racer{Params{}};
  double smallest = 1e9;
  constexpr double dt = 0.025;
  Pose2 car = course.at(5);
  double speed = 2.0;
  double yaw_rate = 0.0;
  double wheel = 0.0;
  for (int i = 0; i < 400 && car.x < 14.0; ++i) {
    const StepResult r = racer.step(scene.scan(car).view(), {speed, yaw_rate, wheel}, dt);
    scene::evaluate(racer, r, scene, course, car, car.x, tour);
    for (const double x : {-0.1, 0.15, 0.33, 0.45}) {
      const Point2 p = scene::to_world(car, x, 0.0);
      smallest = std::min(smallest, box.distance(scene::neither, p));
    }
    speed += std::clamp(r.command.speed - speed, -0.15, 0.15);
    wheel = r.command.steering_angle;
    yaw_rate = speed * std::tan(wheel) / 0.33;
    car = {car.x + speed * dt * std::cos(car.yaw), car.y + speed * dt * std::sin(car.yaw), car.yaw + yaw_rate * dt};
  }
  return smallest;
}

TEST(Cases, a_shoe_box_near_one_wall_is_passed_on_its_free_side) {
  for (const double y : {-0.75, -0.5, 0.5, 0.75}) {
    Tour tour;
    EXPECT_GT(clearance_of_box(y, 2.0, tour), 0.155) << "box at y " << y << ": the car touches it";
    EXPECT_EQ(tour.not_ok, 0) << y;
  }
}

TEST(Cases, a_shoe_box_in_the_middle_is_not_hit) {
  for (const double width : {2.0, 2.6, 3.2}) {
    for (const double y : {-0.1, 0.0, 0.1}) {
      Tour tour;
      EXPECT_GT(clearance_of_box(y, width, tour), 0.155) << "width " << width << ", box at y " << y;
    }
  }
}

TEST(Cases, a_box_that_blocks_the_track_stops_the_car_before_it) {
  const Course course = Course{}.straight(30);
  Scene scene = course.walls(1.0);
  scene.box(scene::neither, 12, -0.25, 0.3, 0.5);
  Racer racer{Params{}};
  double x = 5.0;
  double speed = 2.0;
  StepResult r;
  for (int i = 0; i < 400 && x < 12.0; ++i) {
    r = racer.step(scene.scan({x, 0, 0}).view(), {speed, 0.0, 0.0}, 0.025);
    speed += std::clamp(r.command.speed - speed, -0.15, 0.15);
    x += speed * 0.025;
  }
  EXPECT_LT(x + 0.455, 12.0) << "the front bumper";
  EXPECT_TRUE(r.status == Status::blocked || r.status == Status::no_path) << to_string(r.status);
}

// Behind the car ---------------------------------------------------------------------------------------

TEST(Cases, the_car_does_not_turn_back_where_the_corridor_it_came_from_is_the_deepest_gap) {
  for (const double sign : {1.0, -1.0}) {
    // A long straight, a hairpin, a short straight, and a hairpin back.
    const Course course =
        Course{}.straight(12).turn(1.0, sign * scene::pi).straight(2.5).turn(1.0, -sign * scene::pi).straight(10);
    Racer racer{Params{}};
    const Tour tour = drive(racer, course.walls(1.6), course, 3, course.length() - 7, 2.0);
    expect_driven(tour, 0.5, named("double hairpin", sign));
  }
}

}  // namespace
}  // namespace firstlap
