"""int8: calibration, quantization, and what makes it exact."""
