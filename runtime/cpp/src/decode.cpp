#include "decode.hpp"

#include <cmath>

namespace footprints_edge {

Maps decode(const std::vector<float> &output, Size size, const Metadata &metadata,
            const Camera &camera) {
    const double scale =
        metadata.focal_px == 0 ? 1 : std::sqrt(camera.fx * camera.fy) / metadata.focal_px;
    const float farthest = float(1 / (scale * metadata.farthest_m));
    const float range = float(1 / (scale * metadata.nearest_m) - 1 / (scale * metadata.farthest_m));
    const size_t pixels = size_t(size.height) * size.width;
    auto channel = output.begin();
    const auto next = [&](bool there) {
        if (!there) return std::vector<float>();
        const auto begin = channel;
        channel += std::ptrdiff_t(pixels);
        return std::vector<float>(begin, channel);
    };
    const auto metres = [&](std::vector<float> disparity) {
        for (float &value : disparity) value = 1 / (farthest + range * value);
        return disparity;
    };
    Maps maps;
    maps.size = size;
    maps.visible_probability = next(metadata.has_masks);
    maps.ground_probability = next(metadata.has_masks);
    maps.visible_depth_m = metres(next(metadata.has_depths));
    maps.unmasked_ground_depth_m = metres(next(metadata.has_depths));
    return maps;
}

}  // namespace footprints_edge
