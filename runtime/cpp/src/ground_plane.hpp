/* The ground plane: its fit, its gate, and metric coordinates on it. */
#pragma once

#include <cstdint>
#include <vector>

#include "camera.hpp"
#include "size.hpp"

namespace footprints_edge {

/* A place on the plane: forward and left, metres. */
struct Place {
    double forward, left;
};

/* A point of a picture. */
struct Pixel {
    double x, y;
};

struct GroundPlane {
    Vector up;              /* the unit normal in camera axes */
    double camera_height_m; /* of the camera above the plane */
    double error_m;         /* median distance of the fitted pixels; 0 for a known plane */

    double pitch_deg() const;
    double roll_deg() const;

    /* Forward, left and up: unit vectors in camera axes. */
    std::array<Vector, 3> axes() const;
};

/* The inverse of the plane's depth at every pixel; not positive at and above the horizon. */
std::vector<float> inverse_depth(const GroundPlane &plane, const Camera &camera, Size size);

/* A plane with its axes at hand, for many conversions. */
class PlaneMap {
  public:
    PlaneMap(const GroundPlane &plane, const Camera &camera);
    Place at_pixel(Pixel pixel) const;  /* NaN at and above the horizon */
    Pixel to_pixel(Place place) const;  /* NaN behind the camera */

  private:
    std::array<Vector, 3> axes_;
    double camera_height_m_;
    Camera camera_;
};

/* The ground plane, if there is one to be believed; throws NoGroundPlane. A pose that is known
   completely gives it; otherwise it is fitted to the depth, metres, where `ground` is 1. */
GroundPlane find_ground_plane(const std::vector<float> &depth_m, const std::vector<uint8_t> &ground,
                              Size size, const Camera &camera, const Pose &pose);

}  // namespace footprints_edge
