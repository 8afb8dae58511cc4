#pragma once

namespace footprints_edge {

/* (height, width) in pixels. */
struct Size {
    int height = 0, width = 0;
    bool operator==(const Size &other) const {
        return height == other.height && width == other.width;
    }
};

}  // namespace footprints_edge
