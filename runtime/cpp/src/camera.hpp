/* Pinhole cameras, and what is known of a camera's pose above the ground. */
#pragma once

#include <array>
#include <cmath>

#include "footprints_edge.h"
#include "size.hpp"

namespace footprints_edge {

using Vector = std::array<double, 3>; /* in camera axes: x right, y down, z forward */
using Camera = fpe_camera;

inline double dot(const Vector &a, const Vector &b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector cross(const Vector &a, const Vector &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Vector times(const Vector &a, double factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

inline double radians(double degrees) { return degrees * (3.14159265358979323846 / 180); }
inline double degrees(double radians) { return radians * (180 / 3.14159265358979323846); }

Camera camera_of_focal(double focal_px, Size image);

/* Refuses a camera that cannot be. */
void check_camera(const Camera &camera);

/* The same camera after its image is resized. */
Camera scaled(const Camera &camera, Size from, Size to);

/* The ray through a pixel, with z = 1: times the depth, it is a point. */
inline Vector ray(const Camera &camera, double x, double y) {
    return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1};
}

/* The known part of a pose above level ground; NaN where it is not known. */
struct Pose {
    double height_m = NAN, pitch_deg = NAN, roll_deg = NAN;
    bool knows_height() const { return !std::isnan(height_m); }
    bool knows_pitch() const { return !std::isnan(pitch_deg); }
    bool knows_roll() const { return !std::isnan(roll_deg); }
    bool anything() const { return knows_height() || knows_pitch() || knows_roll(); }
    bool everything() const { return knows_height() && knows_pitch() && knows_roll(); }
};

/* Refuses a pose that cannot be. */
void check_pose(const Pose &pose);

/* The unit vector that points up. */
Vector up_vector(double pitch_deg, double roll_deg);

}  // namespace footprints_edge
