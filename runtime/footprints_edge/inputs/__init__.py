"""From a picture in any form to the input of a network."""
