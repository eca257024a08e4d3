# What `cmake --install` puts where. Component `runtime`: the program, what it is called with as examples (scenes,
# variants, benches, in folders side by side as in the sources, since they name each other by relative paths), the pages
# that the README leads to, shell completion and manual pages; nothing of it is needed for the program to run.
# Component `development`: the libraries of core and evaluation with their headers, for find_package(uniquadric).
# Component `python`: the Python package (python/CMakeLists.txt).
include(CMakePackageConfigHelpers)
set(data ${CMAKE_INSTALL_DATADIR}/uniquadric)

install(TARGETS uniquadric RUNTIME COMPONENT runtime)
install(DIRECTORY scenes configs docs examples results DESTINATION ${data} COMPONENT runtime)
install(FILES README.md DESTINATION ${data} COMPONENT runtime)
foreach(folder estimator simulator/lidar)
  install(FILES ${folder}/README.md DESTINATION ${data}/${folder} COMPONENT runtime)
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT runtime)

# Asked of the program itself when it is installed, so that no build has to wait for it.
set(said ${PROJECT_BINARY_DIR}/said)
install(CODE "execute_process(COMMAND [[${PROJECT_SOURCE_DIR}/scripts/describe]] [[$<TARGET_FILE:uniquadric>]] [[${said}]]
              COMMAND_ERROR_IS_FATAL ANY)" COMPONENT runtime)
install(FILES ${said}/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
        RENAME uniquadric COMPONENT runtime)
install(DIRECTORY ${said}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT runtime)

set(headers ${CMAKE_INSTALL_INCLUDEDIR}/uniquadric)
install(DIRECTORY core evaluation DESTINATION ${headers} COMPONENT development FILES_MATCHING PATTERN "*.h"
        PATTERN page EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/generated/core/base/version.h DESTINATION ${headers}/core/base
        COMPONENT development)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/uniquadric)
configure_package_config_file(cmake/uniquadric-config.cmake.in ${PROJECT_BINARY_DIR}/uniquadric-config.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/uniquadric-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/uniquadric-config.cmake ${PROJECT_BINARY_DIR}/uniquadric-config-version.cmake
        DESTINATION ${package} COMPONENT development)
install(EXPORT uniquadric-targets NAMESPACE uniquadric:: DESTINATION ${package} COMPONENT development)
