"""Perspective views of panoramas on which people drew the ground, seen and hidden."""
