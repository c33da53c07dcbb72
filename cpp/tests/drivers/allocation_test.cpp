// Replaces the global operator new of the whole test program by a counting one.
#include <cstddef>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>
#include <vector>

#include "support/allocations.hpp"
#include "support/random_inputs.hpp"

// The compiler inlines these pairs partly and reports them as mismatched.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
#endif

namespace firstlap::scene {
thread_local bool counting = false;
thread_local long allocations = 0;
}  // namespace firstlap::scene

namespace {
using firstlap::scene::allocations;
using firstlap::scene::counting;

void* counted(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  const std::size_t rounded = (std::max<std::size_t>(size, 1) + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, rounded)) return memory;
  throw std::bad_alloc();
}
constexpr std::size_t standard = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
}  // namespace

void* operator new(std::size_t size) { return counted(size, standard); }
void* operator new[](std::size_t size) { return counted(size, standard); }
void* operator new(std::size_t size, std::align_val_t a) { return counted(size, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t size, std::align_val_t a) { return counted(size, static_cast<std::size_t>(a)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace firstlap {
namespace {

TEST(Allocation, the_counter_counts) {
  counting = true;
  const std::vector<int> v(1000, 1);
  counting = false;
  EXPECT_GE(allocations, 1) << v.size();
}

TEST(Allocation, a_thousand_steps_on_varied_scans_allocate_nothing) {
  scene::RandomInputs random(scene::seed_or(8));
  std::vector<scene::Scan> scans;
  std::vector<VehicleState> states;
  std::vector<double> steps;
  const scene::Course course = scene::Course{}.straight(3).turn(1.2, 3.1).turn(1.2, -3.1).straight(8);
  const scene::Scene track = course.pipes(1.8, 1.0, 0.3);
  for (int i = 0; i < 1000; ++i) {
    const bool drive = i % 100 < 70;
    scans.push_back(drive ? track.scan(course.at(1.0 + 0.05 * (i % 200))) : random.scan());
    states.push_back(drive ? VehicleState{2.0, 0.0, 0.0} : random.state());
    steps.push_back(drive ? 0.025 : random.dt());
  }
  Params params;
  params.minimum_curvature.bend_passes = 30;
  Racer racer{params};
  allocations = 0;
  int ok = 0;
  counting = true;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ok += racer.step(scans[i].view(), states[i], steps[i]).status == Status::ok;
    if (i % 333 == 0) racer.reset();
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(ok, 500) << "the whole method must have run";
}

}  // namespace
}  // namespace firstlap
