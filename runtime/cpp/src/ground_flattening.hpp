#pragma once

#include <cstdint>
#include <vector>

#include "camera.hpp"
#include "ground_plane.hpp"
#include "size.hpp"

namespace footprints_edge {

/* Moves the ground's depth, metres, onto the plane where it lies close to it; with a pose that is
   known completely, wherever the plane is nearer than 100 m. */
void lay_onto(const GroundPlane &plane, std::vector<float> &depth_m,
              const std::vector<uint8_t> &ground, Size size, const Camera &camera, const Pose &pose);

}  // namespace footprints_edge
