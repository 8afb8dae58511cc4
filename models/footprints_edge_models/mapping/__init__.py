"""The floor of a clip: planes, stereo depth, a floor map in bird's-eye view."""
