// All parameters of the map-less method, one section per stage. A setup file contains only what differs from the
// defaults.
#pragma once

#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/control/params.hpp"
#include "firstlap/estimation/params.hpp"
#include "firstlap/perception/params.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

struct Params {
  CarModel car{};
  ScanParams scan{};
  SegmentationParams segmentation{};
  TrackWidthParams track_width{};
  CenterlineParams centerline{};
  TrajectoryParams trajectory{};
  MinimumCurvatureParams minimum_curvature{};
  VelocityProfileParams velocity_profile{};
  StanleyParams stanley{};
  StoppingCheckParams stopping_check{};
  SpeedScaleParams speed_scale{};
};

// Calls `visit(name, section)` for every section, in the order of the stages. Field names are unique over all sections.
template <class AnyParams, class Visitor>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("car", params.car);
  visit("scan", params.scan);
  visit("segmentation", params.segmentation);
  visit("track_width", params.track_width);
  visit("centerline", params.centerline);
  visit("trajectory", params.trajectory);
  visit("minimum_curvature", params.minimum_curvature);
  visit("velocity_profile", params.velocity_profile);
  visit("stanley", params.stanley);
  visit("stopping_check", params.stopping_check);
  visit("speed_scale", params.speed_scale);
}

// Throws std::invalid_argument with section, field, value and allowed range; also for contradicting pairs, such as
// v_min above v_max.
void validate(const Params& params);

}  // namespace firstlap
