"""Export of PyTorch networks to ONNX files of the footprints-edge contract, verified throughout."""

import footprints_edge  # noqa: F401 - it keeps onnxruntime from reporting to its maker
