#pragma once

// Embree 3 or 4, whichever CMake found (4 first); for the .cpp files that call it, and their private headers.
// What differs between the two is here alone. Rays count as incoherent, which is both versions' default: for
// a LiDAR's beams it is a quarter faster than coherent, though they are neighbours.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace uniquadric {

#if RTC_VERSION_MAJOR >= 4

/// What a filter function gets of its query; the first member of what the query's caller wants to hand over.
using RayContext = RTCRayQueryContext;

/// Calls the geometries' occlusion filters for hits of each valid ray, of all triangles where the filters
/// reject all. `valid` as below; `context` need not be initialised.
inline void filter_hits(RTCScene scene, const int* valid, RTCRay8& rays, RayContext& context) {
  rtcInitRayQueryContext(&context);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  arguments.context = &context;
  rtcOccluded8(valid, scene, &rays, &arguments);
}

inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect1(scene, &ray, &arguments);
}

/// `valid`: -1 for each lane that holds a ray, else 0; aligned to 32 bytes.
inline void intersect(RTCScene scene, const int* valid, RTCRayHit8& rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect8(valid, scene, &rays, &arguments);
}

#else

using RayContext = RTCIntersectContext;

inline void filter_hits(RTCScene scene, const int* valid, RTCRay8& rays, RayContext& context) {
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded8(valid, scene, &context, &rays);
}

inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect1(scene, &context, &ray);
}

/// `valid`: -1 for each lane that holds a ray, else 0; aligned to 32 bytes.
inline void intersect(RTCScene scene, const int* valid, RTCRayHit8& rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect8(valid, scene, &context, &rays);
}

#endif

}  // namespace uniquadric
