#pragma once

#include <string>

namespace uniquadric {

/// Lets the process, when SIGINT or SIGTERM ends it, say first in one line on standard error what it leaves.
/// It still ends by that signal. Signals that are ignored stay so.
void say_what_is_left_when_interrupted();

/// What that line says from now on: "what is done is kept in OUT: ..."; empty: nothing more.
void leave_when_interrupted(const std::string& what);

}  // namespace uniquadric
