"""LiteRT with its XNNPACK kernels, float32, converted by litert-torch."""

from pathlib import Path

from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
    describe_precisions,
)


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend; its precision is that of the outputs of its convolutions."""
    from ai_edge_litert.interpreter import Interpreter

    path = _converted(backend, setting)
    interpreter = Interpreter(str(path), num_threads=setting.threads)
    interpreter.allocate_tensors()
    (given,), (made,) = interpreter.get_input_details(), interpreter.get_output_details()

    def run(image: Rgb) -> Floats:
        interpreter.set_tensor(given["index"], image)
        interpreter.invoke()
        maps: Floats = interpreter.get_tensor(made["index"])
        return maps

    tensors = {tensor["index"]: tensor for tensor in interpreter.get_tensor_details()}
    kinds: dict[str, int] = {}
    for operator in interpreter._get_ops_details():
        if operator["op_name"] in ("CONV_2D", "DEPTHWISE_CONV_2D"):
            kind = tensors[operator["outputs"][0]]["dtype"].__name__
            kinds[kind] = kinds.get(kind, 0) + 1
    return LoadedBackend(run, describe_precisions(kinds), path.stat().st_size)


def _converted(backend: Backend, setting: BackendSetting) -> Path:
    try:
        import litert_torch
    except ModuleNotFoundError as error:
        raise BackendError(
            "converting the network needs litert-torch, whose requirements conflict with those of "
            "our tests, so no extra installs it; pip install litert-torch in another environment"
        ) from error
    import torch

    from footprints_edge_models.networks.channels import raw_to_maps

    network = setting.cache.network(backend.network)

    class WithMaps(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.network = network

        def forward(self, image: torch.Tensor) -> torch.Tensor:
            return raw_to_maps(self.network(image.permute(0, 3, 1, 2).float() / 255))

    def make(folder: Path) -> None:
        example = (torch.zeros(1, *backend.size, 3, dtype=torch.uint8),)
        litert_torch.convert(WithMaps().eval(), example).export(str(folder / "network.tflite"))

    made = setting.cache.kept(
        f"{backend.network}-{backend.size[0]}x{backend.size[1]}-litert",
        {"weights": setting.cache.weights_sha256(backend.network), "size": backend.size},
        make,
    )
    return made / "network.tflite"
