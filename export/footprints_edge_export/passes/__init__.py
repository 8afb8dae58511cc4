"""Rewrites of a graph that make it faster and leave its maps as they are, one a file.

Each is a function that changes a model in place. ``registry.PASSES`` lists them in the order in
which they are applied.
"""
