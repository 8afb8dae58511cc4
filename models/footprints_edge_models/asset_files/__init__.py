"""3D models, worlds, textures and panoramas from files, with their licences."""
