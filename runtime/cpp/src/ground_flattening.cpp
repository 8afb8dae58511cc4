#include "ground_flattening.hpp"

#include <algorithm>
#include <cmath>

#include "median.hpp"

namespace footprints_edge {
namespace {

/* Of |ln(depth / plane's depth)|: up to the first, a pixel moves onto the plane; from the second on,
   it is another surface. */
constexpr double SNAP_BELOW = 0.4, KEEP_ABOVE = 0.8;
constexpr double FARTHEST_M = 100;
constexpr float BELOW_HORIZON = 1e-4f;

}  // namespace

void lay_onto(const GroundPlane &plane, std::vector<float> &depth_m,
              const std::vector<uint8_t> &ground, Size size, const Camera &camera,
              const Pose &pose) {
    const std::vector<float> of_plane = inverse_depth(plane, camera, size);
    if (pose.everything()) {
        for (size_t i = 0; i < depth_m.size(); i++)
            if (of_plane[i] > float(1 / FARTHEST_M)) depth_m[i] = 1 / of_plane[i];
        return;
    }
    std::vector<float> deviation(depth_m.size());
    for (size_t i = 0; i < depth_m.size(); i++)
        deviation[i] = std::log((of_plane[i] > BELOW_HORIZON ? of_plane[i] : 1) / (1 / depth_m[i]));
    if (pose.anything()) { /* a known height corrects the scale of the depth */
        std::vector<float> on_ground;
        for (size_t i = 0; i < deviation.size(); i++)
            if (ground[i]) on_ground.push_back(deviation[i]);
        const float middle = median(std::move(on_ground));
        for (float &value : deviation) value -= middle;
    }
    const float scale = float(1 / (KEEP_ABOVE - SNAP_BELOW));
    for (size_t i = 0; i < depth_m.size(); i++) {
        if (!(of_plane[i] > BELOW_HORIZON)) continue;
        const float weight =
            std::clamp((float(KEEP_ABOVE) - std::abs(deviation[i])) * scale, 0.0f, 1.0f);
        const float own = 1 / depth_m[i];
        depth_m[i] = 1 / (own + weight * (of_plane[i] - own));
    }
}

}  // namespace footprints_edge
