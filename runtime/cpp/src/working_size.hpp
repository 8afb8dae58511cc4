#pragma once

#include "size.hpp"

namespace footprints_edge {

constexpr int STRIDE = 32; /* networks halve the picture five times */

/* The input size of a network that leaves it free: docs/porting.md, "Size". */
Size working_size(Size image);

}  // namespace footprints_edge
