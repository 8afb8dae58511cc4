"""The engines that can run a network, one per file, behind one function: ``open_backend``."""
