"""From a scene to a photo."""
