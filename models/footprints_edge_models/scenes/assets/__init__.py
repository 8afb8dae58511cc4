"""What scenes are made of: things, materials, textures."""
