// Rays per second of a whole LiDAR scan (pattern, trajectory, placing the bodies, casting, points) against a
// bare Embree loop over the same rays, ready in packets, and the same scene; without and with noise; with 1
// thread and with all.
//   lidar_speed [ROUNDS [PATTERN [FINENESS [RATE_HZ]]]]
// FINENESS multiplies the meshes' segments (1: 787 k triangles), RATE_HZ (10) is that of the scans.
// The measurements take turns, each after one of its kind that is not counted, as in a sequence of scans: its
// meshes are in the caches. What is printed are medians of the rounds and of the ratios within a round:
// processor time where one thread works, wall time for the gain of all threads.
#include <fmt/format.h>
#include <pmmintrin.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <thread>
#include <vector>

#include "core/embree/rtcore_parts.h"
#include "simulator/lidar/lidar_scan.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/named_motions.h"
#include "simulator/scene/shapes.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kScan = 7;

Body make_body(int id, std::vector<Mesh> meshes, Motion motion) {
  Body body;
  body.id = id;
  body.name = fmt::format("body{}", id);
  body.meshes = std::move(meshes);
  body.motion = std::move(motion);
  return body;
}

struct Course {
  std::vector<Body> world, objects;
  Motion sensor;
};

// An uneven hall around the sensor, and four bodies that swing and turn in it.
Course make_course(double fineness) {
  const auto segments = [&](double n) { return static_cast<int>(std::lround(n * fineness)); };
  Course course;
  Material plain;
  plain.size_px = 8;
  course.world = {make_body(0, ellipsoid({80, 60, 20}, segments(80), plain), Motion())};
  for (int i = 0; i < 4; ++i) {
    SwingOptions swing;
    swing.pivot_m = {8.0 + 2 * i, 6.0 * i - 9, 2};
    swing.axis = i % 2 == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
    swing.period_s = 2 + 0.3 * i;
    ScrewOptions spin;
    spin.axis = Eigen::Vector3d(1, i, 2).normalized();
    course.objects.push_back(make_body(i + 1, ellipsoid({4, 3, 2}, segments(50), plain),
                                       composed_motion({swing_motion(swing), screw_motion(spin)})));
  }
  CircleOptions circle;
  circle.radius_m = 3;
  course.sensor = circle_motion(circle);
  return course;
}

std::size_t count_triangles(const Course& course) {
  std::size_t count = 0;
  for (const auto* bodies : {&course.world, &course.objects})
    for (const Body& body : *bodies)
      for (const Mesh& mesh : body.meshes) count += mesh.triangles.size();
  return count;
}

RTCScene robust_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  return scene;
}

void attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

RTCScene mesh_scene(RTCDevice device, const Body& body) {
  RTCScene scene = robust_scene(device);
  for (const Mesh& mesh : body.meshes) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                        mesh.positions.size()),
                mesh.positions.data(), 12 * mesh.positions.size());
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                        mesh.triangles.size()),
                mesh.triangles.data(), 12 * mesh.triangles.size());
    attach(scene, geometry);
  }
  rtcCommitScene(scene);
  return scene;
}

// The bodies at the times of the scan, as the caster places them.
RTCScene bare_scene(RTCDevice device, const Course& course, const std::vector<MotionKeys>& keys,
                    const SensorPath& path, double start_s, double end_s) {
  RTCScene top = robust_scene(device);
  std::vector<const Body*> bodies = {&course.world[0]};
  for (const Body& body : course.objects) bodies.push_back(&body);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    RTCScene meshes = mesh_scene(device, *bodies[i]);
    rtcSetGeometryInstancedScene(instance, meshes);
    rtcReleaseScene(meshes);
    const int n = i == 0 ? 1 : keys[i - 1].count;
    rtcSetGeometryTimeStepCount(instance, static_cast<unsigned>(n));
    for (int k = 0; k < n; ++k) {
      const Pose pose = bodies[i]->motion.at(n == 1 ? start_s : start_s + (end_s - start_s) * k / (n - 1));
      const Eigen::Vector3f t = (pose.translation - path.origin()).cast<float>();
      if (n > 1 && !keys[i - 1].slerp) {
        Eigen::Matrix<float, 3, 4> matrix;
        matrix << pose.rotation.toRotationMatrix().cast<float>(), t;
        rtcSetGeometryTransform(instance, static_cast<unsigned>(k), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                matrix.data());
        continue;
      }
      const Eigen::Quaternionf q = pose.rotation.cast<float>();
      RTCQuaternionDecomposition key;
      rtcInitQuaternionDecomposition(&key);
      rtcQuaternionDecompositionSetQuaternion(&key, q.w(), q.x(), q.y(), q.z());
      rtcQuaternionDecompositionSetTranslation(&key, t.x(), t.y(), t.z());
      rtcSetGeometryTransformQuaternion(instance, static_cast<unsigned>(k), &key);
    }
    attach(top, instance);
  }
  rtcCommitScene(top);
  return top;
}

std::vector<RTCRayHit8> packets_of(const LidarRig& rig, const SensorPath& path) {
  const std::int64_t start = rig.start_ns(kScan), end = rig.start_ns(kScan + 1);
  std::vector<RTCRayHit8> packets;
  BeamBlock beams;
  WorldRays rays;
  const std::int64_t last = rig.pattern.first_at(end);
  for (std::int64_t first = rig.pattern.first_at(start); first + 8 <= last; first += 8) {
    rig.pattern.fill(first, 8, beams);
    path.place(beams, rays);
    RTCRayHit8& packet = packets.emplace_back();
    for (int i = 0; i < 8; ++i) {
      packet.ray.org_x[i] = static_cast<float>(rays.origin_x[i]);
      packet.ray.org_y[i] = static_cast<float>(rays.origin_y[i]);
      packet.ray.org_z[i] = static_cast<float>(rays.origin_z[i]);
      packet.ray.dir_x[i] = static_cast<float>(rays.x[i]);
      packet.ray.dir_y[i] = static_cast<float>(rays.y[i]);
      packet.ray.dir_z[i] = static_cast<float>(rays.z[i]);
      packet.ray.time[i] = static_cast<float>(static_cast<double>(beams.time_ns[i] - start) /
                                              static_cast<double>(end - start));
      packet.ray.tnear[i] = 0;
      packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
      packet.ray.mask[i] = ~0u;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
  }
  return packets;
}

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Of this thread alone, so that what else runs on the machine counts little.
double cpu_seconds(const std::function<void()>& action) {
  action();
  const double start = seconds(CLOCK_THREAD_CPUTIME_ID);
  action();
  return seconds(CLOCK_THREAD_CPUTIME_ID) - start;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

float bare_loop(RTCScene scene, const std::vector<RTCRayHit8>& packets) {
  alignas(32) const int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
  float sum = 0;
  for (const RTCRayHit8& ready : packets) {
    RTCRayHit8 packet = ready;
    intersect(scene, valid, packet);
    sum += packet.ray.tfar[0];
  }
  return sum;
}

int run(int rounds, const std::string& pattern, double fineness, double rate_hz) {
  const Course course = make_course(fineness);
  const RayCaster caster(course.world, course.objects);
  LidarRig noisy;
  noisy.pattern_name = pattern;
  noisy.pattern = named_pattern(pattern);
  noisy.noise = noise_of(pattern);
  noisy.rate_hz = rate_hz;
  LidarRig exact = noisy;
  exact.noise = LidarNoise::none();
  const PoseAt path = lidar_path(course.sensor, exact);
  const std::int64_t start = exact.start_ns(kScan), end = exact.start_ns(kScan + 1);
  const SensorPath cubics(path, start, end);
  const std::vector<MotionKeys> keys = caster.open(cubics.origin(), start, end).motion_keys();
  RTCDevice device = rtcNewDevice("isa=avx2");
  RTCScene scene = bare_scene(device, course, keys, cubics, static_cast<double>(start) * 1e-9,
                              static_cast<double>(end) * 1e-9);
  const std::vector<RTCRayHit8> packets = packets_of(exact, cubics);
  const int all = static_cast<int>(std::thread::hardware_concurrency());

  std::vector<double> bare, open, whole, with_noise;
  float sum = 0;
  for (int round = 0; round < rounds; ++round) {
    bare.push_back(cpu_seconds([&] {
      const unsigned saved = _mm_getcsr();
      _mm_setcsr(saved | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
      sum += bare_loop(scene, packets);
      _mm_setcsr(saved);
    }));
    open.push_back(cpu_seconds([&] { caster.open(cubics.origin(), start, end); }));
    whole.push_back(cpu_seconds([&] { take_scan(caster, exact, path, kScan, 0, 1); }));
    with_noise.push_back(cpu_seconds([&] { take_scan(caster, noisy, path, kScan, 0, 1); }));
  }
  // Scan after scan, so that the scheduler has the time to spread the threads. On a machine that is busy
  // otherwise the wall time says little; the processor time all threads take together still says what sharing
  // the work costs.
  const auto scans = [&](clockid_t clock, int threads) {
    const double from = seconds(clock);
    for (int i = 0; i < rounds; ++i) take_scan(caster, exact, path, kScan, 0, threads);
    return seconds(clock) - from;
  };
  std::vector<double> wall_gain, work_gain;
  for (int turn = 0; turn < 5; ++turn) {
    wall_gain.push_back(scans(CLOCK_MONOTONIC, 1) / scans(CLOCK_MONOTONIC, all));
    work_gain.push_back(scans(CLOCK_PROCESS_CPUTIME_ID, 1) / scans(CLOCK_PROCESS_CPUTIME_ID, all));
  }
  const double rays = static_cast<double>(packets.size() * 8);
  const auto row = [&](const char* what, const std::vector<double>& times) {
    const double time_s = median(times);
    std::vector<double> ratios;
    for (std::size_t i = 0; i < times.size(); ++i) ratios.push_back(bare[i] / times[i]);
    fmt::print("{:<28} {:>8.3f} Mray/s  {:>6.1f} ns a ray  {:>5.3f} of the bare loop\n", what,
               rays / time_s * 1e-6, time_s / rays * 1e9, median(ratios));
  };
  fmt::print("{}: {} rays, {} triangles, motion keys", pattern, rays, count_triangles(course));
  for (const MotionKeys& n : keys) fmt::print(" {}{}", n.count, n.slerp ? " (slerp)" : "");
  fmt::print(" (mean range {:.1f} m)\n",
             sum / static_cast<float>(packets.size()) / static_cast<float>(2 * rounds));
  row("bare Embree loop, 1 thread", bare);
  row("placing the bodies", open);
  row("whole scan, 1 thread", whole);
  row("whole scan with noise", with_noise);
  fmt::print("{} threads: {:.2f} times as fast by the wall, processor time {:.3f} of one thread's work\n",
             all, median(wall_gain), 1 / median(work_gain));
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  return uniquadric::run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 50, argc > 2 ? argv[2] : "livox_avia",
                         argc > 3 ? std::max(0.1, std::atof(argv[3])) : 1,
                         argc > 4 ? std::max(0.5, std::atof(argv[4])) : 10);
}
