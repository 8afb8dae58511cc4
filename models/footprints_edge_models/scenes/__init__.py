"""Made scenes: rooms and streets whose visible and hidden ground is known exactly.

Data flows one way: ``shapes -> things -> furniture, people, vehicles, outdoors -> rooms, streets
-> scene -> geometry -> cameras -> truth, shading -> sensor -> files -> dataset``.

Train and test are kept apart by construction: the split is part of every seed, of scenes and of
textures, and a photo gives its textures to one split, by a checksum of its bytes. What the two
share is the program: kinds of rooms, furniture and patterns, and one plain grey that is tinted.
"""
