#include "ground_plane.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "errors.hpp"
#include "median.hpp"

namespace footprints_edge {
namespace {

constexpr size_t FEWEST_PIXELS = 20;
constexpr int TRIALS = 150;       /* triples drawn */
constexpr size_t FITTED = 8000;   /* most pixels of the fit */
constexpr int JUDGED = 600;       /* pixels that rank the triples' planes */
constexpr int ROUNDS = 6;         /* of least squares without outliers */
constexpr double LEAST_AREA = 0.02;
constexpr double FLAT = 0.15;     /* most median of |ln(depth / the plane's)| */
constexpr double LOWEST_M = 0.03, HIGHEST_M = 100, STEEPEST_UP_DEG = -30, MOST_LEANING_DEG = 45;
constexpr double SEARCHED_DEG = 25, SEARCH_STEP_DEG = 0.5;

/* The same numbers from 0 to count - 1 on every machine: the finaliser of MurmurHash3 of 0, 1, ... */
size_t drawn(uint32_t which, size_t count) {
    uint32_t mixed = which;
    mixed ^= mixed >> 16;
    mixed *= 0x85EBCA6Bu;
    mixed ^= mixed >> 13;
    mixed *= 0xC2B2AE35u;
    mixed ^= mixed >> 16;
    return size_t((uint64_t(mixed) * count) >> 32);
}

/* Indices of ground pixels, row by row: all of them, or FITTED. */
std::vector<size_t> evenly_drawn(const std::vector<uint8_t> &ground) {
    std::vector<size_t> found;
    for (size_t i = 0; i < ground.size(); i++)
        if (ground[i]) found.push_back(i);
    if (found.size() <= FITTED) return found;
    std::vector<size_t> chosen(FITTED);
    for (size_t i = 0; i < FITTED; i++) chosen[i] = found[i * found.size() / FITTED];
    return chosen;
}

/* The pixels of the fit: the rays through them, and the inverse of their depths. */
struct Samples {
    std::vector<Vector> rays;
    std::vector<double> inverse_depth;
};

/* The x with x . a = p, x . b = q, x . c = r. */
Vector solved(const Vector &a, const Vector &b, const Vector &c, const Vector &right) {
    const double determinant = dot(a, cross(b, c));
    const Vector bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    Vector result;
    for (int i = 0; i < 3; i++)
        result[i] = (right[0] * bc[i] + right[1] * ca[i] + right[2] * ab[i]) / determinant;
    return result;
}

/* The plane through a triple with the least median |plane . ray - inverse depth|. */
Vector least_median(const Samples &samples) {
    const size_t count = samples.rays.size();
    std::vector<size_t> judged(JUDGED);
    for (int i = 0; i < JUDGED; i++) judged[i] = drawn(uint32_t(3 * TRIALS + i), count);
    Vector best{};
    float least = std::numeric_limits<float>::infinity();
    bool any = false;
    std::vector<float> residuals(JUDGED);
    for (int trial = 0; trial < TRIALS; trial++) {
        Vector corners[3], right{};
        for (int i = 0; i < 3; i++) {
            const size_t pixel = drawn(uint32_t(3 * trial + i), count);
            corners[i] = samples.rays[pixel];
            right[i] = samples.inverse_depth[pixel];
        }
        /* collinear points span no plane */
        if (!(std::abs(dot(corners[0], cross(corners[1], corners[2]))) > 1e-9)) continue;
        const Vector plane = solved(corners[0], corners[1], corners[2], right);
        for (int i = 0; i < JUDGED; i++)
            residuals[i] = float(std::abs(dot(plane, samples.rays[judged[i]]) -
                                          samples.inverse_depth[judged[i]]));
        std::nth_element(residuals.begin(), residuals.begin() + JUDGED / 2, residuals.end());
        if (!any || residuals[JUDGED / 2] < least) {
            any = true;
            best = plane;
            least = residuals[JUDGED / 2];
        }
    }
    if (!any)
        throw NoGroundPlane("one_line",
                            text("the %zu ground pixels lie in one line, which spans no plane; use "
                                 "a picture that shows more ground",
                                 count));
    return best;
}

/* Least squares over the pixels that are no outliers of the plane so far. */
Vector refitted(const Vector &gradient, const Samples &samples) {
    const size_t count = samples.rays.size();
    std::vector<double> residual(count);
    for (size_t i = 0; i < count; i++)
        residual[i] = std::abs(dot(gradient, samples.rays[i]) - samples.inverse_depth[i]);
    const double most = std::max(2.5 * 1.4826 * median(residual), 1e-9);
    Vector normal[3] = {}, right{};
    for (size_t i = 0; i < count; i++) {
        if (!(residual[i] <= most)) continue;
        const Vector &ray = samples.rays[i];
        for (int row = 0; row < 3; row++) {
            right[row] += ray[row] * samples.inverse_depth[i];
            for (int column = 0; column < 3; column++) normal[row][column] += ray[row] * ray[column];
        }
    }
    if (!(dot(normal[0], cross(normal[1], normal[2])) > 1e-12)) return gradient; /* all in a line */
    /* symmetric, so that its rows are its columns */
    return solved(normal[0], normal[1], normal[2], right);
}

double length(const Vector &vector) { return std::sqrt(dot(vector, vector)); }

std::vector<double> around(double angle, double least, double most) {
    std::vector<double> found;
    for (int i = 0; i <= int(2 * SEARCHED_DEG / SEARCH_STEP_DEG); i++)
        found.push_back(std::clamp(angle - SEARCHED_DEG + i * SEARCH_STEP_DEG, least, most));
    return found;
}

/* The gradient of inverse depth with the known part of the pose instead of the fitted one. */
Vector with_known(const Vector &gradient, const Samples &samples, const Pose &pose) {
    const double size = length(gradient);
    const GroundPlane fitted{times(gradient, -1 / size), 1 / size, 0};
    std::vector<double> pitches{pose.knows_pitch() ? pose.pitch_deg : fitted.pitch_deg()};
    std::vector<double> rolls{pose.knows_roll() ? pose.roll_deg : fitted.roll_deg()};
    if (!pose.knows_pitch() && (pose.knows_roll() || pose.knows_height()))
        pitches = around(fitted.pitch_deg(), -89, 90);
    else if (pose.knows_pitch() && !pose.knows_roll())
        rolls = around(fitted.roll_deg(), -INFINITY, INFINITY);
    const size_t count = samples.rays.size();
    Vector best = gradient;
    double least = INFINITY;
    std::vector<double> falling(count), heights, error(count);
    for (double pitch : pitches)
        for (double roll : rolls) {
            const Vector up = up_vector(pitch, roll);
            for (size_t i = 0; i < count; i++) falling[i] = -dot(up, samples.rays[i]);
            double height_m = pose.height_m;
            if (!pose.knows_height()) {
                heights.clear();
                for (size_t i = 0; i < count; i++)
                    if (falling[i] > 0) heights.push_back(falling[i] / samples.inverse_depth[i]);
                height_m = heights.empty() ? 1 : median(heights);
            }
            for (size_t i = 0; i < count; i++)
                error[i] = std::abs(falling[i] / height_m - samples.inverse_depth[i]);
            const double middle = median(error);
            if (middle < least) {
                least = middle;
                best = times(up, -1 / height_m);
            }
        }
    return best;
}

GroundPlane fit(const std::vector<float> &depth_m, const std::vector<uint8_t> &ground, Size size,
                const Camera &camera, const Pose &pose) {
    const std::vector<size_t> chosen = evenly_drawn(ground);
    if (chosen.size() < FEWEST_PIXELS)
        throw NoGroundPlane("few_pixels",
                            text("%zu pixels are ground; a plane needs %zu; lower the threshold, or "
                                 "use a picture that shows more ground",
                                 chosen.size(), FEWEST_PIXELS));
    Samples samples;
    for (size_t pixel : chosen) {
        samples.rays.push_back(
            ray(camera, double(pixel % size.width), double(pixel / size.width)));
        samples.inverse_depth.push_back(1 / double(depth_m[pixel]));
    }
    Vector gradient = least_median(samples);
    for (int round = 0; round < ROUNDS; round++) gradient = refitted(gradient, samples);
    if (pose.anything()) gradient = with_known(gradient, samples, pose);
    const double size_of = length(gradient); /* up . ray = -height / depth */
    GroundPlane plane{times(gradient, -1 / size_of), 1 / size_of, 0};
    if (!(plane.up[1] <= 0.2))
        throw NoGroundPlane("above_camera",
                            "the ground plane is above the camera; turn the picture if it is "
                            "upside down");
    std::vector<double> above;
    for (size_t i = 0; i < samples.rays.size(); i++)
        above.push_back(std::abs(dot(plane.up, samples.rays[i]) / samples.inverse_depth[i] +
                                 plane.camera_height_m));
    plane.error_m = median(above);
    return plane;
}

/* The median of |ln(depth / plane's depth)|, relative to its own median: a camera height that is
   known rescales the plane, which does not make the ground uneven. */
float median_deviation(const GroundPlane &plane, const std::vector<float> &depth_m,
                       const std::vector<uint8_t> &ground, Size size, const Camera &camera) {
    const std::vector<float> of_plane = inverse_depth(plane, camera, size);
    std::vector<float> log_ratio;
    for (size_t pixel : evenly_drawn(ground))
        log_ratio.push_back(std::log(std::max(of_plane[pixel] * depth_m[pixel], 1e-6f)));
    const float middle = median(log_ratio);
    for (float &value : log_ratio) value = std::abs(value - middle);
    return median(log_ratio);
}

}  // namespace

double GroundPlane::pitch_deg() const {
    return degrees(std::asin(std::clamp(-up[2], -1.0, 1.0)));
}

double GroundPlane::roll_deg() const { return degrees(std::atan2(-up[0], -up[1])); }

std::array<Vector, 3> GroundPlane::axes() const {
    Vector towards{0, 0, 1};
    if (std::abs(up[2]) > 0.999) towards = {0, -1, 0}; /* straight down: up in the picture */
    const double rise = dot(towards, up);
    Vector forward;
    for (int i = 0; i < 3; i++) forward[i] = towards[i] - rise * up[i];
    forward = times(forward, 1 / length(forward));
    return {forward, cross(up, forward), up};
}

std::vector<float> inverse_depth(const GroundPlane &plane, const Camera &camera, Size size) {
    const Vector slope = times(plane.up, -1 / plane.camera_height_m);
    std::vector<float> across(size.width), result;
    for (int x = 0; x < size.width; x++)
        across[x] = float(slope[0] * (x - camera.cx) / camera.fx);
    result.reserve(size_t(size.height) * size.width);
    for (int y = 0; y < size.height; y++) {
        const float along = float(slope[1] * (y - camera.cy) / camera.fy + slope[2]);
        for (float value : across) result.push_back(along + value);
    }
    return result;
}

PlaneMap::PlaneMap(const GroundPlane &plane, const Camera &camera)
    : axes_(plane.axes()), camera_height_m_(plane.camera_height_m), camera_(camera) {}

Place PlaneMap::at_pixel(Pixel pixel) const {
    const Vector direction = ray(camera_, pixel.x, pixel.y);
    const double rise = dot(direction, axes_[2]);
    if (!(rise < -1e-9)) return {NAN, NAN};
    const double stretch = camera_height_m_ / -rise;
    return {dot(direction, axes_[0]) * stretch, dot(direction, axes_[1]) * stretch};
}

Pixel PlaneMap::to_pixel(Place place) const {
    Vector point;
    for (int i = 0; i < 3; i++)
        point[i] = place.forward * axes_[0][i] + place.left * axes_[1][i] -
                   camera_height_m_ * axes_[2][i];
    if (!(point[2] > 1e-6)) return {NAN, NAN};
    return {camera_.cx + camera_.fx * point[0] / point[2],
            camera_.cy + camera_.fy * point[1] / point[2]};
}

GroundPlane find_ground_plane(const std::vector<float> &depth_m, const std::vector<uint8_t> &ground,
                              Size size, const Camera &camera, const Pose &pose) {
    if (pose.everything()) return {up_vector(pose.pitch_deg, pose.roll_deg), pose.height_m, 0};
    const GroundPlane plane = fit(depth_m, ground, size, camera, pose);
    const double area = double(std::count(ground.begin(), ground.end(), 1)) / double(ground.size());
    if (area < LEAST_AREA)
        throw NoGroundPlane("little_ground",
                            text("%.1f%% of the picture is ground; a plane needs %.0f%%; use a "
                                 "picture that shows more ground, or give the camera's height, "
                                 "pitch and roll",
                                 100 * area, 100 * LEAST_AREA));
    const double lean_deg = degrees(std::asin(std::min(1.0, std::abs(plane.up[0]))));
    if (!(plane.camera_height_m >= LOWEST_M && plane.camera_height_m <= HIGHEST_M &&
          plane.pitch_deg() >= STEEPEST_UP_DEG &&
          (lean_deg <= MOST_LEANING_DEG || pose.knows_roll())))
        throw NoGroundPlane("impossible_pose",
                            text("the plane of what looks like ground cannot be the ground: the "
                                 "camera would be %.2f m above it, look down by %.0f degrees and "
                                 "lean by %.0f; give the camera's height, pitch and roll, if they "
                                 "are so",
                                 plane.camera_height_m, plane.pitch_deg(), lean_deg));
    const float deviation = median_deviation(plane, depth_m, ground, size, camera);
    if (!(deviation <= FLAT))
        throw NoGroundPlane("not_flat",
                            text("the ground is not flat: half of it deviates by more than %.0f%% "
                                 "from one plane; use a picture of flat ground, or give the "
                                 "camera's height, pitch and roll",
                                 100.0 * deviation));
    return plane;
}

}  // namespace footprints_edge
