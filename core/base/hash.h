#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace uniquadric {

/// An incremental 64-bit FNV-1a hash with a final avalanche: names stages by their inputs and keys random
/// streams. Not cryptographic.
class Hash {
 public:
  Hash& add(std::string_view text);  ///< length first, so ("ab","c") and ("a","bc") differ
  Hash& add(std::uint64_t number);
  Hash& add_file(const std::filesystem::path& path);  ///< its hash_file()
  std::uint64_t value() const;
  std::string hex() const;  ///< 16 lower-case digits

 private:
  void bytes(const void* data, std::size_t size);
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

/// XXH64 of a file's content, as `xxh64sum` computes it. Throws InputError when it cannot be read.
std::uint64_t hash_file(const std::filesystem::path& path);

/// 16 lower-case digits.
std::string hex(std::uint64_t hash);

}  // namespace uniquadric
