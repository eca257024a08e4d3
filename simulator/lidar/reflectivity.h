#pragma once

#include "simulator/scene/mesh.h"

namespace uniquadric {

/// Mean luminance (Rec. 709 weights) of a mesh's texture and colour, in [0, 1]: what stands for its
/// reflectivity at the laser's wavelength, which a colour does not say.
float mean_luminance(const Mesh& mesh);

}  // namespace uniquadric
