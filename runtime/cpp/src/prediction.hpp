/* The data of a prediction: four maps, their masks, their camera and the ground plane. */
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "camera.hpp"
#include "errors.hpp"
#include "ground_plane.hpp"
#include "size.hpp"

namespace footprints_edge {

/* height * width values each, row by row; empty where the model file lacks the map. */
struct Maps {
    Size size;
    std::vector<float> visible_probability, ground_probability;
    std::vector<float> visible_depth_m, unmasked_ground_depth_m;
    bool has_masks() const { return !ground_probability.empty(); }
    bool has_depths() const { return !unmasked_ground_depth_m.empty(); }
};

struct Masks {
    std::vector<uint8_t> visible, ground, hidden;
};

struct Prediction {
    Maps maps;
    Masks masks;
    std::vector<float> ground_depth_m; /* NaN off the ground */
    Camera camera;                     /* in pixels of the maps */
    Size image;
    double threshold;
    Pose pose;
    std::shared_ptr<const GroundPlane> plane;       /* null if there is none, */
    std::shared_ptr<const NoGroundPlane> no_plane;  /* which says why */
};

/* Masks and plane of maps; with `flatten`, the ground's depth is laid onto the plane. */
Prediction make_prediction(Maps maps, const Camera &camera, Size image, double threshold,
                           const Pose &pose, bool flatten);

Prediction at_size(const Prediction &prediction, Size size);

/* The plane, or NoGroundPlane is thrown. */
const GroundPlane &ground_plane(const Prediction &prediction);

/* Throws if a map is missing. */
void require_all_maps(const Prediction &prediction);

}  // namespace footprints_edge
