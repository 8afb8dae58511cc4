"""The four maps of a prediction as data."""
