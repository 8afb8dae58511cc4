#include "occupancy_grid.hpp"

#include <cmath>

#include "errors.hpp"

namespace footprints_edge {

static constexpr int MOST_CELLS = 1500; /* in the range */

void check_grid(double cell_m, double range_m) {
    if (!(std::isfinite(range_m) && cell_m > 0 && cell_m <= range_m &&
          range_m <= MOST_CELLS * cell_m))
        throw Failure(FPE_BAD_ARGUMENT,
                      text("the cell is %g m, the range %g m; give positive numbers of metres, with "
                           "1 to %d cells in the range",
                           cell_m, range_m, MOST_CELLS));
}

OccupancyGrid make_grid(const Prediction &prediction, const Obstacles &obstacles, double cell_m,
                        double range_m) {
    const int rows = int(std::ceil(range_m / cell_m - 1e-6)); /* 1.1 / 0.1 is a little over 11 */
    OccupancyGrid grid{rows, cell_m, std::vector<uint8_t>(size_t(rows) * 2 * rows, FPE_UNKNOWN)};
    const PlaneMap plane(ground_plane(prediction), prediction.camera);
    const Size size = prediction.maps.size;
    const std::vector<uint8_t> occupied = obstacles.covered(rows, cell_m);
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < grid.columns(); column++) {
            const Place place = centre_of(row, column, rows, cell_m);
            if (!(std::hypot(place.forward, place.left) <= range_m)) continue;
            const size_t cell = size_t(row) * grid.columns() + column;
            const Pixel at = plane.to_pixel(place);
            if (at.x >= -0.5 && at.x < size.width - 0.5 && at.y >= -0.5 &&
                at.y < size.height - 0.5) { /* NaN is outside */
                const size_t pixel = size_t(std::floor(at.y + 0.5)) * size.width +
                                     size_t(std::floor(at.x + 0.5));
                if (obstacles.raised()[pixel]) /* what is beneath a table top is not seen */
                    grid.cells[cell] = FPE_UNKNOWN;
                else if (prediction.masks.hidden[pixel])
                    grid.cells[cell] = FPE_HIDDEN;
                else if (prediction.masks.ground[pixel])
                    grid.cells[cell] = FPE_FREE;
            }
            if (occupied[cell]) grid.cells[cell] = FPE_OCCUPIED;
        }
    return grid;
}

float nearest_obstacle_m(const OccupancyGrid &grid, double bearing_deg) {
    if (!std::isfinite(bearing_deg)) return NAN;
    const double ahead = std::cos(radians(bearing_deg)), aside = std::sin(radians(bearing_deg));
    const double most = 4 * std::hypot(grid.rows, grid.columns());
    for (int quarters = 0; quarters < most; quarters++) {
        const double row = std::floor(grid.rows - ahead * quarters / 4);
        const double column = std::floor(grid.rows - aside * quarters / 4);
        if (row >= 0 && row < grid.rows && column >= 0 && column < grid.columns() &&
            grid.cells[size_t(row) * grid.columns() + size_t(column)] == FPE_OCCUPIED)
            return float(quarters * grid.cell_m / 4);
    }
    return INFINITY;
}

}  // namespace footprints_edge
