#include "prediction.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "ground_flattening.hpp"
#include "resize.hpp"

namespace footprints_edge {
namespace {

std::vector<uint8_t> above(const std::vector<float> &probability, float threshold) {
    std::vector<uint8_t> mask;
    mask.reserve(probability.size());
    for (float value : probability) mask.push_back(value > threshold);
    return mask;
}

Masks masks_of(const Maps &maps, double threshold) {
    Masks masks{above(maps.visible_probability, float(threshold)),
                above(maps.ground_probability, float(threshold)),
                {}};
    for (size_t i = 0; i < masks.ground.size(); i++)
        masks.hidden.push_back(masks.ground[i] && !masks.visible[i]);
    return masks;
}

// Weight of a clear top, and the least evidence of ground: docs/porting-metres.md.
constexpr double CLEAR_TOP = 2.500, LEAST_EVIDENCE = 5.209;

// How sure the surest ground is, and how little of it reaches the upper border, as walls do.
double evidence_of_ground(std::vector<float> probability, Size size) {
    const auto rows = std::max(1, size.height / 4);
    const auto upper_end = probability.begin() + std::ptrdiff_t(rows) * size.width;
    const double upper = std::accumulate(probability.begin(), upper_end, 0.0);
    const double clear_top = 1 - upper / (double(rows) * size.width);
    const auto surest = probability.begin() + std::ptrdiff_t(0.98 * double(probability.size() - 1));
    std::nth_element(probability.begin(), surest, probability.end());
    const double p = std::clamp(double(*surest), 0.002473, 0.997527);
    return std::log(p / (1 - p)) + CLEAR_TOP * clear_top;
}

void check_that_ground_is_shown(const Maps &maps, const Pose &pose) {
    if (pose.everything() || maps.ground_probability.empty()) return;
    if (evidence_of_ground(maps.ground_probability, maps.size) < LEAST_EVIDENCE)
        throw NoGroundPlane("no_ground",
                            "the picture shows no ground; use a picture that shows some, or give "
                            "the camera's height, pitch and roll");
}

std::vector<float> masked(const std::vector<float> &depth_m, const std::vector<uint8_t> &ground) {
    std::vector<float> result = depth_m;
    for (size_t i = 0; i < ground.size() && i < result.size(); i++)
        if (!ground[i]) result[i] = NAN;
    return ground.empty() ? std::vector<float>() : result;
}

std::vector<float> inverted(std::vector<float> values) {
    for (float &value : values) value = 1 / value;
    return values;
}

std::vector<float> resized(const std::vector<float> &map, Size from, Size to) {
    return map.empty() ? map : resize_map(map, from, to);
}

/* Along a plane the inverse depth is affine in the pixel, so planes stay flat. */
std::vector<float> resized_depth(const std::vector<float> &depth_m, Size from, Size to) {
    return inverted(resized(inverted(depth_m), from, to));
}

}  // namespace

Prediction make_prediction(Maps maps, const Camera &camera, Size image, double threshold,
                           const Pose &pose, bool flatten) {
    Prediction result{};
    result.maps = std::move(maps);
    result.masks = masks_of(result.maps, threshold);
    result.camera = camera;
    result.image = image;
    result.threshold = threshold;
    result.pose = pose;
    if (result.maps.has_masks() && result.maps.has_depths()) {
        try {
            check_that_ground_is_shown(result.maps, pose);
            result.plane = std::make_shared<GroundPlane>(
                find_ground_plane(result.maps.unmasked_ground_depth_m, result.masks.ground,
                                  result.maps.size, camera, pose));
        } catch (const NoGroundPlane &why) {
            result.no_plane = std::make_shared<NoGroundPlane>(why);
        }
        if (flatten && result.plane)
            lay_onto(*result.plane, result.maps.unmasked_ground_depth_m, result.masks.ground,
                     result.maps.size, camera, pose);
    }
    result.ground_depth_m = masked(result.maps.unmasked_ground_depth_m, result.masks.ground);
    return result;
}

Prediction at_size(const Prediction &prediction, Size size) {
    Prediction result = prediction;
    const Size from = prediction.maps.size;
    if (size == from) return result;
    Maps &maps = result.maps;
    maps.size = size;
    maps.visible_probability = resized(maps.visible_probability, from, size);
    maps.ground_probability = resized(maps.ground_probability, from, size);
    maps.visible_depth_m = resized_depth(maps.visible_depth_m, from, size);
    maps.unmasked_ground_depth_m = resized_depth(maps.unmasked_ground_depth_m, from, size);
    result.masks = masks_of(maps, prediction.threshold);
    result.ground_depth_m = masked(maps.unmasked_ground_depth_m, result.masks.ground);
    result.camera = scaled(prediction.camera, from, size);
    return result;
}

const GroundPlane &ground_plane(const Prediction &prediction) {
    require_all_maps(prediction);
    if (!prediction.plane) throw NoGroundPlane(*prediction.no_plane);
    return *prediction.plane;
}

void require_all_maps(const Prediction &prediction) {
    const bool masks = prediction.maps.has_masks();
    if (masks && prediction.maps.has_depths()) return;
    throw Failure(FPE_MISSING_MAP,
                  text("the model has no %s, as it was converted with --outputs %s; use one with "
                       "all maps",
                       masks ? "depths" : "masks", masks ? "masks" : "depths"));
}

}  // namespace footprints_edge
