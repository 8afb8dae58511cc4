"""ncnn, float32, converted by pnnx."""

import subprocess
from pathlib import Path

import numpy as np

from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
)


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend; ncnn reports no precision per operator, so it is taken from the options."""
    import ncnn

    folder = _converted(backend, setting)
    param, weights = folder / "network.ncnn.param", folder / "network.ncnn.bin"
    net = ncnn.Net()
    net.opt.num_threads = setting.threads
    net.opt.use_vulkan_compute = False
    net.opt.use_fp16_packed = net.opt.use_fp16_storage = net.opt.use_fp16_arithmetic = False
    net.opt.use_bf16_storage = False
    if net.load_param(str(param)) or net.load_model(str(weights)):
        raise BackendError(f"ncnn cannot load the files that pnnx made of {backend.network}")
    height, width = backend.size

    def run(image: Rgb) -> Floats:
        frame = ncnn.Mat.from_pixels(
            np.ascontiguousarray(image[0]), ncnn.Mat.PixelType.PIXEL_RGB, width, height
        )
        frame.substract_mean_normalize([], [1 / 255] * 3)
        extractor = net.create_extractor()
        extractor.input("in0", frame)
        failed, maps = extractor.extract("out0")
        if failed:
            raise BackendError(f"ncnn failed on {backend.name}: code {failed}")
        return np.array(maps)[None]

    convolutions = sum(line.startswith("Convolution") for line in param.read_text().splitlines())
    options = net.opt
    is_half = options.use_bf16_storage or options.use_fp16_arithmetic
    kind = "half precision" if is_half else "float32"
    file_bytes = param.stat().st_size + weights.stat().st_size
    return LoadedBackend(run, f"{kind} ({convolutions} convolutions, by its options)", file_bytes)


def _converted(backend: Backend, setting: BackendSetting) -> Path:
    import pnnx
    import torch

    from footprints_edge_models.networks.channels import raw_to_maps

    network = setting.cache.network(backend.network)
    height, width = backend.size

    class WithMaps(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.network = network

        def forward(self, image: torch.Tensor) -> torch.Tensor:
            return raw_to_maps(self.network(image))

    def make(folder: Path) -> None:
        example = torch.zeros(1, 3, *backend.size)
        traced = torch.jit.trace(WithMaps().eval(), example)  # type: ignore[no-untyped-call]
        traced.save(str(folder / "network.pt"))
        command = [pnnx.EXEC_PATH, "network.pt", f"inputshape=[1,3,{height},{width}]", "fp16=0"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if not (folder / "network.ncnn.param").is_file():
            raise BackendError(f"pnnx made no ncnn files of {backend.network}: {done.stderr}")

    return setting.cache.kept(
        f"{backend.network}-{height}x{width}-ncnn",
        {"weights": setting.cache.weights_sha256(backend.network), "size": backend.size},
        make,
    )
