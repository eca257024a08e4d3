#include "harness/bench/program.h"

#include "harness/source_commit.h"

namespace uniquadric {

std::string program_source() {
  const std::string commit = kCommit;
  if (commit.empty()) return "no known commit";
  return "commit " + commit + (kChangedSince ? ", changed since" : ", unchanged");
}

}  // namespace uniquadric
