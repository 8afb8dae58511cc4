"""ONNX graphs: export from PyTorch, editing, uint8 input, fp16 weights, .ort format."""
