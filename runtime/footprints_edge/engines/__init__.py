"""What runs a model file: one engine a file, all behind one protocol."""
