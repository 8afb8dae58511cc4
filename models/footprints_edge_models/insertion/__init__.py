"""3D models put into photos, on the floor that these show: hidden ground with exact labels."""
