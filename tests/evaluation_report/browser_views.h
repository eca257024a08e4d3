#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace uniquadric {

// What the image and the 3D view of a page showed (browser_steps.js, `space`), against the motion that the
// page was given.

/// What WebGL fills is what core's outline encloses: a box is drawn as a box. So it is in lines, without
/// WebGL.
void expect_solid_pixels(const nlohmann::json& space, const nlohmann::json& motion);

/// At two times of the slider all bodies are painted where core projects them, in image and space.
void expect_slider_moves_ellipsoids(const nlohmann::json& space, const nlohmann::json& motion);

/// All that the views show at one time is where it belongs; the number of bodies that were compared in space.
int expect_painted(const nlohmann::json& painted, const nlohmann::json& motion, const std::string& scene);

void expect_turns_zooms_follows_and_plays(const nlohmann::json& space);

/// The link to the weakest object and the film open the variant that they name, also while another one plays.
void expect_links_show_their_variant(const nlohmann::json& space);

}  // namespace uniquadric
