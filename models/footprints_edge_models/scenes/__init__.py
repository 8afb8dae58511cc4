"""Synthetic scenes: rooms and streets with exact ground truth of visible and hidden ground.

Data flows one way: ``assets -> layout -> rendering -> ground_truth -> storage``. ``generate`` makes
one scene from its number, ``make`` fills a folder.

Train and test are kept apart by construction: the split is part of every seed, of scenes and of
textures, and a photo gives its textures to one split, by a checksum of its bytes. What the two
share is the program: kinds of rooms, furniture and patterns, and one plain grey that is tinted.
"""
