// Sequence folders: images, scans and IMU as NumPy's arrays.
#include "core/sequence/sequence.h"

#include <algorithm>
#include <cstring>
#include <opencv2/core.hpp>

#include "core/sequence/stamps.h"
#include "python/module_parts.h"

namespace uniquadric::python {
namespace {

// A row of the array of IMU samples.
struct ImuRow {
  std::int64_t stamp_ns;
  double angular_velocity_radps[3], specific_force_mps2[3];
};

template <typename T>
py::array_t<T> image_array(const cv::Mat& image) {
  py::array_t<T> array({image.rows, image.cols});
  for (int y = 0; y < image.rows; ++y) std::copy_n(image.ptr<T>(y), image.cols, array.mutable_data(y, 0));
  return array;
}

py::array_t<std::uint8_t> color_array(const cv::Mat& bgr) {
  py::array_t<std::uint8_t> array({bgr.rows, bgr.cols, 3});
  for (int y = 0; y < bgr.rows; ++y) {
    std::uint8_t* rgb = array.mutable_data(y, 0, 0);
    const auto* pixels = bgr.ptr<cv::Vec3b>(y);
    for (int x = 0; x < bgr.cols; ++x)
      for (int channel = 0; channel < 3; ++channel) *rgb++ = pixels[x][2 - channel];
  }
  return array;
}

// What reads, without Python's lock; `index` is that of a frame.
template <typename Reader>
cv::Mat read_unlocked(Reader reader, const Sequence& sequence, std::size_t index) {
  const SequenceFrame& frame = sequence.frames.at(index);
  const py::gil_scoped_release unlocked;
  return reader(sequence, frame);
}

py::object depth_array(const Sequence& sequence, std::size_t index) {
  if (sequence.frames.at(index).depth.empty()) return py::none();
  return image_array<float>(read_unlocked(read_depth, sequence, index));
}

py::object masks_array(const Sequence& sequence, std::size_t index) {
  if (sequence.frames.at(index).masks.empty()) return py::none();
  return image_array<std::uint16_t>(read_unlocked(read_masks, sequence, index));
}

py::array_t<LidarPoint> scan_array(const Sequence& sequence, std::size_t index) {
  return array_of(read_lidar_points(sequence.folder / sequence.scans.at(index).file));
}

py::array_t<ImuRow> imu_array(const Sequence& sequence) {
  std::vector<ImuRow> rows;
  for (const ImuSample& sample : read_imu_csv(sequence.folder / "imu.csv")) {
    const Eigen::Vector3d &w = sample.angular_velocity_radps, &f = sample.specific_force_mps2;
    rows.push_back({sample.stamp_ns, {w.x(), w.y(), w.z()}, {f.x(), f.y(), f.z()}});
  }
  return array_of(rows);
}

py::object imu_calibration(const Sequence& sequence) {
  if (!sequence.imu) return py::none();
  const ImuCalibration& imu = *sequence.imu;
  return py::make_tuple(imu.rate_hz, imu.camera_from_imu.matrix(), imu.gyroscope_noise_radps_rthz,
                        imu.gyroscope_walk_radps2_rthz, imu.accelerometer_noise_mps2_rthz,
                        imu.accelerometer_walk_mps3_rthz, imu.gravity_mps2);
}

py::object lidar_calibration(const Sequence& sequence) {
  if (!sequence.lidar) return py::none();
  const LidarCalibration& lidar = *sequence.lidar;
  return py::make_tuple(lidar.pattern, lidar.rate_hz, lidar.camera_from_lidar.matrix());
}

// (stamp [ns], when the masks arrive [ns]) of each frame.
std::vector<std::pair<std::int64_t, std::int64_t>> frame_stamps(const Sequence& sequence) {
  std::vector<std::pair<std::int64_t, std::int64_t>> stamps;
  for (const SequenceFrame& frame : sequence.frames)
    stamps.emplace_back(frame.stamp_ns, frame.masks_arrival_ns);
  return stamps;
}

}  // namespace

void add_sequence(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(LidarPoint, x, y, z, intensity, offset_ns, ring, tag);
  PYBIND11_NUMPY_DTYPE(ImuRow, stamp_ns, angular_velocity_radps, specific_force_mps2);
  py::class_<Sequence>(module, "Sequence")
      .def(py::init(&open_sequence))
      .def_readonly("folder", &Sequence::folder)
      .def_readonly("program", &Sequence::program)
      .def_readonly("name", &Sequence::name)
      .def_readonly("seed", &Sequence::seed)
      .def_readonly("rate_hz", &Sequence::rate_hz)
      .def("camera", [](const Sequence& sequence) { return camera_of(sequence.camera); })
      .def("imu", &imu_calibration)
      .def("lidar", &lidar_calibration)
      .def("frame_stamps", &frame_stamps)
      .def("scan_stamps", [](const Sequence& sequence) { return stamps_of(sequence.scans); })
      .def("given_camera",
           [](const Sequence& sequence) -> py::object {
             return sequence.given_camera ? py::object(arrays_of(*sequence.given_camera)) : py::none();
           })
      .def("rgb", [](const Sequence& s, std::size_t k) { return color_array(read_unlocked(read_rgb, s, k)); })
      .def("depth", &depth_array)
      .def("masks", &masks_array)
      .def("scan", &scan_array)
      .def("imu_samples", &imu_array);
}

}  // namespace uniquadric::python
