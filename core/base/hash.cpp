#include "core/base/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/base/read_file.h"

namespace uniquadric {
namespace {
constexpr std::size_t kChunk = 1 << 16;  // bytes of a file at a time: more would be mapped anew for each file
}

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
  return add(hash_file(path));
}

std::uint64_t Hash::value() const {  // MurmurHash3's finaliser: FNV's high bits mix poorly
  std::uint64_t h = state_;
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdu;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53u;
  return h ^ (h >> 33);
}

std::string Hash::hex() const {
  return uniquadric::hex(value());
}

std::uint64_t hash_file(const std::filesystem::path& path) {
  require_regular_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
  const std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> state(XXH64_createState(),
                                                                         &XXH64_freeState);
  XXH64_reset(state.get(), 0);
  std::vector<char> chunk(kChunk);
  do {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    XXH64_update(state.get(), chunk.data(), static_cast<std::size_t>(in.gcount()));
  } while (in);
  if (in.bad()) throw InputError(path, "read failed");
  return XXH64_digest(state.get());
}

std::string hex(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

}  // namespace uniquadric
