// CPU time of this thread. Unlike the wall clock it excludes waiting and the time taken by other programs or races.
#pragma once

#include <chrono>
#include <ctime>

namespace firstlap::sim {

// [s] from an arbitrary start.
inline double cpu_seconds() noexcept {
#ifdef CLOCK_THREAD_CPUTIME_ID
  timespec now{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0)
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
#endif
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace firstlap::sim
