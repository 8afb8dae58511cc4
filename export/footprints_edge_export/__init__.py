"""Export of PyTorch networks to ONNX files of the footprints-edge contract, verified throughout."""
