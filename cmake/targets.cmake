include(GNUInstallDirs)
include(GoogleTest)

add_library(uniquadric_warnings INTERFACE)
target_compile_options(uniquadric_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                                     -Wno-sign-conversion
                                                     $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # false positives of GCC 12 (PR 105651)
if(UNIQUADRIC_WERROR)
  target_compile_options(uniquadric_warnings INTERFACE -Werror)
endif()
if(UNIQUADRIC_SANITIZE)
  target_compile_options(uniquadric_warnings INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # false positives of GCC 12 in std::regex (PR 105562)
  add_compile_options(-fsanitize=${UNIQUADRIC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${UNIQUADRIC_SANITIZE})
endif()
# Programs of ours take it in, for what the sanitizers do not see of libraries.
add_library(sanitized_libraries INTERFACE)
if(UNIQUADRIC_SANITIZE MATCHES "thread|address")
  string(REGEX MATCH "thread|address" sanitizer ${UNIQUADRIC_SANITIZE})
  string(SUBSTRING ${sanitizer} 0 1 initial)
  add_library(sanitized_libraries_object OBJECT ${PROJECT_SOURCE_DIR}/cmake/sanitizers/${initial}san_libraries.cpp)
  target_link_libraries(sanitized_libraries_object PRIVATE opencv_imgproc uniquadric_warnings)
  target_sources(sanitized_libraries INTERFACE $<TARGET_OBJECTS:sanitized_libraries_object>)
  target_link_libraries(sanitized_libraries INTERFACE opencv_imgproc)
endif()
# One value for one input on every machine: no contraction to FMA, no value-changing optimisation.
add_compile_options(-ffp-contract=off)

# Without ccache, as on a new machine, nearly all of the time of a build is compiling, so there:
# - What most files include is parsed once; not beside ccache, which tells a file's result by all that the file includes.
# - Tests are optimised less, as most run for less time than their optimisation takes; what they test is not.
# - GCC's garbage collection starts at 512 MB instead of 128 MB, which few files reach.
function(uniquadric_headers name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LINKS;OPTIONS" ${ARGN})
  file(WRITE ${PROJECT_BINARY_DIR}/generated/${name}.cpp "")
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/generated/${name}.cpp)
  target_link_libraries(${name} PRIVATE Eigen3::Eigen fmt::fmt opencv_core uniquadric_warnings ${ARG_LINKS})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE <Eigen/Geometry> <algorithm> <filesystem> <fmt/format.h> <functional> <map>
                            <opencv2/core.hpp> <optional> <string> <vector> ${ARG_HEADERS})
endfunction()
if(NOT CCACHE)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # more false positives, where strings are concatenated beside a precompiled header (PR 105329)
    target_compile_options(uniquadric_warnings INTERFACE -Wno-array-bounds -Wno-stringop-overflow)
  endif()
  set(test_options $<$<CONFIG:Release>:-O1>)
  add_compile_options("$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=524288>")
  uniquadric_headers(library_headers)
  uniquadric_headers(module_headers)
  set_target_properties(module_headers PROPERTIES POSITION_INDEPENDENT_CODE ${UNIQUADRIC_PYTHON})
  uniquadric_headers(test_headers HEADERS <gtest/gtest.h> LINKS GTest::gtest_main OPTIONS ${test_options})
endif()
function(uniquadric_reuse_headers target headers)
  if(NOT CCACHE)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    target_compile_definitions(${target} PRIVATE FMT_SHARED)  # as fmt was parsed with it, or GCC parses all again
  endif()
endfunction()

# uniquadric_library(NAME SOURCES ... LINKS ... PRIVATE_LINKS ...): a static library of this folder, its
# links being exactly the arrows of docs/decisions.md. Those of core and evaluation are installed for other projects.
function(uniquadric_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_include_directories(${name} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR};${PROJECT_BINARY_DIR}/generated>"
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/uniquadric>)
  target_link_libraries(${name} PUBLIC ${ARG_LINKS}
                                PRIVATE ${ARG_PRIVATE_LINKS} $<BUILD_INTERFACE:uniquadric_warnings>)
  if(NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/(core|evaluation)")
    uniquadric_reuse_headers(${name} library_headers)
  else()
    uniquadric_reuse_headers(${name} module_headers)
    # -fPIC, as the Python module is a shared library
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ${UNIQUADRIC_PYTHON})
    target_compile_features(${name} INTERFACE $<INSTALL_INTERFACE:cxx_std_20>)
    install(TARGETS ${name} EXPORT uniquadric-targets
            ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/uniquadric COMPONENT development)
  endif()
endfunction()

# uniquadric_test(NAME SOURCES ... LINKS ...): one test program, its cases registered with ctest.
function(uniquadric_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} GTest::gtest_main sanitized_libraries uniquadric_warnings)
  target_compile_definitions(${name} PRIVATE UNIQUADRIC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_compile_options(${name} PRIVATE ${test_options})
  uniquadric_reuse_headers(${name} test_headers)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()
