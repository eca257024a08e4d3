#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evaluation/association/object_overlap.h"

namespace uniquadric {

/// Which true objects are scored.
struct ObjectChoice {
  bool moving = false;               ///< those alone whose centre moves farther than their smallest side
  bool in_view = false;              ///< each one only while the truth says that it is visible
  std::vector<std::string> classes;  ///< those alone whose class (class_of) is one of these; empty: all
  bool operator==(const ObjectChoice&) const = default;
};

/// What to make of estimated states that overlap no scored object.
enum class Unlabelled {
  counted_false,  ///< the truth names every object, so they are false
  ignored,        ///< the truth is partial: nobody knows what they are
};

/// Parses `all`, or a list with commas of `moving`, `in_view`, `labelled` (all that the truth names) and
/// classes. Throws InputError for an empty item.
ObjectChoice parse_object_choice(const std::string& text);
std::string to_string(const ObjectChoice& choice);

/// A name without the number that tells it from others: `car` of `car_12`, in lower case.
std::string class_of(const std::string& name);

/// [object]: whether it is scored; `in_view` has no part in it.
std::vector<bool> scored_objects(const std::vector<ObjectTrack>& truth, const ObjectChoice& choice);

/// [track]: whether it belongs to one of `objects`: it is matched to it, or to no object and overlaps none
/// more, summed over time (a second track of it, after its id changed). `matches` as of match_objects.
std::vector<bool> tracks_of(const std::vector<bool>& objects,
                            const std::vector<std::optional<std::size_t>>& matches,
                            const ObjectOverlaps& overlaps);

/// Takes out of frames what does not count there, for scores over all objects. With `ignored` these are the
/// states that overlap no true object. Where labels are partial, these are also the states of a track in
/// frames in which the object that it is matched to has none (it left the view, or its labels end), unless
/// they overlap another one.
void drop_unlabelled(Unlabelled unlabelled, bool labels_are_partial,
                     const std::vector<std::optional<std::size_t>>& matches, ObjectOverlaps& overlaps);

}  // namespace uniquadric
