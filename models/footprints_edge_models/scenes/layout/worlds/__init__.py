"""Scenes in whole places from files."""
