#include "network.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#if __has_include(<onnxruntime_c_api.h>)
#include <onnxruntime_c_api.h>
#else
#include <onnxruntime/onnxruntime_c_api.h>
#endif

#include "errors.hpp"
#include "working_size.hpp"

namespace footprints_edge {
namespace {

/* Functions of the table are those of 2023, so that an older library than the header will do. */
constexpr uint32_t API_VERSION = 14;
constexpr int MOST_SIDE_PX = 4096, MOST_PX = 1 << 22, MOST_THREADS = 256;

const OrtApi &ort() {
    static const OrtApi *const api = [] {
        /* onnxruntime reports to its maker unless this is set before it starts; 0 lets it */
#ifdef _WIN32
        if (!std::getenv("ORT_DISABLE_TELEMETRY")) _putenv_s("ORT_DISABLE_TELEMETRY", "1");
#else
        setenv("ORT_DISABLE_TELEMETRY", "1", 0);
#endif
        return OrtGetApiBase()->GetApi(API_VERSION);
    }();
    if (!api)
        throw Failure(FPE_BAD_MODEL, text("onnxruntime %s is too old; link one of 1.14 or later",
                                          OrtGetApiBase()->GetVersionString()));
    return *api;
}

/* Throws what a call complains about, behind `what`. */
void check(OrtStatus *status, const std::string &what) {
    if (!status) return;
    const std::string said = ort().GetErrorMessage(status);
    ort().ReleaseStatus(status);
    throw Failure(FPE_BAD_MODEL, what + ". onnxruntime says: " + said);
}

template <typename Object>
using Owned = std::unique_ptr<Object, void (*)(Object *)>;

/* An object that a function of the table makes, released by another. */
template <typename Object, typename Release, typename Make>
Owned<Object> owned(Release release, const std::string &what, Make make) {
    Object *object = nullptr;
    check(make(&object), what);
    return Owned<Object>(object, release);
}

std::vector<int64_t> shape_of(const OrtTensorTypeAndShapeInfo *info, const std::string &what) {
    size_t count = 0;
    check(ort().GetDimensionsCount(info, &count), what);
    std::vector<int64_t> shape(count);
    check(ort().GetDimensions(info, shape.data(), count), what);
    return shape;
}

}  // namespace

std::vector<uint8_t> read_file(const std::string &path) {
    const std::unique_ptr<FILE, int (*)(FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file)
        throw Failure(FPE_BAD_MODEL, path + " cannot be opened: " + std::strerror(errno));
    std::vector<uint8_t> data;
    std::vector<uint8_t> part(1 << 20);
    while (const size_t count = std::fread(part.data(), 1, part.size(), file.get()))
        data.insert(data.end(), part.begin(), part.begin() + std::ptrdiff_t(count));
    if (std::ferror(file.get()))
        throw Failure(FPE_BAD_MODEL, path + " cannot be read: " + std::strerror(errno));
    return data;
}

struct Network::Session {
    Owned<OrtEnv> environment;
    Owned<OrtSession> session;
    Owned<OrtMemoryInfo> memory;
};

Network::Network(const void *data, size_t bytes, const std::string &file, int threads)
    : file_(file), fixed_{} {
    if (threads < 0 || threads > MOST_THREADS)
        throw Failure(FPE_BAD_ARGUMENT, text("threads is %d; give 1 to %d, or 0 for onnxruntime's "
                                             "choice",
                                             threads, MOST_THREADS));
    const std::string what =
        text("%s cannot be loaded (%zu bytes): it is damaged, not an ONNX model, or made for a newer "
             "onnxruntime than %s; fetch or convert it again",
             file.c_str(), bytes, OrtGetApiBase()->GetVersionString());
    const OrtApi &api = ort();
    /* errors arrive as statuses; not to be printed as well */
    auto environment = owned<OrtEnv>(api.ReleaseEnv, what, [&](OrtEnv **made) {
        return api.CreateEnv(ORT_LOGGING_LEVEL_FATAL, "footprints-edge", made);
    });
    auto options = owned<OrtSessionOptions>(
        api.ReleaseSessionOptions, what,
        [&](OrtSessionOptions **made) { return api.CreateSessionOptions(made); });
    check(api.SetIntraOpNumThreads(options.get(), threads), what);
    /* between two runs, waiting threads must not occupy the cores */
    check(api.AddSessionConfigEntry(options.get(), "session.force_spinning_stop", "1"), what);
    auto session = owned<OrtSession>(api.ReleaseSession, what, [&](OrtSession **made) {
        return api.CreateSessionFromArray(environment.get(), data, bytes, options.get(), made);
    });

    OrtAllocator *allocator = nullptr;
    check(api.GetAllocatorWithDefaultOptions(&allocator), what);
    auto properties = owned<OrtModelMetadata>(
        api.ReleaseModelMetadata, what,
        [&](OrtModelMetadata **made) { return api.SessionGetModelMetadata(session.get(), made); });
    metadata_ = read_metadata(
        [&](const char *key) {
            char *value = nullptr;
            check(api.ModelMetadataLookupCustomMetadataMap(properties.get(), allocator, key, &value),
                  what);
            const std::string result = value ? value : "";
            if (value) check(api.AllocatorFree(allocator, value), what);
            return result;
        },
        file);

    const std::string contract =
        text("%s has another input than footprints-edge's, image uint8 [1, H, W, 3]; convert one "
             "with: fp-export convert CHECKPOINT -o OUT.onnx --arch edge",
             file.c_str());
    auto type = owned<OrtTypeInfo>(api.ReleaseTypeInfo, contract, [&](OrtTypeInfo **made) {
        return api.SessionGetInputTypeInfo(session.get(), 0, made);
    });
    const OrtTensorTypeAndShapeInfo *tensor = nullptr; /* the type's own */
    check(api.CastTypeInfoToTensorInfo(type.get(), &tensor), contract);
    if (!tensor) throw Failure(FPE_BAD_MODEL, contract);
    ONNXTensorElementDataType element{};
    check(api.GetTensorElementType(tensor, &element), contract);
    const std::vector<int64_t> shape = shape_of(tensor, contract);
    if (element != ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8 || shape.size() != 4 || shape[3] != 3)
        throw Failure(FPE_BAD_MODEL, contract);
    if (shape[1] > 0 && shape[2] > 0) {
        if (shape[1] > MOST_SIDE_PX || shape[2] > MOST_SIDE_PX || shape[1] * shape[2] > MOST_PX ||
            shape[1] % STRIDE || shape[2] % STRIDE)
            throw Failure(FPE_BAD_MODEL,
                          text("%s has the fixed input size %lld x %lld; multiples of %d up to %d, "
                               "and %d pixels in all, are possible; convert it again",
                               file.c_str(), static_cast<long long>(shape[1]),
                               static_cast<long long>(shape[2]), STRIDE, MOST_SIDE_PX, MOST_PX));
        fixed_ = {int(shape[1]), int(shape[2])};
    }
    auto memory = owned<OrtMemoryInfo>(api.ReleaseMemoryInfo, what, [&](OrtMemoryInfo **made) {
        return api.CreateCpuMemoryInfo(OrtArenaAllocator, OrtMemTypeDefault, made);
    });
    session_.reset(new Session{std::move(environment), std::move(session), std::move(memory)});
}

Network::~Network() = default;

Size Network::input_size(Size image) const {
    return fixed_.height ? fixed_ : working_size(image);
}

void Network::check_input_size(Size size) const {
    if (fixed_.height && !(size == fixed_))
        throw Failure(FPE_BAD_ARGUMENT, text("%s takes inputs of %d x %d only, not %d x %d",
                                             file_.c_str(), fixed_.height, fixed_.width, size.height,
                                             size.width));
    const int least = std::min(size.height, size.width), most = std::max(size.height, size.width);
    if (least < 2 * STRIDE || most > MOST_SIDE_PX || size.height % STRIDE || size.width % STRIDE ||
        size.height * size.width > MOST_PX)
        throw Failure(FPE_BAD_ARGUMENT,
                      text("the network's input cannot be %d x %d; give multiples of %d from %d to "
                           "%d, and at most %d pixels",
                           size.height, size.width, STRIDE, 2 * STRIDE, MOST_SIDE_PX, MOST_PX));
}

std::vector<float> Network::run(const std::vector<uint8_t> &rgb, Size size) const {
    const OrtApi &api = ort();
    const std::string what =
        text("%s failed on an input of %d x %d", file_.c_str(), size.height, size.width);
    const int64_t shape[] = {1, size.height, size.width, 3};
    auto image = owned<OrtValue>(api.ReleaseValue, what, [&](OrtValue **made) {
        /* an input is read only */
        return api.CreateTensorWithDataAsOrtValue(
            session_->memory.get(), const_cast<uint8_t *>(rgb.data()), rgb.size(), shape, 4,
            ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8, made);
    });
    const char *const inputs[] = {"image"}, *const outputs[] = {"maps"};
    const OrtValue *const images[] = {image.get()};
    auto output = owned<OrtValue>(api.ReleaseValue, what, [&](OrtValue **made) {
        return api.Run(session_->session.get(), nullptr, inputs, images, 1, outputs, 1, made);
    });
    auto info = owned<OrtTensorTypeAndShapeInfo>(
        api.ReleaseTensorTypeAndShapeInfo, what,
        [&](OrtTensorTypeAndShapeInfo **made) { return api.GetTensorTypeAndShape(output.get(), made); });
    ONNXTensorElementDataType element{};
    check(api.GetTensorElementType(info.get(), &element), what);
    const int channels = (metadata_.has_masks ? 2 : 0) + (metadata_.has_depths ? 2 : 0);
    const std::vector<int64_t> expected = {1, channels, size.height, size.width};
    if (element != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT || shape_of(info.get(), what) != expected)
        throw Failure(FPE_BAD_MODEL, text("%s gives maps of another shape than float32 [1, %d, %d, "
                                          "%d]; it is damaged, or no model of footprints-edge",
                                          file_.c_str(), channels, size.height, size.width));
    float *values = nullptr;
    check(api.GetTensorMutableData(output.get(), reinterpret_cast<void **>(&values)), what);
    std::vector<float> maps(values, values + size_t(channels) * size.height * size.width);
    for (float &value : maps) {
        if (!(value >= -1e-6f && value <= 1 + 1e-6f)) /* NaN is neither */
            throw Failure(FPE_BAD_MODEL, text("%s gives the value %g; maps are from 0 to 1: its "
                                              "weights are damaged",
                                              file_.c_str(), double(value)));
        value = std::clamp(value, 0.0f, 1.0f);
    }
    return maps;
}

}  // namespace footprints_edge
