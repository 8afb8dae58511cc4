"""Speed of networks, of whole frames and of training labels."""
