#include "harness/mcap/ros2_messages.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "harness/mcap/cdr.h"

namespace uniquadric {
namespace {

// Definitions list a type's fields; those of the types that it uses follow, each behind a line of its name.
std::string defined(std::string fields, std::initializer_list<std::pair<const char*, const char*>> used) {
  for (const auto& [name, definition] : used)
    fields += std::string(80, '=') + "\nMSG: " + name + "\n" + definition;
  return fields;
}

constexpr const char* kTime = "int32 sec\nuint32 nanosec\n";
constexpr const char* kHeader = "builtin_interfaces/Time stamp\nstring frame_id\n";
constexpr const char* kXyz = "float64 x\nfloat64 y\nfloat64 z\n";
constexpr const char* kXyzw = "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

void put_time(CdrWriter& out, std::int64_t stamp_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  out.number(static_cast<std::int32_t>(stamp_ns / kSecond));
  out.number(static_cast<std::uint32_t>(stamp_ns % kSecond));
}

void put_header(CdrWriter& out, const Ros2Header& header) {
  put_time(out, header.stamp_ns);
  out.text(header.frame_id);
}

void put_vector(CdrWriter& out, const Eigen::Vector3d& v) {
  out.numbers(v.x(), v.y(), v.z());
}

void put_pose(CdrWriter& out, const Pose& pose) {
  put_vector(out, pose.translation);
  const Eigen::Quaterniond& q = pose.rotation;
  out.numbers(q.x(), q.y(), q.z(), q.w());
}

void put_color(CdrWriter& out, const std::array<float, 4>& color) {
  for (const float part : color) out.number(part);
}

// Row by row, of a covariance that is the same along all axes.
void put_covariance(CdrWriter& out, double variance) {
  for (int i = 0; i < 9; ++i) out.number(i % 4 == 0 ? variance : 0.0);
}

struct Field {
  const char* name;
  std::uint32_t offset;
  std::uint8_t type;  // sensor_msgs/PointField
};
constexpr std::uint8_t kUint8 = 2, kUint16 = 4, kUint32 = 6, kFloat32 = 7;
constexpr Field kFields[] = {{"x", 0, kFloat32},          {"y", 4, kFloat32}, {"z", 8, kFloat32},
                             {"intensity", 12, kFloat32}, {"t", 16, kUint32}, {"ring", 20, kUint16},
                             {"tag", 22, kUint8}};
constexpr std::uint32_t kPointSize = 24;

// A point of the surface in a direction.
Eigen::Vector3d on_surface(Superellipsoid body, const Eigen::Vector3d& direction) {
  constexpr double kLeast = 1.02;  // the gauge has no exponent 1; a corner is cut by less than a line's width
  for (double* q : {&body.exponents.outline, &body.exponents.upper, &body.exponents.lower})
    *q = std::max(*q, kLeast);
  return direction / gauge(body, direction);
}

// Directions on a grid, so that boxes keep their edges: those to points of the box with the same axes.
std::vector<Eigen::Vector3d> triangles_of(const Superellipsoid& body) {
  constexpr int kCells = 8;
  std::vector<Eigen::Vector3d> corners;
  const auto corner = [&](int axis, double side, double u, double v) {
    Eigen::Vector3d direction;
    direction[axis] = side, direction[(axis + 1) % 3] = u, direction[(axis + 2) % 3] = v;
    corners.push_back(on_surface(body, direction.cwiseProduct(body.semi_axes_m)));
  };
  const auto at = [](int i) { return 2.0 * i / kCells - 1; };
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < kCells; ++i)
        for (int k = 0; k < kCells; ++k) {
          const double u[] = {at(i), at(i + 1)}, v[] = {at(k), at(k + 1)};
          const bool out = side > 0;  // counter-clockwise as seen from outside
          corner(axis, side, u[0], v[0]), corner(axis, side, u[out], v[!out]), corner(axis, side, u[1], v[1]);
          corner(axis, side, u[0], v[0]), corner(axis, side, u[1], v[1]), corner(axis, side, u[!out], v[out]);
        }
  return corners;
}

constexpr std::int32_t kCube = 1, kSphere = 2, kTriangles = 11, kAdd = 0, kDeleteAll = 3;

void put_marker(CdrWriter& out, const Ros2Header& header, const std::string& name, std::int32_t action,
                const Ros2Solid& solid, const std::array<float, 4>& color) {
  const bool has_triangles = action == kAdd && !is_box(solid.body) && !is_ellipsoid(solid.body);
  const std::int32_t type = has_triangles ? kTriangles : is_ellipsoid(solid.body) ? kSphere : kCube;
  put_header(out, header);
  out.text(name);
  out.numbers(static_cast<std::int32_t>(solid.id), type, action);
  put_pose(out, solid.pose);
  put_vector(out, has_triangles ? Eigen::Vector3d::Ones() : Eigen::Vector3d(2 * solid.body.semi_axes_m));
  put_color(out, color);
  put_time(out, 0);  // lifetime: until it is replaced
  out.flag(false);
  const auto triangles = has_triangles ? triangles_of(solid.body) : std::vector<Eigen::Vector3d>();
  out.count(triangles.size());
  for (const Eigen::Vector3d& corner : triangles) put_vector(out, corner);
  out.count(0);  // colours
  out.text("");  // texture_resource, texture
  put_header(out, {});
  out.text("");
  out.count(0);
  out.count(0);  // uv_coordinates
  out.text("");  // text
  out.text("");  // mesh_resource, mesh_file
  out.text("");
  out.count(0);
  out.flag(false);
}

}  // namespace

const McapSchema kImageSchema{
    "sensor_msgs/msg/Image",
    defined("std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
            "uint32 step\nuint8[] data\n",
            {{"std_msgs/Header", kHeader}, {"builtin_interfaces/Time", kTime}})};

const McapSchema kCameraInfoSchema{
    "sensor_msgs/msg/CameraInfo",
    defined("std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
            "float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
            "sensor_msgs/RegionOfInterest roi\n",
            {{"std_msgs/Header", kHeader},
             {"builtin_interfaces/Time", kTime},
             {"sensor_msgs/RegionOfInterest",
              "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"}})};

const McapSchema kPointCloudSchema{
    "sensor_msgs/msg/PointCloud2",
    defined("std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
            "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
            {{"std_msgs/Header", kHeader},
             {"builtin_interfaces/Time", kTime},
             {"sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"}})};

const McapSchema kImuSchema{
    "sensor_msgs/msg/Imu",
    defined("std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
            "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
            "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
            "float64[9] linear_acceleration_covariance\n",
            {{"std_msgs/Header", kHeader},
             {"builtin_interfaces/Time", kTime},
             {"geometry_msgs/Quaternion", kXyzw},
             {"geometry_msgs/Vector3", kXyz}})};

const McapSchema kTransformsSchema{
    "tf2_msgs/msg/TFMessage",
    defined("geometry_msgs/TransformStamped[] transforms\n",
            {{"geometry_msgs/TransformStamped",
              "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
             {"std_msgs/Header", kHeader},
             {"builtin_interfaces/Time", kTime},
             {"geometry_msgs/Transform",
              "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
             {"geometry_msgs/Vector3", kXyz},
             {"geometry_msgs/Quaternion", kXyzw}})};

const McapSchema kMarkersSchema{
    "visualization_msgs/msg/MarkerArray",
    defined(
        "visualization_msgs/Marker[] markers\n",
        {{"visualization_msgs/Marker",
          "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
          "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
          "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\n"
          "string texture_resource\nsensor_msgs/CompressedImage texture\n"
          "visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n"
          "visualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n"},
         {"std_msgs/Header", kHeader},
         {"builtin_interfaces/Time", kTime},
         {"builtin_interfaces/Duration", kTime},
         {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
         {"geometry_msgs/Point", kXyz},
         {"geometry_msgs/Quaternion", kXyzw},
         {"geometry_msgs/Vector3", kXyz},
         {"std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"},
         {"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
         {"visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"},
         {"visualization_msgs/MeshFile", "string filename\nuint8[] data\n"}})};

std::string image_message(const Ros2Header& header, const cv::Mat& image) {
  CdrWriter out;
  put_header(out, header);
  const auto step = static_cast<std::uint32_t>(image.cols * static_cast<int>(image.elemSize()));
  out.numbers(static_cast<std::uint32_t>(image.rows), static_cast<std::uint32_t>(image.cols));
  out.text(image.type() == CV_8UC3 ? "bgr8" : "32FC1");
  out.numbers(std::uint8_t{0}, step);
  out.count(static_cast<std::size_t>(step) * static_cast<std::size_t>(image.rows));
  for (int v = 0; v < image.rows; ++v) out.raw(image.ptr(v), step);
  return out.bytes();
}

std::string camera_info_message(const Ros2Header& header, const Camera& camera) {
  CdrWriter out;
  put_header(out, header);
  out.numbers(static_cast<std::uint32_t>(camera.height), static_cast<std::uint32_t>(camera.width));
  out.text("plumb_bob");
  out.count(camera.distortion.size());
  for (const double d : camera.distortion) out.number(d);
  out.numbers(camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
  out.numbers(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
  out.numbers(camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0);
  for (int i = 0; i < 6; ++i) out.number(std::uint32_t{0});  // binning, region of interest: all
  out.flag(false);
  return out.bytes();
}

std::string point_cloud_message(const Ros2Header& header, const std::vector<LidarPoint>& points) {
  CdrWriter out;
  put_header(out, header);
  const auto width = static_cast<std::uint32_t>(points.size());
  out.numbers(std::uint32_t{1}, width);
  out.count(std::size(kFields));
  for (const Field& field : kFields) {
    out.text(field.name);
    out.numbers(field.offset, field.type, std::uint32_t{1});
  }
  out.flag(false);
  out.numbers(kPointSize, kPointSize * width);
  out.count(static_cast<std::size_t>(kPointSize) * width);
  for (const LidarPoint& p : points) {
    const float xyzi[] = {p.x, p.y, p.z, p.intensity};
    const std::uint8_t end[] = {p.tag, 0};
    out.raw(xyzi, sizeof xyzi);
    out.raw(&p.offset_ns, sizeof p.offset_ns);
    out.raw(&p.ring, sizeof p.ring);
    out.raw(end, sizeof end);
  }
  out.flag(true);
  return out.bytes();
}

std::string imu_message(const Ros2Header& header, const ImuSample& sample,
                        const ImuCalibration& calibration) {
  CdrWriter out;
  put_header(out, header);
  out.numbers(0.0, 0.0, 0.0, 1.0);
  for (int i = 0; i < 9; ++i) out.number(i == 0 ? -1.0 : 0.0);  // no orientation is given
  put_vector(out, sample.angular_velocity_radps);
  put_covariance(out, std::pow(calibration.gyroscope_noise_radps_rthz, 2) * calibration.rate_hz);
  put_vector(out, sample.specific_force_mps2);
  put_covariance(out, std::pow(calibration.accelerometer_noise_mps2_rthz, 2) * calibration.rate_hz);
  return out.bytes();
}

std::string transforms_message(const std::vector<Ros2Transform>& transforms) {
  CdrWriter out;
  out.count(transforms.size());
  for (const Ros2Transform& transform : transforms) {
    put_header(out, transform.header);
    out.text(transform.child);
    put_pose(out, transform.parent_from_child);
  }
  return out.bytes();
}

std::string markers_message(const Ros2Header& header, const std::string& name,
                            const std::vector<Ros2Solid>& solids, const std::array<float, 4>& color) {
  CdrWriter out;
  out.count(solids.size() + 1);
  put_marker(out, header, name, kDeleteAll, {}, color);
  for (const Ros2Solid& solid : solids) put_marker(out, header, name, kAdd, solid, color);
  return out.bytes();
}

}  // namespace uniquadric
