"""Decoding and resizing: from a picture in any form to the network's input."""
