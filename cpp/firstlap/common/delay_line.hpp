// Transport delay of a command: a value pushed for time t is returned from t on. Fixed memory.
#pragma once

#include <array>
#include <cstddef>

namespace firstlap {

class DelayLine {
 public:
  void reset(double value) noexcept {
    current_ = value;
    head_ = tail_ = 0;
  }

  // `value` takes effect at `time` [s], but not before earlier values: a shrinking delay does not change their order.
  // If the line is full, the oldest value takes effect immediately.
  void push(double time, double value) noexcept {
    if (tail_ - head_ == entries_.size()) current_ = entries_[head_++ % entries_.size()].value;
    entries_[tail_++ % entries_.size()] = {time, value};
  }

  // The value in effect at `time` [s]. Times must not decrease.
  double at(double time) noexcept {
    while (head_ != tail_ && entries_[head_ % entries_.size()].time <= time + 1e-9) {
      current_ = entries_[head_++ % entries_.size()].value;
    }
    return current_;
  }

 private:
  struct Entry {
    double time = 0.0;
    double value = 0.0;
  };

  std::array<Entry, 128> entries_{};
  std::size_t head_ = 0, tail_ = 0;
  double current_ = 0.0;
};

}  // namespace firstlap
