"""Scenes on disk, as samples, and as a contact sheet."""
