# Every library comes from Debian's packages (packages.txt).
set(CMAKE_DISABLE_FIND_PACKAGE_VTK ON)  # PCL asks for it, nothing here does
if(POLICY CMP0144)
  cmake_policy(SET CMP0144 NEW)  # PCL's FindFLANN names a variable FLANN_ROOT
endif()
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(OpenCV 4.6 REQUIRED CONFIG COMPONENTS core imgproc imgcodecs calib3d features2d video dnn)
find_package(Ceres 2.1 REQUIRED CONFIG)
find_package(PCL 1.13 REQUIRED CONFIG COMPONENTS common kdtree octree search)
find_package(Boost 1.74 REQUIRED)  # its header-only part
find_package(assimp 5.2 REQUIRED CONFIG)
find_package(yaml-cpp REQUIRED CONFIG)
find_package(nanoflann REQUIRED CONFIG)
find_package(nlohmann_json REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(fmt REQUIRED CONFIG)
find_package(TBB REQUIRED CONFIG)
find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED CONFIG)
endif()
find_package(octomap 1.9 REQUIRED CONFIG)
target_compile_definitions(octomap INTERFACE OCTOMAP_NODEBUGOUT)  # else it prints where assertions are on
find_package(GTest REQUIRED CONFIG)
find_package(PkgConfig REQUIRED)
pkg_check_modules(OSMESA osmesa)  # for its header: it is not linked, but loaded on demand; Mesa has none after 25.0
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo)
pkg_check_modules(LIBDEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(POLYCLIPPING REQUIRED IMPORTED_TARGET polyclipping)
if(UNIQUADRIC_BENCHMARKS)
  find_package(benchmark REQUIRED CONFIG)
endif()
