#pragma once

namespace uniquadric {

/// How closely a sequence is looked at before it is used. All numbers are ours.
struct PlausibilityOptions {
  bool enabled = true;
  int pairs = 16;     // of frames, evenly spread; each test takes what it needs of them
  bool scans = true;  // a few are followed; estimate, which follows all of them, leaves it out
};

}  // namespace uniquadric
