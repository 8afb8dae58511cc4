/* What a model file states about itself: docs/model-file.md. */
#pragma once

#include <functional>
#include <string>

#include "resize.hpp"

namespace footprints_edge {

struct Metadata {
    std::string name;
    double nearest_m, farthest_m; /* depths at disparity 1 and 0 */
    double focal_px;              /* of the camera that the depths are for; 0 for any camera */
    Filter filter;                /* of the resize to the network's input */
    bool has_masks, has_depths;
};

/* Reads the metadata with a function that gives the text of a key, or an empty one. Throws a Failure
   that names the file. */
Metadata read_metadata(const std::function<std::string(const char *)> &value_of,
                       const std::string &file);

}  // namespace footprints_edge
