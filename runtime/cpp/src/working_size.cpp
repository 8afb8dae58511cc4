#include "working_size.hpp"

#include <cmath>

namespace footprints_edge {

Size working_size(Size image) {
    if (image.height > image.width) {
        const Size lying = working_size({image.width, image.height});
        return {lying.width, lying.height};
    }
    constexpr int budget = 256 * 448, most = budget * 115 / 100;
    const double log_aspect = std::log(double(image.width) / image.height);
    Size best;
    double least = INFINITY;
    for (int h = 2 * STRIDE; h * h <= most; h += STRIDE)
        for (int w = h; h * w <= most; w += STRIDE) {
            const double distortion = std::abs(std::log(double(w) / h) - log_aspect);
            const double cost =
                distortion + 0.25 * std::abs(std::log(double(h) * w / budget));
            if (cost < least) {
                least = cost;
                best = {h, w};
            }
        }
    return best;
}

}  // namespace footprints_edge
