/* A model file in onnxruntime. The only files that know onnxruntime are this one's sources. */
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "metadata.hpp"
#include "size.hpp"

namespace footprints_edge {

/* The bytes of a file; throws a Failure that names it. */
std::vector<uint8_t> read_file(const std::string &path);

class Network {
  public:
    /* Loads a file's bytes; `file` names it in messages. Threads for one run; 0 for onnxruntime's
       choice. */
    Network(const void *data, size_t bytes, const std::string &file, int threads);
    ~Network();
    Network(const Network &) = delete;
    Network &operator=(const Network &) = delete;

    const Metadata &metadata() const { return metadata_; }

    /* The size of the input for a picture: the file's own, or that of the size rule. */
    Size input_size(Size image) const;

    /* Refuses a size that the file cannot take. */
    void check_input_size(Size size) const;

    /* RGB bytes of the size to maps, channel by channel, from 0 to 1. May be called by many threads
       at a time. */
    std::vector<float> run(const std::vector<uint8_t> &rgb, Size size) const;

  private:
    struct Session;
    std::string file_;
    Metadata metadata_;
    Size fixed_; /* (0, 0) for a free size */
    std::unique_ptr<Session> session_;
};

}  // namespace footprints_edge
