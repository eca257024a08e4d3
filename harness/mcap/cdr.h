#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace uniquadric {

/// Writes ROS 2 messages in OMG's common data representation (DDS Interoperability Wire Protocol 2.5, 10.2;
/// CORBA 3.3, 15.3): little-endian, each number aligned to its own size, counted from behind the four bytes
/// that say so. Assumes a little-endian machine, as the sequences' own binary files do.
class CdrWriter {
 public:
  template <typename T>
  requires std::integral<T> || std::floating_point<T>
  void number(T value) {
    bytes_.resize(kHeader + (bytes_.size() - kHeader + sizeof(T) - 1) / sizeof(T) * sizeof(T));
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void flag(bool value) { number<std::uint8_t>(value ? 1 : 0); }
  /// With a zero behind it, which counts.
  void text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.append(value).push_back('\0');
  }
  /// How many elements a sequence has; they follow.
  void count(std::size_t elements) { number(static_cast<std::uint32_t>(elements)); }
  /// Elements of one byte.
  void raw(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  template <typename... T>
  void numbers(T... values) {
    (number(values), ...);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHeader = 4;
  std::string bytes_ = std::string("\0\1\0\0", kHeader);  // plain CDR, little-endian
};

}  // namespace uniquadric
