/* The one rule for obstacles: what is seen between a step and the robot's height above the ground.
   docs/planning.md, "Obstacles". */
#pragma once

#include <cstdint>
#include <vector>

#include "ground_plane.hpp"
#include "prediction.hpp"

namespace footprints_edge {

class Obstacles {
  public:
    Obstacles(const Prediction &prediction, double robot_height_m);

    /* Pixels of visible ground that are too high to be ground, height * width. */
    const std::vector<uint8_t> &raised() const { return raised_; }

    /* Marks cells of a grid, `rows` by twice as many columns of `cell_m`, that are occupied. */
    std::vector<uint8_t> covered(int rows, double cell_m) const;

    /* The range of the first obstacle at a bearing, metres; infinite where nothing is seen, NaN out of
       view. */
    float nearest_m(double bearing_deg) const;

  private:
    std::vector<uint8_t> occupied_; /* bearings by ranges */
    std::vector<uint8_t> in_view_;  /* bearings */
    std::vector<uint8_t> raised_;
};

}  // namespace footprints_edge
