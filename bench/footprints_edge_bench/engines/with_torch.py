"""PyTorch in eager mode, float32: the network as it was trained."""

from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    LoadedBackend,
    describe_precisions,
)


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend; its precision is that of its weights."""
    import torch

    from footprints_edge_models.networks.channels import raw_to_maps

    network = setting.cache.network(backend.network)
    torch.set_num_threads(setting.threads)

    def run(image: Rgb) -> Floats:
        with torch.inference_mode():
            x = torch.tensor(image).permute(0, 3, 1, 2).float() / 255
            maps: Floats = raw_to_maps(network(x)).numpy()
            return maps

    kinds: dict[str, int] = {}
    for module in network.modules():
        if isinstance(module, torch.nn.Conv2d):
            kind = str(module.weight.dtype).removeprefix("torch.")
            kinds[kind] = kinds.get(kind, 0) + 1
    return LoadedBackend(run, describe_precisions(kinds), None)
