#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace pliant::io {

/// Appends text to a string; numbers in the shortest form that reads back as the same bits,
/// whatever the locale.
class NumberWriter {
 public:
  NumberWriter& operator<<(std::string_view text) {
    text_.append(text);
    return *this;
  }
  NumberWriter& operator<<(char c) {
    text_.push_back(c);
    return *this;
  }
  template <class T>
  requires std::floating_point<T> ||(std::integral<T> && !std::same_as<T, char>)NumberWriter&
  operator<<(T value) {
    std::array<char, 32> buffer;
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    text_.append(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
    return *this;
  }

  [[nodiscard]] const std::string& text() const& { return text_; }
  [[nodiscard]] std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace pliant::io
