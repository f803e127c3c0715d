#include "client/io/number_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace pliant::io {
namespace {

constexpr std::int64_t kInt32Max = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kInt32Min = std::numeric_limits<std::int32_t>::min();

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
bool IsSpace(char c) { return IsBlank(c) || c == '\n'; }

}  // namespace

void NumberReader::Seek(std::size_t position) {
  if (!ok()) return;
  if (position > bytes_.size()) {
    FailSyntax("expected more data at byte " + std::to_string(position) +
               ", but the file ends at byte " + std::to_string(bytes_.size()));
    return;
  }
  position_ = position;
}

void NumberReader::Skip(std::size_t count) {
  if (count > remaining()) {
    FailSyntax("expected " + std::to_string(count) + " more bytes, but only " +
               std::to_string(remaining()) + " are left; is the file cut off?");
    return;
  }
  position_ += count;
}

void NumberReader::SkipPast(std::string_view text) {
  const std::size_t found = bytes_.find(text, position_);
  if (found == std::string_view::npos) {
    FailSyntax("expected '" + std::string(text) + "', which does not follow; is the file cut off?");
    return;
  }
  position_ = found + text.size();
}

void NumberReader::SkipLine() {
  const std::size_t found = bytes_.find('\n', position_);
  position_ = found == std::string_view::npos ? bytes_.size() : found + 1;
}

bool NumberReader::AtLineEnd() {
  while (position_ < bytes_.size() && IsBlank(bytes_[position_])) ++position_;
  if (position_ < bytes_.size() && bytes_[position_] == '#') {
    position_ = std::min(bytes_.find('\n', position_), bytes_.size());
  }
  return position_ == bytes_.size() || bytes_[position_] == '\n';
}

bool NumberReader::AtEnd() {
  SkipBlanks();
  return position_ == bytes_.size();
}

void NumberReader::SkipBlanks() {
  for (;;) {
    while (position_ < bytes_.size() && IsSpace(bytes_[position_])) ++position_;
    if (position_ == bytes_.size() || bytes_[position_] != '#') return;
    SkipLine();
  }
}

std::string_view NumberReader::Word() {
  SkipBlanks();
  const std::size_t begin = position_;
  while (position_ < bytes_.size() && !IsSpace(bytes_[position_])) ++position_;
  return bytes_.substr(begin, position_ - begin);
}

std::string_view NumberReader::Line() {
  std::size_t begin = position_;
  std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
  position_ = std::min(end + 1, bytes_.size());
  while (begin < end && IsBlank(bytes_[begin])) ++begin;
  while (end > begin && IsBlank(bytes_[end - 1])) --end;
  return bytes_.substr(begin, end - begin);
}

void NumberReader::Expect(std::string_view expected) {
  SkipBlanks();
  const std::string found = ok() ? Found() : "";
  if (Word() != expected) FailSyntax("expected '" + std::string(expected) + "', found " + found);
}

std::int64_t NumberReader::Integer() {
  if (encoding_ == Encoding::kText) return TextInteger();
  return integer_size_ == 8 ? Raw<std::int64_t>() : Raw<std::int32_t>();
}

std::int64_t NumberReader::Long() {
  return encoding_ == Encoding::kText ? TextInteger() : Raw<std::int64_t>();
}

std::int64_t NumberReader::Short() {
  return encoding_ == Encoding::kText ? TextInteger() : Raw<std::int32_t>();
}

double NumberReader::Real() {
  double value = 0;
  if (encoding_ == Encoding::kText) {
    value = TextReal();
  } else {
    value = real_size_ == 8 ? Raw<double>() : static_cast<double>(Raw<float>());
  }
  if (!std::isfinite(value)) {
    Fail(ErrorCode::kNotFinite, "found a number that is infinite or not a number");
    return 0;
  }
  return value;
}

std::int32_t NumberReader::Tag() {
  const std::int64_t value = Integer();
  if (value < kInt32Min || value > kInt32Max) {
    Fail(ErrorCode::kOutOfRange,
         "tag " + std::to_string(value) + " does not fit 32 bits; renumber the tags");
    return 0;
  }
  return static_cast<std::int32_t>(value);
}

std::int32_t NumberReader::TagFromReal() {
  const double value = Real();
  if (value != std::floor(value) || std::abs(value) > static_cast<double>(kInt32Max)) {
    Fail(ErrorCode::kOutOfRange, "attribute " + std::to_string(value) +
                                     " is used as a tag, so it must be a 32-bit integer");
    return 0;
  }
  return static_cast<std::int32_t>(value);
}

std::int32_t NumberReader::Index(std::int64_t base) {
  const std::int64_t value = Integer();
  if (!ok()) return 0;
  if (value < base || value - base > kInt32Max) {
    Fail(ErrorCode::kIndexOutOfRange, "index " + std::to_string(value) +
                                          " names no element (from " + std::to_string(base) +
                                          " to at most 2147483647)");
    return 0;
  }
  return static_cast<std::int32_t>(value - base);
}

std::size_t NumberReader::Count(std::int64_t count, std::size_t element_size_min) {
  if (!ok()) return 0;
  if (count < 0) {
    FailSyntax("expected a count, found " + std::to_string(count));
    return 0;
  }
  if (count > kInt32Max) {
    Fail(ErrorCode::kTooLarge,
         "count " + std::to_string(count) + " is beyond the limit of 2147483647 elements");
    return 0;
  }
  const auto elements = static_cast<std::size_t>(count);
  // The last number of a text file needs no blank after it.
  if (elements > (remaining() + 1) / element_size_min) {
    FailSyntax("the header announces " + std::to_string(count) + " elements, but only " +
               std::to_string(remaining()) + " bytes follow; is the file cut off?");
    return 0;
  }
  return elements;
}

void NumberReader::Fail(ErrorCode code, const std::string& message) {
  if (error_.has_value()) return;
  // Positions are turned into line numbers here only, so that counting them costs nothing.
  const auto lines =
      std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(position_), '\n');
  const bool text = encoding_ == Encoding::kText;
  const std::int64_t place =
      text ? static_cast<std::int64_t>(lines) + 1 : static_cast<std::int64_t>(position_);
  error_ = Error{.code = code,
                 .message = (text ? "line " : "byte ") + std::to_string(place) + ": " + message,
                 .index = place};
  position_ = bytes_.size();
}

std::string NumberReader::Found() {
  if (position_ >= bytes_.size()) return "the end of the file";
  std::size_t end = position_;
  while (end < bytes_.size() && end - position_ < 24 && !IsSpace(bytes_[end])) ++end;
  std::string word(bytes_.substr(position_, end - position_));
  for (char& c : word) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + word + "'";
}

template <class T>
T NumberReader::Raw() {
  if (remaining() < sizeof(T)) {
    FailSyntax("expected " + std::to_string(sizeof(T)) + " more bytes; is the file cut off?");
    return T{};
  }
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
  if (encoding_ == Encoding::kBinarySwapped) std::reverse(raw.begin(), raw.end());
  position_ += sizeof(T);
  T value{};
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

std::int64_t NumberReader::TextInteger() {
  SkipBlanks();
  const char* begin = bytes_.data() + position_;
  const char* const end = bytes_.data() + bytes_.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  std::int64_t value = 0;
  const auto [stop, cause] = std::from_chars(begin, end, value);
  if (cause != std::errc() || (stop != end && !IsSpace(*stop) && *stop != '#')) {
    if (ok()) FailSyntax("expected an integer, found " + Found());
    return 0;
  }
  position_ = static_cast<std::size_t>(stop - bytes_.data());
  return value;
}

double NumberReader::TextReal() {
  SkipBlanks();
  const char* begin = bytes_.data() + position_;
  const char* const end = bytes_.data() + bytes_.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  double value = 0;
  const auto [stop, cause] = std::from_chars(begin, end, value);
  if (cause == std::errc::result_out_of_range) {
    Fail(ErrorCode::kOutOfRange, Found() + " is beyond the range of a double");
    return 0;
  }
  if (cause != std::errc() || (stop != end && !IsSpace(*stop) && *stop != '#')) {
    if (ok()) FailSyntax("expected a number, found " + Found());
    return 0;
  }
  position_ = static_cast<std::size_t>(stop - bytes_.data());
  return value;
}

}  // namespace pliant::io
