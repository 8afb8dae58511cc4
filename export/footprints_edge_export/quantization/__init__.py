"""int8: calibration, quantization, bias correction, and exact sums."""
