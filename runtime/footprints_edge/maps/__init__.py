"""The data of a prediction: four maps, their masks and their camera."""
