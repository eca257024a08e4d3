#pragma once

#include <string>
#include <vector>

#include "harness/rosbag/import_rosbag.h"

namespace uniquadric {

class BagReader;

/// The topics to import of a bag: those that are asked for, else the only ones of their type; empty where
/// there is none. Throws InputError for a topic that there is not, one of another type, and several of a
/// type.
BagTopicNames choose_topics(const BagReader& bag, const BagTopicNames& wanted);

/// Whether a topic of a LiDAR has the Livox driver's messages.
bool is_livox(const BagReader& bag, const std::string& topic);

/// Poses as `export rosbag` writes them: the camera's topic, or empty, and those of objects.
std::string truth_camera_topic(const BagReader& bag);
std::vector<std::string> truth_object_topics(const BagReader& bag);

}  // namespace uniquadric
