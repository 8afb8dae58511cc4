/* Antialiased resizing with the arithmetic of Pillow's Image.resize: docs/porting.md, "Resize". */
#pragma once

#include <cstdint>
#include <vector>

#include "size.hpp"

namespace footprints_edge {

enum class Filter { lanczos, hamming, bilinear };

/* An RGB picture of 8 bits, height * width * 3 bytes, at another size. */
std::vector<uint8_t> resize_rgb(const uint8_t *rgb, Size from, Size to, Filter filter);

/* A map, height * width floats, bilinear. */
std::vector<float> resize_map(const std::vector<float> &map, Size from, Size to);

}  // namespace footprints_edge
