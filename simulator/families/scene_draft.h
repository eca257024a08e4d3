#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "simulator/families/draw.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// An object before it has a place: its keys but for id and motion.
struct Thing {
  std::string name;
  std::string keys;  ///< YAML lines below `- id:`, each ended and indented by four
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();

  /// Of the circle that its foot stays within, however it turns about the vertical.
  double reach_m() const { return 0.5 * size_m.head<2>().norm(); }
};

/// What stands about on tables: a box, can, book, block, bottle, mug, bowl or angle; or, with
/// FamilyOptions::meshes, one of the folder's files. Throws InputError for a mesh that does not fit a hand
/// (2 to 60 cm).
Thing draw_thing(RandomStream& random, const FamilyOptions& options);

/// A scene in the making. Objects are added one by one, and only those that in no frame come nearer to
/// another one than `clear_m` (boxes about them) and with which each is seen in one of every third frame.
class SceneDraft {
 public:
  /// `camera` is the scene's section without its key, indented by two; options.lens comes before it.
  SceneDraft(const FamilyOptions& options, const std::string& camera, double clear_m);

  void add_world(const std::string& line) { world_ += line; }
  /// What objects keep clear of, though it is none: a box along the axes of a motion (as YAML in one line).
  /// `hides`: whether the camera cannot see through it.
  void keep_clear_of(const std::string& motion, const Eigen::Vector3d& size_m, bool hides = true);
  /// How far from the world's origin objects may be along x and y: walls are beyond.
  void keep_within(double half_m) { half_m_ = half_m; }
  /// `motion` as YAML lines indented by six. Whether it was added.
  bool add(const Thing& thing, const std::string& motion);
  /// Draws motions, `most` of them, until the thing can be added with one: that one, or nothing where there
  /// is no place left. A draw may be nothing, too.
  std::optional<std::string> add_drawn(const Thing& thing,
                                       const std::function<std::optional<std::string>()>& draw_motion,
                                       int most = 40);
  /// Adds what is seen and not scored: the others do not have to keep clear of it.
  void add_unscored(const Thing& thing, const std::string& motion);

  int count() const { return count_; }
  int next_id() const { return next_id_; }
  /// `camera`, `world` and `objects`. Warns where fewer objects than FamilyOptions::count found a place, and
  /// throws InputError where none did.
  std::string text() const;

 private:
  std::string object_text(const Thing& thing, const std::string& motion) const;
  static std::optional<Body> read(const std::string& object);
  bool meets_another(const Body& body) const;
  bool leaves(const Body& body) const;
  bool is_seen(std::size_t body) const;
  bool is_seen_at(std::size_t body, double time_s) const;
  bool all_seen() const;
  double time_s(std::int64_t frame) const { return static_cast<double>(frame) / 30; }

  FamilyOptions options_;
  double clear_m_;
  double half_m_ = std::numeric_limits<double>::infinity();
  Scene sensors_;  // camera and its motion alone
  std::string camera_, world_, objects_;
  struct Box {
    Body body;  // without its meshes
    bool is_object, hides;
  };
  std::vector<Box> boxes_;
  int count_ = 0;
  int next_id_ = 1;
};

}  // namespace uniquadric
