// A vector of fixed capacity: nothing is allocated while driving. Items that do not fit are dropped, which bounds the
// work for any input.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace firstlap {

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Buffer(std::size_t capacity) : items_(capacity) {}
  Buffer(const Buffer&) = default;
  Buffer(Buffer&&) noexcept = default;
  Buffer& operator=(Buffer&&) noexcept = default;
  // Copies the items only. The other buffer's capacity must not be larger.
  Buffer& operator=(const Buffer& other) noexcept {
    assign(other.span());
    return *this;
  }
  ~Buffer() = default;

  bool push(const T& item) noexcept {
    if (size_ == items_.size()) return false;
    items_[size_++] = item;
    return true;
  }
  void clear() noexcept { size_ = 0; }
  void fill(std::size_t size, const T& item) noexcept {
    size_ = std::min(size, items_.size());
    std::fill_n(items_.begin(), size_, item);
  }
  // Keeps the first `size` items.
  void shrink(std::size_t size) noexcept { size_ = std::min(size_, size); }
  void assign(std::span<const T> other) noexcept {
    size_ = std::min(other.size(), items_.size());
    std::copy_n(other.begin(), size_, items_.begin());
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return items_.size(); }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  T& operator[](std::size_t i) noexcept {
    assert(i < size_);
    return items_[i];
  }
  const T& operator[](std::size_t i) const noexcept {
    assert(i < size_);
    return items_[i];
  }
  T& back() noexcept { return (*this)[size_ - 1]; }
  const T& back() const noexcept { return (*this)[size_ - 1]; }
  const T& front() const noexcept { return (*this)[0]; }
  T* begin() noexcept { return items_.data(); }
  T* end() noexcept { return items_.data() + size_; }
  const T* begin() const noexcept { return items_.data(); }
  const T* end() const noexcept { return items_.data() + size_; }
  T* data() noexcept { return items_.data(); }
  const T* data() const noexcept { return items_.data(); }
  [[nodiscard]] std::span<const T> span() const noexcept { return {items_.data(), size_}; }

 private:
  std::vector<T> items_;
  std::size_t size_ = 0;
};

}  // namespace firstlap
