#pragma once

#include <string>

#include "simulator/families/draw.h"

namespace uniquadric {

/// Each draws `camera`, `world` and `objects` of a scene.
std::string tabletop_scene(RandomStream& random, const FamilyOptions& options);
std::string tossed_scene(RandomStream& random, const FamilyOptions& options);
std::string handled_scene(RandomStream& random, const FamilyOptions& options);
std::string street_scene(RandomStream& random, const FamilyOptions& options);
std::string room_scene(RandomStream& random, const FamilyOptions& options);

}  // namespace uniquadric
