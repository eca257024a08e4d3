#pragma once

#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {

/// The paired figures of one (variant, subjects, metric), in order of their keys.
using MetricPairs = std::vector<const PairedScore*>;

/// `objects` for an object, else the object's own name: camera, all.
std::string subjects_of_object(const std::string& object);

/// The random stream that draws the flips of a metric's test.
std::string stream_of(const MetricChange& change);

/// Means, places and the uncorrected tests of one metric; verdicts, and the places' tests, come when all
/// metrics are known.
MetricChange measure_change(const MetricPairs& pairs, const ChangeRule& rule);

}  // namespace uniquadric
