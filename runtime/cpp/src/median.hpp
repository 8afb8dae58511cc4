#pragma once

#include <algorithm>
#include <vector>

namespace footprints_edge {

/* The median of at least one value; of an even number, the mean of the middle two. */
template <typename Number>
Number median(std::vector<Number> values) {
    const auto middle = values.begin() + values.size() / 2;
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2) return *middle;
    return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

}  // namespace footprints_edge
