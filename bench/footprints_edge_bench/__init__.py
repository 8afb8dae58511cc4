"""Benchmarks of the models: accuracy, navigation, temporal consistency, speed."""
