"""How fast and how accurate the models are, measured."""
