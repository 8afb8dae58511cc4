"""Reads checkpoints strictly, and without executing anything: they are pickles from anywhere."""

import hashlib
import math
import warnings
from pathlib import Path
from typing import Any

import torch
from torch import nn

from footprints_edge.errors import ModelError
from footprints_edge_models.bounded_files import refuse_packed

FOCAL_PX_KEY = "canonical_focal_px"
"""Key of a state dict's canonical focal length, a tensor of one number, beside the weights."""
CREDITS_KEY = "credits"
"""Key of whom to credit for what the weights were trained on: JSON, a tensor of its bytes."""

_BESIDE = (FOCAL_PX_KEY, CREDITS_KEY)


def read_checkpoint(path: Path) -> Any:  # noqa: ANN401  (a checkpoint holds what its writer put in)
    """The plain data of a PyTorch checkpoint, on the CPU.

    Raises:
        ModelError: no such file, not a checkpoint, or one that holds more than plain data and
            would run code when loaded.
    """
    try:
        refuse_packed(path)  # PyTorch stores, and packs nothing
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return torch.load(path, map_location="cpu", weights_only=True)
    except FileNotFoundError as error:
        raise ModelError(f"{path}: no such checkpoint; name the model.pth to load") from error
    except Exception as error:  # damaged bytes make the unpickler raise nearly anything
        # torch's own words advise to load it all the same; they stay in the chained error only
        raise ModelError(
            f"{path}: refused, it is not a PyTorch checkpoint of plain tensors. Either it is "
            "damaged or something else, or it holds objects that would run code when loaded; "
            "save a network's state_dict() with torch.save"
        ) from error


def load_weights(network: nn.Module, weights: Any, name: str) -> None:  # noqa: ANN401
    """Fill a network from a state dict, every key and shape as expected.

    A stated focal length (see :func:`stated_focal_px`) and credits are none of the network's.

    Raises:
        ModelError: naming the missing, unexpected and misshapen keys.
    """
    if not isinstance(weights, dict) or not all(
        isinstance(key, str) and isinstance(value, torch.Tensor) for key, value in weights.items()
    ):
        raise ModelError(
            f"{name}: expected a state dict of named tensors, found "
            f"{type(weights).__name__}; save network.state_dict()"
        )
    weights = {key: tensor for key, tensor in weights.items() if key not in _BESIDE}
    expected = network.state_dict()
    odd = [key for key, tensor in weights.items() if not _is_plain(tensor)]
    if odd:
        raise ModelError(
            f"{name}: {_listed('no plain numbers', odd)}; sparse, quantised, complex and empty "
            "tensors are none: save the network's state_dict() as it is trained"
        )
    problems = [
        _listed("missing", [key for key in expected if key not in weights]),
        _listed("unexpected", [key for key in weights if key not in expected]),
        _listed(
            "of another shape",
            [
                f"{key} {tuple(weights[key].shape)} instead of {tuple(tensor.shape)}"
                for key, tensor in expected.items()
                if key in weights and weights[key].shape != tensor.shape
            ],
        ),
    ]
    if any(problems):
        raise ModelError(
            f"{name}: not a checkpoint of {type(network).__name__}: "
            + "; ".join(filter(None, problems))
        )
    boundless = [key for key, tensor in weights.items() if not tensor.float().isfinite().all()]
    if boundless:
        raise ModelError(
            f"{name}: {_listed('not finite', boundless)}; values beyond half precision's 65,504 "
            "end so when they are saved in it: save them again in float32"
        )
    try:
        network.load_state_dict(weights, strict=True)
    except Exception as error:
        raise ModelError(f"{name}: its tensors do not load: {error!s:.500}") from error


def _is_plain(tensor: torch.Tensor) -> bool:
    """Whether a tensor is an ordinary one, whose numbers are there."""
    return (
        tensor.layout is torch.strided
        and not (tensor.is_meta or tensor.is_quantized or tensor.is_complex() or tensor.is_nested)
        and tensor.dtype is not torch.bool
    )


def stated_focal_px(weights: Any, name: str) -> float | None:  # noqa: ANN401
    """Focal length of the canonical camera that a state dict's depths are for, if it says so.

    It is in pixels of the network's input, whatever the input's size: a convolution sees pixels.

    Raises:
        ModelError: what is stated is no focal length.
    """
    if not isinstance(weights, dict) or FOCAL_PX_KEY not in weights:
        return None
    stated = weights[FOCAL_PX_KEY]
    is_number = isinstance(stated, torch.Tensor) and _is_plain(stated) and stated.numel() == 1
    if not is_number or not 0 < float(stated) < math.inf:
        raise ModelError(
            f"{name}: {FOCAL_PX_KEY} is {stated!s:.200}; it must be one positive number of pixels"
        )
    return float(stated)


def _listed(what: str, keys: list[str], most: int = 5) -> str:
    if not keys:
        return ""
    more = f" and {len(keys) - most} more" if len(keys) > most else ""
    shown = (
        key if key.isprintable() and len(key) < 100 else f"{key!r:.100}" for key in keys[:most]
    )
    return f"{len(keys)} {what}: {', '.join(shown)}{more}"


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
