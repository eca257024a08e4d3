// The program of scripts/fuzz: libFuzzer with the target that --target=NAME names; --list names all.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "fuzz/target.h"

namespace {
const uniquadric::fuzz::Target* target = nullptr;
}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const auto& all = uniquadric::fuzz::Target::all();
  for (int i = 1; i < *argc; ++i) {
    const std::string_view argument = (*argv)[i];
    constexpr std::string_view kTarget = "--target=";
    if (argument == "--list") {
      for (const auto& [name, each] : all) std::puts(name.c_str());
      std::exit(0);
    }
    if (!argument.starts_with(kTarget)) continue;
    const auto found = all.find(std::string(argument.substr(kTarget.size())));
    if (found != all.end()) target = &found->second;
  }
  if (!target) {
    std::fputs("--target=NAME: expected one that --list names\n", stderr);
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target->feed({reinterpret_cast<const char*>(data), size});
  return 0;
}
