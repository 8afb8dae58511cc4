"""Checks of model files: contract, parity with torch, differences, test vectors."""
