"""The engines that can run a network, one a file, all behind one function: ``open_backend``."""
