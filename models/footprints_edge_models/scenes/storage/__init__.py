"""Scenes on disk, and their contact sheet."""
