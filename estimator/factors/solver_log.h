#pragma once

namespace uniquadric {

/// The solver writes what it meets on its way to standard error, in its own words and with its own files and
/// lines. It says the same in its summaries, which are looked at: from here on it writes nothing but what
/// ends the program.
void keep_solver_silent();

}  // namespace uniquadric
