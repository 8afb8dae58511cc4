#include "resize.hpp"

#include <algorithm>
#include <cmath>

namespace footprints_edge {
namespace {

constexpr double PI = 3.14159265358979323846;
constexpr int FRACTION_BITS = 32 - 8 - 2; /* of weights: room for 8 bits, a sign and overshoot */

double sinc(double x) { return x == 0 ? 1 : std::sin(PI * x) / (PI * x); }

double support_of(Filter filter) { return filter == Filter::lanczos ? 3 : 1; }

double weight_at(double x, Filter filter) {
    if (filter == Filter::lanczos) return x >= -3 && x < 3 ? sinc(x) * sinc(x / 3) : 0;
    if (std::abs(x) >= 1) return 0;
    if (filter == Filter::hamming) return sinc(x) * (0.54 + 0.46 * std::cos(PI * x));
    return 1 - std::abs(x);
}

/* Which pixels of a line make one pixel of the result, and how much of each. */
struct Taps {
    int first;
    std::vector<double> weights;
};

std::vector<Taps> taps_of(int from, int to, Filter filter) {
    const double scale = double(from) / to, stretch = std::max(scale, 1.0);
    const double reach = support_of(filter) * stretch;
    std::vector<Taps> result;
    result.reserve(to);
    for (int i = 0; i < to; i++) {
        const double centre = (i + 0.5) * scale;
        const int first = std::max(0, int(centre - reach + 0.5));
        const int end = std::min(from, int(centre + reach + 0.5));
        Taps taps{first, {}};
        double total = 0;
        for (int j = first; j < end; j++) {
            taps.weights.push_back(weight_at((j - centre + 0.5) / stretch, filter));
            total += taps.weights.back();
        }
        for (double &weight : taps.weights) weight /= total;
        result.push_back(std::move(taps));
    }
    return result;
}

/* Bytes are weighted in fixed point, floats in double. */
struct Bytes {
    using Pixel = uint8_t;
    using Sum = int32_t;
    static constexpr Sum START = 1 << (FRACTION_BITS - 1);
    static Sum weight(double exact) { return Sum(std::lround(exact * (1 << FRACTION_BITS))); }
    static Pixel pixel(Sum sum) { return Pixel(std::clamp(sum >> FRACTION_BITS, 0, 255)); }
};

struct Reals {
    using Pixel = float;
    using Sum = double;
    static constexpr Sum START = 0;
    static Sum weight(double exact) { return exact; }
    static Pixel pixel(Sum sum) { return Pixel(sum); }
};

template <typename Kind>
std::vector<typename Kind::Sum> weights_of(const Taps &taps) {
    std::vector<typename Kind::Sum> result;
    for (double exact : taps.weights) result.push_back(Kind::weight(exact));
    return result;
}

template <typename Kind, int CHANNELS>
std::vector<typename Kind::Pixel> along_x(const typename Kind::Pixel *from, Size size, int width,
                                          Filter filter) {
    using Sum = typename Kind::Sum;
    std::vector<typename Kind::Pixel> result(size_t(size.height) * width * CHANNELS);
    const std::vector<Taps> all = taps_of(size.width, width, filter);
    std::vector<std::vector<Sum>> weights;
    for (const Taps &taps : all) weights.push_back(weights_of<Kind>(taps));
    auto *write = result.data();
    for (int y = 0; y < size.height; y++) {
        const auto *line = from + size_t(y) * size.width * CHANNELS;
        for (int x = 0; x < width; x++) {
            const auto *read = line + size_t(all[x].first) * CHANNELS;
            Sum sums[CHANNELS];
            std::fill_n(sums, CHANNELS, Kind::START);
            for (Sum weight : weights[x])
                for (int c = 0; c < CHANNELS; c++) sums[c] += *read++ * weight;
            for (Sum sum : sums) *write++ = Kind::pixel(sum);
        }
    }
    return result;
}

/* `width` counts values, so channels need no care here. */
template <typename Kind>
std::vector<typename Kind::Pixel> along_y(const typename Kind::Pixel *from, Size size, int height,
                                          Filter filter) {
    using Sum = typename Kind::Sum;
    std::vector<typename Kind::Pixel> result(size_t(height) * size.width);
    std::vector<Sum> sums(size.width);
    auto *write = result.data();
    for (const Taps &taps : taps_of(size.height, height, filter)) {
        std::fill(sums.begin(), sums.end(), Kind::START);
        const auto *line = from + size_t(taps.first) * size.width;
        for (Sum weight : weights_of<Kind>(taps)) {
            for (int x = 0; x < size.width; x++) sums[x] += line[x] * weight;
            line += size.width;
        }
        for (Sum sum : sums) *write++ = Kind::pixel(sum);
    }
    return result;
}

template <typename Kind, int CHANNELS>
std::vector<typename Kind::Pixel> resize(const typename Kind::Pixel *from, Size size, Size to,
                                         Filter filter) {
    const size_t values = size_t(size.height) * size.width * CHANNELS;
    std::vector<typename Kind::Pixel> narrow =
        size.width == to.width ? std::vector<typename Kind::Pixel>(from, from + values)
                               : along_x<Kind, CHANNELS>(from, size, to.width, filter);
    if (size.height == to.height) return narrow;
    return along_y<Kind>(narrow.data(), {size.height, to.width * CHANNELS}, to.height, filter);
}

}  // namespace

std::vector<uint8_t> resize_rgb(const uint8_t *rgb, Size from, Size to, Filter filter) {
    return resize<Bytes, 3>(rgb, from, to, filter);
}

std::vector<float> resize_map(const std::vector<float> &map, Size from, Size to) {
    return resize<Reals, 1>(map.data(), from, to, Filter::bilinear);
}

}  // namespace footprints_edge
