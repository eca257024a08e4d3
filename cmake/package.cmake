# cpack makes two Debian packages of the components: the program, which depends on what its libraries are found in
# (dpkg-shlibdeps), and the libraries for other projects, which depend on what uniquadric-config.cmake looks for.
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_PACKAGE_CONTACT "The Uniquadric authors <noreply@uniquadric.invalid>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME uniquadric)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "libopencv-imgcodecs406, libosmesa6")  # loaded on demand, which it does not see
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "simulates, estimates and evaluates object-level SLAM with moving objects")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libuniquadric-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(needed libboost-dev libdeflate-dev libeigen3-dev libembree-dev libfmt-dev liboctomap-dev libopencv-dev
           libpolyclipping-dev libtbb-dev libxxhash-dev libyaml-cpp-dev nlohmann-json3-dev pkg-config)
list(JOIN needed ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "core and evaluation libraries of uniquadric")
include(CPack)
