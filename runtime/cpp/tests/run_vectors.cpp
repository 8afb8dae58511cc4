/* The outputs of one test vector, by the file names of docs/porting.md:

       run_vectors MODEL PICTURE.ppm OUT_DIR FX FY CX CY HEIGHT WIDTH CAMERA_HEIGHT PITCH ROLL
                   CELL RANGE ROBOT_HEIGHT [START_X START_Y GOAL_X GOAL_Y MARGIN]

   PICTURE is binary PPM; HEIGHT and WIDTH are the network's; `nan` is what is not known of the pose.
   The network's input and maps come from inside the library, all else from its interface. */
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>

#include "errors.hpp"
#include "footprints_edge.hpp"
#include "network.hpp"

namespace fpe = footprints_edge;

namespace {

std::string folder;

std::vector<uint8_t> read_ppm(const std::string &path, int *height, int *width) {
    std::ifstream file(path, std::ios::binary);
    std::string magic;
    int most = 0;
    if (!(file >> magic >> *width >> *height >> most) || magic != "P6" || most != 255)
        throw std::runtime_error(path + " is no 8-bit P6 file");
    file.get();
    std::vector<uint8_t> rgb(size_t(*height) * size_t(*width) * 3);
    if (!file.read(reinterpret_cast<char *>(rgb.data()), std::streamsize(rgb.size())))
        throw std::runtime_error(path + " ends too early");
    return rgb;
}

/* A NumPy file of |u1, <f4 or <f8; this machine is taken to be little-endian. */
void write_npy(const std::string &name, const char *type, const std::string &shape,
               const void *values, size_t bytes) {
    std::string header = std::string("{'descr': '") + type +
                         "', 'fortran_order': False, 'shape': (" + shape + "), }";
    header.resize(118, ' ');
    header.back() = '\n';
    std::ofstream file(folder + "/" + name + ".npy", std::ios::binary);
    file.write("\x93NUMPY\x01\x00\x76\x00", 10) << header;
    file.write(static_cast<const char *>(values), std::streamsize(bytes));
    if (!file.flush()) throw std::runtime_error(folder + "/" + name + ".npy cannot be written");
}

std::string sides(int rows, int columns) {
    return std::to_string(rows) + ", " + std::to_string(columns);
}

template <typename Value>
void write(const std::string &name, const fpe::View<Value> &view) {
    write_npy(name, sizeof(Value) == 1 ? "|u1" : "<f4", sides(view.rows, view.columns), view.values,
              size_t(view.end() - view.begin()) * sizeof(Value));
}

void write(const std::string &name, const std::vector<float> &values) {
    write_npy(name, "<f4", std::to_string(values.size()) + ",", values.data(), values.size() * 4);
}

void write_plane(const fpe::Plane *plane, const std::string &reason) {
    std::ofstream file(folder + "/ground_plane.json");
    file.precision(17);
    if (plane)
        file << "{\"refused\": null, \"up\": [" << plane->up[0] << ", " << plane->up[1] << ", "
             << plane->up[2] << "], \"camera_height_m\": " << plane->camera_height_m
             << ", \"pitch_deg\": " << plane->pitch_deg << ", \"roll_deg\": " << plane->roll_deg
             << ", \"error_m\": " << plane->error_m << "}\n";
    else
        file << "{\"refused\": \"" << reason << "\"}\n";
}

void run(int count, char **words) {
    if (count != 16 && count != 21) throw std::runtime_error("give 15 or 20 words");
    folder = words[3];
    double numbers[21] = {};
    for (int i = 4; i < count; i++) numbers[i] = std::strtod(words[i], nullptr);
    int height = 0, width = 0;
    const std::vector<uint8_t> rgb = read_ppm(words[2], &height, &width);
    const fpe::Camera camera{numbers[4], numbers[5], numbers[6], numbers[7]};
    fpe_options options = fpe_default_options();
    options.network_height = int(numbers[8]);
    options.network_width = int(numbers[9]);
    options.camera_height_m = numbers[10];
    options.pitch_deg = numbers[11];
    options.roll_deg = numbers[12];

    const fpe::Size size{options.network_height, options.network_width};
    const std::vector<uint8_t> file = fpe::read_file(words[1]);
    const fpe::Network network(file.data(), file.size(), words[1], 1);
    network.check_input_size(size);
    const std::vector<uint8_t> input =
        fpe::resize_rgb(rgb.data(), {height, width}, size, network.metadata().filter);
    const std::vector<float> maps = network.run(input, size);
    write_npy("input", "|u1", "1, " + sides(size.height, size.width) + ", 3", input.data(),
              input.size());
    write_npy("maps", "<f4", "1, 4, " + sides(size.height, size.width), maps.data(), maps.size() * 4);

    const fpe::Model model(file.data(), file.size(), words[1], 1);
    options.flatten = 0;
    const fpe::Prediction own = model.predict(rgb.data(), height, width, camera, options);
    write("visible_ground", own.mask(FPE_VISIBLE_GROUND));
    write("ground", own.mask(FPE_GROUND));
    write("hidden_ground", own.mask(FPE_HIDDEN_GROUND));
    write("visible_depth_m", own.map(FPE_VISIBLE_DEPTH_M));
    write("ground_depth_m", own.map(FPE_GROUND_DEPTH_M));
    const fpe::Prediction large = own.at_size(height, width);
    write("visible_ground_at_image_size", large.mask(FPE_VISIBLE_GROUND));
    write("ground_at_image_size", large.mask(FPE_GROUND));
    write("hidden_ground_at_image_size", large.mask(FPE_HIDDEN_GROUND));

    options.flatten = 1;
    const fpe::Prediction flat = model.predict(rgb.data(), height, width, camera, options);
    write("flat_ground_depth_m", flat.map(FPE_GROUND_DEPTH_M));
    try {
        const fpe::Plane plane = flat.ground_plane();
        write_plane(&plane, "");
    } catch (const fpe::Error &error) {
        if (error.status != FPE_NO_GROUND_PLANE) throw;
        write_plane(nullptr, flat.no_ground_plane_reason());
        return;
    }
    const double robot_height_m = numbers[15];
    const fpe::Grid grid = flat.top_down(numbers[13], numbers[14], robot_height_m);
    write("occupancy", grid.cells());
    std::vector<double> bearings;
    std::vector<float> nearest;
    for (int bearing = -90; bearing <= 90; bearing++) {
        bearings.push_back(bearing);
        nearest.push_back(grid.nearest_obstacle_m(bearing));
    }
    write("nearest_obstacle_m", nearest);
    write("scan_m", flat.scan(bearings, robot_height_m));
    if (count == 16) return;
    fpe_path_options path_options = fpe_default_path_options();
    path_options.margin_m = numbers[20];
    path_options.robot_height_m = robot_height_m;
    try {
        const fpe::Path path =
            flat.plan({numbers[16], numbers[17]}, {numbers[18], numbers[19]}, path_options);
        write_npy("path_m", "<f8", sides(int(path.places_m.size()), 2), path.places_m.data(),
                  path.places_m.size() * sizeof(fpe::Point));
    } catch (const fpe::Error &error) { /* another engine's maps may have none */
        if (error.status < FPE_OUTSIDE || error.status > FPE_NO_PATH) throw;
        std::cerr << "no path: " << error.what() << "\n";
    }
}

}  // namespace

int main(int count, char **words) {
    try {
        run(count, words);
    } catch (const std::exception &error) {
        std::cerr << "run_vectors: " << error.what() << "\n";
        return 1;
    }
    return 0;
}
