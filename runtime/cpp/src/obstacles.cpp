#include "obstacles.hpp"

#include <algorithm>
#include <cmath>

#include "errors.hpp"
#include "median.hpp"
#include "occupancy_grid.hpp"

namespace footprints_edge {
namespace {

constexpr double STEP_HEIGHT_M = 0.15; /* lower things are no obstacles */
constexpr double BEARING_DEG = 1;      /* width of a bin */
constexpr double NEAREST_M = 0.2;
constexpr double RANGE_STEP = 0.02; /* length of a bin, as a share of its range */
constexpr int RANGES = 277;         /* ceil(ln(50 m / NEAREST_M) / RANGE_STEP) */
constexpr int BEARINGS = 181;       /* from -90 to 90 degrees */
constexpr int WINDOW = 6;           /* a bin is judged together with the bins behind it */
constexpr double LEAST_SEEN_M = 0.01;
constexpr int LEAST_PX = 3;
constexpr double RAISED = 0.35;  /* visible ground above this share of the camera's height is none */
constexpr float STEEPEST = 0.04f; /* change of ln(depth) along a row, where nothing stands */
constexpr size_t SCALED_BY_PX = 100;

double middle_of(int range) { return NEAREST_M * std::exp((range + 0.5) * RANGE_STEP); }

double angle_of(int bearing) { return radians((bearing - (BEARINGS - 1) / 2) * BEARING_DEG); }

template <typename Number>
int bearing_of(Number degrees) {
    return int(std::nearbyint(degrees / Number(BEARING_DEG) + Number((BEARINGS - 1) / 2)));
}

template <typename Number>
int range_of(Number range_m) {
    const Number place = std::log(std::max(range_m, Number(1e-3)) / Number(NEAREST_M)) /
                         Number(RANGE_STEP);
    return int(std::floor(std::min(place, Number(RANGES))));
}

bool is_bin(int bearing, int range) {
    return bearing >= 0 && bearing < BEARINGS && range >= 0 && range < RANGES;
}

/* Forward, left and rise of the rays with z = 1 through all pixels. */
struct RayMap {
    std::vector<float> forward, left, rise;

    RayMap(const GroundPlane &plane, const Camera &camera, Size size) {
        const std::array<Vector, 3> axes = plane.axes();
        std::vector<float> *const maps[] = {&forward, &left, &rise};
        for (int which = 0; which < 3; which++) {
            const float axis[] = {float(axes[which][0]), float(axes[which][1]), float(axes[which][2])};
            maps[which]->reserve(size_t(size.height) * size.width);
            for (int y = 0; y < size.height; y++) {
                const float along = float((y - camera.cy) / camera.fy) * axis[1] + axis[2];
                for (int x = 0; x < size.width; x++)
                    maps[which]->push_back(along + float((x - camera.cx) / camera.fx) * axis[0]);
            }
        }
    }
};

/* The visible depth, scaled so that visible ground lies on the plane in the median. */
std::vector<float> on_plane(std::vector<float> depth_m, const std::vector<float> &rise,
                            const std::vector<uint8_t> &visible, double camera_height_m) {
    std::vector<float> below_m;
    for (size_t i = 0; i < depth_m.size(); i++)
        if (visible[i] && rise[i] < -1e-3f) below_m.push_back(depth_m[i] * -rise[i]);
    if (below_m.size() < SCALED_BY_PX) return depth_m;
    const float too_far = median(std::move(below_m)) / float(camera_height_m);
    for (float &value : depth_m) value /= too_far;
    return depth_m;
}

}  // namespace

Obstacles::Obstacles(const Prediction &prediction, double robot_height_m)
    : occupied_(BEARINGS * RANGES), in_view_(BEARINGS) {
    if (!(std::isfinite(robot_height_m) && robot_height_m > STEP_HEIGHT_M))
        throw Failure(FPE_BAD_ARGUMENT,
                      text("the robot's height is %g; give metres, more than the %g m of a step",
                           robot_height_m, STEP_HEIGHT_M));
    const GroundPlane &plane = ground_plane(prediction);
    const Camera &camera = prediction.camera;
    const Size size = prediction.maps.size;
    const RayMap rays(plane, camera, size);
    const std::vector<uint8_t> &visible = prediction.masks.visible;
    const float camera_height_m = float(plane.camera_height_m);
    const std::vector<float> depth_m = on_plane(prediction.maps.visible_depth_m, rays.rise, visible,
                                                plane.camera_height_m);
    std::vector<float> log_depth;
    log_depth.reserve(depth_m.size());
    for (float value : depth_m) log_depth.push_back(std::log(value));

    const float table_m = float(std::max(STEP_HEIGHT_M, RAISED * plane.camera_height_m));
    /* a pixel is depth / f wide and high, a bin as wide as an arc */
    const float square_f = float(camera.fx * camera.fy), arc = float(radians(BEARING_DEG));
    std::vector<int> count(BEARINGS * RANGES);
    std::vector<double> surface_m(BEARINGS * RANGES);
    raised_.reserve(depth_m.size());
    for (size_t i = 0; i < depth_m.size(); i++) {
        const float above_m = depth_m[i] * rays.rise[i] + camera_height_m;
        const bool raised = visible[i] && above_m > table_m;
        raised_.push_back(raised);
        const int bearing = bearing_of(std::atan2(rays.left[i], rays.forward[i]) *
                                       float(180 / 3.14159265358979323846));
        if (bearing >= 0 && bearing < BEARINGS) in_view_[bearing] = 1;
        if (!(above_m > float(STEP_HEIGHT_M) && above_m < float(robot_height_m))) continue;
        if (visible[i] && !raised) continue;
        const int x = int(i % size_t(size.width));
        if (x > 0 && x < size.width - 1 &&
            !(std::abs(log_depth[i + 1] - log_depth[i - 1]) < 2 * STEEPEST))
            continue;
        const float range_m = depth_m[i] * std::hypot(rays.forward[i], rays.left[i]);
        const int range = range_of(range_m);
        if (!is_bin(bearing, range)) continue;
        count[bearing * RANGES + range]++;
        surface_m[bearing * RANGES + range] +=
            depth_m[i] * depth_m[i] / square_f / (range_m * arc);
    }
    for (int bearing = 0; bearing < BEARINGS; bearing++)
        for (int range = 0; range < RANGES; range++) {
            const int bin = bearing * RANGES + range;
            if (!count[bin]) continue;
            int seen = 0;
            double seen_m = 0;
            for (int behind = 0; behind < WINDOW && range + behind < RANGES; behind++) {
                seen += count[bin + behind];
                seen_m += surface_m[bin + behind];
            }
            occupied_[bin] = seen >= LEAST_PX && seen_m >= LEAST_SEEN_M;
        }
}

std::vector<uint8_t> Obstacles::covered(int rows, double cell_m) const {
    const int columns = 2 * rows;
    std::vector<uint8_t> found(size_t(rows) * columns);
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < columns; column++) {
            const Place place = centre_of(row, column, rows, cell_m);
            const int bearing = bearing_of(degrees(std::atan2(place.left, place.forward)));
            const int range = range_of(std::hypot(place.forward, place.left));
            if (is_bin(bearing, range))
                found[size_t(row) * columns + column] = occupied_[bearing * RANGES + range];
        }
    /* near the camera bins are smaller than cells */
    const Place first = centre_of(0, 0, rows, cell_m);
    for (int bin = 0; bin < BEARINGS * RANGES; bin++) {
        if (!occupied_[bin]) continue;
        const double angle = angle_of(bin / RANGES), range_m = middle_of(bin % RANGES);
        const double row = std::floor((first.forward - range_m * std::cos(angle)) / cell_m + 0.5);
        const double column = std::floor((first.left - range_m * std::sin(angle)) / cell_m + 0.5);
        if (row >= 0 && row < rows && column >= 0 && column < columns)
            found[size_t(row) * columns + size_t(column)] = 1;
    }
    return found;
}

float Obstacles::nearest_m(double bearing_deg) const {
    const double row = std::nearbyint(bearing_deg / BEARING_DEG + (BEARINGS - 1) / 2);
    if (!(row >= 0 && row < BEARINGS) || !in_view_[size_t(row)]) return NAN;
    for (int range = 0; range < RANGES; range++)
        if (occupied_[size_t(row) * RANGES + range]) return float(middle_of(range));
    return INFINITY;
}

}  // namespace footprints_edge
