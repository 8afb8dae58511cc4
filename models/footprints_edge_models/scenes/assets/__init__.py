"""Assets of scenes: things, materials, textures."""
