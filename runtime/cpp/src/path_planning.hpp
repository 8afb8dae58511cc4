#pragma once

#include <cstdint>
#include <vector>

#include "footprints_edge.h"
#include "ground_plane.hpp"
#include "prediction.hpp"

namespace footprints_edge {

/* A path over the ground, from start to goal, straight between its corners; its points are at most a
   cell apart. */
struct GroundPath {
    std::vector<double> places_m; /* forward and left of each point */
    std::vector<double> pixels;   /* x and y in the picture of each point */
    std::vector<uint8_t> hidden;  /* whether the ground is hidden behind something there */
    double cost, length_m;
};

GroundPath find_path(const Prediction &prediction, const double start[2], const double goal[2],
                     const fpe_path_options &options);

}  // namespace footprints_edge
