/* The ground in bird's-eye view. Rows run from far to near, columns from left to right. */
#pragma once

#include <cstdint>
#include <vector>

#include "obstacles.hpp"
#include "prediction.hpp"

namespace footprints_edge {

struct OccupancyGrid {
    int rows; /* and twice as many columns */
    double cell_m;
    std::vector<uint8_t> cells; /* FPE_UNKNOWN, FPE_OCCUPIED, FPE_FREE or FPE_HIDDEN */
    int columns() const { return 2 * rows; }
};

/* The centre of a cell. */
inline Place centre_of(int row, int column, int rows, double cell_m) {
    return {(rows - row - 0.5) * cell_m, (rows - column - 0.5) * cell_m};
}

/* Refuses sizes that cannot be, or make too many cells. */
void check_grid(double cell_m, double range_m);

OccupancyGrid make_grid(const Prediction &prediction, const Obstacles &obstacles, double cell_m,
                        double range_m);

/* Metres to the first occupied cell at a bearing, degrees, left positive; infinite without one. */
float nearest_obstacle_m(const OccupancyGrid &grid, double bearing_deg);

}  // namespace footprints_edge
