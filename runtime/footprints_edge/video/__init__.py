"""Videos, cameras and pipes: frames in, smoothed maps out."""
