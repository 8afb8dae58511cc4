#pragma once

#include <vector>

#include "camera.hpp"
#include "metadata.hpp"
#include "prediction.hpp"

namespace footprints_edge {

/* The network's output, channel by channel, in probabilities and metres; `camera` in its pixels. */
Maps decode(const std::vector<float> &output, Size size, const Metadata &metadata,
            const Camera &camera);

}  // namespace footprints_edge
