"""Engines that run model files: one module each, behind one protocol."""
