# cmake -DSOURCE_DIR=... -DOUTPUT=... -P: writes a header that says which commit the sources are of, and whether they
# were changed since. Run with every build; the header is written anew where that has changed alone.
find_program(GIT git)
set(commit "")
set(changed false)
set(sources core simulator estimator evaluation harness cmake CMakeLists.txt)
if(GIT AND EXISTS ${SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT} rev-parse HEAD WORKING_DIRECTORY ${SOURCE_DIR} OUTPUT_VARIABLE head
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  execute_process(COMMAND ${GIT} --no-optional-locks status --porcelain -- ${sources} WORKING_DIRECTORY ${SOURCE_DIR}
                  OUTPUT_VARIABLE changes ERROR_QUIET RESULT_VARIABLE also_failed)
  if(NOT failed AND NOT also_failed)
    set(commit ${head})
    if(NOT changes STREQUAL "")
      set(changed true)
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[#pragma once

namespace uniquadric {
inline constexpr const char* kCommit = "@commit@";  // empty: not known
inline constexpr bool kChangedSince = @changed@;
}  // namespace uniquadric
]])
