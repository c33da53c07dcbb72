// A vector whose capacity is fixed when it is made, so that nothing allocates while driving. What does
// not fit is dropped: work stays bounded for any input.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace firstlap {

template <class T>
class Buffer {
 public:
  explicit Buffer(std::size_t capacity) { items_.reserve(capacity); }

  bool push(const T& item) noexcept {
    if (items_.size() == items_.capacity()) return false;
    items_.push_back(item);
    return true;
  }
  void clear() noexcept { items_.clear(); }
  void shrink(std::size_t size) noexcept {
    if (size < items_.size()) items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(size), items_.end());
  }
  void assign(std::span<const T> other) noexcept {
    clear();
    for (const T& item : other) push(item);
  }

  [[nodiscard]] std::size_t size() const noexcept { return items_.size(); }
  [[nodiscard]] std::size_t capacity() const noexcept { return items_.capacity(); }
  [[nodiscard]] bool empty() const noexcept { return items_.empty(); }
  T& operator[](std::size_t i) noexcept { return items_[i]; }
  const T& operator[](std::size_t i) const noexcept { return items_[i]; }
  T& back() noexcept { return items_.back(); }
  const T& back() const noexcept { return items_.back(); }
  const T& front() const noexcept { return items_.front(); }
  auto begin() noexcept { return items_.begin(); }
  auto end() noexcept { return items_.end(); }
  auto begin() const noexcept { return items_.begin(); }
  auto end() const noexcept { return items_.end(); }
  const T* data() const noexcept { return items_.data(); }
  T* data() noexcept { return items_.data(); }
  std::span<const T> span() const noexcept { return {items_.data(), items_.size()}; }

 private:
  std::vector<T> items_;
};

}  // namespace firstlap
