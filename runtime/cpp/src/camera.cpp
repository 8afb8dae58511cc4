#include "camera.hpp"

#include <algorithm>

#include "errors.hpp"

namespace footprints_edge {

static constexpr double MOST_PX = 1e9; /* beyond this, numbers of a camera are no pixels */

Camera camera_of_focal(double focal_px, Size image) {
    return {focal_px, focal_px, (image.width - 1) / 2.0, (image.height - 1) / 2.0};
}

void check_camera(const Camera &camera) {
    const double most = std::max({camera.fx, camera.fy, std::abs(camera.cx), std::abs(camera.cy)});
    const double least = std::min(camera.fx, camera.fy);
    const double sum = camera.fx + camera.fy + camera.cx + camera.cy; /* NaN if one is */
    if (!(std::isfinite(sum) && least >= 1 / MOST_PX && most <= MOST_PX))
        throw Failure(FPE_BAD_ARGUMENT,
                      text("fx %g, fy %g, cx %g, cy %g cannot be a camera; give numbers of pixels "
                           "up to %g, positive ones for the focal lengths",
                           camera.fx, camera.fy, camera.cx, camera.cy, MOST_PX));
}

Camera scaled(const Camera &camera, Size from, Size to) {
    const double x = double(to.width) / from.width, y = double(to.height) / from.height;
    return {camera.fx * x, camera.fy * y, (camera.cx + 0.5) * x - 0.5, (camera.cy + 0.5) * y - 0.5};
}

void check_pose(const Pose &pose) {
    if (pose.knows_height() && !(std::isfinite(pose.height_m) && pose.height_m > 0))
        throw Failure(FPE_BAD_ARGUMENT,
                      text("the camera height is %g; give it as a positive number of metres above "
                           "the ground",
                           pose.height_m));
    const auto check = [](const char *name, double value, int most) {
        if (std::abs(value) > most)
            throw Failure(FPE_BAD_ARGUMENT,
                          text("the %s is %g; give degrees from -%d to %d (pitch down and right "
                               "side down are positive)",
                               name, value, most, most));
    };
    check("pitch", pose.pitch_deg, 90);
    check("roll", pose.roll_deg, 180);
}

Vector up_vector(double pitch_deg, double roll_deg) {
    const double pitch = radians(pitch_deg), roll = radians(roll_deg), level = std::cos(pitch);
    return {-std::sin(roll) * level, -std::cos(roll) * level, -std::sin(pitch)};
}

}  // namespace footprints_edge
