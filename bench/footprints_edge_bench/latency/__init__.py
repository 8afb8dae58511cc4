"""How fast networks and whole frames are."""
