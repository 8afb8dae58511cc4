/* The nearest free ground in a picture, by the C++ interface of footprints-edge.

       nearest_ground MODEL.onnx PICTURE [CAMERA_HEIGHT_M]

   PICTURE is upright: any that stb_image reads, such as JPEG, where that is installed (Debian:
   libstb-dev); else binary PPM. Of the camera no more is known than its height, if given. */
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <footprints_edge.hpp>

#if __has_include(<stb/stb_image.h>)
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#else
#include <fstream>
#endif

struct Picture {
    int height = 0, width = 0;
    std::vector<uint8_t> rgb;

    explicit Picture(const std::string &path) {
#ifdef STB_IMAGE_IMPLEMENTATION
        uint8_t *pixels = stbi_load(path.c_str(), &width, &height, nullptr, 3);
        if (!pixels) throw std::runtime_error(path + " cannot be read: " + stbi_failure_reason());
        rgb.assign(pixels, pixels + size_t(height) * width * 3);
        stbi_image_free(pixels);
#else
        std::ifstream file(path, std::ios::binary);
        std::string magic;
        int most = 0;
        file >> magic >> width >> height >> most;
        const bool is_ppm = file && magic == "P6" && most == 255 && width > 0 && height > 0;
        if (!is_ppm) throw std::runtime_error(path + " cannot be read: it is no 8-bit P6 file");
        file.get();
        rgb.resize(size_t(height) * width * 3);
        if (!file.read(reinterpret_cast<char *>(rgb.data()), std::streamsize(rgb.size())))
            throw std::runtime_error(path + " ends too early");
#endif
    }
};

int main(int count, char **words) try {
    if (count < 3) throw std::runtime_error("usage: nearest_ground MODEL PICTURE [CAMERA_HEIGHT_M]");
    const footprints_edge::Model model(words[1]);
    const Picture picture(words[2]);
    fpe_options options = fpe_default_options();
    if (count > 3) options.camera_height_m = std::atof(words[3]);
    const auto ground =
        model.predict(picture.rgb.data(), picture.height, picture.width, std::nullopt, options);

    const auto grid = ground.top_down();
    const auto cells = grid.cells();
    footprints_edge::Point nearest{INFINITY, 0};
    for (int row = 0; row < cells.rows; row++)
        for (int column = 0; column < cells.columns; column++) {
            const auto [ahead_m, left_m] = grid.place(row, column);
            if (cells.at(row, column) == FPE_FREE &&
                std::hypot(ahead_m, left_m) < std::hypot(nearest.first, nearest.second))
                nearest = {ahead_m, left_m};
        }
    if (std::isinf(nearest.first))
        std::puts("no free ground within 10 m");
    else
        std::printf("nearest free ground: %.2f m ahead, %.2f m to the %s\n", nearest.first,
                    std::abs(nearest.second), nearest.second < 0 ? "right" : "left");
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "nearest_ground: %s\n", error.what());
    return 1;
}
