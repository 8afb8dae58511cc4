"""The floor of a whole clip: planes, stereo, a map from above."""
