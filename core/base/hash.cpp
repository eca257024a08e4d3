#include "core/base/hash.h"

#include <fmt/format.h>

#include "core/base/files.h"

namespace uniquadric {

void Hash::bytes(const void* data, std::size_t size) {
  const auto* p = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) state_ = (state_ ^ p[i]) * 0x100000001b3u;
}

Hash& Hash::add(std::uint64_t number) {
  bytes(&number, sizeof number);
  return *this;
}

Hash& Hash::add(std::string_view text) {
  add(std::uint64_t{text.size()});
  bytes(text.data(), text.size());
  return *this;
}

Hash& Hash::add_file(const std::filesystem::path& path) {
  return add(read_text(path));
}

std::uint64_t Hash::value() const {  // MurmurHash3's finaliser: FNV's high bits mix poorly
  std::uint64_t h = state_;
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdu;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53u;
  return h ^ (h >> 33);
}

std::string Hash::hex() const {
  return fmt::format("{:016x}", value());
}

}  // namespace uniquadric
