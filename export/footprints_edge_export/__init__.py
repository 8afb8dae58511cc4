"""Torch networks to ONNX files of the footprints-edge contract, verified at every step."""
