#pragma once

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// Every ray of every beam, beam after beam: the beam's error of aim (`draws`) and the ray's place in the
/// beam. `rays` gets beams.count * rig.beam.rays() rays, which must fit.
void spread_beams(const LidarRig& rig, const BeamBlock& beams, const BeamDraws& draws, BeamBlock& rays);

}  // namespace uniquadric
